//! A directional model that is in no list: one lobe over the sphere and an even rest, fitted by moments.

use crate::guiding::directional::{
    DirectionalModel, Directions, Evaluator, InFrame, Normals, PROFILE, SamplingOptions, Totals, WORLD,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::Rate;
use crate::math::Frame;
use crate::simd::{LANES, Vec3Lanes};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f32::consts::{PI, TAU};
use std::ops::Range;

/// Share of the directions that are drawn evenly.
const EVEN: f32 = 0.2;

#[derive(Clone)]
pub struct OneLobe;

/// Sums over samples of their weights, and of their directions times these.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    weight: f32,
    direction: Vec3,
    samples: f32,
}

/// A von Mises–Fisher lobe.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    axis: Vec3,
    sharpness: f32,
}

impl DirectionalModel for OneLobe {
    type Learnt = Sums;
    type Located = [Vec3; LANES];
    type Frozen = Lobe;
    type Pool = Vec<Lobe>;
    type Directions<'f> = Lobe;

    fn untrained(&self) -> Sums {
        Sums::default()
    }

    fn locate(&self, _about: &Vec3Lanes, wi: &Vec3Lanes) -> [Vec3; LANES] {
        std::array::from_fn(|k| wi.get(k))
    }

    fn record(&self, learnt: &mut Sums, at: &[Vec3; LANES], k: usize, transition: &Transition, _rate: Rate) {
        let weight = transition.target / transition.pdf;
        learnt.weight += weight;
        learnt.direction += weight * at[k];
        learnt.samples += 1.0;
    }

    fn decay(&self, learnt: &mut Sums, share: f32) {
        *learnt = Sums {
            weight: learnt.weight * share,
            direction: learnt.direction * share,
            samples: learnt.samples * share,
        };
    }

    fn is_informed(&self, learnt: &Sums) -> bool {
        learnt.weight > 0.0
    }

    fn profile(&self, learnt: &Sums) -> [f32; PROFILE] {
        std::array::from_fn(|k| if k < 3 { learnt.weight + learnt.direction[k] } else { 0.0 } / learnt.samples.max(1.0))
    }

    fn freeze(&self, learnt: &Sums, _options: &SamplingOptions, _fraction: f32) -> (Lobe, Totals) {
        let r = (learnt.direction.length() / learnt.weight).min(0.999);
        let axis = learnt.direction.normalize_or(Vec3::Z);
        let mean = learnt.weight / (4.0 * PI * learnt.samples);
        (
            Lobe { axis, sharpness: (r * (3.0 - r * r) / (1.0 - r * r)).max(0.01) },
            Totals { irradiance: PI * mean, peak: mean },
        )
    }

    fn append(&self, frozen: Lobe, pool: &mut Vec<Lobe>) -> Range<u32> {
        pool.push(frozen);
        pool.len() as u32 - 1..pool.len() as u32
    }

    fn directions<'f>(
        &'f self,
        pool: &'f Vec<Lobe>,
        range: Range<usize>,
        _normals: Normals,
        _options: &SamplingOptions,
    ) -> InFrame<Lobe> {
        InFrame { frame: WORLD, directions: pool[range.start] }
    }

    fn evaluator<'l>(&'l self, _learnt: &'l Sums, _smoothing: f32) -> Evaluator<'l> {
        Box::new(|_, _| None)
    }

    fn bytes(&self, _learnt: &Sums) -> usize {
        size_of::<Lobe>()
    }

    fn usual_bytes(&self) -> usize {
        size_of::<Lobe>()
    }

    fn pool_bytes(&self, pool: &Vec<Lobe>) -> usize {
        size_of_val(&pool[..])
    }

    fn is_sound(&self, learnt: &Sums) -> bool {
        learnt.weight.is_finite() && learnt.direction.is_finite() && learnt.samples >= 0.0
    }
}

impl Directions for Lobe {
    fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let cos = if (u as f32) < EVEN {
            2.0 * inside[0] - 1.0
        } else {
            1.0 + (inside[0] + (1.0 - inside[0]) * (-2.0 * self.sharpness).exp()).ln() / self.sharpness
        };
        let (sin, (s, c)) = ((1.0 - cos * cos).max(0.0).sqrt(), (TAU * inside[1]).sin_cos());
        let w = Frame::from_normal(self.axis).to_world(Vec3::new(sin * c, sin * s, cos.clamp(-1.0, 1.0)));
        (w, self.pdf(w))
    }

    fn pdf(&self, w: Vec3) -> f32 {
        let norm = self.sharpness / (TAU * (1.0 - (-2.0 * self.sharpness).exp()));
        EVEN / (4.0 * PI) + (1.0 - EVEN) * norm * (self.sharpness * (w.dot(self.axis) - 1.0)).exp()
    }

    fn times(&self, _value: impl Fn(Vec3) -> f32) -> Lobe {
        *self
    }
}
