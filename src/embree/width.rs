//! Packets of 8 and 16 in the widths for which Embree has kernels. Where it has them for 8 rays but not for 16, as with AVX and
//! AVX2, Embree 4 would take a packet of 16 apart, ray by ray; it is given two halves instead. Embree 3 makes the halves itself,
//! at the same speed.

use super::coherence::Coherence;
use super::compat::{self, Query};
use super::packet::Valid;
use super::scene::Scene;
use super::sys;
use crate::geometry::NOTHING;

/// Finds the closest hits of the first `lanes` rays.
pub(super) fn intersect8(packet: &mut sys::RTCRayHit8, scene: &Scene, lanes: usize, coherence: Coherence) {
    let (valid, mut query) = (Valid::first(lanes), Query::new(coherence));
    // SAFETY: a `Scene` is committed and alive; both types carry Embree's alignment, and the mask has 16 elements, as many as
    // the widest packet.
    unsafe { compat::intersect8(valid.as_ptr(), scene.handle(), &mut query, packet) }
}

/// As [`intersect8`].
pub(super) fn intersect16(packet: &mut sys::RTCRayHit16, scene: &Scene, lanes: usize, coherence: Coherence) {
    if scene.takes_halves() {
        for (half, first) in [0, 8].into_iter().enumerate().take(lanes.div_ceil(8)) {
            let mut part = sys::RTCRayHit8 { ray: half_of(&packet.ray, half), ..Default::default() };
            part.hit.geomID = [NOTHING; 8];
            part.hit.instID[0] = [NOTHING; 8];
            intersect8(&mut part, scene, 8.min(lanes - first), coherence);
            give_back(&part, packet, half);
        }
        return;
    }
    let (valid, mut query) = (Valid::first(lanes), Query::new(coherence));
    // SAFETY: as in `intersect8`.
    unsafe { compat::intersect16(valid.as_ptr(), scene.handle(), &mut query, packet) }
}

/// Asks of the first `lanes` rays whether something lies on them.
pub(super) fn occluded8(packet: &mut sys::RTCRay8, scene: &Scene, lanes: usize, coherence: Coherence) {
    let (valid, mut query) = (Valid::first(lanes), Query::new(coherence));
    // SAFETY: as in `intersect8`.
    unsafe { compat::occluded8(valid.as_ptr(), scene.handle(), &mut query, packet) }
}

/// As [`occluded8`].
pub(super) fn occluded16(packet: &mut sys::RTCRay16, scene: &Scene, lanes: usize, coherence: Coherence) {
    if scene.takes_halves() {
        for (half, first) in [0, 8].into_iter().enumerate().take(lanes.div_ceil(8)) {
            let mut part = half_of(packet, half);
            occluded8(&mut part, scene, 8.min(lanes - first), coherence);
            packet.tfar.as_chunks_mut().0[half] = part.tfar;
        }
        return;
    }
    let (valid, mut query) = (Valid::first(lanes), Query::new(coherence));
    // SAFETY: as in `intersect8`.
    unsafe { compat::occluded16(valid.as_ptr(), scene.handle(), &mut query, packet) }
}

/// Lanes 0 to 7 or 8 to 15.
#[inline(always)]
fn half_of(ray: &sys::RTCRay16, half: usize) -> sys::RTCRay8 {
    let row = |row: &[f32; 16]| row.as_chunks::<8>().0[half];
    sys::RTCRay8 {
        org_x: row(&ray.org_x),
        org_y: row(&ray.org_y),
        org_z: row(&ray.org_z),
        tnear: row(&ray.tnear),
        dir_x: row(&ray.dir_x),
        dir_y: row(&ray.dir_y),
        dir_z: row(&ray.dir_z),
        time: row(&ray.time),
        tfar: row(&ray.tfar),
        mask: ray.mask.as_chunks::<8>().0[half],
        ..Default::default()
    }
}

/// Puts what a half found where the whole packet keeps it.
#[inline(always)]
fn give_back(part: &sys::RTCRayHit8, packet: &mut sys::RTCRayHit16, half: usize) {
    packet.ray.tfar.as_chunks_mut().0[half] = part.ray.tfar;
    let (from, to) = (&part.hit, &mut packet.hit);
    to.Ng_x.as_chunks_mut().0[half] = from.Ng_x;
    to.Ng_y.as_chunks_mut().0[half] = from.Ng_y;
    to.Ng_z.as_chunks_mut().0[half] = from.Ng_z;
    to.u.as_chunks_mut().0[half] = from.u;
    to.v.as_chunks_mut().0[half] = from.v;
    to.primID.as_chunks_mut().0[half] = from.primID;
    to.geomID.as_chunks_mut().0[half] = from.geomID;
    to.instID[0].as_chunks_mut().0[half] = from.instID[0];
}
