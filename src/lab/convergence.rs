//! How near the learnt irradiance comes to a light field that is known in closed form, by visits: one curve for each
//! rule and rate.
//!
//! The field is a closed sphere of radius 1 that glows with 1 and reflects the share a of what it receives: radiance is
//! 1/(1 − a) and irradiance π/(1 − a) everywhere. Without next-event estimation all light comes along the paths, so
//! that all of it is to be learnt.

use crate::Result;
use crate::format;
use crate::guiding::Guide;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, LearningRule, Rate};
use crate::integrator::{IntegratorSettings, Roulette};
use crate::math::{rng::Rng, warp};
use crate::render::{GuideIo, Settings, render_keeping};
use crate::scene::Scene;
use glam::Vec3;
use serde::Serialize;
use std::f64::consts::PI;
use std::path::Path;

/// Points of the sphere where the guide is asked.
const POINTS: u32 = 2000;

/// A rule and a rate.
pub struct Way {
    pub name: &'static str,
    pub rule: LearningRule,
    pub rate: Rate,
}

/// The rates with the rule that most will use, and the other rules with the rate that forgets.
pub const WAYS: [Way; 6] = [
    Way { name: "vanishing rate", rule: LearningRule::ExpectedSarsa, rate: Rate::Vanishing },
    Way { name: "constant rate, 0.1", rule: LearningRule::ExpectedSarsa, rate: Rate::Constant(0.1) },
    Way { name: "forgetting rate, 0.5", rule: LearningRule::ExpectedSarsa, rate: Rate::Forgetting(0.5) },
    Way { name: "Monte Carlo, forgetting", rule: LearningRule::MonteCarlo, rate: Rate::Forgetting(0.5) },
    Way { name: "blend, forgetting", rule: LearningRule::Blend, rate: Rate::Forgetting(0.5) },
    Way { name: "Q-learning, forgetting", rule: LearningRule::QLearning, rate: Rate::Forgetting(0.5) },
];

/// The learnt irradiance over the true one, at points spread evenly over the sphere.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Reported {
    pub mean: f64,
    /// Root mean square of its deviation from 1.
    pub rms: f64,
    /// Share of the points whose state is known well enough to draw from.
    pub known: f64,
}

/// What was learnt after so many samples.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Learnt {
    pub samples: u32,
    /// Visits so far, over the states.
    pub visits_per_state: f64,
    #[serde(flatten)]
    pub reported: Reported,
}

/// The field with the reflectance `albedo`.
pub struct Furnace {
    pub scene: Scene,
    pub settings: Settings,
    albedo: f64,
}

impl Furnace {
    /// `file` is the project's scene `furnace`; the picture has `side` × `side` pixels. A grid of four cells along the
    /// sphere's diameter learns.
    ///
    /// # Errors
    /// Those of reading a scene.
    pub fn load(file: &Path, albedo: f32, side: u32) -> Result<Furnace> {
        let material = format!("material.glow={{type=\"diffuse\",reflectance={albedo},emission=1}}");
        let sides = [format!("film.width={side}"), format!("film.height={side}")];
        let overrides = [sides.to_vec(), vec![material, "integrator.next_event=false".into()]].concat();
        let (description, _) = format::load(file, &overrides)?;
        let (scene, _) = description.load_scene(0)?;
        let integrator = IntegratorSettings { roulette: Roulette::Throughput, ..description.integrator };
        let render = description.render;
        let guiding = GuidingSettings { method: GuidingMethod::Grid, resolution: 4, ..GuidingSettings::default() };
        Ok(Furnace { scene, settings: Settings { integrator, guiding, render }, albedo: albedo.into() })
    }

    /// What the guide says of the field.
    pub fn reported(&self, guide: &Guide) -> Reported {
        let mut rng = Rng::new(1);
        let points = (0..POINTS).map(|_| warp::square_to_uniform_sphere(rng.f32x2()));
        let field = guide.field();
        let known: Vec<f64> = points
            .filter_map(|p: Vec3| field.summary(field.locate(p, -p, [0.5; 3])?.drawn))
            .map(|summary| self.scene.light_unit().value() * f64::from(summary.irradiance) * (1.0 - self.albedo) / PI)
            .collect();
        let mean = |f: &dyn Fn(f64) -> f64| known.iter().map(|&e| f(e)).sum::<f64>() / known.len() as f64;
        let rms = mean(&|e| (e - 1.0).powi(2)).sqrt();
        Reported { mean: mean(&|e| e), rms, known: known.len() as f64 / f64::from(POINTS) }
    }

    /// What is learnt `way` from 1, 3, 7 … up to `most` samples per pixel, iterations doubling, with hemispheres of 6 × 6
    /// strata. Counts at which less than nine points in ten are known are left out.
    pub fn curve(&self, way: &Way, seed: u64, most: u32) -> Vec<Learnt> {
        let mut settings = self.settings.clone();
        settings.guiding = GuidingSettings { table: DirectionTable::Hemisphere, strata: 6, ..settings.guiding };
        (settings.guiding.rule, settings.guiding.rate, settings.guiding.blend_visits) = (way.rule, way.rate, 100.0);
        settings.render.seed = seed;
        let counts = (1..32).map(|k| (1u32 << k) - 1).take_while(|&samples| samples <= most);
        let learnt = counts.filter_map(|samples| self.learnt(&settings, samples));
        learnt.filter(|learnt| learnt.reported.known > 0.9).collect()
    }

    fn learnt(&self, settings: &Settings, samples: u32) -> Option<Learnt> {
        let mut settings = settings.clone();
        settings.render.spp = samples;
        let keeping = GuideIo { from: None, keep: true };
        let rendering = render_keeping(&self.scene, &settings, keeping, &mut |_| true);
        let visits = rendering.total().transitions;
        let guide = rendering.guide?;
        let visits_per_state = visits as f64 / guide.states().max(1) as f64;
        Some(Learnt { samples, visits_per_state, reported: self.reported(&guide) })
    }
}
