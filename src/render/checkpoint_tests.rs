//! A render goes on from its checkpoint to the same bits, wherever it was left.

use super::super::{GuideIo, Rendering, Settings, Stop, render_shown, resume};
use super::{Checkpoint, Header, Moment, open};
use crate::format;
use crate::integrator::Task;
use crate::integrator::probe::Watch;
use crate::render::{Occasion, Onlooker};
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;

pub(super) fn door(set: &[&str]) -> (Scene, Settings) {
    // six tiles, so that a pass can be cut
    let small = ["film.width=96", "film.height=40", "render.spp=23", "render.layers=[\"direct\"]"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Writes a checkpoint after every so many passes, and at an end.
pub(super) struct Keeper<'a> {
    header: &'a Header<()>,
    folder: TempDir,
    every: usize,
    looks: usize,
    pub(super) written: Vec<PathBuf>,
}

impl<'a> Keeper<'a> {
    pub(super) fn new(header: &'a Header<()>, every: usize) -> Keeper<'a> {
        Keeper { header, folder: tempfile::tempdir().unwrap(), every, looks: 0, written: Vec::new() }
    }
}

impl Onlooker for Keeper<'_> {
    fn is_due(&mut self, occasion: Occasion) -> bool {
        self.looks += 1;
        self.looks.is_multiple_of(self.every) || occasion != Occasion::Between
    }

    fn look(&mut self, moment: &Moment) {
        if moment.can_go_on() {
            let path = self.folder.path().join(self.looks.to_string());
            moment.write_checkpoint(&path, self.header).unwrap();
            self.written.push(path);
        }
    }

    fn keeps_state(&self) -> bool {
        true
    }
}

/// Asks for the end when so many tasks have begun.
pub(super) struct Stopper {
    pub(super) stop: Stop,
    pub(super) begun: AtomicUsize,
    at: usize,
    /// At once, in the middle of a pass.
    at_once: bool,
}

impl Stopper {
    pub(super) fn new(at: usize, at_once: bool) -> Stopper {
        Stopper { stop: Stop::new(), begun: AtomicUsize::new(0), at, at_once }
    }
}

impl Watch for Stopper {
    type Probe = ();

    fn begin(&self, _task: &Task) {
        if self.begun.fetch_add(1, Ordering::Relaxed) + 1 == self.at {
            if self.at_once { self.stop.insist() } else { self.stop.ask() }
        }
    }

    fn end(&self, _task: &Task, _probe: ()) {}
}

pub(super) fn gone_on(path: &Path, scene: &Scene, settings: &Settings) -> Rendering {
    let from = open::<()>(path).unwrap().read(scene, settings).unwrap();
    let is_last = from.record.order.last;
    let rendering = resume(scene, settings, (from, false), &(), &Stop::new(), (&mut |_| true, &mut ()));
    assert!(is_last || rendering.iterations.len() > 1);
    rendering
}

pub(super) fn assert_same(a: &Rendering, b: &Rendering, what: &str) {
    assert!(a.estimate.mean == b.estimate.mean, "{what}: another picture");
    assert!(a.estimate.variance == b.estimate.variance && a.estimate.layers == b.estimate.layers, "{what}");
    assert!((a.samples, a.verdict, a.learnt_paths) == (b.samples, b.verdict, b.learnt_paths), "{what}");
    let (depth, ids) = (|r: &Rendering| -> Vec<f32> { r.estimate.features.iter().map(|f| f.depth).collect() }, 0);
    assert!(depth(a) == depth(b) && ids == 0, "{what}: other features");
    let spp = |r: &Rendering| -> Vec<u32> { r.iterations.iter().map(|i| i.samples).collect() };
    assert_eq!(spp(a), spp(b), "{what}");
}

/// Renders and goes on from checkpoints after every so many passes, and from those of renders that were cut in the middle of
/// one.
fn check(set: &[&str], keep: bool, every: usize) -> Rendering {
    let (scene, settings) = door(set);
    let header = Header::new(&scene, &settings, ());
    let keeping = || GuideIo { from: None, keep };
    let mut keeper = Keeper::new(&header, every);
    let shown = (&mut |_: &_| true, &mut keeper);
    let whole = render_shown(&scene, &settings, keeping(), &(), &Stop::new(), (shown.0, shown.1));
    let plain = super::super::render_keeping(&scene, &settings, keeping(), &mut |_| true);
    assert_same(&plain, &whole, &format!("{set:?}, with checkpoints"));
    assert!(keeper.written.len() >= 3, "{} checkpoints", keeper.written.len());
    for path in &keeper.written {
        assert_same(&whole, &gone_on(path, &scene, &settings), &format!("{set:?} from {}", path.display()));
    }
    let cuts = match (settings.render.noise, settings.render.spp) {
        _ if settings.render.adaptive => &[70][..],
        (Some(_), _) => &[9],
        (None, ..=100) => &[9, 33],
        (None, _) => &[33],
    };
    for &at in cuts {
        let watch = Stopper::new(at, true);
        let mut keeper = Keeper::new(&header, usize::MAX);
        let shown = (&mut |_: &_| true, &mut keeper);
        let cut = render_shown(&scene, &settings, keeping(), &watch, &watch.stop, (shown.0, shown.1));
        assert!(cut.samples < whole.samples);
        for path in &keeper.written {
            assert_same(&whole, &gone_on(path, &scene, &settings), &format!("{set:?} cut at {at}"));
        }
        // of a round that such a guide should have learnt from there is none
        assert!(keeper.written.len() == 1 || set.contains(&"guiding.updates=online"), "{set:?} cut at {at}");
    }
    whole
}

#[test]
fn without_a_guide() {
    check(&["guiding.method=none"], false, 3);
    check(&["guiding.method=none", "render.sampler=independent", "render.combine=last"], false, 3);
}

#[test]
fn until_it_is_good() {
    let small = ["film.width=32", "film.height=18", "render.spp=50000", "render.noise=0.6"];
    let whole = check(&[&["guiding.method=adaptive"][..], &small].concat(), false, 9);
    assert!(whole.relative_error.unwrap() <= 0.6 && whole.samples < 50000, "{} samples", whole.samples);
}

#[test]
fn where_tiles_get_different_numbers_of_samples() {
    let whole = check(&["guiding.method=none", "render.adaptive=true", "render.spp=120"], false, 7);
    assert!(whole.adaptive_tiles.is_some() && whole.samples == 120);
    let guided = ["guiding.method=adaptive", "render.adaptive=true", "film.width=64"];
    let until = check(&[&guided[..], &["render.spp=50000", "render.noise=0.5"]].concat(), false, 5);
    assert!(until.adaptive_tiles.is_some() && until.samples < 50000);
}

#[test]
fn with_a_grid() {
    check(&["guiding.method=grid", "guiding.table=hemisphere"], false, 3);
}

#[test]
fn with_adaptive_cells() {
    check(&["guiding.method=adaptive", "render.layers=[\"cryptomatte\"]"], true, 3);
    // there is not room for all
    check(&["guiding.method=adaptive", "guiding.memory=2000000"], false, 3);
}

#[test]
fn with_voronoi_cells() {
    check(&["guiding.method=voronoi", "guiding.placement=paths"], false, 3);
}

#[test]
fn with_an_sd_tree() {
    check(&["guiding.method=sdtree"], false, 3);
}

#[test]
fn with_online_updates() {
    check(&["guiding.method=grid", "guiding.updates=online"], false, 3);
}

#[test]
fn with_auto() {
    let whole = check(&["guiding.method=auto", "render.spp=360", "film.width=64", "film.height=36"], false, 45);
    assert!(whole.iterations.iter().any(|iteration| iteration.counters.guide_hits > 0), "no guide was tried");
}

/// A checkpoint after a few passes of a guided render, as bytes.
fn some_checkpoint(scene: &Scene, settings: &Settings) -> Vec<u8> {
    let header = Header::new(scene, settings, ());
    let mut keeper = Keeper::new(&header, 4);
    let shown = (&mut |_: &_| true, &mut keeper);
    render_shown(scene, settings, GuideIo::default(), &(), &Stop::new(), (shown.0, shown.1));
    std::fs::read(&keeper.written[0]).unwrap()
}

#[test]
fn what_is_no_whole_checkpoint_of_this_scene_is_an_error_that_says_so() {
    let small = ["guiding.method=adaptive", "film.width=32", "film.height=18"];
    let (scene, settings) = door(&small);
    let good = some_checkpoint(&scene, &settings);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let error = |bytes: &[u8], scene: &Scene, settings: &Settings| {
        std::fs::write(&path, bytes).unwrap();
        let read = open::<()>(&path).and_then(|file| file.read(scene, settings));
        read.err().map_or(String::new(), |error| error.to_string())
    };
    assert_eq!(error(&good, &scene, &settings), "");
    for length in (0..good.len()).step_by(good.len() / 37).chain([1, 11, 12, 15, 16, good.len() - 1]) {
        let said = error(&good[..length], &scene, &settings);
        assert!(said.contains("truncated") || (length == 0 && said.contains("no")), "{length} bytes: {said}");
        let mut damaged = good.clone();
        damaged[length] ^= 4;
        assert_ne!(error(&damaged, &scene, &settings), "", "byte {length}");
    }
    assert!(error(&[&good[..], b"!"].concat(), &scene, &settings).contains("damaged"));
    assert!(error(b"a text of some length", &scene, &settings).contains("this is no checkpoint"));
    let mut other = good.clone();
    other[8] = 77;
    assert!(error(&other, &scene, &settings).contains("version 77 of the format"));
    let (elsewhere, _) = door(&[&small[..], &["camera.origin=[0.1, 1, 1]"]].concat());
    assert!(error(&good, &elsewhere, &settings).contains("of another scene"));
    for set in ["integrator.max_depth=3", "guiding.resolution=9", "render.seed=7"] {
        let (_, changed) = door(&[&small[..], &[set]].concat());
        assert!(error(&good, &scene, &changed).contains("of other settings"), "{set}");
    }
    let (_, longer) = door(&[&small[..], &["render.spp=99", "render.time=3"]].concat());
    assert_eq!(error(&good, &scene, &longer), "", "the budget may be another");
}

#[test]
fn what_a_checkpoint_loses_shows_in_the_picture() {
    type Change = fn(&mut Checkpoint);
    let changes: [(&str, Change); 5] = [
        ("nothing", |_| ()),
        // the snapshot is then made of what has been learnt since it was made
        ("what the snapshot was made of", |from| from.state.guide.as_mut().unwrap().refresh()),
        ("what has been learnt", |from| from.record.order.learn = false),
        ("the iteration's length", |from| from.record.order.samples += 1),
        ("the seed", |from| from.state.seed += 1),
    ];
    let (scene, settings) = door(&["guiding.method=adaptive"]);
    // in the middle of the third iteration
    let bytes = some_checkpoint(&scene, &settings);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    std::fs::write(&path, bytes).unwrap();
    let whole = super::super::render(&scene, &settings, &mut |_| true).estimate.mean;
    for (what, change) in changes {
        let mut from = open::<()>(&path).unwrap().read(&scene, &settings).unwrap();
        change(&mut from);
        let ended = resume(&scene, &settings, (from, false), &(), &Stop::new(), (&mut |_| true, &mut ()));
        assert_eq!(ended.estimate.mean == whole, what == "nothing", "{what}");
    }
}

/// Renders to the end of a budget, and then on to that of `spp` samples.
fn extended(scene: &Scene, settings: &Settings, spp: u32) -> Rendering {
    let header = Header::new(scene, settings, ());
    let mut keeper = Keeper::new(&header, usize::MAX);
    let shown = (&mut |_: &_| true, &mut keeper);
    render_shown(scene, settings, GuideIo::default(), &(), &Stop::new(), (shown.0, shown.1));
    let mut more = settings.clone();
    more.render.spp = spp;
    let from = open::<()>(&keeper.written[0]).unwrap().read(scene, &more).unwrap();
    resume(scene, &more, (from, true), &(), &Stop::new(), (&mut |_| true, &mut ()))
}

#[test]
fn more_samples_without_a_guide_are_those_of_a_longer_render() {
    let (scene, settings) = door(&["guiding.method=none"]);
    let long =
        Settings { render: crate::render::RenderSettings { spp: 50, ..settings.render.clone() }, ..settings.clone() };
    let long = render_shown(&scene, &long, GuideIo::default(), &(), &Stop::new(), (&mut |_| true, &mut ()));
    let longer = extended(&scene, &settings, 50);
    assert_eq!((longer.samples, longer.estimate.samples), (50, 50));
    let all = longer.estimate.mean.iter().zip(&long.estimate.mean);
    let furthest =
        all.map(|(a, b)| ((*a - *b).abs() / b.max(crate::math::Rgb::splat(1e-9))).max_element()).fold(0.0, f32::max);
    assert!(furthest < 1e-4, "{furthest}");
}

#[test]
fn more_samples_with_a_guide_are_unbiased() {
    const RENDERS: u64 = 16;
    let set = ["guiding.method=adaptive", "film.width=32", "film.height=18", "render.spp=9"];
    let (scene, settings) = door(&set);
    let light = |rendering: &Rendering| -> f64 {
        let all = &rendering.estimate.mean;
        all.iter().map(|&c| f64::from(crate::math::luminance(c))).sum::<f64>() / all.len() as f64
    };
    let mut settings = settings;
    let mut sums = [[0.0; 2]; 2];
    let mut take = |k: usize, x: f64| sums[k] = [sums[k][0] + x, sums[k][1] + x * x];
    for seed in 0..RENDERS {
        settings.render.seed = 100 + seed;
        let longer = extended(&scene, &settings, 40);
        assert!(longer.samples == 40 && longer.iterations.len() > 3);
        take(0, light(&longer));
        let mut plain = settings.clone();
        (plain.guiding.method, plain.render.spp) = (crate::guiding::settings::GuidingMethod::None, 80);
        let plain = render_shown(&scene, &plain, GuideIo::default(), &(), &Stop::new(), (&mut |_| true, &mut ()));
        take(1, light(&plain));
    }
    let n = RENDERS as f64;
    let [(a, va), (b, vb)] = sums.map(|[sum, squares]| (sum / n, (squares / n - (sum / n).powi(2)) / (n - 1.0)));
    // a false alarm once in 16,000
    let z = (a - b) / (va + vb).sqrt();
    assert!(z.abs() < 4.0, "{a} and {b}: z = {z}");
    assert!((va + vb).sqrt() < 0.05 * b, "the test would not see a bias of a fifth");
}
