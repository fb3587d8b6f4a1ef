//! No surface at all.

use super::model::{BsdfParameters, Prepared};
use super::{BLACK, BsdfSample, BsdfTables, Model, Scatter};
use crate::Result;
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use glam::Vec3;

/// No surface, as written: nothing is to be said of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NullParameters;

impl Fields for NullParameters {
    fn fields<V: FieldVisitor>(&mut self, _visitor: &mut V) -> Result<(), V::Error> {
        Ok(())
    }
}

impl BsdfParameters for NullParameters {
    const NUMBER: u32 = 0;
    const OPAQUE: bool = false;
    const IS_SURFACE: bool = false;

    fn model(&self, _tables: &mut BsdfTables) -> Result<Model> {
        Ok(Null.into())
    }
}

impl Prepared for Null {
    type At<'s> = Null;

    #[inline(always)]
    fn at(&self, _: [Rgb; 2]) -> Null {
        Null
    }
}

/// Lets everything pass straight through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Null;

impl Scatter for Null {
    const SMOOTH: bool = false;
    const OPAQUE: bool = false;

    fn eval_pdf(&self, _wo: Vec3, _wi: Vec3) -> (Rgb, f32) {
        BLACK
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        BsdfSample::delta(-wo, Rgb::ONE, 1.0, 1.0)
    }

    fn albedo(&self, _wo: Vec3) -> Rgb {
        Rgb::ONE
    }

    fn roughness(&self) -> f32 {
        0.0
    }
}
