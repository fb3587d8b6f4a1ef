//! Polished metal.

use super::conductor::Metal;
use super::model::{BsdfParameters, Prepared};
use super::{BLACK, BsdfSample, BsdfTables, Model, Scatter};
use crate::Result;
use crate::document::key;
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::texture::ColorTexture;
use glam::Vec3;

/// A perfect mirror as written: what a conductor without index and roughness is.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorParameters {
    pub specular_reflectance: ColorTexture,
}

impl Default for MirrorParameters {
    fn default() -> MirrorParameters {
        MirrorParameters { specular_reflectance: ColorTexture::grey(1.0) }
    }
}

impl Fields for MirrorParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.texture(key("specular_reflectance", "multiplies the reflection"), &mut self.specular_reflectance)
    }
}

impl BsdfParameters for MirrorParameters {
    const NUMBER: u32 = 7;
    const OPAQUE: bool = true;

    fn model(&self, _tables: &mut BsdfTables) -> Result<Model> {
        Ok(MirrorModel(Metal::Perfect).into())
    }
}

/// A smooth metal; how much it reflects may vary from place to place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorModel(pub(super) Metal);

impl Prepared for MirrorModel {
    type At<'s> = Mirror;

    #[inline(always)]
    fn at(&self, [reflectance, _]: [Rgb; 2]) -> Mirror {
        Mirror { metal: self.0, reflectance }
    }
}

/// A perfect mirror of Fresnel reflectance times `reflectance`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mirror {
    pub metal: Metal,
    pub reflectance: Rgb,
}

impl Scatter for Mirror {
    const SMOOTH: bool = false;
    const OPAQUE: bool = true;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        let value = self.albedo(wo);
        if wo.z > 0.0 { BsdfSample::delta(Vec3::new(-wo.x, -wo.y, wo.z), value, 1.0, 1.0) } else { None }
    }

    fn albedo(&self, wo: Vec3) -> Rgb {
        if wo.z > 0.0 { self.reflectance * self.metal.fresnel(wo.z) } else { Rgb::ZERO }
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
