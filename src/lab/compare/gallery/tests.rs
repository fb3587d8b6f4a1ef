//! Runs with planted faults: each must be found, and nothing else.

use super::matrix::{Matrix, MatrixCell};
use super::*;
use crate::lab::compare::bias::ReferenceBlocks;
use crate::lab::compare::cell::cells;
use crate::lab::compare::plan::{Budget, Plan};
use crate::lab::compare::record::Run;
use crate::lab::compare::schedule::{Slot, order};
use crate::lab::compare::store::Store;
use crate::lab::compare::{file, fixtures};
use crate::math::rng::Rng;
use std::collections::BTreeMap;
use std::path::Path;

const RUNS: u32 = 20;
const BLOCKS: usize = 16;
const MEMORY: u64 = 2 << 20;

/// Two scenes, `none` and `grid`, one budget.
fn plan() -> Plan {
    Plan { runs: RUNS, budgets: vec![Budget::Seconds(2.0)], ..fixtures::plan() }
}

/// About normal, of variance 1.
fn noise(rng: &mut Rng) -> f64 {
    (0..12).map(|_| f64::from(rng.f32())).sum::<f64>() - 6.0
}

/// A run without fault: the mean is right, errors of both methods are alike and vary by a few per cent.
fn honest(plan: &Plan, slot: &Slot) -> Run {
    let mut run = fixtures::run(plan, slot);
    let mut rng = Rng::new(1000 * slot.scene as u64 + slot.seed);
    run.blocks = (0..BLOCKS).map(|_| 1.0 + 0.02 * noise(&mut rng)).collect();
    run.errors.relmse = 0.1 * (1.0 + 0.05 * noise(&mut rng));
    run.errors.relmse_trimmed = 0.9 * run.errors.relmse;
    run
}

/// The matrix of honest runs but for what `spoil` does to those of `grid` on the first scene (by the number of the run).
fn matrix_of(gallery: &Gallery, spoil: impl Fn(u32, &mut Run), repeatable: bool) -> Matrix {
    let (plan, folder) = (plan(), tempfile::tempdir().unwrap());
    let mut store = Store::open(&folder.path().join("runs.jsonl"), "", "").unwrap();
    for slot in order(&plan) {
        let mut run = honest(&plan, &slot);
        if (slot.scene, slot.method) == (0, 1) {
            spoil(slot.run, &mut run);
        }
        store.add(run).unwrap();
    }
    for (scene, method) in [("s0", "none"), ("s0", "grid"), ("s1", "none"), ("s1", "grid")] {
        let equal = repeatable || (scene, method) != ("s0", "grid");
        store.add_repeat(scene, method, gallery.bounds.repeat, equal).unwrap();
    }
    let reference = ReferenceBlocks { mean: vec![1.0; BLOCKS], variance: vec![1e-8; BLOCKS] };
    let blocks: BTreeMap<String, ReferenceBlocks> = ["s0", "s1"].map(|s| (s.to_owned(), reference.clone())).into();
    Matrix::judged(&plan, gallery, &store, &cells(&plan, &store, &blocks), &|_, _| MEMORY)
}

fn spoilt(spoil: impl Fn(u32, &mut Run)) -> MatrixCell {
    let matrix = matrix_of(&Gallery::default(), spoil, true);
    assert_others_green(&matrix);
    matrix.find("s0", "grid").unwrap().clone()
}

fn assert_others_green(matrix: &Matrix) {
    let others = matrix.cells.iter().filter(|c| (c.scene.as_str(), c.method.as_str()) != ("s0", "grid"));
    others.for_each(|cell| assert_eq!(cell.colour, Colour::Green, "{cell:?}"));
}

/// That exactly these checks are not green, and of this colour.
fn assert_found(cell: &MatrixCell, wanted: &[(Check, Colour)]) {
    let found: Vec<(Check, Colour)> =
        cell.findings.iter().filter(|f| f.colour != Colour::Green).map(|f| (f.check, f.colour)).collect();
    assert_eq!(found, wanted, "{cell:?}");
}

#[test]
fn clean_runs_are_green() {
    let cell = spoilt(|_, _| {});
    assert_found(&cell, &[]);
    assert_eq!((cell.colour, cell.runs, cell.failures().count()), (Colour::Green, 20, 0));
    assert!((cell.firefly_share.unwrap() - 0.1).abs() < 1e-9);
}

#[test]
fn a_value_that_is_not_finite_is_found() {
    assert_found(&spoilt(|k, run| run.non_finite = u64::from(k == 7)), &[(Check::Finite, Colour::Red)]);
    let broken = spoilt(|k, run| run.broken_pixels = u64::from(k == 7));
    assert_found(&broken, &[(Check::Finite, Colour::Red)]);
    assert!(broken.findings[1].says.contains("1 pixels not finite"), "{broken:?}");
    // noise below 0 is no fault of an estimate that is right on average
    assert_found(&spoilt(|_, run| run.negative_pixels = 9), &[]);
    let undefined = spoilt(|k, run| {
        if k == 7 {
            (run.errors.relmse, run.errors.relmse_trimmed, run.blocks[3]) = (f64::NAN, f64::NAN, f64::NAN);
        }
    });
    assert_eq!(undefined.findings[1].colour, Colour::Red);
    assert_eq!(undefined.colour, Colour::Red);
    // what cannot be judged for it is not called good
    assert_eq!([0, 2, 3].map(|k| undefined.findings[k].colour), [Colour::Amber; 3]);
}

#[test]
fn a_bias_is_found_on_either_side() {
    for (factor, side) in [(0.95, "darker"), (1.05, "brighter")] {
        let cell = spoilt(|_, run| run.blocks.iter_mut().for_each(|x| *x *= factor));
        assert_found(&cell, &[(Check::Unbiased, Colour::Red)]);
        assert!(cell.findings[0].says.starts_with(side), "{cell:?}");
    }
}

#[test]
fn the_level_of_each_test_is_that_of_the_family() {
    let matrix = matrix_of(&Gallery::default(), |_, _| {}, true);
    assert_eq!(matrix.tested, 4);
    assert!(((1.0 - matrix.level).powi(4) - 0.99).abs() < 1e-12);
}

#[test]
fn one_run_in_twenty_that_explodes_is_found() {
    let cell = spoilt(|k, run| {
        if k == 13 {
            (run.errors.relmse, run.errors.relmse_trimmed) = (30.0 * run.errors.relmse, 27.0 * run.errors.relmse);
        }
    });
    // its mean is worse for it, which its wide interval does not make certain
    assert_found(&cell, &[(Check::Efficiency, Colour::Amber), (Check::Explosion, Colour::Red)]);
    assert!(cell.relmse_worst.unwrap() > 15.0 * cell.relmse_median.unwrap());
}

#[test]
fn one_that_wins_on_average_and_explodes_once_is_red() {
    let cell = spoilt(|k, run| {
        let factor = if k == 13 { 2.0 } else { 0.05 };
        (run.errors.relmse, run.errors.relmse_trimmed) = (factor * run.errors.relmse, 0.9 * factor * run.errors.relmse);
    });
    assert!(cell.ratio.value.unwrap() > 5.0, "{cell:?}");
    assert_found(&cell, &[(Check::Explosion, Colour::Red)]);
}

#[test]
fn slow_is_amber_and_slower_than_the_bound_red() {
    let times = |factor: f64| spoilt(move |_, run| run.wall_seconds *= factor);
    assert_found(&times(1.5), &[(Check::Efficiency, Colour::Amber)]);
    assert_found(&times(3.0), &[(Check::Efficiency, Colour::Red)]);
    assert_found(&times(0.3), &[]);
}

#[test]
fn fireflies_are_red_only_where_they_are_the_methods_own() {
    let own = spoilt(|_, run| run.errors.relmse_trimmed *= 0.3);
    assert_found(&own, &[(Check::Fireflies, Colour::Red)]);
    // more than half on average, but not in all runs
    let now_and_then = spoilt(|k, run| run.errors.relmse_trimmed *= if k % 5 < 3 { 0.1 } else { 1.0 });
    assert_found(&now_and_then, &[(Check::Fireflies, Colour::Amber)]);
    // as large a share of a much smaller error
    let small = spoilt(|_, run| {
        run.errors.relmse *= 0.05;
        run.errors.relmse_trimmed = 0.3 * run.errors.relmse;
    });
    assert_found(&small, &[(Check::Fireflies, Colour::Amber)]);
}

#[test]
fn a_guide_above_its_memory_is_found() {
    let cell = spoilt(|k, run| run.guide_bytes = if k == 3 { MEMORY + 1 } else { MEMORY });
    assert_found(&cell, &[(Check::Memory, Colour::Red)]);
    assert_found(&spoilt(|_, run| run.guide_bytes = MEMORY), &[]);
}

#[test]
fn what_cannot_be_repeated_is_found() {
    let matrix = matrix_of(&Gallery::default(), |_, _| {}, false);
    assert_others_green(&matrix);
    assert_found(matrix.find("s0", "grid").unwrap(), &[(Check::Repeatable, Colour::Red)]);
}

#[test]
fn without_any_error_speed_is_compared() {
    let faultless = |run: &mut Run| {
        (run.errors.mse, run.errors.relmse, run.errors.relmse_trimmed) = (0.0, 0.0, 0.0);
        run.blocks = vec![1.0; BLOCKS];
    };
    let plan = plan();
    for (factor, colour) in [(1.0, Colour::Green), (3.0, Colour::Red)] {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("runs.jsonl"), "", "").unwrap();
        for slot in order(&plan) {
            let mut run = honest(&plan, &slot);
            faultless(&mut run);
            run.wall_seconds *= if slot.method == 1 { factor } else { 1.0 };
            store.add(run).unwrap();
        }
        let cells = cells(&plan, &store, &BTreeMap::new());
        let matrix = Matrix::judged(&plan, &Gallery::default(), &store, &cells, &|_, _| MEMORY);
        let cell = matrix.find("s0", "grid").unwrap();
        assert_eq!(cell.findings[0].colour, Colour::Green, "equal pictures need no test: {cell:?}");
        assert_eq!(cell.findings[2].colour, colour, "{cell:?}");
        assert_eq!(cell.findings[6].colour, Colour::Amber, "not tried");
    }
}

fn explained() -> Gallery {
    let text = "[gallery]\n[[scene]]\npath = 's0.toml'\n[[why]]\nscenes = ['s0']\nmethods = ['grid']\n\
                fails = ['memory']\nsays = 'It has no end.'\n";
    file::parse(text, Path::new("plan.toml")).unwrap().gallery.unwrap()
}

#[test]
fn red_cells_have_their_sentence_or_are_loudly_without() {
    let gallery = explained();
    let full = |run: &mut Run| run.guide_bytes = MEMORY + 1;
    let matrix = matrix_of(&gallery, |_, run| full(run), true);
    let table = output::markdown(&plan(), &matrix);
    assert!(table.contains("It has no end.") && !table.contains("UNEXPLAINED"), "{table}");
    let both = matrix_of(&gallery, |k, run| (run.non_finite, run.guide_bytes) = (u64::from(k == 0), MEMORY + 1), true);
    let table = output::markdown(&plan(), &both);
    assert!(table.contains("It has no end.") && table.contains("**UNEXPLAINED**"), "{table}");
    assert!(output::csv(&both).contains(",unexplained / It has no end."), "{}", output::csv(&both));
    // a sentence makes nothing red
    let table = output::markdown(&plan(), &matrix_of(&gallery, |_, _| {}, true));
    assert!(!table.contains("It has no end.") && !table.contains("✗]"), "{table}");
}

#[test]
fn tables_have_a_cell_for_each_method() {
    let matrix = matrix_of(&Gallery::default(), |_, run| run.wall_seconds *= 3.0, true);
    let csv = output::csv(&matrix);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0].len()), (5, rows[2].len()));
    assert_eq!(rows[2][..6], ["s0", "grid", "red", "green", "green", "red"]);
    let table = output::markdown(&plan(), &matrix);
    assert!(table.contains("| `s0` | ✓ 1.00, "), "{table}");
    assert!(table.contains("| grid | 1 | 0 | 1 |"), "{table}");
    assert!(table.contains("- s0, grid: efficiency: 0.3"), "{table}");
}

#[test]
fn faults_of_the_section_are_named_with_their_place() {
    let head = "[gallery]\n[[scene]]\npath = 's0.toml'\n";
    let cases = [
        ("[gallery]\nalarm = 2".to_owned(), "2:9: `alarm` must be greater than 0 and at most 1, found 2"),
        ("[gallery]\nslow = 2".to_owned(), "2:1: unknown key `slow` in [gallery]: did you mean `slower`?"),
        (format!("{head}[[why]]\nscenes = ['s1']\nsays = 'a'"), "5:10: `s1` in `scenes` is not there: known are `s0`"),
        (
            format!("{head}[[why]]\nmethods = ['gird']\nsays = 'a'"),
            "5:11: `gird` in `methods` is not there: did you mean `grid`?",
        ),
        (format!("{head}[[why]]\nscenes = ['s0']"), "4:1: [[why]] needs `says`"),
        ("[[why]]\nsays = 'a'".to_owned(), "1:1: [[why]] belongs to a [gallery]"),
    ];
    for (text, wanted) in cases {
        let message = file::parse(&text, Path::new("plan.toml")).unwrap_err().to_string();
        assert_eq!(message, format!("plan.toml:{wanted}"));
    }
}
