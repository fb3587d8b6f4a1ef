//! From whole batches of paths back to what each vertex should learn.

use crate::guiding::{PackedDirection, Recorder, StateKey, Transition};
use crate::math::{Rgb, luminance};
use crate::scene::description::LearningRule;

/// How a path came to a vertex: the direction in which it left the last one, where something can be learnt there.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    pub key: StateKey,
    pub wi: PackedDirection,
    /// Shading normal of the last vertex on the side of the path.
    pub normal: PackedDirection,
    /// Densities of `wi`: of the mixture, of the BSDF alone, of the guide alone (negative where it knew nothing).
    pub pdf: f32,
    pub bsdf_pdf: f32,
    pub guide_pdf: f32,
    /// Luminance of f·|cosθ| over that of the albedo.
    pub scattered: f32,
}

/// The way from one vertex to the next.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The last vertex, by its place in its wave.
    pub parent: u32,
    /// f·|cosθ|/p of the direction, roulette and splitting included.
    pub weight: Rgb,
    pub edge: Option<Edge>,
}

/// A vertex as the backward pass needs it.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    pub arrival: Arrival,
    /// Radiance towards the path's last vertex that this vertex accounts for itself: emission, weighted for
    /// next-event estimation, and next-event estimation.
    pub local: Rgb,
    /// What the frozen table expects of going on; `None` where it cannot say.
    pub expected: Option<Expectation>,
}

/// ∫ Q f cosθ dω, or what the rule takes for it, and its share against what the path finds.
#[derive(Clone, Copy, Debug)]
pub struct Expectation {
    pub radiance: Rgb,
    pub share: f32,
}

impl Expectation {
    /// `irradiance` and `peak` as in a guide's summary of a state with `visits`, `reflectance` that of a Lambertian
    /// surface.
    #[inline]
    pub fn new(
        rule: LearningRule,
        blend_visits: f32,
        (irradiance, peak, visits): (f32, f32, f32),
        reflectance: Rgb,
    ) -> Option<Expectation> {
        let (e, share) = match rule {
            LearningRule::MonteCarlo => return None,
            LearningRule::ExpectedSarsa => (irradiance, 1.0),
            LearningRule::QLearning => (peak, 1.0),
            LearningRule::Blend => (irradiance, visits / (visits + blend_visits)),
        };
        Some(Expectation { radiance: reflectance * (std::f32::consts::FRAC_1_PI * e), share })
    }
}

/// What came back to a vertex from those after it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Followed {
    radiance: Rgb,
    rays: f32,
}

/// Radiance that arrived at the batch's vertices, computed from the last wave to the first:
///
/// G(x) = local(y) + share · ∫ Q f cosθ + (1 − share) · Σ weight · G(y)
///
/// Share 1 is the expected SARSA of Dahm & Keller (2017), 0 the Monte Carlo return. Where the table cannot say what
/// to expect (a mirror, glass, a glossy surface, a state not met before), it is 0.
pub(super) fn record(waves: &[Vec<Vertex>], buffers: &mut [Vec<Followed>; 2], recorder: &mut Recorder) {
    let [followed, before] = buffers;
    followed.clear();
    for (depth, wave) in waves.iter().enumerate().rev() {
        // the wave before has not been reached yet; the last wave has nothing behind it
        followed.resize(wave.len(), Followed::default());
        before.clear();
        before.resize(if depth == 0 { 0 } else { waves[depth - 1].len() }, Followed::default());
        for (vertex, behind) in wave.iter().zip(followed.iter()) {
            let arrived = vertex.local
                + match vertex.expected {
                    Some(e) => e.radiance * e.share + behind.radiance * (1.0 - e.share),
                    None => behind.radiance,
                };
            let rays = 1.0 + behind.rays;
            push(recorder, &vertex.arrival, luminance(arrived), rays);
            if let Some(parent) = before.get_mut(vertex.arrival.parent as usize) {
                parent.radiance += vertex.arrival.weight * arrived;
                parent.rays += rays;
            }
        }
        std::mem::swap(followed, before);
    }
}

fn push(recorder: &mut Recorder, arrival: &Arrival, target: f32, rays: f32) {
    if let Some(edge) = arrival.edge
        && target.is_finite()
    {
        let Edge { key, wi, normal, pdf, bsdf_pdf, guide_pdf, scattered } = edge;
        recorder.push(Transition { key, wi, normal, target, pdf, bsdf_pdf, guide_pdf, scattered, rays });
    }
}

#[cfg(test)]
#[path = "backup_tests.rs"]
mod tests;
