//! Radiance that arrives at a point, as the guide has learnt it and as it is.

use super::PixelVertex;
use crate::geometry::Ray;
use crate::guiding::{Guide, StateView};
use crate::integrator::mixture::{GuidedBy, GuidedLobes, Mixture, glossy_product};
use crate::integrator::path::Start;
use crate::integrator::sampler::PathKey;
use crate::integrator::{Batch, IntegratorSettings, PathIntegrator};
use crate::math::Frame;
use crate::math::{luminance, rng::Rng, warp};
use crate::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::f32::consts::TAU;

/// Bins along the side of the hemisphere's square, as many as a tree of directions has cells at its finest.
const SIDE: u32 = 64;

/// Luminance of incident radiance over the hemisphere of a state, in bins of equal solid angle; in W/(sr·m²), whatever the
/// scene's own unit of light.
///
/// Learnt and traced are one quantity: what next-event estimation at the point does not find. That is all light from
/// surfaces that reflect, and of emission the share that multiple importance sampling gives to directions drawn from the
/// mixture of BSDF and guide (all of it where next-event estimation is off). The traced one uses no guide for its paths,
/// and for the weights the guide as it now is.
pub(crate) struct Radiance {
    pub(crate) frame: Frame,
    bins: Vec<Bin>,
    samples: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    /// Mean of Q.
    learnt: f64,
    traced: f64,
    /// Squared standard error of `traced`.
    variance: f64,
    /// Whether light can arrive from there.
    open: bool,
}

/// How far the learnt radiance is from the traced one. All values are `None` where nothing is traced but darkness, or
/// the guide knows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// Pearson's, over the bins.
    pub(crate) correlation: Option<f64>,
    /// Σ |learnt − traced| / Σ traced.
    pub(crate) relative_error: Option<f64>,
    /// Σ standard error of traced / Σ traced: the part of the relative error that is noise of the truth.
    pub(crate) truth_noise: Option<f64>,
    /// ∫ Q cosθ dω, W/m² of luminance.
    pub(crate) learnt_irradiance: f64,
    pub(crate) traced_irradiance: f64,
    pub(crate) directions: usize,
    pub(crate) samples_per_direction: u32,
}

impl Radiance {
    /// Traces `samples` paths for each bin, and asks the guide for its own opinion.
    pub(crate) fn new(
        scene: &Scene,
        settings: &IntegratorSettings,
        guide: &Guide,
        seen: &PixelVertex,
        samples: u32,
        seed: u64,
    ) -> Radiance {
        let view = seen.state(guide).and_then(|key| guide.view(key));
        let normal = view.as_ref().and_then(StateView::normal).unwrap_or(seen.normal());
        let summary = seen.state(guide).and_then(|key| guide.field().summary(key));
        let (field, wo) = (guide.field(), seen.si.frame.to_local(seen.wo));
        let glossy = summary
            .and_then(|summary| glossy_product((field, summary), &seen.bsdf, wo, (&seen.si.frame, seen.normal())));
        let (lobes, product) = match glossy {
            Some((lobes, product)) => (lobes, Some(product)),
            None => (GuidedLobes::of(&seen.bsdf, wo, GuidedBy::Radiance), None),
        };
        let summary = summary.filter(|_| lobes.share() > 0.0);
        let distribution = product.or_else(|| summary.map(|summary| field.distribution(summary, seen.normal())));
        let fraction = summary.map_or(1.0, |summary| summary.bsdf_fraction);
        let tracer = Tracer {
            integrator: PathIntegrator::plain(scene, settings, seed),
            seen,
            // what paths go on by at the point, as the guide now is
            mixture: Mixture::new(&seen.bsdf, distribution.as_ref(), fraction, lobes),
            frame: Frame::from_normal(normal),
            samples,
        };
        let bins =
            (0..SIDE * SIDE).into_par_iter().map_init(Batch::new, |batch, k| tracer.bin(k, view.as_ref(), batch));
        Radiance { bins: bins.collect(), frame: tracer.frame, samples }
    }

    /// Traced radiance from a direction in world space; `None` where no light can come from.
    pub(crate) fn traced(&self, w: Vec3) -> Option<f32> {
        let local = self.frame.to_local(w);
        let cell = |v: f32| ((v * SIDE as f32) as usize).min(SIDE as usize - 1);
        let [x, y] = warp::uniform_hemisphere_to_square(local).map(cell);
        let bin = self.bins[y * SIDE as usize + x];
        (local.z >= 0.0 && bin.open).then_some(bin.traced as f32)
    }

    /// The traced radiance below which the given share of bins is.
    pub(crate) fn quantile(&self, share: f64) -> f32 {
        let mut traced: Vec<f64> = self.bins.iter().map(|bin| bin.traced).collect();
        traced.sort_unstable_by(f64::total_cmp);
        traced[((traced.len() - 1) as f64 * share) as usize] as f32
    }

    pub(crate) fn compare(&self) -> Comparison {
        let open: Vec<&Bin> = self.bins.iter().filter(|bin| bin.open).collect();
        let sum = |of: &dyn Fn(&Bin) -> f64| open.iter().map(|bin| of(bin)).sum::<f64>();
        let whole = sum(&|bin| bin.traced);
        let relative = |part: f64| (whole > 0.0).then(|| part / whole);
        let irradiance = |of: &dyn Fn(&Bin) -> f64| {
            let lit = |(k, bin): (usize, &Bin)| if bin.open { of(bin) * cosine(k as u32) } else { 0.0 };
            self.bins.iter().enumerate().map(lit).sum::<f64>() * f64::from(TAU) / self.bins.len() as f64
        };
        Comparison {
            correlation: correlation(&open),
            relative_error: relative(sum(&|bin| (bin.learnt - bin.traced).abs())),
            truth_noise: relative(sum(&|bin| bin.variance.sqrt())),
            learnt_irradiance: irradiance(&|bin| bin.learnt),
            traced_irradiance: irradiance(&|bin| bin.traced),
            directions: open.len(),
            samples_per_direction: self.samples,
        }
    }
}

struct Tracer<'a> {
    integrator: PathIntegrator<'a>,
    seen: &'a PixelVertex<'a>,
    mixture: Mixture<'a>,
    frame: Frame,
    samples: u32,
}

impl Tracer<'_> {
    fn bin(&self, k: u32, view: Option<&StateView>, batch: &mut Batch) -> Bin {
        let starts: Vec<Start> = (0..self.samples).filter_map(|sample| self.start(k, sample)).collect();
        let n = starts.len() as f64;
        if starts.is_empty() {
            return Bin::default();
        }
        let (light, unit) = (self.integrator.radiance(&starts, batch), self.integrator.scene.light_unit().value());
        let light = || light.iter().filter(|l| l.is_finite()).map(|&l| unit * f64::from(luminance(l)));
        let mean = light().sum::<f64>() / n;
        let square = light().map(|l| (l - mean).powi(2)).sum::<f64>();
        let q = |start: &Start| view.and_then(|view| view.q(self.seen.normal(), start.ray.dir)).unwrap_or(0.0);
        let learnt = starts.iter().map(|start| unit * f64::from(q(start))).sum::<f64>() / n;
        Bin { learnt, traced: mean, variance: square / (n * (n - 1.0).max(1.0)), open: true }
    }

    /// A ray through bin `k`; `None` for a direction in which no path goes on from here.
    fn start(&self, k: u32, sample: u32) -> Option<Start> {
        let mut rng = Rng::for_place(self.integrator.seed, k, sample);
        let inside = rng.f32x2();
        let dir = self.frame.to_world(warp::square_to_uniform_hemisphere(in_square(k, inside)));
        let si = &self.seen.si;
        if !si.consistent(dir) {
            return None;
        }
        let (_, pdf) = self.mixture.eval_pdf(si, si.frame.to_local(self.seen.wo), dir);
        let ray = Ray { org: si.spawn(dir), dir, tfar: f32::INFINITY };
        let normal = if self.seen.bsdf.is_opaque() { self.seen.normal() } else { Vec3::ZERO };
        let keys = PathKey::new(self.integrator.seed, k, 0, sample);
        (pdf > 0.0).then_some(Start { ray, pdf: Some(pdf), normal, keys })
    }
}

/// A point of bin `k` in the unit square.
fn in_square(k: u32, inside: [f32; 2]) -> [f32; 2] {
    [((k % SIDE) as f32 + inside[0]) / SIDE as f32, ((k / SIDE) as f32 + inside[1]) / SIDE as f32]
}

fn cosine(k: u32) -> f64 {
    warp::square_to_uniform_hemisphere(in_square(k, [0.5; 2])).z.into()
}

fn correlation(bins: &[&Bin]) -> Option<f64> {
    let n = bins.len() as f64;
    let mean = |of: &dyn Fn(&Bin) -> f64| bins.iter().map(|bin| of(bin)).sum::<f64>() / n;
    let (a, b) = (mean(&|bin| bin.learnt), mean(&|bin| bin.traced));
    let product = mean(&|bin| (bin.learnt - a) * (bin.traced - b));
    let squares = mean(&|bin| (bin.learnt - a).powi(2)) * mean(&|bin| (bin.traced - b).powi(2));
    (squares > 0.0).then(|| product / squares.sqrt())
}
