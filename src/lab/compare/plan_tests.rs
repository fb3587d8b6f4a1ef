use super::*;
use crate::lab::compare::file;
use crate::lab::compare::schedule::order;

const FILE: &str = r#"title = "How fine a grid"
baseline = "none"
time = [4, 2]
runs = 3
reference_noise = 0.1

[set]
"film.width" = 64
film.height = 48

[[scene]]
path = "scenes/cornell.toml"
set = { "integrator.max_depth" = 4 }

[methods.none]
[methods.fine]
"guiding.method" = "grid"
"guiding.resolution" = 32
guiding.jitter = false
"#;

fn draft(text: &str) -> Result<Draft> {
    file::parse(text, &Path::new(env!("CARGO_MANIFEST_DIR")).join("plan.toml"))
}

#[test]
fn a_file_says_all_that_flags_can() {
    let plan = draft(FILE).unwrap().finish().unwrap();
    assert_eq!((plan.title.as_str(), plan.runs, plan.seed), ("How fine a grid", 3, 0));
    assert_eq!(plan.budgets, [Budget::Seconds(2.0), Budget::Seconds(4.0)]);
    assert_eq!((plan.reference_noise, plan.reference_time), (0.1, 600.0));
    let names: Vec<&str> = plan.methods.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["none", "fine"]);
    let (file, _) = plan.describe(&plan.scenes[0], Some(&plan.methods[1])).unwrap();
    assert_eq!((file.scene.film.width, file.scene.film.height, file.integrator.max_depth), (64, 48, 4));
    assert_eq!((file.guiding.method, file.guiding.resolution), (GuidingMethod::Grid, 32));
    assert!(!file.guiding.jitter);
    assert_eq!(plan.scenes[0].name(), "cornell");
}

#[test]
fn values_keep_their_kinds_on_their_way() {
    let text = "[set]\nlist = [1, 2.5]\ntext = 'a \"b\"'\nsmall = 1e-7\ndeep.'a b'.flag = true";
    let set = draft(text).unwrap().overrides;
    let texts: Vec<String> = set.iter().map(Override::text).collect();
    assert_eq!(texts[0], "list=[1, 2.5]");
    assert_eq!(texts[3], "deep.\"a b\".flag=true");
    let read: toml::Table = texts.join("\n").parse().unwrap();
    assert_eq!((read["text"].as_str(), read["small"].as_float()), (Some("a \"b\""), Some(1e-7)));
}

#[test]
fn faults_are_named_with_their_place() {
    let cases = [
        ("runs = 0", "1:8: `runs` must be between 1 and 10000, found 0"),
        ("\nrun = 3", "2:1: unknown key `run` in the comparison: did you mean `runs`?"),
        ("time = 1\nspp = 4", "2:7: budgets are either of `time` or of `spp`"),
        ("spp = [4, 0]", "1:11: `spp` must be a whole number between 1 and 1073741824"),
        ("time = -1", "1:8: `time` must be greater than 0, found -1"),
        ("[[scene]]\nnam = 'a'", "1:1: [[scene]] needs `path`"),
        ("[[scene]]\npath = 'a'\nnam = 'a'", "3:1: unknown key `nam` in [[scene]]: did you mean `name`?"),
        ("compare = 'none'", "1:11: `compare` must be an array of strings, found a string"),
        ("[methods]\na = 3", "2:5: [methods.a] must be a table, found an integer"),
        ("[set]\na = 1979-05-27", "2:5: `a` must be a value of a scene file, found a date"),
    ];
    for (text, wanted) in cases {
        let message = draft(text).unwrap_err().to_string();
        assert!(message.ends_with(&format!("plan.toml:{wanted}")), "{message}");
    }
}

#[test]
fn wrong_settings_of_a_method_are_named_with_their_place_in_the_file() {
    for (wrong, wanted) in [
        ("guiding.resolutoin = 4", "21:9: unknown key `resolutoin` in [guiding]: did you mean `resolution`?"),
        (
            "\n  \"guiding.memory\" = 0",
            "22:3: `memory` must be 1 or more bytes, or text with a unit (B, KiB, MiB, GiB, TiB, kB, MB, GB or TB)",
        ),
        ("integrator.mis = 'no'", "21:12: `mis` must be true or false, found a string"),
    ] {
        let plan = draft(&format!("{FILE}\n{wrong}\n")).unwrap().finish().unwrap();
        let message = plan.describe(&plan.scenes[0], Some(&plan.methods[1])).unwrap_err().to_string();
        assert!(message.ends_with(&format!("plan.toml:{wanted}")), "{message}");
    }
    let flags = Draft { overrides: vec![parse_set("film.widht=3").unwrap()], ..draft(FILE).unwrap() };
    let plan = flags.finish().unwrap();
    let message = plan.describe(&plan.scenes[0], None).unwrap_err().to_string();
    assert_eq!(message, "--set 'film.widht=3': unknown key `widht` in [film]: did you mean `width`?");
    assert!(parse_set("film.width").is_err());
}

#[test]
fn what_does_not_go_together_is_refused() {
    type Spoil = fn(&mut Draft);
    let cases: [(Spoil, &str); 7] = [
        (|d| d.scenes.clear(), "no scene"),
        (|d| d.methods.clear(), "no method"),
        (|d| d.methods.push("sdtee".into()), "unknown method `sdtee`: did you mean `sdtree`?"),
        (|d| d.methods.push("none".into()), "methods need names that tell them apart, and `none` is taken"),
        (|d| d.baseline = Some("grid".into()), "the baseline `grid` is none of the methods"),
        (|d| d.budgets = vec![Budget::Seconds(1.0), Budget::Samples(4)], "needs budgets"),
        (
            |d| (d.runs, d.budgets) = (Some(10_000), (1..=100).map(Budget::Samples).collect()),
            "1 scenes × 2 methods × 100 budgets × 10000 runs are more than 1000000 renders",
        ),
    ];
    for (spoil, wanted) in cases {
        let mut draft = draft(FILE).unwrap();
        spoil(&mut draft);
        let message = draft.finish().unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn runs_take_turns_and_have_seeds_of_their_own() {
    let plan = draft(FILE).unwrap().finish().unwrap();
    let slots = order(&plan);
    assert_eq!(slots.len(), 3 * 2 * 2);
    let turns: Vec<(u32, usize, usize)> = slots.iter().map(|s| (s.run, s.budget, s.method)).collect();
    assert_eq!(turns[..5], [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 0, 0)]);
    let seeds: BTreeSet<u64> = slots.iter().map(|s| s.seed).collect();
    assert_eq!(seeds.len(), slots.len());
    let longer = order(&Plan { runs: 5, ..plan });
    assert_eq!(longer[..12], slots[..], "more runs go on where fewer ended");
}

#[test]
fn the_example_of_the_documentation_is_read() {
    let page = include_str!("../../../docs/compare.md");
    let example = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let plan = draft(example).unwrap().finish().unwrap();
    let names: Vec<&str> = plan.methods.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["none", "coarse", "fine", "sdtree"]);
    let (file, _) = plan.describe(&plan.scenes[0], Some(&plan.methods[2])).unwrap();
    assert_eq!((file.guiding.resolution, file.guiding.memory, file.scene.film.width), (64, 64 << 20, 320));
    assert_eq!(plan.budgets.last(), Some(&Budget::Seconds(20.0)));
}
