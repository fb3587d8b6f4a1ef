//! Any number of parts teaches a guide the same, bit for bit, and as much as one render learns from as many samples.

use super::super::part::{Part, Wanted, join, render_part};
use super::super::{GuideIo, Rendering, Settings, Stop, guide_file, part, render_keeping};
use super::{Header, open, teach};
use crate::film::blur::mean_without_largest;
use crate::format;
use crate::guiding::settings::GuidingMethod;
use crate::math::{Rgb, luminance};
use crate::render::guide_file::{GuideFingerprint, LoadedGuide};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

struct Here {
    folder: tempfile::TempDir,
    scene: Scene,
    settings: Settings,
}

impl Here {
    fn new(set: &[&str]) -> Here {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door.toml");
        let (description, _) = format::load(&path, &set).unwrap();
        let (scene, _) = description.load_scene(1).unwrap();
        let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
        Here { folder: tempfile::tempdir().unwrap(), scene, settings: Settings { integrator, guiding, render } }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn subject(&self) -> GuideFingerprint {
        GuideFingerprint::new(self.scene.content_hash_text(), &self.settings.guiding, &self.settings.integrator)
    }

    fn guide(&self, name: &str) -> LoadedGuide {
        guide_file::read(&self.path(name), &self.subject(), &self.settings.guiding, self.scene.bounds()).unwrap()
    }

    /// Renders part `number` of `parts` of an iteration of `spp` samples per pixel into a lesson and a film; returns their names.
    fn part(&self, (number, parts, spp): (u32, u32, u32), guide: Option<&str>, seed: u64) -> [String; 2] {
        let guide = guide.map(|name| self.guide(name));
        let wanted = (Part::of(number, parts, spp).unwrap(), Wanted { film: true, lesson: true });
        let mut settings = self.settings.clone();
        settings.render.seed = seed;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1 + number as usize % 2).build().unwrap();
        let render = || render_part(&self.scene, &settings, guide.as_ref(), wanted, &Stop::new(), &mut |_| true);
        let names = ["lesson", "film"].map(|kind| format!("{number}-{parts}-{spp}-{seed}.{kind}"));
        let [lesson, film] = names.each_ref().map(|name| self.path(name));
        let done = pool.install(render).unwrap();
        done.write(&Header::new(&self.scene, &settings, ()), Some(&film), Some(&lesson)).unwrap();
        names
    }

    fn teach(&self, lessons: &[String], guide: Option<&str>, to: &str) -> Result<(), String> {
        let files = lessons.iter().map(|name| open::<()>(&self.path(name)).unwrap()).collect();
        let guide = guide.map(|name| self.guide(name));
        let taught = teach(&self.scene, &self.settings, guide, files).map_err(|error| error.to_string())?;
        let (subject, view) = (self.subject(), taught.view.as_ref());
        guide_file::write_with_view(&self.path(to), &taught.guide, &subject, taught.paths, view).unwrap();
        Ok(())
    }

    /// Iterations of 1, 2, 4 … samples per pixel, in as many parts as there are, `parts` at most; returns the last guide's name.
    fn learn(&self, iterations: u32, parts: u32, seed: u64) -> String {
        (0..iterations)
            .fold(None, |guide: Option<String>, k| {
                let (spp, from) = (1 << k, guide.as_deref());
                let parts = parts.min(spp);
                let lessons: Vec<String> =
                    (1..=parts).rev().map(|n| self.part((n, parts, spp), from, seed)[0].clone()).collect();
                let to = format!("{parts}-{spp}-{seed}.guide");
                self.teach(&lessons, from, &to).unwrap();
                Some(to)
            })
            .unwrap()
    }
}

#[test]
fn any_number_of_parts_teaches_the_same() {
    let here = Here::new(&["film.width=70", "film.height=40", "guiding.method=adaptive", "guiding.refine_visits=100"]);
    let bytes = |parts| std::fs::read(here.path(&here.learn(4, parts, 0))).unwrap();
    let one = bytes(1);
    assert!(one == bytes(2), "two parts");
    assert!(one == bytes(5), "five parts");
    let guide = here.guide("1-8-0.guide");
    assert!(guide.guide.field().len() > 100 && guide.view.is_some());
    let other = Here::new(&["film.width=70", "film.height=40", "guiding.method=grid", "guiding.table=hemisphere"]);
    let bytes = |parts| std::fs::read(other.path(&other.learn(3, parts, 0))).unwrap();
    assert!(bytes(1) == bytes(4), "a grid of strata");
}

/// What a guide makes of so many pictures, of 8 samples per pixel each.
struct Worth {
    /// Mean luminance of each.
    light: Vec<f64>,
    /// Variance of a sample relative to the pixel, but for the noisiest, times the rays of a path.
    cost: f64,
}

impl Here {
    fn worth(&self, guide: Option<&LoadedGuide>, pictures: u64) -> Worth {
        let wanted = (Part::of(1, 1, 8).unwrap(), Wanted { film: true, lesson: false });
        let pictures: Vec<Rendering> = (100..100 + pictures)
            .map(|seed| {
                let mut settings = self.settings.clone();
                settings.render.seed = seed;
                settings.guiding.method = if guide.is_some() { settings.guiding.method } else { GuidingMethod::None };
                let done = render_part(&self.scene, &settings, guide, wanted.clone(), &Stop::new(), &mut |_| true);
                let film = self.path("film");
                done.unwrap().write(&Header::new(&self.scene, &settings, ()), Some(&film), None).unwrap();
                join(&self.scene, &settings, vec![part::open::<()>(&film).unwrap()], false).unwrap()
            })
            .collect();
        let light = |picture: &Rendering| picture.estimate.mean.iter().map(|c| f64::from(luminance(*c))).sum::<f64>();
        let lights: Vec<f64> = pictures.iter().map(light).collect();
        let pixels = pictures[0].estimate.mean.len();
        let mean = |of: &dyn Fn(&Rendering) -> Rgb| {
            pictures.iter().map(|p| f64::from(luminance(of(p)))).sum::<f64>() / pictures.len() as f64
        };
        let all = lights.iter().sum::<f64>() / (lights.len() * pixels) as f64;
        let relative = (0..pixels).map(|k| {
            let square = mean(&|p| p.estimate.mean[k]).powi(2) + (0.1 * all).powi(2);
            mean(&|p| p.estimate.variance[k]) / square
        });
        let noise = mean_without_largest(relative.collect(), 0.01);
        let counters = &pictures[0].iterations[0].counters;
        Worth { light: lights, cost: noise * counters.rays as f64 / counters.paths as f64 }
    }
}

/// How many standard errors the means of two are apart.
fn z(a: &[f64], b: &[f64]) -> f64 {
    let moments = |x: &[f64]| {
        let (n, mean) = (x.len() as f64, x.iter().sum::<f64>() / x.len() as f64);
        (mean, x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
    };
    let ((a, va), (b, vb)) = (moments(a), moments(b));
    (a - b) / (va + vb).sqrt()
}

/// Two-sided, of a t-distribution with 22 degrees of freedom: a false alarm in 3000 runs with other random numbers. These are always
/// the same, so that what passes once passes always.
const ALARM: f64 = 4.2;

#[test]
fn it_is_worth_what_one_render_learns_from_as_many_samples() {
    let here = Here::new(&[
        "film.width=60",
        "film.height=34",
        "guiding.method=adaptive",
        "guiding.refine_visits=500",
        "render.spp=31",
    ]);
    let shared = here.guide(&here.learn(5, 3, 0));
    let alone = render_keeping(&here.scene, &here.settings, GuideIo { from: None, keep: true }, &mut |_| true);
    guide_file::write(&here.path("alone"), alone.guide.as_ref().unwrap(), &here.subject(), 1).unwrap();
    // without the view, as that of a single render has none
    let [shared, alone, none] = [Some(LoadedGuide { view: None, ..shared }), Some(here.guide("alone")), None]
        .map(|guide| here.worth(guide.as_ref(), 12));
    eprintln!("variance times rays: shared {}, alone {}, no guide {}", shared.cost, alone.cost, none.cost);
    // so short a training makes a guide worth a tenth: less than half of that may lie between the two
    assert!(shared.cost < 1.04 * alone.cost, "{} {}", shared.cost, alone.cost);
    assert!(shared.cost < 0.96 * none.cost, "{} {}", shared.cost, none.cost);
    let found = z(&shared.light, &alone.light);
    assert!(found.abs() < ALARM, "{found}");
    let brighter: Vec<f64> = shared.light.iter().map(|light| 1.2 * light).collect();
    assert!(z(&brighter, &alone.light).abs() > ALARM, "a fifth too bright would not be found");
    eprintln!("z {found} {}", z(&shared.light, &none.light));
    assert!(z(&shared.light, &none.light).abs() < ALARM);
}

#[test]
fn roulette_that_knows_the_picture_pays() {
    let here = Here::new(&["film.width=60", "film.height=34", "guiding.method=adaptive", "guiding.refine_visits=500"]);
    let name = here.learn(5, 2, 0);
    let [with, without] =
        [here.guide(&name), LoadedGuide { view: None, ..here.guide(&name) }].map(|guide| here.worth(Some(&guide), 12));
    eprintln!("variance times rays: {} with the view, {} without", with.cost, without.cost);
    assert!(with.cost < without.cost, "{} {}", with.cost, without.cost);
    assert!(z(&with.light, &without.light).abs() < ALARM);
}

#[test]
fn lessons_that_make_no_whole_are_refused() {
    let here = Here::new(&["film.width=20", "film.height=12", "guiding.method=adaptive"]);
    let lesson = |part, guide: Option<&str>, seed| here.part(part, guide, seed)[0].clone();
    let first = lesson((1, 1, 1), None, 0);
    here.teach(std::slice::from_ref(&first), None, "first").unwrap();
    let halves = [lesson((1, 2, 4), Some("first"), 0), lesson((2, 2, 4), Some("first"), 0)];
    let said = |names: &[&String], guide: Option<&str>| {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        here.teach(&names, guide, "x").err().unwrap_or_default()
    };
    let [a, b] = [&halves[0], &halves[1]];
    let has = |names: &[&String], guide: Option<&str>, text: &str| {
        assert!(said(names, guide).contains(text), "{names:?}: {}", said(names, guide));
    };
    has(&[a], Some("first"), "samples 2 to 3 after it are in no file");
    has(&[a, b, b], Some("first"), "its samples 2 to 3 are in");
    has(&[a, b], None, "--guide-in has to give that");
    has(&[&first], Some("first"), "it was learnt without a guide");
    here.teach(&halves, Some("first"), "second").unwrap();
    has(&[a, b], Some("second"), "it was learnt with another guide");
    has(&[a, &lesson((2, 2, 4), Some("first"), 7)], Some("first"), "it has another seed");
    let elsewhere = Here { folder: here.folder, ..Here::new(&["film.width=20", "film.height=12", "camera.vfov=50"]) };
    let error = elsewhere.teach(std::slice::from_ref(&first), None, "x").err().unwrap();
    assert!(error.contains("another scene"), "{error}");
    let bytes = std::fs::read(elsewhere.path(&first)).unwrap();
    for (length, text) in [(bytes.len() - 5, "truncated"), (10, "truncated"), (0, "this is no lesson")] {
        std::fs::write(elsewhere.path("short"), &bytes[..length]).unwrap();
        let error = open::<()>(&elsewhere.path("short")).err().unwrap().to_string();
        assert!(error.contains(text), "{error}");
    }
    let film = elsewhere.path("1-1-1-0.film");
    assert!(open::<()>(&film).err().unwrap().to_string().contains("this is no lesson"));
}
