use super::*;
use crate::draw::png;
use crate::lab::compare::cell::cells;
use crate::lab::compare::fixtures;
use crate::lab::compare::overall::overall;
use crate::lab::compare::plan::{Budget, Method};
use crate::lab::compare::schedule::order;
use std::collections::BTreeMap;

/// All runs of the plan, in a store, and their charts.
fn drawn(plan: &Plan) -> Vec<Chart> {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("runs.jsonl"), "", "").unwrap();
    order(plan).iter().for_each(|slot| store.add(fixtures::run(plan, slot)).unwrap());
    {
        let cells = cells(plan, &store, &BTreeMap::new());
        charts(plan, &store, &cells, &overall(plan, &cells))
    }
}

#[test]
fn every_kind_is_drawn_for_each_scene() {
    let all = drawn(&fixtures::plan());
    let kinds = ["error-time", "error-samples", "error-memory", "pareto", "path-length", "efficiency"];
    let of_scenes = ["s0", "s1"].iter().flat_map(|s| kinds.map(|k| format!("{k}-{s}")));
    let wanted: Vec<String> = std::iter::once("efficiency-all".to_string()).chain(of_scenes).collect();
    assert_eq!(all.iter().map(|c| c.id.clone()).collect::<Vec<_>>(), wanted);
    for chart in &all {
        let document = resvg::usvg::roxmltree::Document::parse(&chart.svg).unwrap();
        let texts: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        assert!(texts.contains(&chart.title.as_str()), "{}", chart.id);
        assert!(chart.svg.contains(style(1).color) && texts.iter().any(|t| t.contains("grid")), "{}", chart.id);
        assert!(!chart.svg.contains("NaN") && !chart.svg.contains("inf"), "{}", chart.id);
    }
}

#[test]
fn one_budget_and_one_run_still_give_charts() {
    let mut plan = fixtures::plan();
    (plan.budgets, plan.runs) = (vec![Budget::Seconds(2.0)], 1);
    assert_eq!(drawn(&plan).len(), 13);
}

#[test]
fn pngs_have_letters_and_twice_the_size() {
    let mut plan = fixtures::plan();
    plan.methods[1] = Method { name: "<a & \"b\">".into(), overrides: vec![] };
    let all = drawn(&plan);
    let with = png(&all[1].svg, "").unwrap();
    let picture = image::load_from_memory(&with).unwrap();
    assert_eq!((picture.width(), picture.height()), (1520, 880));
    let mute = regex_free_without_text(&all[1].svg);
    assert_ne!(with, png(&mute, "").unwrap(), "letters leave traces");
    assert!(png("no svg", "").is_err());
}

fn regex_free_without_text(svg: &str) -> String {
    svg.lines().filter(|line| !line.starts_with("<text")).collect::<Vec<_>>().join("\n")
}

#[test]
fn methods_keep_their_style_and_no_two_of_thirty_look_alike() {
    let styles: Vec<Style> = (0..30).map(style).collect();
    assert!(styles.iter().enumerate().all(|(i, s)| !styles[..i].contains(s)));
}

#[test]
fn a_narrow_chart_shows_all_of_its_names_within_a_phone() {
    let mut plan = fixtures::plan();
    plan.methods[1].name = "a method with a name of forty letters or".into();
    for chart in drawn(&plan) {
        let document = resvg::usvg::roxmltree::Document::parse(&chart.narrow).unwrap();
        let root = document.root_element();
        assert_eq!(root.attribute("width"), Some("343"), "{}", chart.id);
        let tree = crate::draw::tree(&chart.narrow).unwrap();
        let bounds = tree.root().abs_bounding_box();
        assert!(bounds.left() >= 0.0 && bounds.right() <= 343.0, "{}: {bounds:?}", chart.id);
        assert!(bounds.bottom() <= tree.size().height(), "{}: {bounds:?}", chart.id);
        assert!(document.descendants().filter_map(|n| n.text()).any(|t| t.contains("a method with")), "{}", chart.id);
    }
}

#[test]
fn what_has_a_colour_has_its_class() {
    for chart in drawn(&fixtures::plan()) {
        for line in chart.svg.lines().filter(|line| line.contains("fill=\"#") || line.contains("stroke=\"#")) {
            assert!(line.contains(" class=\"f-") || line.contains(" class=\"s-"), "{line}");
        }
    }
}
