//! Rays by themselves.

use super::coherence::Coherence;
use super::compat::{self, Query};
use super::scene::Scene;
use super::sys;
use crate::geometry::{Hit, NOTHING, Ray};
use glam::Vec3;

impl Scene {
    /// Closest hit of a single ray.
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut packet = sys::RTCRayHit { ray: single(ray), ..Default::default() };
        packet.hit.geomID = NOTHING;
        packet.hit.instID[0] = u32::MAX;
        let mut query = Query::new(Coherence::Incoherent);
        // SAFETY: a `Scene` is committed and alive; the struct is bindgen's own and so aligned.
        unsafe { compat::intersect1(self.handle(), &mut query, &mut packet) };
        let h = &packet.hit;
        (h.geomID != NOTHING).then(|| Hit {
            t: packet.ray.tfar,
            u: h.u,
            v: h.v,
            ng: Vec3::new(h.Ng_x, h.Ng_y, h.Ng_z),
            primitive: h.primID,
            geometry: h.geomID,
            instance: h.instID[0],
        })
    }

    /// Whether anything lies on a single ray.
    pub(crate) fn occluded(&self, ray: &Ray) -> bool {
        let mut packet = single(ray);
        let mut query = Query::new(Coherence::Incoherent);
        // SAFETY: as in `intersect`.
        unsafe { compat::occluded1(self.handle(), &mut query, &mut packet) };
        packet.tfar == f32::NEG_INFINITY
    }
}

fn single(ray: &Ray) -> sys::RTCRay {
    sys::RTCRay {
        org_x: ray.org.x,
        org_y: ray.org.y,
        org_z: ray.org.z,
        dir_x: ray.dir.x,
        dir_y: ray.dir.y,
        dir_z: ray.dir.z,
        tfar: ray.tfar,
        mask: u32::MAX,
        ..Default::default()
    }
}
