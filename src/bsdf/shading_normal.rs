//! Surfaces whose normal a picture turns: a BSDF about another normal than that of the shading frame.
//!
//! A BSDF that is only turned would send light below the surface, where it is lost, and would be black where the turned normal faces
//! away from the viewer. Here neither happens, and no energy is gained:
//! - a normal that faces away is seen as its mirror image about the plane across the view, which faces the viewer as much as it faced
//!   away;
//! - what would be reflected below the surface, or transmitted above it, leaves by the mirror image of its direction about the
//!   surface: value and density at a direction are those of it and of its mirror image, as far as these are on the wrong side.
//!
//! So the whole scatters as much as the BSDF itself about the turned normal, and where nothing is folded it is that BSDF: for a normal
//! turned by θ, light from less than 90° − θ is as with plain normal mapping.

use super::{BLACK, Bsdf, BsdfSample, mirrored};
use crate::math::Frame;
use crate::math::Rgb;
use glam::Vec3;

/// A view of a surface with a turned normal.
struct Turned<'s> {
    /// The BSDF about its own normal.
    flat: Bsdf<'s>,
    /// About the turned normal, in the shading frame.
    frame: Frame,
    /// Whether all is seen in the mirror of the surface, as two-sided ones are from behind.
    behind: bool,
    /// To the viewer: in the shading frame (mirrored where `behind`), and about the turned normal.
    wo: Vec3,
    own: Vec3,
}

impl<'s> Bsdf<'s> {
    /// The same surface with the unit normal `normal` (shading frame, on its upper side).
    #[must_use]
    pub(crate) fn with_normal(self, normal: Vec3) -> Bsdf<'s> {
        Bsdf { normal: (normal != Vec3::Z).then_some(normal), ..self }
    }

    /// The normal about which it scatters, in the shading frame, on its upper side.
    pub(crate) fn normal(&self) -> Vec3 {
        self.normal.unwrap_or(Vec3::Z)
    }

    fn turned_about(&self, normal: Vec3, wo: Vec3) -> Turned<'s> {
        let behind = self.turns() && wo.z < 0.0;
        // a dent is a bump from behind
        let (wo, normal) =
            if behind { (mirrored(wo), Vec3::new(-normal.x, -normal.y, normal.z)) } else { (wo, normal) };
        let facing = wo.dot(normal);
        let seen = if facing * wo.z < 0.0 { normal - wo * (2.0 * facing) } else { normal };
        let frame = Frame::from_normal(seen.normalize());
        Turned { flat: Bsdf { normal: None, ..*self }, frame, behind, wo, own: frame.to_local(wo) }
    }

    #[inline(never)]
    pub(super) fn eval_pdf_turned(&self, normal: Vec3, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.turned_about(normal, wo).sum(wi, |flat, wo, wi| flat.eval_pdf(wo, wi))
    }

    #[inline(never)]
    pub(super) fn eval_pdf_rough_turned(&self, normal: Vec3, wo: Vec3, wi: Vec3, alpha: f32) -> (Rgb, f32) {
        self.turned_about(normal, wo).sum(wi, |flat, wo, wi| flat.eval_pdf_rough(wo, wi, alpha))
    }

    #[inline(never)]
    pub(super) fn sample_turned(&self, normal: Vec3, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let view = self.turned_about(normal, wo);
        let drawn = view.flat.sample(view.own, u_lobe, u)?;
        let w = view.frame.to_world(drawn.wi);
        let wi = if view.keeps_side(w, drawn.wi) { w } else { mirrored(w) };
        let wi = if view.behind { mirrored(wi) } else { wi };
        if drawn.delta {
            return Some(BsdfSample { wi, ..drawn });
        }
        // the mirror image may have been drawn as well
        BsdfSample::smooth(wi, self.eval_pdf_turned(normal, wo, wi), drawn.eta)
    }

    /// To the viewer, about the normal with which the surface is seen.
    #[inline(never)]
    pub(super) fn own_view(&self, normal: Vec3, wo: Vec3) -> (Bsdf<'s>, Vec3) {
        let view = self.turned_about(normal, wo);
        (view.flat, view.own)
    }
}

impl Turned<'_> {
    /// What all ways to `wi` (shading frame) bring together.
    fn sum(&self, wi: Vec3, of: impl Fn(&Bsdf, Vec3, Vec3) -> (Rgb, f32)) -> (Rgb, f32) {
        let wi = if self.behind { mirrored(wi) } else { wi };
        let mut sum = BLACK;
        // the direction itself where it stays on its side, the image where it is folded to this side
        for (w, keeps) in [(wi, true), (mirrored(wi), false)] {
            let own = self.frame.to_local(w);
            if self.keeps_side(w, own) == keeps {
                let (value, pdf) = of(&self.flat, self.own, own);
                sum = (sum.0 + value, sum.1 + pdf);
            }
        }
        sum
    }

    /// Whether `w` is reflected by the surface as it is by the turned one (`own`), or transmitted by both.
    fn keeps_side(&self, w: Vec3, own: Vec3) -> bool {
        ((w.z > 0.0) == (self.wo.z > 0.0)) == ((own.z > 0.0) == (self.own.z > 0.0))
    }
}
