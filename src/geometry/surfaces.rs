//! Surface points of a packet's rays, found side by side.

use super::interaction::{Facet, corner_normals};
use super::{Mesh, Placement, SurfaceInteraction};
use crate::geometry::{Hit, HitRows};
use crate::math::{Frame, Rgb};
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each};
use glam::Vec3;

/// Up to [`LANES`] hits and the points that follow from them: what [`SurfaceInteraction::new`] gives one by one, to the
/// last bit. A point has the lane of its ray.
pub(crate) struct Surfaces<'a> {
    met: Mask,
    /// Where corners, normals, texture coordinates and materials are still to be read.
    unread: [Option<&'a Mesh>; LANES],
    primitive: [u32; LANES],
    triangle: [[u32; 3]; LANES],
    corners: [Vec3Lanes; 3],
    normals: [Vec3Lanes; 3],
    winding: Vec3Lanes,
    weights: [Lanes; 2],
    slack: Lanes,
    wo: Vec3Lanes,
    uv: [Lanes; 2],
    material: [u32; LANES],
    /// Of the vertices, on instances; on the scene's own meshes they are looked up where a material asks for them.
    placed_color: Vec3Lanes,
    p: Vec3Lanes,
    ng: Vec3Lanes,
    /// `s`, `t` and `n` of the shading frame.
    frame: [Vec3Lanes; 3],
    facing: Lanes,
    offset: Lanes,
    wo_local: Vec3Lanes,
}

impl<'a> Surfaces<'a> {
    pub(crate) fn new() -> Self {
        Surfaces {
            met: Mask::NONE,
            unread: [None; LANES],
            primitive: [0; LANES],
            triangle: [[0; 3]; LANES],
            corners: [Vec3Lanes::ZERO; 3],
            normals: [Vec3Lanes::ZERO; 3],
            winding: Vec3Lanes::ZERO,
            weights: [[0.0; LANES]; 2],
            slack: [0.0; LANES],
            wo: Vec3Lanes::ZERO,
            uv: [[0.0; LANES]; 2],
            material: [0; LANES],
            placed_color: Vec3Lanes::ZERO,
            p: Vec3Lanes::ZERO,
            ng: Vec3Lanes::ZERO,
            frame: [Vec3Lanes::ZERO; 3],
            facing: [0.0; LANES],
            offset: [0.0; LANES],
            wo_local: Vec3Lanes::ZERO,
        }
    }

    /// Begins with what these of a packet of rays met; where that is, [`Self::push`] says.
    #[inline(always)]
    pub(crate) fn begin(&mut self, rows: &HitRows, met: Mask) {
        self.met = met;
        (self.weights[0], self.weights[1]) = (*rows.weights[0], *rows.weights[1]);
        self.winding.set_rows(rows.ng);
        self.wo.set_rows(rows.dir);
        for k in 0..LANES {
            self.wo.set(k, -self.wo.get(k));
        }
    }

    /// The rays that met a surface.
    #[inline(always)]
    pub(crate) fn met(&self) -> Mask {
        self.met
    }

    /// Ray `k` met this triangle of `mesh`.
    #[inline(always)]
    pub(crate) fn push(&mut self, k: usize, mesh: &'a Mesh, primitive: u32) {
        self.unread[k] = Some(mesh);
        self.primitive[k] = primitive;
        self.triangle[k] = mesh.triangles[primitive as usize];
        self.slack[k] = 0.0;
    }

    /// Ray `k` met this triangle of an instance of `mesh`.
    #[inline(never)]
    pub(crate) fn push_placed(&mut self, k: usize, mesh: &Mesh, placement: &Placement, hit: &Hit) {
        let facet = Facet::placed(mesh, placement, hit, self.wo.get(k));
        self.unread[k] = None;
        for c in 0..3 {
            self.corners[c].set(k, facet.corners[c]);
            self.normals[c].set(k, facet.normals[c]);
        }
        self.winding.set(k, facet.winding);
        self.slack[k] = facet.slack;
        self.placed_color.set(k, mesh.color(hit.primitive as usize, hit.u, hit.v));
        self.read_attributes(k, mesh, hit.primitive as usize, hit.u, hit.v);
    }

    #[inline(always)]
    fn read_attributes(&mut self, k: usize, mesh: &Mesh, triangle: usize, u: f32, v: f32) {
        let [u, v] = mesh.uv(triangle, u, v);
        (self.uv[0][k], self.uv[1][k]) = (u, v);
        self.material[k] = mesh.materials[triangle];
    }

    /// Reads what meshes say. In large scenes that is not in any cache: by now the indices of all have been asked for, and
    /// nothing below waits for anything but them.
    #[inline(always)]
    fn read(&mut self) {
        for k in each(self.met) {
            let Some(mesh) = self.unread[k] else { continue };
            let (triangle, [a, b, c]) = (self.primitive[k] as usize, self.triangle[k]);
            self.corners[0].set(k, Vec3::from(mesh.positions[a as usize]));
            self.corners[1].set(k, Vec3::from(mesh.positions[b as usize]));
            self.corners[2].set(k, Vec3::from(mesh.positions[c as usize]));
            match corner_normals(mesh, triangle) {
                Some(normals) => (0..3).for_each(|c| self.normals[c].set(k, normals[c])),
                None => (0..3).for_each(|c| self.normals[c].set(k, Vec3::ZERO)),
            }
            self.read_attributes(k, mesh, triangle, self.weights[0][k], self.weights[1][k]);
        }
    }

    /// Finds the points of all that was met. Lanes that met nothing hold any numbers.
    pub(crate) fn resolve(&mut self) {
        self.read();
        for k in 0..LANES {
            let facet = Facet {
                corners: [self.corners[0].get(k), self.corners[1].get(k), self.corners[2].get(k)],
                normals: [self.normals[0].get(k), self.normals[1].get(k), self.normals[2].get(k)],
                winding: self.winding.get(k),
                weights: [self.weights[0][k], self.weights[1][k]],
                slack: self.slack[k],
                wo: self.wo.get(k),
            };
            let point = facet.point();
            self.p.set(k, point.p);
            self.ng.set(k, point.ng);
            self.frame[0].set(k, point.frame.s);
            self.frame[1].set(k, point.frame.t);
            self.frame[2].set(k, point.frame.n);
            self.facing[k] = point.facing;
            self.offset[k] = point.offset;
            self.wo_local.set(k, point.frame.to_local(facet.wo));
        }
    }

    /// Point `k`, once it is found.
    #[inline(always)]
    pub(crate) fn get(&self, k: usize) -> SurfaceInteraction {
        SurfaceInteraction {
            p: self.p.get(k),
            ng: self.ng.get(k),
            frame: self.shading_frame(k),
            front: self.facing[k] > 0.0,
            uv: self.uv(k),
            material: self.material[k],
            offset: self.offset[k],
        }
    }

    /// Material of point `k`.
    #[inline(always)]
    pub(crate) fn material(&self, k: usize) -> u32 {
        self.material[k]
    }

    /// Texture coordinates of point `k`.
    #[inline(always)]
    pub(crate) fn uv(&self, k: usize) -> [f32; 2] {
        [self.uv[0][k], self.uv[1][k]]
    }

    /// Colour of the mesh's vertices at point `k`; white where there is none.
    #[inline(never)]
    pub(crate) fn color(&self, k: usize) -> Rgb {
        match self.unread[k] {
            Some(mesh) => mesh.color(self.primitive[k] as usize, self.weights[0][k], self.weights[1][k]),
            None => self.placed_color.get(k),
        }
    }

    /// Place of point `k`.
    #[inline(always)]
    pub(crate) fn p(&self, k: usize) -> Vec3 {
        self.p.get(k)
    }

    /// Places of all points.
    #[inline(always)]
    pub(crate) fn places(&self) -> &Vec3Lanes {
        &self.p
    }

    /// Shading normal of point `k` on the side of the path.
    #[inline(always)]
    pub(crate) fn facing_normal(&self, k: usize) -> Vec3 {
        let n = self.frame[2].get(k);
        if self.wo.get(k).dot(n) < 0.0 { -n } else { n }
    }

    /// [`Self::facing_normal`] of all points.
    #[inline(always)]
    pub(crate) fn facing_normals(&self, normals: &mut Vec3Lanes) {
        for k in 0..LANES {
            normals.set(k, self.facing_normal(k));
        }
    }

    /// To where the ray came from, unit, in the shading frame.
    #[inline(always)]
    pub(crate) fn wo_local(&self, k: usize) -> Vec3 {
        self.wo_local.get(k)
    }

    /// The same for all.
    #[inline(always)]
    pub(crate) fn wo_locals(&self) -> &Vec3Lanes {
        &self.wo_local
    }

    /// Directions of the world in the shading frames.
    #[inline(always)]
    pub(crate) fn to_local(&self, w: &Vec3Lanes, local: &mut Vec3Lanes) {
        for k in 0..LANES {
            local.set(k, self.shading_frame(k).to_local(w.get(k)));
        }
    }

    /// Directions in the shading frames in the world.
    #[inline(always)]
    pub(crate) fn to_world(&self, local: &Vec3Lanes, w: &mut Vec3Lanes) {
        for k in 0..LANES {
            w.set(k, self.shading_frame(k).to_world(local.get(k)));
        }
    }

    /// [`SurfaceInteraction::spawn`] for all.
    #[inline(always)]
    pub(crate) fn spawn(&self, w: &Vec3Lanes, origin: &mut Vec3Lanes) {
        for k in 0..LANES {
            let ng = self.ng.get(k);
            origin.set(k, self.p.get(k) + ng * self.offset[k].copysign(w.get(k).dot(ng)));
        }
    }

    /// [`SurfaceInteraction::consistent`] for point `k`.
    #[inline(always)]
    pub(crate) fn consistent(&self, k: usize, w: Vec3) -> bool {
        w.dot(self.ng.get(k)) * w.dot(self.frame[2].get(k)) > 0.0
    }

    #[inline(always)]
    fn shading_frame(&self, k: usize) -> Frame {
        Frame { s: self.frame[0].get(k), t: self.frame[1].get(k), n: self.frame[2].get(k) }
    }
}

impl Default for Surfaces<'_> {
    fn default() -> Self {
        Surfaces::new()
    }
}

#[cfg(test)]
#[path = "surfaces_tests.rs"]
pub(crate) mod tests;
