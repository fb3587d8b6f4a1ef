//! The BSDFs of a packet.

use super::{Bsdf, BsdfModel, DiffuseLanes};
use crate::simd::{LANES, Mask, Vec3Lanes};

/// The BSDFs of a packet, as a structure of arrays. (Structures that are stored field by field and loaded at once would stall on
/// store forwarding.)
pub(crate) struct BsdfLanes<'s> {
    are: Mask,
    model: [Option<&'s BsdfModel>; LANES],
    colors: [Vec3Lanes; 2],
    /// Where surfaces scatter about another normal than that of the shading frame, and that normal.
    turned: Mask,
    normal: Vec3Lanes,
    diffuse: DiffuseLanes,
}

impl<'s> BsdfLanes<'s> {
    pub fn new() -> BsdfLanes<'s> {
        BsdfLanes {
            are: Mask::NONE,
            model: [None; LANES],
            colors: [Vec3Lanes::ZERO; 2],
            turned: Mask::NONE,
            normal: Vec3Lanes::ZERO,
            diffuse: DiffuseLanes::new(),
        }
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.are = Mask::NONE;
        self.diffuse.clear();
    }

    #[inline(always)]
    pub fn set(&mut self, k: usize, bsdf: &Bsdf<'s>) {
        self.are.set(k, true);
        self.model[k] = Some(bsdf.model);
        self.colors[0].set(k, bsdf.colors[0]);
        self.colors[1].set(k, bsdf.colors[1]);
        self.turned.set(k, bsdf.normal.is_some());
        if let Some(normal) = bsdf.normal {
            self.normal.set(k, normal);
        }
        self.diffuse.set(k, bsdf);
    }

    /// What was set since all was forgotten.
    #[inline(always)]
    pub fn get(&self, k: usize) -> Option<Bsdf<'s>> {
        let model = self.model[k].filter(|_| self.are.has(k))?;
        let normal = self.turned.has(k).then(|| self.normal.get(k));
        Some(Bsdf { model, colors: [self.colors[0].get(k), self.colors[1].get(k)], normal })
    }

    /// Where something was set.
    #[inline(always)]
    pub fn are(&self) -> Mask {
        self.are
    }

    /// Those that are Lambertian.
    #[inline(always)]
    pub fn diffuse(&self) -> &DiffuseLanes {
        &self.diffuse
    }
}

impl Default for BsdfLanes<'_> {
    fn default() -> Self {
        BsdfLanes::new()
    }
}
