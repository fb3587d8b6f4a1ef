//! What several types have in common: the roughness of a surface and the indices of refraction on its two sides.

use super::MicrofacetDistribution;
use super::model::out_of_domain;
use crate::Result;
use crate::document::{POSITIVE, UNIT, key};
use crate::fields::FieldVisitor;

/// Shows `alpha`, which `meaning` is said of, and `distribution`.
pub(super) fn rough<V: FieldVisitor>(
    visitor: &mut V,
    meaning: &'static str,
    alpha: &mut f32,
    distribution: &mut MicrofacetDistribution,
) -> Result<(), V::Error> {
    visitor.number(key("alpha", meaning), UNIT, alpha)?;
    visitor.choice(key("distribution", "of microfacet normals"), distribution)
}

/// Shows `int_ior`, which `inside` is said of, and `ext_ior`.
pub(super) fn indices<V: FieldVisitor>(
    visitor: &mut V,
    inside: &'static str,
    int_ior: &mut f32,
    ext_ior: &mut f32,
) -> Result<(), V::Error> {
    visitor.number(key("int_ior", inside), POSITIVE, int_ior)?;
    visitor.number(key("ext_ior", "index of refraction outside"), POSITIVE, ext_ior)
}

/// A roughness that can be used.
pub(super) fn checked_alpha(alpha: f32) -> Result<f32> {
    if (0.0..=10.0).contains(&alpha) { Ok(alpha) } else { Err(out_of_domain("alpha", "between 0 and 10")) }
}

/// The index inside over that outside, which is in [0.01, 100].
pub(super) fn checked_eta(int_ior: f32, ext_ior: f32) -> Result<f32> {
    let eta = int_ior / ext_ior;
    if int_ior > 0.0 && ext_ior > 0.0 && (1e-2..=1e2).contains(&eta) {
        Ok(eta)
    } else {
        Err(out_of_domain("int_ior and ext_ior", "positive, with a ratio of 0.01 to 100"))
    }
}
