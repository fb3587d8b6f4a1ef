//! Guides in files: what comes back is what was written, and what is no guide is an error.

use glam::Vec3;
use phototaxis::format;
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings};
use phototaxis::guiding::{Guide, Hue, PackedDirection, Recorder, ShadowOutcome, Transition};
use phototaxis::image::Image;
use phototaxis::image::metrics::compare;
use phototaxis::integrator::IntegratorSettings;
use phototaxis::math::rng::Rng;
use phototaxis::math::warp;
use phototaxis::render::guide_file::{self, GuideFingerprint, LoadedGuide};
use phototaxis::render::{GuideIo, Rendering, Settings, render_keeping};
use phototaxis::scene::Scene;
use std::path::Path;

const BOUNDS: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ONE);

fn kinds() -> Vec<GuidingSettings> {
    let methods = [GuidingMethod::Grid, GuidingMethod::Adaptive, GuidingMethod::Voronoi];
    let tables = [DirectionTable::Tree, DirectionTable::Hemisphere, DirectionTable::Sphere];
    let bounds =
        GuidingSettings { resolution: 4, refine_visits: 50.0, sites: 64, leaf_samples: 1000.0, ..Default::default() };
    let settings = |method, table| GuidingSettings { method, table, ..bounds.clone() };
    let tables = methods.into_iter().flat_map(|method| tables.map(|table| settings(method, table)));
    tables.chain([settings(GuidingMethod::SdTree, DirectionTable::Tree)]).collect()
}

fn subject(settings: &GuidingSettings) -> GuideFingerprint {
    GuideFingerprint::new("a scene".into(), settings, &IntegratorSettings::default())
}

/// Camera paths of an iteration: 1 sample per pixel of the pictures that the SD-tree's threshold is meant for.
const PATHS: u64 = 1280 * 720;

/// Uniform on the sphere.
fn unit(rng: &mut Rng) -> Vec3 {
    warp::square_to_uniform_sphere(rng.f32x2())
}

/// A point on the floor, which the light of [`teach`] falls on.
fn place(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.f32(), 0.5, rng.f32())
}

/// Visits on a floor under light that changes from place to place.
fn teach(guide: &mut Guide, visits: usize, rng: &mut Rng) {
    let mut recorder = Recorder::new();
    for _ in 0..visits {
        let (p, wi) = (place(rng), unit(rng));
        let wi = if wi.y < 0.0 { -wi } else { wi };
        let jitter = [rng.f32(), rng.f32(), 0.5];
        let Some(at) = guide.field().locate(p, Vec3::Y, jitter) else {
            recorder.push_point(p, Vec3::Y);
            continue;
        };
        let target = (8.0 * wi.dot(p)).max(0.0).exp() * rng.f32();
        recorder.push(Transition {
            key: at.recorded,
            wi: PackedDirection::new(wi),
            normal: PackedDirection::new(Vec3::Y),
            target,
            bootstrapped: target,
            pdf: 0.2,
            bsdf_pdf: 0.3,
            guide_pdf: 0.1,
            scattered: 0.3,
            hue: Hue::GREY,
            rays: 2,
            shadow: ShadowOutcome::NONE,
        });
    }
    guide.learn(&[&recorder]);
}

fn learnt(settings: &GuidingSettings) -> Guide {
    let mut guide = Guide::new(settings, BOUNDS, std::iter::empty()).unwrap();
    let mut rng = Rng::new(1);
    for _ in 0..3 {
        teach(&mut guide, 20_000, &mut rng);
        guide.end_iteration(PATHS);
    }
    guide
}

/// All that sampling can see of a guide, in bits.
fn seen(guide: &Guide) -> Vec<Option<Vec<u32>>> {
    let (mut rng, field) = (Rng::new(2), guide.field());
    let mut one = || {
        let summary = field.summary(field.locate(place(&mut rng), Vec3::Y, [0.5; 3])?.drawn)?;
        let distribution = field.distribution(summary, Vec3::Y);
        let known = [summary.irradiance, summary.peak, summary.visits, summary.bsdf_fraction];
        let densities = (0..20).map(|_| distribution.pdf(unit(&mut rng)));
        let drawn: Vec<Vec3> = (0..5).map(|k| distribution.sample(0.2 * k as f64, [0.3; 2]).0).collect();
        let drawn = drawn.iter().flat_map(|w| w.to_array());
        Some(known.into_iter().chain(densities.collect::<Vec<_>>()).chain(drawn).map(f32::to_bits).collect())
    };
    (0..500).map(|_| one()).collect()
}

fn read(path: &Path, settings: &GuidingSettings) -> phototaxis::Result<LoadedGuide> {
    guide_file::read(path, &subject(settings), settings, BOUNDS)
}

#[test]
fn what_was_learnt_comes_back_and_goes_on_alike() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.guide");
    for settings in kinds() {
        let mut before = learnt(&settings);
        guide_file::write(&path, &before, &subject(&settings), 77).unwrap();
        let LoadedGuide { guide: mut after, paths, .. } = read(&path, &settings).unwrap();
        assert_eq!((paths, before.stats()), (77, after.stats()));
        assert!(seen(&before).iter().flatten().count() > 400, "the guide knows most of the floor");
        assert!(seen(&before) == seen(&after), "{:?}, {:?}", settings.method, settings.table);
        for guide in [&mut before, &mut after] {
            teach(guide, 20_000, &mut Rng::new(3));
            guide.end_iteration(PATHS);
        }
        assert!(seen(&before) == seen(&after), "having learnt more: {:?}, {:?}", settings.method, settings.table);
    }
}

#[test]
fn a_fresh_guide_is_not_a_learnt_one() {
    let settings = &kinds()[0];
    assert!(seen(&Guide::new(settings, BOUNDS, std::iter::empty()).unwrap()) != seen(&learnt(settings)));
}

/// Files of every damage: each byte flipped, cut off at each length, something appended.
#[test]
fn no_damage_goes_unnoticed_or_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.guide");
    let settings = GuidingSettings { resolution: 1, levels: 0, ..GuidingSettings::default() };
    let mut guide = Guide::new(&settings, BOUNDS, std::iter::empty()).unwrap();
    teach(&mut guide, 100, &mut Rng::new(1));
    guide.end_iteration(PATHS);
    guide_file::write(&path, &guide, &subject(&settings), 1).unwrap();
    let whole = std::fs::read(&path).unwrap();
    assert!(read(&path, &settings).is_ok() && whole.len() < 20_000, "{} bytes", whole.len());
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read(&path, &settings).is_err()
    };
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        assert!(refused(&bytes), "byte {at} flipped");
        assert!(refused(&whole[..at]), "cut off after {at} bytes");
    }
    assert!(refused(&[&whole[..], &[0]].concat()), "a byte appended");
}

/// The same with a checksum that is right: then what is read is a guide, or an error, and no panic.
#[test]
fn forged_files_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.guide");
    for settings in kinds() {
        let settings = GuidingSettings { resolution: 2, strata: 3, sites: 8, ..settings };
        let mut guide = Guide::new(&settings, BOUNDS, std::iter::empty()).unwrap();
        teach(&mut guide, 400, &mut Rng::new(1));
        guide.end_iteration(PATHS);
        guide_file::write(&path, &guide, &subject(&settings), 1).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let mut rng = Rng::new(4);
        let mut refused = 0;
        for _ in 0..2000 {
            let mut bytes = whole.clone();
            let at = 20 + rng.next_u32() as usize % (whole.len() - 24);
            bytes[at] = rng.next_u32() as u8;
            let end = whole.len() - 4;
            let sum = crc32fast::hash(&bytes[..end]);
            bytes[end..].copy_from_slice(&sum.to_le_bytes());
            std::fs::write(&path, &bytes).unwrap();
            match read(&path, &settings) {
                Ok(LoadedGuide { mut guide, .. }) => {
                    teach(&mut guide, 50, &mut rng);
                    guide.end_iteration(PATHS);
                    guide.stats();
                }
                Err(_) => refused += 1,
            }
        }
        assert!(refused > 20, "only {refused} of 2000 forgeries were refused");
    }
}

/// The format is not to change unnoticed: whoever changes what is stored raises the version, and this number.
#[test]
fn the_format_is_that_of_version_9() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.guide");
    let settings = GuidingSettings { resolution: 1, ..GuidingSettings::default() };
    let mut guide = Guide::new(&settings, BOUNDS, std::iter::empty()).unwrap();
    let mut recorder = Recorder::new();
    let (wi, key) = (PackedDirection::new(Vec3::Y), guide.field().locate(Vec3::ONE, Vec3::Y, [0.5; 3]).unwrap().drawn);
    let (pdf, bsdf_pdf, guide_pdf) = (0.5, 0.5, -1.0);
    let (target, scattered, hue, shadow) = (2.0, 0.5, Hue::GREY, ShadowOutcome::new(2.5, true));
    recorder.push(Transition {
        key,
        wi,
        normal: wi,
        target,
        bootstrapped: target,
        hue,
        pdf,
        bsdf_pdf,
        guide_pdf,
        scattered,
        rays: 1,
        shadow,
    });
    guide.learn(&[&recorder]);
    guide_file::write(&path, &guide, &subject(&settings), 300).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes[..12], *b"PTXGUIDE\x09\0\0\0");
    assert_eq!((bytes.len(), crc32fast::hash(&bytes[..bytes.len() - 4])), (498, 2_568_941_673));
}

fn scene(overrides: &[&str]) -> (Scene, Settings, GuideFingerprint) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
    let tiny = ["film.width=64", "film.height=36", "guiding.method=adaptive", "guiding.resolution=8"];
    let overrides: Vec<String> = tiny.iter().chain(overrides).map(ToString::to_string).collect();
    let (description, _) = format::load(&path, &overrides).unwrap();
    let (scene, _) = description.load_scene(0).unwrap();
    let settings =
        Settings { integrator: description.integrator, guiding: description.guiding, render: description.render };
    let subject = GuideFingerprint::new(scene.content_hash_text(), &settings.guiding, &settings.integrator);
    (scene, settings, subject)
}

fn rendered(
    (scene, settings, _): &(Scene, Settings, GuideFingerprint),
    from: Option<LoadedGuide>,
    keep: bool,
) -> Rendering {
    render_keeping(scene, settings, GuideIo { from, keep }, &mut |_| true)
}

/// relMSE without the worst 0.1 % of the pixels, the mean over four seeds of 16 samples per pixel.
fn error(scene: &(Scene, Settings, GuideFingerprint), guide: Option<&Path>, reference: &Image) -> f64 {
    let one = |seed: u64| {
        let mut settings = scene.1.clone();
        settings.render.seed = seed;
        let from = guide.map(|path| guide_file::read(path, &scene.2, &settings.guiding, scene.0.bounds()).unwrap());
        let keeping = GuideIo { from, keep: false };
        picture(&render_keeping(&scene.0, &settings, keeping, &mut |_| true))
    };
    (1..=4).map(|seed| compare(&one(seed), reference).unwrap().relmse_trimmed).sum::<f64>() / 4.0
}

fn picture(rendering: &Rendering) -> Image {
    let estimate = &rendering.estimate;
    Image { width: estimate.width as usize, height: estimate.height as usize, data: estimate.mean.clone() }
}

/// With the guide of 256 samples per pixel, 16 samples are nearer to the truth than with what they learn themselves; for
/// the camera that taught it, and for another.
#[test]
fn a_trained_guide_has_a_lower_error_at_equal_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.guide");
    // guided roulette waits for a picture: without one a first iteration casts fewer rays for its samples
    let roulette = "integrator.roulette=throughput";
    let long = scene(&["render.spp=256", roulette]);
    let taught = rendered(&long, None, true);
    guide_file::write(&path, taught.guide.as_ref().unwrap(), &long.2, taught.learnt_paths).unwrap();
    for camera in ["camera.vfov=40", "camera.origin=[1.2, 1.3, 3.6]"] {
        let truth = scene(&["render.spp=1024", "render.seed=9", camera, roulette]);
        let reference = picture(&rendered(&truth, None, false));
        let short = scene(&["render.spp=16", camera, roulette]);
        let (with, without) = (error(&short, Some(&path), &reference), error(&short, None, &reference));
        assert!(with < 0.8 * without, "{camera}: {with} with a trained guide, {without} without");
    }
}
