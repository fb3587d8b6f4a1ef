//! What the guide proposes at one path vertex.

use super::{AnyDirections, Directions};
use crate::math::Frame;
use glam::Vec3;

/// Distribution over directions at one path vertex, frozen for this iteration.
///
/// Directions are unit, in world space, away from the surface; densities are per steradian. For every `wi`, `pdf(wi)`
/// is the density with which `sample` returns it. It covers the hemisphere of the region's normal, or the whole sphere
/// where a model does so, and not the BSDF's support: the mixture does that.
#[derive(Clone, Debug)]
pub struct InFrame<D> {
    pub(in crate::guiding) frame: Frame,
    pub(in crate::guiding) directions: D,
}

/// That of any model.
pub type GuidingDistribution<'f> = InFrame<AnyDirections<'f>>;

impl<D: Directions> InFrame<D> {
    /// The product with `value`, of which the centre of each stratum or cell is taken: of the BSDF, without its cosine.
    pub fn times(&self, value: impl Fn(Vec3) -> f32) -> InFrame<D> {
        let frame = self.frame;
        InFrame { frame, directions: self.directions.times(|local| value(frame.to_world(local))) }
    }

    /// A direction in world space and its density: [`Directions::sample`].
    #[inline(always)]
    pub fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
        let (local, pdf) = self.directions.sample(u, inside);
        (self.frame.to_world(local), pdf)
    }

    /// Density per steradian of `sample` at the unit direction `w`; 0 below the horizon of a hemisphere.
    #[inline(always)]
    pub fn pdf(&self, w: Vec3) -> f32 {
        self.directions.pdf(self.frame.to_local(w))
    }
}
