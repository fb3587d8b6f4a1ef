//! What is known of one region.

use super::bsdf_fraction::BsdfFraction;
use super::directional::DirectionalModel;
use super::recorder::Transition;
use super::spatial::RegionId;
use super::visibility::Visibility;
use crate::math::{LUMINANCE, Rgb};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What is known of one region; `L` is what its directional model has learnt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region<L> {
    pub key: RegionId,
    /// The normal that the partition gives, or else of the first visit; hemispheres of an oriented region are about it.
    pub normal: Vec3,
    pub directions: L,
    /// Weight of all visits.
    pub visits: f32,
    /// Visits since the iteration began.
    pub fresh: f32,
    /// Whether it was ever met; else all that it knows is of the region that it was a part of.
    pub met: bool,
    pub returns: ReturnMoments,
    pub fraction: BsdfFraction,
    pub visibility: Visibility,
}

impl<L> Region<L> {
    /// One that is met now for the first time. `origin` as in [`Self::visit`].
    pub(super) fn new(key: RegionId, normal: Vec3, directions: L, origin: f32) -> Region<L> {
        Region {
            key,
            normal,
            directions,
            visits: 0.0,
            fresh: 0.0,
            met: true,
            returns: ReturnMoments::default(),
            fraction: BsdfFraction::at(origin),
            visibility: Visibility::default(),
        }
    }

    /// Counts a visit in, but for its direction. `origin` is the logit of the share of the BSDF that learning starts at.
    #[inline(always)]
    pub(super) fn visit(&mut self, transition: &Transition, origin: f32) {
        self.visits += 1.0;
        self.fresh += 1.0;
        self.met = true;
        self.returns.add(transition);
        self.visibility.add(transition.shadow);
        let Transition { bsdf_pdf, guide_pdf, .. } = *transition;
        self.fraction.learn(transition.contribution(), bsdf_pdf, guide_pdf, origin);
    }

    /// Leaves earlier visits a share of their weight.
    pub(super) fn decay<D: DirectionalModel<Learnt = L>>(&mut self, model: &D, share: f32) {
        model.decay(&mut self.directions, share);
        self.visits *= share;
        self.returns.weight *= share;
        self.visibility.decay(share);
    }

    /// Begins an iteration.
    pub(super) fn begin(&mut self) {
        self.fresh = 0.0;
    }

    /// The same knowledge, of a part of the region with the given share of its visits.
    pub(super) fn part<D>(&self, model: &D, key: RegionId, share: f32) -> Region<L>
    where
        D: DirectionalModel<Learnt = L>,
        L: Clone,
    {
        let mut part = Region { key, fresh: 0.0, met: false, ..self.clone() };
        part.decay(model, share);
        part
    }

    /// Whether the numbers that sampling relies on are of the range that learning keeps them in. The moments of returns
    /// decide only how many paths go on, which is bounded whatever they are.
    pub(super) fn is_sound<D: DirectionalModel<Learnt = L>>(&self, model: &D) -> bool {
        let amount = |x: f32| x >= 0.0 && x.is_finite();
        (self.normal.length() - 1.0).abs() < 1e-3
            && amount(self.visits)
            && amount(self.fresh)
            && self.fraction.is_sound()
            && self.visibility.is_sound()
            && model.is_sound(&self.directions)
    }
}

/// Moments of the one-sample estimate of a region's irradiance over π, that is of f·cosθ/p times the bootstrapped target with the
/// BSDF's albedo divided out, and the rays it took. Roulette and splitting go by them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReturnMoments {
    pub weight: f32,
    pub mean: f32,
    pub square: f32,
    pub rays: f32,
    /// Of the mean, which is a luminance, the channels red and blue.
    pub red: f32,
    pub blue: f32,
}

impl ReturnMoments {
    /// The estimate of a transition; `None` where it tells nothing of the region's irradiance, or its square is beyond an `f32` and
    /// would be all that is ever known.
    #[inline]
    pub(super) fn estimate(transition: &Transition) -> Option<f32> {
        let estimate = transition.bootstrapped * transition.scattered / transition.pdf;
        (transition.scattered > 0.0 && (estimate * estimate).is_finite()).then_some(estimate)
    }

    /// Counts a transition in.
    #[inline]
    fn add(&mut self, transition: &Transition) {
        let Some(estimate) = ReturnMoments::estimate(transition) else { return };
        self.weight += 1.0;
        let step = 1.0 / self.weight;
        self.mean += (estimate - self.mean) * step;
        self.square += (estimate * estimate - self.square) * step;
        self.rays += (f32::from(transition.rays) - self.rays) * step;
        let light = transition.hue.light() * estimate;
        self.red += (light.x - self.red) * step;
        self.blue += (light.z - self.blue) * step;
    }

    /// The mean as a prediction of the estimate: times n/(n + v), where v is the relative variance of one estimate and n their number.
    /// Of all multiples of the mean that is the one with the least mean square error, if the true mean is as it seems.
    pub(super) fn expected(&self) -> Rgb {
        let square = self.mean * self.mean;
        let known = self.weight * square / (self.weight * square + (self.square - square).max(0.0));
        let [red, green, blue] = LUMINANCE.to_array();
        let green = ((self.mean - red * self.red - blue * self.blue) / green).max(0.0);
        let expected = Rgb::new(self.red, green, self.blue) * known;
        if expected.is_finite() && expected.min_element() >= 0.0 { expected } else { Rgb::ZERO }
    }
}
