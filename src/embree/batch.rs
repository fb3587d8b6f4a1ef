//! Batches of rays, held in the very packets that Embree reads: nothing is transposed before a call.

use super::coherence::Coherence;
use super::packet::{HitPacket, Packet16, Shadow16, ShadowPacket};
use super::scene::Scene;
use crate::geometry::{Hit, HitRows, Ray, RayRows};
use crate::simd::{Mask, Packing};

/// Any number of rays that ask for their closest hit. Cleared and refilled wave by wave; memory is kept.
pub(crate) struct HitBatch<P: HitPacket = Packet16> {
    packets: Vec<P>,
    len: usize,
}

impl<P: HitPacket> HitBatch<P> {
    pub(crate) fn with_capacity(rays: usize) -> Self {
        HitBatch { packets: Vec::with_capacity(rays.div_ceil(P::WIDTH)), len: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[inline]
    pub(crate) fn push(&mut self, ray: &Ray) {
        let (packet, lane) = (self.len / P::WIDTH, self.len % P::WIDTH);
        if packet == self.packets.len() {
            self.packets.push(P::empty());
        }
        self.packets[packet].set(lane, ray);
        self.len += 1;
    }

    /// Ray `i` as pushed; after [`HitBatch::trace`] its `tfar` is the distance of the hit.
    #[inline]
    pub(crate) fn ray(&self, i: usize) -> Ray {
        debug_assert!(i < self.len);
        self.packets[i / P::WIDTH].ray(i % P::WIDTH)
    }

    /// What ray `i` met in the last [`HitBatch::trace`].
    #[inline]
    pub(crate) fn hit(&self, i: usize) -> Option<Hit> {
        debug_assert!(i < self.len);
        self.packets[i / P::WIDTH].hit(i % P::WIDTH)
    }

    /// Finds all closest hits.
    pub(crate) fn trace(&mut self, scene: &Scene, coherence: Coherence) {
        let coherence = scene.allowed(coherence);
        self.disable_unused();
        for (k, packet) in self.packets[..self.len.div_ceil(P::WIDTH)].iter_mut().enumerate() {
            packet.trace(scene, P::WIDTH.min(self.len - k * P::WIDTH), coherence);
        }
    }

    /// Only the last packet can have lanes that hold no ray; they hold what was packed or traced there before.
    fn disable_unused(&mut self) {
        if let used @ 1.. = self.len % P::WIDTH {
            self.packets[self.len / P::WIDTH].disable(used);
        }
    }
}

impl HitBatch {
    /// Adds the rays of a packet that `packing`, made for this length, has chosen.
    #[inline(always)]
    pub(crate) fn pack(&mut self, packing: &Packing, rays: &RayRows) {
        Packet16::pack(packing.packets(&mut self.packets, Packet16::empty), packing, rays);
        self.len += packing.count();
    }

    /// What the packet met that begins with ray `first`, a multiple of 16.
    #[inline(always)]
    pub(crate) fn rows(&self, first: usize) -> HitRows<'_> {
        debug_assert!(first < self.len && first.is_multiple_of(Packet16::WIDTH));
        self.packets[first / Packet16::WIDTH].rows()
    }
}

/// Any number of shadow rays.
pub(crate) struct ShadowBatch<P: ShadowPacket = Shadow16> {
    packets: Vec<P>,
    len: usize,
}

impl<P: ShadowPacket> ShadowBatch<P> {
    pub(crate) fn with_capacity(rays: usize) -> Self {
        ShadowBatch { packets: Vec::with_capacity(rays.div_ceil(P::WIDTH)), len: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn push(&mut self, ray: &Ray) {
        let (packet, lane) = (self.len / P::WIDTH, self.len % P::WIDTH);
        if packet == self.packets.len() {
            self.packets.push(P::empty());
        }
        self.packets[packet].set(lane, ray);
        self.len += 1;
    }

    /// Ray `i` as pushed; [`ShadowBatch::trace`] changes its `tfar` where something lies on it.
    #[inline]
    pub(crate) fn ray(&self, i: usize) -> Ray {
        debug_assert!(i < self.len);
        self.packets[i / P::WIDTH].ray(i % P::WIDTH)
    }

    /// Whether something lay on ray `i` in the last [`ShadowBatch::trace`].
    #[inline]
    pub(crate) fn occluded(&self, i: usize) -> bool {
        debug_assert!(i < self.len);
        self.packets[i / P::WIDTH].occluded(i % P::WIDTH)
    }

    /// Answers all rays.
    pub(crate) fn trace(&mut self, scene: &Scene, coherence: Coherence) {
        let coherence = scene.allowed(coherence);
        self.disable_unused();
        for (k, packet) in self.packets[..self.len.div_ceil(P::WIDTH)].iter_mut().enumerate() {
            packet.trace(scene, P::WIDTH.min(self.len - k * P::WIDTH), coherence);
        }
    }

    /// Only the last packet can have lanes that hold no ray; they hold what was packed or traced there before.
    fn disable_unused(&mut self) {
        if let used @ 1.. = self.len % P::WIDTH {
            self.packets[self.len / P::WIDTH].disable(used);
        }
    }
}

impl ShadowBatch {
    /// Adds the rays of a packet that `packing`, made for this length, has chosen.
    #[inline(always)]
    pub(crate) fn pack(&mut self, packing: &Packing, rays: &RayRows) {
        Shadow16::pack(packing.packets(&mut self.packets, Shadow16::empty), packing, rays);
        self.len += packing.count();
    }

    /// The rays from `first`, a multiple of 16, on that nothing lay on in the last [`ShadowBatch::trace`].
    #[inline(always)]
    pub(crate) fn open(&self, first: usize) -> Mask {
        debug_assert!(first < self.len && first.is_multiple_of(Shadow16::WIDTH));
        self.packets[first / Shadow16::WIDTH].open(Shadow16::WIDTH.min(self.len - first))
    }
}

#[cfg(test)]
mod tests {
    use super::super::packet::{Packet8, Shadow8};
    use super::*;
    use glam::Vec3;

    /// After rays that are no rays, so many real ones: lanes behind them must hold what no query of Embree's takes for a
    /// ray, whether it is told the mask or not.
    fn check<B>(width: usize, mut fill: impl FnMut(&Ray, usize, usize) -> B, lane: impl Fn(&B, usize) -> Ray) {
        let (ray, none) = (Ray { org: Vec3::ONE, dir: Vec3::X, tfar: 1.0 }, Vec3::splat(f32::NAN));
        let stale = Ray { org: none, dir: none, tfar: f32::NAN };
        for used in 1..=2 * width {
            let batch = fill(&stale, used, 2 * width);
            for k in 0..used {
                assert_eq!((lane(&batch, k).org, lane(&batch, k).tfar), (ray.org, ray.tfar), "lane {k} of {used}");
            }
            for k in used..used.next_multiple_of(width) {
                let Ray { org, dir, tfar } = lane(&batch, k);
                assert!(org.is_finite() && dir.is_normalized() && tfar == f32::NEG_INFINITY, "lane {k} of {used}");
            }
        }
    }

    fn hits<P: HitPacket>() {
        let fill = |stale: &Ray, used, all| {
            let mut batch = HitBatch::<P>::with_capacity(all);
            (0..all).for_each(|_| batch.push(stale));
            batch.clear();
            (0..used).for_each(|_| batch.push(&Ray { org: Vec3::ONE, dir: Vec3::X, tfar: 1.0 }));
            batch.disable_unused();
            batch
        };
        check(P::WIDTH, fill, |batch, k| batch.packets[k / P::WIDTH].ray(k % P::WIDTH));
    }

    fn shadows<P: ShadowPacket>() {
        let fill = |stale: &Ray, used, all| {
            let mut batch = ShadowBatch::<P>::with_capacity(all);
            (0..all).for_each(|_| batch.push(stale));
            batch.clear();
            (0..used).for_each(|_| batch.push(&Ray { org: Vec3::ONE, dir: Vec3::X, tfar: 1.0 }));
            batch.disable_unused();
            batch
        };
        check(P::WIDTH, fill, |batch, k| batch.packets[k / P::WIDTH].ray(k % P::WIDTH));
    }

    #[test]
    fn lanes_without_a_ray_are_finite_and_end_before_they_begin() {
        hits::<Packet8>();
        hits::<Packet16>();
        shadows::<Shadow8>();
        shadows::<Shadow16>();
    }
}
