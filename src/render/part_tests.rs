//! Parts of a render make the same picture, however many there are.

use super::super::{GuideIo, Rendering, Settings, Stop, guide_file, render, render_keeping};
use super::{Done, Header, Part, Wanted, join, join_films, open, render_part};
use crate::format;
use crate::render::guide_file::{GuideFingerprint, LoadedGuide};
use crate::scene::Scene;
use std::path::Path;

fn door(set: &[&str]) -> (Scene, Settings) {
    let small =
        ["film.width=70", "film.height=40", "render.layers=[\"direct\", \"P\", \"cryptomatte\"]", "render.spp=37"];
    let set: Vec<String> = small.iter().chain(set).map(ToString::to_string).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// Renders so many parts, on so many threads, into files of a folder.
fn files(
    folder: &Path,
    (scene, settings): (&Scene, &Settings),
    guide: Option<&LoadedGuide>,
    parts: u32,
    threads: usize,
) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    for number in 1..=parts {
        let part = Part::of(number, parts, settings.render.spp).unwrap();
        let done = pool.install(|| render_part(scene, settings, guide, (part, FILM), &Stop::new(), &mut |_| true));
        write(done, &folder.join(format!("{number}-{parts}")), scene, settings);
    }
}

const FILM: Wanted = Wanted { film: true, lesson: false };

fn write(done: Option<Done>, path: &Path, scene: &Scene, settings: &Settings) {
    done.unwrap().write(&Header::new(scene, settings, ()), Some(path), None).unwrap();
}

fn joined(folder: &Path, names: &[&str], scene: &Scene, settings: &Settings) -> Result<Rendering, String> {
    let files = names.iter().map(|name| open::<()>(&folder.join(name)).unwrap()).collect();
    join(scene, settings, files, false).map_err(|error| error.to_string())
}

fn assert_same(a: &Rendering, b: &Rendering) {
    let (a, b) = (&a.estimate, &b.estimate);
    assert!(a.mean == b.mean && a.variance == b.variance && a.layers == b.layers && a.samples == b.samples);
    let positions = |e: &crate::film::accumulate::Estimate| -> Vec<_> {
        e.features.iter().map(|f| (f.mean_position(), f.mean_depth(), f.albedo, f.normal)).collect()
    };
    assert!(positions(a) == positions(b));
    assert!(a.ids.counts == b.ids.counts && a.ids.samples == b.ids.samples && !a.ids.counts.is_empty());
}

#[test]
fn any_number_of_parts_makes_the_picture_of_one_render() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, settings) = door(&["guiding.method=none"]);
    let both = (&scene, &settings);
    files(folder.path(), both, None, 1, 2);
    files(folder.path(), both, None, 3, 1);
    files(folder.path(), both, None, 5, 2);
    let one = joined(folder.path(), &["1-1"], &scene, &settings).unwrap();
    assert_same(&one, &joined(folder.path(), &["2-3", "3-3", "1-3"], &scene, &settings).unwrap());
    assert_same(&one, &joined(folder.path(), &["1-5", "2-5", "3-5", "4-5", "5-5"], &scene, &settings).unwrap());
    // the samples are those that a render takes that is not shared
    let whole = render(&scene, &settings, &mut |_| true).estimate;
    for (i, (a, b)) in one.estimate.mean.iter().zip(&whole.mean).enumerate() {
        assert!((*a - *b).abs().max_element() <= 1e-4 * b.max_element() + 1e-9, "pixel {i}: {a} and {b}");
    }
    let depth = |e: &crate::film::accumulate::Estimate| e.features.iter().map(|f| f.depth).sum::<f32>();
    assert!((depth(&one.estimate) / depth(&whole) - 1.0).abs() < 1e-4);
    // those are of the first 32 samples, and here of all tasks that begin with one of them
    let shares = |e: &crate::film::accumulate::Estimate, pixel: usize| -> Vec<std::collections::BTreeMap<u32, f64>> {
        let share = |(id, count): (u32, u16)| (id, f64::from(count) / f64::from(e.ids.samples[pixel]));
        e.ids.counts[pixel].iter().map(|counts| counts.iter().map(share).collect()).collect()
    };
    let mut mixed = 0;
    for pixel in 0..whole.mean.len() {
        for (own, other) in shares(&one.estimate, pixel).iter().zip(shares(&whole, pixel)) {
            mixed += usize::from(own.len() > 1);
            let differs = |(id, share): (&u32, &f64)| (other.get(id).unwrap_or(&0.0) - share).abs() > 0.15;
            assert!(!own.iter().any(differs), "pixel {pixel}: {own:?} and {other:?}");
        }
    }
    assert!(mixed > 0, "each pixel shows one thing alone");
}

#[test]
fn with_a_guide_from_before_too() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, settings) = door(&["guiding.method=adaptive", "render.spp=12"]);
    let learnt = render_keeping(&scene, &settings, GuideIo { from: None, keep: true }, &mut |_| true);
    let subject = GuideFingerprint::new(scene.content_hash_text(), &settings.guiding, &settings.integrator);
    let path = folder.path().join("guide");
    guide_file::write(&path, learnt.guide.as_ref().unwrap(), &subject, learnt.learnt_paths).unwrap();
    let guide = guide_file::read(&path, &subject, &settings.guiding, scene.bounds()).unwrap();
    files(folder.path(), (&scene, &settings), Some(&guide), 1, 2);
    files(folder.path(), (&scene, &settings), Some(&guide), 2, 2);
    let one = joined(folder.path(), &["1-1"], &scene, &settings).unwrap();
    assert!(one.iterations[0].counters.guide_hits > 0);
    assert_same(&one, &joined(folder.path(), &["1-2", "2-2"], &scene, &settings).unwrap());
    files(folder.path(), (&scene, &settings), None, 3, 2);
    let said = joined(folder.path(), &["1-2", "3-3"], &scene, &settings).err().unwrap();
    assert!(said.contains("another guide"), "{said}");
}

#[test]
fn parts_that_make_no_whole_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, settings) = door(&["guiding.method=none", "render.spp=8"]);
    files(folder.path(), (&scene, &settings), None, 4, 2);
    files(folder.path(), (&scene, &settings), None, 2, 2);
    let said = |names: &[&str], scene: &Scene, settings: &Settings| joined(folder.path(), names, scene, settings).err();
    let has = |names: &[&str], text: &str| {
        let error = said(names, &scene, &settings).unwrap_or_default();
        assert!(error.contains(text), "{names:?}: {error}");
    };
    has(&["1-2", "2-4", "4-4", "3-4"], "its samples 2 to 3 are in");
    has(&["1-2", "2-2", "2-2"], "its samples 4 to 7 are in");
    has(&["1-4", "3-4", "4-4"], "samples 2 to 3 before it are in no file");
    has(&["2-2"], "samples 0 to 3 before it are in no file");
    has(&["1-2", "3-4"], "samples 6 to 7 after it are in no file");
    assert!(said(&["1-2", "3-4", "4-4"], &scene, &settings).is_none());
    let (elsewhere, _) = door(&["camera.origin=[0.1, 1, 1]"]);
    assert!(said(&["1-2", "2-2"], &elsewhere, &settings).unwrap().contains("of another scene"));
    let (_, changed) = door(&["guiding.method=none", "integrator.max_depth=3"]);
    assert!(said(&["1-2", "2-2"], &scene, &changed).unwrap().contains("of other settings"));
    let mut other = settings.clone();
    other.render.seed = 5;
    let part = |spp| (Part::of(2, 2, spp).unwrap(), FILM);
    let film = render_part(&scene, &other, None, part(8), &Stop::new(), &mut |_| true);
    write(film, &folder.path().join("seed"), &scene, &other);
    has(&["1-2", "seed"], "it has another seed");
    let film = render_part(&scene, &settings, None, part(9), &Stop::new(), &mut |_| true);
    write(film, &folder.path().join("nine"), &scene, &settings);
    has(&["1-2", "nine"], "more or fewer samples");
    let bytes = std::fs::read(folder.path().join("1-2")).unwrap();
    std::fs::write(folder.path().join("short"), &bytes[..bytes.len() - 9]).unwrap();
    assert!(open::<()>(&folder.path().join("short")).err().unwrap().to_string().contains("truncated"));
}

#[test]
fn parts_are_as_equal_as_can_be_and_none_is_empty() {
    let all: Vec<_> = (1..=3).map(|k| Part::of(k, 3, 10).unwrap().samples).collect();
    assert_eq!(all, [0..3, 3..6, 6..10]);
    assert!(Part::of(0, 3, 10).is_none() && Part::of(4, 3, 10).is_none() && Part::of(1, 3, 2).is_none());
    assert_eq!(Part::of(u32::MAX, u32::MAX, u32::MAX).unwrap().samples, u32::MAX - 1..u32::MAX);
}

#[test]
fn a_part_that_is_stopped_is_no_part() {
    let (scene, settings) = door(&["guiding.method=none"]);
    let part = || (Part::of(1, 2, 8).unwrap(), FILM);
    assert!(render_part(&scene, &settings, None, part(), &Stop::new(), &mut |_| false).is_none());
    let stop = Stop::new();
    stop.insist();
    assert!(render_part(&scene, &settings, None, part(), &stop, &mut |_| true).is_none());
}

#[test]
fn films_that_are_there_make_a_picture_of_their_samples() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, settings) = door(&["guiding.method=none", "render.spp=80"]);
    files(folder.path(), (&scene, &settings), None, 4, 2);
    let some = |names: &[&str]| {
        let files = names.iter().map(|name| open::<()>(&folder.path().join(name)).unwrap()).collect();
        join(&scene, &settings, files, true).map_err(|error| error.to_string())
    };
    let all = some(&["1-4", "2-4", "3-4", "4-4"]).unwrap();
    assert_same(&all, &joined(folder.path(), &["1-4", "2-4", "3-4", "4-4"], &scene, &settings).unwrap());
    let (outer, inner) = (some(&["1-4", "4-4"]).unwrap().estimate, some(&["2-4", "3-4"]).unwrap().estimate);
    assert_eq!((outer.samples, inner.samples), (40, 40));
    for (i, whole) in all.estimate.mean.iter().enumerate() {
        let mean = 0.5 * (outer.mean[i] + inner.mean[i]);
        assert!((mean - *whole).abs().max_element() <= 1e-5 * whole.max_element() + 1e-12, "pixel {i}: {mean} {whole}");
    }
    // features are of samples 0 to 31: 20 of them in the first film, the others in the second
    let depths = [&outer, &inner, &all.estimate].map(|e| e.features.iter().map(|f| f.depth).sum::<f32>());
    assert!((depths[0] / depths[2] - 1.0).abs() < 0.1 && (depths[1] / depths[2] - 1.0).abs() < 0.1, "{depths:?}");
    assert!(some(&["1-4", "1-4"]).err().unwrap().contains("its samples 0 to 19 are in"));
}

#[test]
fn films_of_films_make_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, settings) = door(&["guiding.method=none", "render.spp=10"]);
    files(folder.path(), (&scene, &settings), None, 5, 2);
    let films = |names: &[&str], to: &str| {
        let files = names.iter().map(|name| open::<()>(&folder.path().join(name)).unwrap()).collect();
        let (header, done) = join_films(&scene, &settings, files).map_err(|error| error.to_string())?;
        done.write(&header, Some(&folder.path().join(to)), None).map_err(|error| error.to_string())
    };
    films(&["2-5", "3-5"], "inner").unwrap();
    films(&["inner", "1-5"], "first").unwrap();
    films(&["5-5", "4-5"], "last").unwrap();
    let whole = joined(folder.path(), &["1-5", "2-5", "3-5", "4-5", "5-5"], &scene, &settings).unwrap();
    let tree = joined(folder.path(), &["last", "first"], &scene, &settings).unwrap();
    assert_same(&tree, &whole);
    assert_eq!(tree.total().paths, whole.total().paths);
    let refused = |names: &[&str]| films(names, "no").unwrap_err();
    assert!(refused(&["1-5", "3-5"]).contains("samples 2 to 3 before it are in no file"));
    assert!(refused(&["first", "3-5"]).contains("its samples 4 to 5 are in"));
    assert!(!folder.path().join("no").exists());
}
