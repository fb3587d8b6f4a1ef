//! Renders with samples that are spread evenly: the same picture on average, less noise, and figures of noise that hold.

use super::{Settings, render};
use crate::film::Combine;
use crate::film::accumulate::Film;
use crate::film::tile::Tile;
use crate::format;
use crate::guiding::settings::GuidingMethod;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, SamplerKind, Task};
use crate::math::luminance;
use crate::scene::Scene;
use crate::stats::ztest::z_two_means;
use crate::stats::{ImageMoments, Summary, z_test_images};
use rayon::prelude::*;

const SIDE: u32 = 16;
const PIXELS: usize = (SIDE * SIDE) as usize;
const SPP: u32 = 32;
const SEEDS: u64 = 100;

fn own(name: &str, set: &[&str]) -> (Scene, Settings) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    let (description, _) = format::load(&path, &set).unwrap();
    let (scene, _) = description.load_scene(1).unwrap();
    let (integrator, guiding, render) = (description.integrator, description.guiding, description.render);
    (scene, Settings { integrator, guiding, render })
}

/// A render of `spp` samples in passes of four, with its film.
fn film(scene: &Scene, settings: &Settings, sampler: SamplerKind, seed: u64, spp: u32) -> Film {
    let even = sampler != SamplerKind::Independent;
    let mut film = Film::new(SIDE, SIDE, Combine::All, &[]).of_even_samples(even);
    let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
    let integrator = PathIntegrator { sampler, ..PathIntegrator::plain(scene, &settings.integrator, seed) };
    let mut batch = Batch::new();
    for first_sample in (0..spp).step_by(4) {
        let result = integrator.render(&Task { tile, first_sample, samples: 4 }, &mut batch);
        film.add(&tile, &result.samples);
        film.add_samples(4, false);
    }
    film
}

/// What one render says of a pixel's luminance: its mean, the variance of that by samples and by halves.
#[derive(Clone, Copy)]
struct Said {
    mean: f64,
    by_samples: f64,
    by_halves: f64,
}

fn said(film: &Film) -> Vec<Said> {
    let (estimate, halves) = (film.resolve(), film.sample_variances().unwrap());
    let of = |i: usize| Said {
        mean: f64::from(luminance(estimate.mean[i])),
        by_samples: f64::from(luminance(estimate.variance[i])),
        by_halves: halves[i] / f64::from(estimate.samples),
    };
    (0..PIXELS).map(of).collect()
}

/// Pixels by many seeds each, and their true values from independent samples with their variance.
struct Experiment {
    runs: Vec<Vec<Said>>,
    truth: Vec<Said>,
}

impl Experiment {
    fn new(sampler: SamplerKind) -> Experiment {
        let (scene, settings) = own("cornell.toml", &["film.width=16", "film.height=16"]);
        let truths: Vec<Vec<Said>> = (0..8u64)
            .into_par_iter()
            .map(|k| said(&film(&scene, &settings, SamplerKind::Independent, 1000 + k, 2048)))
            .collect();
        let average = |i: usize, of: fn(&Said) -> f64| truths.iter().map(|truth| of(&truth[i])).sum::<f64>() / 8.0;
        let truth = |i: usize| Said {
            mean: average(i, |s| s.mean),
            by_samples: average(i, |s| s.by_samples) / 8.0,
            by_halves: 0.0,
        };
        let run = |seed| said(&film(&scene, &settings, sampler, seed, SPP));
        Experiment { runs: (0..SEEDS).into_par_iter().map(run).collect(), truth: (0..PIXELS).map(truth).collect() }
    }

    fn summary(&self, pixel: usize) -> Summary {
        Summary::of(&self.runs.iter().map(|run| run[pixel].mean).collect::<Vec<_>>()).unwrap()
    }

    /// What variances of a pixel are relative to: dark ones, which seldom see a light, count no more than it does on average.
    fn square(&self, i: usize) -> f64 {
        let mean = self.truth.iter().map(|truth| truth.mean).sum::<f64>() / PIXELS as f64;
        self.truth[i].mean.powi(2) + mean * mean
    }

    /// Variance of a pixel from seed to seed, relative and on average.
    fn real(&self) -> f64 {
        (0..PIXELS).map(|i| self.summary(i).variance / self.square(i)).sum::<f64>() / PIXELS as f64
    }

    /// What runs say of it, on average.
    fn claimed(&self, of: impl Fn(&Said) -> f64) -> f64 {
        let average = |i: usize| self.runs.iter().map(|run| of(&run[i])).sum::<f64>() / self.runs.len() as f64;
        (0..PIXELS).map(|i| average(i) / self.square(i)).sum::<f64>() / PIXELS as f64
    }

    /// Share of pixels and runs whose interval of 95 % holds the true value, where variances are `factor` times those said.
    fn coverage(&self, factor: f64) -> f64 {
        let holds = |(said, truth): (&Said, &Said)| {
            let error = (factor * said.by_samples + truth.by_samples).sqrt();
            (said.mean - truth.mean).abs() <= 1.96 * error
        };
        let held = self.runs.iter().map(|run| run.iter().zip(&self.truth).filter(|pair| holds(*pair)).count());
        held.sum::<usize>() as f64 / (PIXELS * self.runs.len()) as f64
    }

    /// Whether the mean over the seeds is `scale` times the truth.
    fn z(&self, scale: f64) -> crate::stats::ImageZTest {
        let all: Vec<Summary> = (0..PIXELS).map(|i| self.summary(i)).collect();
        let row = |of: &dyn Fn(usize) -> f64| -> Vec<f32> { (0..PIXELS).map(|i| of(i) as f32).collect() };
        let (mean, variance) = (row(&|i| all[i].mean), row(&|i| all[i].variance / all[i].runs as f64));
        let truth = row(&|i| scale * self.truth[i].mean);
        let own = row(&|i| self.truth[i].by_samples);
        let truth = ImageMoments { mean: &truth, variance: &own };
        z_test_images(ImageMoments { mean: &mean, variance: &variance }, truth, 0.01).unwrap()
    }
}

#[test]
fn even_samples_have_the_same_mean_and_less_noise_and_intervals_hold_the_truth() {
    let [even, independent] = [SamplerKind::Sobol, SamplerKind::Independent].map(Experiment::new);
    for (name, experiment, wrong) in [("even", &even, 1.03), ("independent", &independent, 1.1)] {
        let (z, real) = (experiment.z(1.0), experiment.real());
        let (by_samples, by_halves) = (experiment.claimed(|s| s.by_samples), experiment.claimed(|s| s.by_halves));
        println!(
            "{name}: {z:?}; variance {real:e}, by samples {:.3} times, by halves {:.3}; coverage {:.4}, of a quarter {:.4}",
            by_samples / real,
            by_halves / real,
            experiment.coverage(1.0),
            experiment.coverage(0.25)
        );
        // five standard deviations of a share of 0.99 among 256 pixels, and five of a normal number
        assert!(z.passed > 0.99 - 5.0 * (0.0099f64 / 256.0).sqrt() && z.mean_z.abs() < 5.0, "{name}: {z:?}");
        assert!(experiment.z(wrong).mean_z.abs() > 5.0, "{name}: too dark a picture is seen");
    }
    let (real, independent_real) = (even.real(), independent.real());
    assert!(real < independent_real / 1.5, "{real} and {independent_real}");
    // by samples: right where they are independent, a bound where they are even
    let claimed = independent.claimed(|s| s.by_samples) / independent_real;
    assert!((claimed - 1.0).abs() < 0.1, "{claimed}");
    assert!(even.claimed(|s| s.by_samples) > 1.5 * real);
    let halves = even.claimed(|s| s.by_halves) / real;
    assert!((0.9..1.8).contains(&halves), "{halves} of the variance by halves");
    // few samples are no normal numbers: even where they are independent, 95 % are 92 to 95 %
    let (covered, bounded) = (independent.coverage(1.0), even.coverage(1.0));
    assert!((0.92..0.955).contains(&covered) && bounded > 0.95, "{covered} and {bounded}");
    // too small a variance is seen
    assert!(independent.coverage(0.25) < 0.75 && even.coverage(0.25) < 0.9);
}

#[test]
fn a_guide_that_learns_from_even_samples_renders_the_same_picture() {
    let (scene, settings) = own("door.toml", &["film.width=32", "film.height=18", "render.spp=63"]);
    let runs = |sampler| -> (Summary, f64) {
        let run = |seed: u64| {
            let mut settings = settings.clone();
            (settings.guiding.method, settings.render.seed, settings.render.sampler) =
                (GuidingMethod::Adaptive, seed, sampler);
            let rendering = render(&scene, &settings, &mut |_| true);
            let picture = &rendering.estimate.mean;
            let light = picture.iter().map(|&c| f64::from(luminance(c))).sum::<f64>() / picture.len() as f64;
            (light, rendering.iterations.last().unwrap().usable_states as f64)
        };
        let (light, states): (Vec<f64>, Vec<f64>) = (0..40).map(run).unzip();
        (Summary::of(&light).unwrap(), states.iter().sum::<f64>() / 40.0)
    };
    let (even, even_states) = runs(SamplerKind::Sobol);
    let (independent, states) = runs(SamplerKind::Independent);
    let z = |scale: f64| {
        z_two_means(scale * even.mean, scale * even.std_error(), independent.mean, independent.std_error())
    };
    println!("{even:?} with {even_states} states, {independent:?} with {states}; z {}", z(1.0));
    assert!(z(1.0).abs() < 5.0, "{even:?} and {independent:?}");
    assert!(z(1.1).abs() > 5.0, "ten per cent more light would be seen: {even:?} and {independent:?}");
    // less noise asks for more paths, which visit more states
    assert!((0.9..1.25).contains(&(even_states / states)), "{even_states} states and {states}");
}
