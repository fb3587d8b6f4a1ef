use super::*;
use crate::lab::compare::fixtures::{plan, run};
use crate::lab::compare::record::{ReferenceRecord, Source};
use crate::lab::compare::store::Store;
use std::path::Path;

/// Pretends to render, by a clock that a run of method `m` moves by `m + 1` seconds.
struct Mock {
    seconds: f64,
    /// Seconds at which it is told to stop.
    until: f64,
    referred: Vec<usize>,
    prepared: Vec<usize>,
    made: Vec<Slot>,
}

impl Mock {
    fn new(until: f64) -> Mock {
        Mock { seconds: 0.0, until, referred: vec![], prepared: vec![], made: vec![] }
    }
}

impl Executor for Mock {
    fn reference(&mut self, scene: usize, _: &mut Store) -> Result<bool> {
        assert!(self.made.is_empty(), "references come before all runs");
        self.referred.push(scene);
        Ok(true)
    }

    fn pace(&self, _: usize, _: usize) -> Option<f64> {
        None
    }

    fn prepare(&mut self, scene: usize, store: &mut Store) -> Result<bool> {
        self.prepared.push(scene);
        let reference = ReferenceRecord {
            source: Source::Made,
            path: "r.exr".into(),
            samples: Some(4),
            wall_seconds: Some(1.0),
            relmse_noise: Some(1e-3),
        };
        store.add_reference(["s0", "s1"][scene], &reference)?;
        Ok(true)
    }

    fn run(&mut self, slot: &Slot) -> Result<Option<Run>> {
        let seconds = slot.method as f64 + 1.0;
        if self.seconds + seconds > self.until {
            return Ok(None);
        }
        self.seconds += seconds;
        self.made.push(*slot);
        Ok(Some(Run { wall_seconds: seconds, ..run(&plan(), slot) }))
    }
}

struct Silent(Vec<usize>);

impl Watcher for Silent {
    fn before(&mut self, _: usize, seconds: Option<f64>) {
        assert!(seconds.is_some_and(|seconds| seconds > 0.0));
    }

    fn after(&mut self, _: &Run, done: usize, all: usize, seconds: Option<f64>) {
        assert_eq!((all, seconds.is_some()), (24, true));
        self.0.push(done);
    }
}

fn go(path: &Path, until: f64) -> (bool, Mock, Store, Vec<usize>) {
    let mut store = Store::open(path, "hash", "title").unwrap();
    let (mut mock, mut watcher) = (Mock::new(until), Silent(vec![]));
    let whole = carry_out(&plan(), &mut store, &mut mock, &mut watcher).unwrap();
    (whole, mock, store, watcher.0)
}

#[test]
fn methods_alternate_and_each_scene_is_prepared_once() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, mock, store, done) = go(&folder.path().join("runs.jsonl"), f64::INFINITY);
    assert!(whole && mock.referred == [0, 1] && mock.prepared == [0, 1] && mock.made == order(&plan()));
    assert!(mock.made.iter().enumerate().all(|(i, slot)| slot.method == i % 2), "A B A B");
    assert_eq!(done, (1..=24).collect::<Vec<_>>());
    assert!(order(&plan()).iter().all(|slot| store.find(&plan(), slot).is_some()));
}

#[test]
fn a_comparison_that_was_stopped_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    // 20 seconds: thirteen runs of 1 and 2 seconds in turn, the last scene only begun
    let (whole, first, _, _) = go(&path, 20.0);
    assert!(!whole && first.made.len() == 13 && first.prepared == [0, 1]);
    // a line that a crash cut short
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{text}{{\"run\":{{\"scene")).unwrap();
    let (whole, second, store, done) = go(&path, f64::INFINITY);
    assert!(whole && second.prepared == [1] && done == (14..=24).collect::<Vec<_>>());
    assert_eq!([first.made, second.made].concat(), order(&plan()));
    assert_eq!(store.reference("s0").unwrap().samples, Some(4));
    let (whole, third, ..) = go(&path, 0.0);
    assert!(whole && third.made.is_empty() && third.prepared.is_empty());
}

#[test]
fn runs_come_back_from_the_disk_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    go(&path, f64::INFINITY);
    let store = Store::open(&path, "hash", "title").unwrap();
    for slot in order(&plan()) {
        let wanted = Run { wall_seconds: slot.method as f64 + 1.0, ..run(&plan(), &slot) };
        assert_eq!(store.find(&plan(), &slot), Some(&wanted));
    }
}

#[test]
fn another_plan_and_damage_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    go(&path, 5.0);
    let message = Store::open(&path, "other", "title").err().unwrap().to_string();
    assert!(message.contains("another comparison") && message.contains("--restart"), "{message}");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("\"wall_seconds\"", "\"secs\"", 2)).unwrap();
    let message = Store::open(&path, "hash", "title").err().unwrap().to_string();
    assert!(message.contains("runs.jsonl:2") || message.contains("runs.jsonl:3"), "{message}");
}

#[test]
fn a_measure_that_is_not_finite_survives_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    let slot = order(&plan())[0];
    let mut broken = run(&plan(), &slot);
    broken.errors.relmse = f64::NAN;
    Store::open(&path, "hash", "title").unwrap().add(broken).unwrap();
    let store = Store::open(&path, "hash", "title").unwrap();
    assert!(store.find(&plan(), &slot).unwrap().errors.relmse.is_nan());
}
