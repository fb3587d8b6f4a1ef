//! From whole batches of paths back to what each vertex should learn.

use super::vertex_record::{PathSegment, VertexRecord, VertexRecords};
use crate::guiding::settings::LearningRule;
use crate::guiding::{Hue, Recorder, ShadowOutcome, Transition};
use crate::math::{Rgb, luminance};

/// The vertices of a wave as the backward pass needs them, in the order of its rays.
#[derive(Debug, Default)]
pub(super) struct WaveRecord {
    pub(crate) arrivals: VertexRecords,
    /// Radiance towards the path's last vertex that each accounts for itself: emission, weighted for next-event
    /// estimation, and next-event estimation.
    pub(crate) local: Vec<Rgb>,
    /// What the frozen table expects of going on.
    pub(crate) expected: Vec<Targets<BootstrapValue>>,
    /// What the path's shadow ray found.
    pub(crate) shadows: Vec<ShadowOutcome>,
}

impl WaveRecord {
    /// Takes the arrivals of a wave, in exchange for memory.
    pub(crate) fn begin(&mut self, arrivals: &mut VertexRecords) {
        std::mem::swap(&mut self.arrivals, arrivals);
        self.local.clear();
        self.local.resize(self.arrivals.len(), Rgb::ZERO);
        self.shadows.clear();
        self.shadows.resize(self.arrivals.len(), ShadowOutcome::NONE);
        self.expected.clear();
        self.expected.resize(self.arrivals.len(), Targets::NOTHING_EXPECTED);
    }

    pub(crate) fn clear(&mut self) {
        self.arrivals.clear();
    }
}

/// What there is one of for each target of a transition.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Targets<T> {
    /// Of what the guide learns, by the rule in use.
    pub(crate) rule: T,
    /// Of what the moments of roulette are of: bootstrapped under every rule, so that rules can be compared without comparing
    /// splitting, and the moments are not those of whole paths, whose few bright ones would decide them.
    pub(crate) moments: T,
}

impl<T> Targets<T> {
    #[inline(always)]
    pub(crate) fn map<U>(self, with: impl Fn(T) -> U) -> Targets<U> {
        Targets { rule: with(self.rule), moments: with(self.moments) }
    }

    #[inline(always)]
    fn zip<U, V>(self, other: Targets<U>, with: impl Fn(T, U) -> V) -> Targets<V> {
        Targets { rule: with(self.rule, other.rule), moments: with(self.moments, other.moments) }
    }
}

impl Targets<BootstrapValue> {
    /// Where the table cannot say.
    pub(crate) const NOTHING_EXPECTED: Targets<BootstrapValue> =
        Targets { rule: BootstrapValue::NONE, moments: BootstrapValue::NONE };

    /// By the rule in use and by the one that bootstraps by the mean: each of `value`.
    #[inline]
    pub(crate) fn expected(
        rule: LearningRule,
        value: impl Fn(LearningRule) -> Option<BootstrapValue>,
    ) -> Targets<BootstrapValue> {
        let value = |rule| value(rule).unwrap_or(BootstrapValue::NONE);
        Targets { rule: value(rule), moments: value(LearningRule::ExpectedSarsa) }
    }
}

/// What a vertex takes from the table instead of from the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BootstrapValue {
    /// ∫ Q f cosθ dω, or what the rule takes for it, times its share against what the path finds.
    pub(crate) radiance: Rgb,
    /// How much of what the path finds counts beside it.
    pub(crate) rest: f32,
}

impl BootstrapValue {
    /// Where the table cannot say.
    pub(crate) const NONE: BootstrapValue = BootstrapValue { radiance: Rgb::ZERO, rest: 1.0 };

    /// `irradiance` and `peak` as in a guide's summary of a state with `visits`, `reflectance` that of a Lambertian
    /// surface.
    #[inline]
    pub(crate) fn new(
        rule: LearningRule,
        blend_visits: f32,
        (irradiance, peak, visits): (f32, f32, f32),
        reflectance: Rgb,
    ) -> Option<BootstrapValue> {
        let share = BootstrapValue::share(rule, blend_visits, visits)?;
        let e = if rule == LearningRule::QLearning { peak } else { irradiance };
        let radiance = reflectance * (std::f32::consts::FRAC_1_PI * e);
        Some(BootstrapValue { radiance: radiance * share, rest: 1.0 - share })
    }

    /// The share of a state's table in what is learnt at a vertex in it, against what the path finds; `None` where only
    /// the path counts.
    #[inline]
    pub(crate) fn share(rule: LearningRule, blend_visits: f32, visits: f32) -> Option<f32> {
        match rule {
            LearningRule::MonteCarlo => None,
            LearningRule::ExpectedSarsa | LearningRule::QLearning => Some(1.0),
            LearningRule::Blend => Some(visits / (visits + blend_visits)),
        }
    }

    /// The same where it is that of some lobes only. The weights of what the path finds are to leave out what is expected.
    #[inline]
    pub(crate) fn of_a_part(self) -> BootstrapValue {
        BootstrapValue { rest: 1.0, ..self }
    }
}

/// What came back to a vertex from those after it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Return {
    radiance: Targets<Rgb>,
    rays: f32,
}

/// Radiance that arrived at the batch's vertices, computed from the last wave to the first:
///
/// G(x) = local(y) + share · ∫ Q f cosθ + (1 − share) · Σ weight · G(y)
///
/// Share 1 is the expected SARSA of Dahm & Keller (2017), 0 the Monte Carlo return. The table can say what to expect of
/// diffuse lobes; of others (mirrors, glass, gloss), and in a state not met before, the share is 0.
pub(super) fn record(waves: &mut [WaveRecord], buffers: &mut [Vec<Return>; 2], recorder: &mut Recorder) {
    let [followed, before] = buffers;
    followed.clear();
    for depth in (0..waves.len()).rev() {
        let (earlier, wave) = waves[..=depth].split_at_mut(depth);
        let (wave, parents) = (&wave[0], earlier.last_mut().map_or(&mut [][..], |parents| &mut parents.shadows));
        // the wave before has not been reached yet; the last wave has nothing behind it
        followed.resize(wave.arrivals.len(), Return::default());
        before.clear();
        before.resize(parents.len(), Return::default());
        for (i, behind) in followed.iter().enumerate() {
            let (arrival, expected) = (wave.arrivals.get(i), wave.expected[i]);
            let local = wave.local[i];
            let arrived = expected.zip(behind.radiance, |value, found| local + (value.radiance + found * value.rest));
            let rays = 1.0 + behind.rays;
            let shadow = parents.get_mut(arrival.parent as usize);
            push(recorder, &arrival, arrived, rays, shadow);
            if let Some(parent) = before.get_mut(arrival.parent as usize) {
                let brought = arrival.weight.zip(arrived, |weight, arrived| weight * arrived);
                parent.radiance = parent.radiance.zip(brought, |sum, more| sum + more);
                parent.rays += rays;
            }
        }
        std::mem::swap(followed, before);
    }
}

/// `shadow` is what the shadow ray of the vertex before has found, which the first transition from there takes with it.
fn push(
    recorder: &mut Recorder,
    arrival: &VertexRecord,
    arrived: Targets<Rgb>,
    rays: f32,
    shadow: Option<&mut ShadowOutcome>,
) {
    let (target, bootstrapped) = (luminance(arrived.rule), luminance(arrived.moments));
    if let Some(edge) = arrival.edge
        && target.is_finite()
        && bootstrapped.is_finite()
    {
        let (hue, rays) = (Hue::of(arrived.moments), rays as u16);
        let shadow = shadow.map(std::mem::take).unwrap_or_default();
        let PathSegment { key, wi, normal, pdf, bsdf_pdf, guide_pdf, scattered } = edge;
        recorder.push(Transition {
            key,
            wi,
            normal,
            target,
            bootstrapped,
            hue,
            pdf,
            bsdf_pdf,
            guide_pdf,
            scattered,
            rays,
            shadow,
        });
    }
}

#[cfg(test)]
#[path = "backward_pass_tests.rs"]
mod tests;
