//! The packets in which Embree takes rays and gives hits.

use super::{sys, width};
use crate::geometry::{Hit, HitRows, NOTHING, Ray, RayRows};
use crate::simd::{Mask, Packing, mask};
use glam::Vec3;

/// What lanes hold that no ray is in. Where Embree 3 has no kernels for a packet's width (16 lanes without AVX-512) it does
/// not pass the mask on: it takes every lane for a ray whose interval is not empty, and refuses numbers that are not finite.
const NO_RAY: Ray = Ray { org: Vec3::ZERO, dir: Vec3::Z, tfar: f32::NEG_INFINITY };

/// One lane mask for any width: Embree 3 reads it with 64-byte loads, and crashes where it is not aligned for them.
#[repr(C, align(64))]
pub(super) struct Valid([i32; 16]);

impl Valid {
    /// The first `n` lanes are active.
    pub(crate) fn first(n: usize) -> Valid {
        let mut active = [0; 16];
        for lane in 0..16 {
            active[lane] = if lane < n { -1 } else { 0 };
        }
        Valid(active)
    }

    pub(super) fn as_ptr(&self) -> *const i32 {
        self.0.as_ptr()
    }
}

mod private {
    pub(crate) trait Sealed {}
}

/// A packet of rays for closest hits.
pub(crate) trait HitPacket: Copy + private::Sealed {
    const WIDTH: usize;
    #[doc(hidden)]
    fn empty() -> Self;
    #[doc(hidden)]
    fn set(&mut self, lane: usize, ray: &Ray);
    #[doc(hidden)]
    fn ray(&self, lane: usize) -> Ray;
    #[doc(hidden)]
    fn hit(&self, lane: usize) -> Option<Hit>;
    /// Makes lanes from `first` on such that no query takes them for rays.
    #[doc(hidden)]
    fn disable(&mut self, first: usize);
    #[doc(hidden)]
    fn trace(&mut self, scene: &super::Scene, lanes: usize, coherence: super::Coherence);
}

/// A packet of rays that only ask whether something is in the way.
pub(crate) trait ShadowPacket: Copy + private::Sealed {
    const WIDTH: usize;
    #[doc(hidden)]
    fn empty() -> Self;
    #[doc(hidden)]
    fn set(&mut self, lane: usize, ray: &Ray);
    #[doc(hidden)]
    fn ray(&self, lane: usize) -> Ray;
    #[doc(hidden)]
    fn occluded(&self, lane: usize) -> bool;
    /// As [`HitPacket::disable`].
    #[doc(hidden)]
    fn disable(&mut self, first: usize);
    #[doc(hidden)]
    fn trace(&mut self, scene: &super::Scene, lanes: usize, coherence: super::Coherence);
}

macro_rules! packets {
    ($hit_name:ident, $shadow_name:ident, $width:literal, $rayhit:ident, $ray:ident, $blank:ident, $store:ident, $load:ident, $intersect:ident, $occluded:ident) => {
        #[doc = concat!($width, " rays for closest hits.")]
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $hit_name(sys::$rayhit);

        #[doc = concat!($width, " shadow rays.")]
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $shadow_name(sys::$ray);

        impl private::Sealed for $hit_name {}
        impl private::Sealed for $shadow_name {}

        #[inline(always)]
        fn $store(packet: &mut sys::$ray, lane: usize, ray: &Ray) {
            packet.org_x[lane] = ray.org.x;
            packet.org_y[lane] = ray.org.y;
            packet.org_z[lane] = ray.org.z;
            packet.dir_x[lane] = ray.dir.x;
            packet.dir_y[lane] = ray.dir.y;
            packet.dir_z[lane] = ray.dir.z;
            packet.tfar[lane] = ray.tfar;
        }

        /// What all rays have in common, and Embree leaves as it is: they begin at 0, at time 0, and may meet anything.
        #[inline(always)]
        fn $blank() -> sys::$ray {
            sys::$ray { mask: [u32::MAX; $width], ..Default::default() }
        }

        #[inline(always)]
        fn $load(packet: &sys::$ray, lane: usize) -> Ray {
            Ray {
                org: Vec3::new(packet.org_x[lane], packet.org_y[lane], packet.org_z[lane]),
                dir: Vec3::new(packet.dir_x[lane], packet.dir_y[lane], packet.dir_z[lane]),
                tfar: packet.tfar[lane],
            }
        }

        impl HitPacket for $hit_name {
            const WIDTH: usize = $width;

            fn empty() -> Self {
                $hit_name(sys::$rayhit { ray: $blank(), ..Default::default() })
            }

            #[inline(always)]
            fn set(&mut self, lane: usize, ray: &Ray) {
                $store(&mut self.0.ray, lane, ray);
                // what an earlier wave left there must not look like a hit
                self.0.hit.geomID[lane] = NOTHING;
                self.0.hit.instID[0][lane] = u32::MAX;
            }

            #[inline(always)]
            fn ray(&self, lane: usize) -> Ray {
                $load(&self.0.ray, lane)
            }

            #[inline(always)]
            fn hit(&self, lane: usize) -> Option<Hit> {
                let h = &self.0.hit;
                (h.geomID[lane] != NOTHING).then(|| Hit {
                    t: self.0.ray.tfar[lane],
                    u: h.u[lane],
                    v: h.v[lane],
                    ng: Vec3::new(h.Ng_x[lane], h.Ng_y[lane], h.Ng_z[lane]),
                    primitive: h.primID[lane],
                    geometry: h.geomID[lane],
                    instance: h.instID[0][lane],
                })
            }

            fn disable(&mut self, first: usize) {
                (first..$width).for_each(|lane| self.set(lane, &NO_RAY));
            }

            fn trace(&mut self, scene: &super::Scene, lanes: usize, coherence: super::Coherence) {
                width::$intersect(&mut self.0, scene, lanes, coherence);
            }
        }

        impl ShadowPacket for $shadow_name {
            const WIDTH: usize = $width;

            fn empty() -> Self {
                $shadow_name($blank())
            }

            #[inline(always)]
            fn set(&mut self, lane: usize, ray: &Ray) {
                $store(&mut self.0, lane, ray);
            }

            #[inline(always)]
            fn ray(&self, lane: usize) -> Ray {
                $load(&self.0, lane)
            }

            #[inline(always)]
            fn occluded(&self, lane: usize) -> bool {
                self.0.tfar[lane] == f32::NEG_INFINITY
            }

            fn disable(&mut self, first: usize) {
                (first..$width).for_each(|lane| self.set(lane, &NO_RAY));
            }

            fn trace(&mut self, scene: &super::Scene, lanes: usize, coherence: super::Coherence) {
                width::$occluded(&mut self.0, scene, lanes, coherence);
            }
        }
    };
}

packets!(Packet8, Shadow8, 8, RTCRayHit8, RTCRay8, blank8, store8, load8, intersect8, occluded8);
packets!(Packet16, Shadow16, 16, RTCRayHit16, RTCRay16, blank16, store16, load16, intersect16, occluded16);

impl Packet16 {
    /// Packs rays behind those that the first packet holds. What earlier waves have left there does not look like a hit.
    #[inline(always)]
    pub(super) fn pack([first, second]: [&mut Packet16; 2], packing: &Packing, rays: &RayRows) {
        pack([&mut first.0.ray, &mut second.0.ray], packing, rays);
        for packet in [first, second] {
            packet.0.hit.geomID = [NOTHING; 16];
            packet.0.hit.instID[0] = [NOTHING; 16];
        }
    }

    /// What [`HitPacket::hit`] and [`HitPacket::ray`] give lane by lane.
    #[inline(always)]
    pub(super) fn rows(&self) -> HitRows<'_> {
        let sys::RTCRayHit16 { ray, hit } = &self.0;
        HitRows {
            dir: [&ray.dir_x, &ray.dir_y, &ray.dir_z],
            ng: [&hit.Ng_x, &hit.Ng_y, &hit.Ng_z],
            weights: [&hit.u, &hit.v],
            geometry: &hit.geomID,
            primitive: &hit.primID,
            instance: &hit.instID[0],
        }
    }
}

impl Shadow16 {
    /// Packs rays behind those that the first packet holds.
    #[inline(always)]
    pub(super) fn pack([first, second]: [&mut Shadow16; 2], packing: &Packing, rays: &RayRows) {
        pack([&mut first.0, &mut second.0], packing, rays);
    }

    /// Which of the first `lanes` rays nothing lay on, one bit each.
    #[inline(always)]
    pub(super) fn open(&self, lanes: usize) -> Mask {
        let open = mask(|lane| self.0.tfar[lane] != f32::NEG_INFINITY);
        open & Mask::from_bits(((1u32 << lanes) - 1) as u16)
    }
}

#[inline(always)]
fn pack([first, second]: [&mut sys::RTCRay16; 2], packing: &Packing, rays: &RayRows) {
    packing.put(rays.org[0], [&mut first.org_x, &mut second.org_x]);
    packing.put(rays.org[1], [&mut first.org_y, &mut second.org_y]);
    packing.put(rays.org[2], [&mut first.org_z, &mut second.org_z]);
    packing.put(rays.dir[0], [&mut first.dir_x, &mut second.dir_x]);
    packing.put(rays.dir[1], [&mut first.dir_y, &mut second.dir_y]);
    packing.put(rays.dir[2], [&mut first.dir_z, &mut second.dir_z]);
    packing.put(rays.tfar, [&mut first.tfar, &mut second.tfar]);
}
