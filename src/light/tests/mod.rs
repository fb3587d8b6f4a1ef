//! Statistical tests compare with |Z| < 5 (false alarms: 6·10⁻⁷ each) or χ² at 10⁻⁶; seeds are fixed.

mod environment;
mod lights;
mod patterns;
mod samples;
mod shadows;
mod sky;
mod tree;

use crate::light::{LightSample, LightSampleContext, LightSampler, Lights};
use crate::math::rng::Rng;
use crate::math::warp::square_to_uniform_sphere;
use glam::Vec3;

const BOTH: [LightSampler; 2] = [LightSampler::Tree, LightSampler::Power];

/// By power.
fn draw(lights: &Lights, p: Vec3, u_choice: f64, u: [f32; 2]) -> Option<LightSample> {
    lights.sample(LightSampler::Power, &LightSampleContext::unoriented(p), u_choice, u)
}

/// The densities of [`draw`].
fn pdf_triangle(lights: &Lights, light: u32, p: Vec3, y: Vec3, weights: [f32; 2]) -> f32 {
    lights.pdf_triangle(LightSampler::Power, &LightSampleContext::unoriented(p), light, y, weights)
}

fn pdf_environment(lights: &Lights, wi: Vec3) -> f32 {
    lights.pdf_environment(LightSampler::Power, &LightSampleContext::unoriented(Vec3::ZERO), wi)
}

/// Mean of samples and the standard error of that mean.
struct Estimate {
    mean: f64,
    error: f64,
}

impl Estimate {
    fn of(n: usize, mut sample: impl FnMut() -> f64) -> Estimate {
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n {
            let x = sample();
            sum += x;
            squares += x * x;
        }
        let mean = sum / n as f64;
        Estimate { mean, error: ((squares / n as f64 - mean * mean).max(0.0) / n as f64).sqrt() }
    }

    fn z(&self, truth: f64) -> f64 {
        (self.mean - truth) / self.error
    }

    /// Agrees with the truth, and is precise enough to tell it from one that is wrong by `control`.
    fn assert_is(&self, truth: f64, control: f64) {
        assert!(self.z(truth).abs() < 5.0, "{} ± {}, not {truth}", self.mean, self.error);
        let wrong = self.z(truth * (1.0 + control)).abs();
        assert!(wrong > 5.0, "{} ± {} cannot tell {truth}", self.mean, self.error);
    }
}

/// ∫ f dω over the sphere, one random point in each of n × 2n equal areas.
fn sphere_integral(n: u32, mut f: impl FnMut(Vec3) -> f64) -> f64 {
    let mut rng = Rng::new(7);
    let mut sum = 0.0;
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let u = [(i as f32 + rng.f32()) / n as f32, (j as f32 + rng.f32()) / (2 * n) as f32];
        sum += f(square_to_uniform_sphere(u));
    }
    sum * 4.0 * std::f64::consts::PI / (2 * n * n) as f64
}
