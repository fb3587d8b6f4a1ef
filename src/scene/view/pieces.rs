//! The model's surface in pieces, so that it can be counted how much of it is seen.

use super::subject::Subject;
use crate::embree::{Coherence, HitBatch};
use crate::geometry::Ray;
use crate::scene::Scene;
use glam::Vec3;

/// Cells of the grid along the longest side of the model. Pieces are counted by a few thousand rays: much smaller ones would be
/// met by one ray each, and rays be counted instead.
const CELLS: f32 = 10.0;

/// A piece of surface: what of one material lies in one cell of a grid and faces one of the six ways along the axes. How finely
/// a model is tessellated changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Piece(u64);

/// What a ray met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) distance: f32,
    pub(super) piece: Piece,
}

/// The grid about what is to be seen. What lies beyond it belongs to its outermost cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pieces {
    centre: Vec3,
    cell: f32,
}

impl Pieces {
    pub(super) fn of(subject: &Subject) -> Pieces {
        Pieces { centre: subject.centre(), cell: (subject.high - subject.low).max_element() / CELLS }
    }

    /// What rays from `origin` meet, in the order of their unit directions.
    pub(super) fn seen(&self, scene: &Scene, origin: Vec3, directions: &[Vec3]) -> Vec<Option<Sight>> {
        let mut rays: HitBatch = HitBatch::with_capacity(directions.len());
        directions.iter().for_each(|&dir| rays.push(&Ray { org: origin, dir, tfar: f32::INFINITY }));
        rays.trace(scene.geometry(), Coherence::Incoherent);
        let sight = |(k, &dir): (usize, &Vec3)| {
            let hit = rays.hit(k)?;
            let si = scene.interaction(&hit, -dir);
            let facing = if si.ng.dot(dir) > 0.0 { -si.ng } else { si.ng };
            Some(Sight { distance: hit.t, piece: self.piece(si.p, facing, si.material) })
        };
        directions.iter().enumerate().map(sight).collect()
    }

    fn piece(&self, p: Vec3, facing: Vec3, material: u32) -> Piece {
        let cell = ((p - self.centre) / self.cell + 0.5 * CELLS).clamp(Vec3::ZERO, Vec3::splat(CELLS - 1.0)).as_uvec3();
        let axis = facing.abs().max_position();
        let side = 2 * axis + usize::from(facing[axis] < 0.0);
        let place = [cell.x, cell.y, cell.z, side as u32].iter().fold(0, |id, &k| id << 8 | u64::from(k));
        Piece(place << 32 | u64::from(material))
    }
}

/// How many different ones there are.
pub(super) fn count(pieces: impl Iterator<Item = Piece>) -> usize {
    let mut pieces: Vec<Piece> = pieces.collect();
    pieces.sort_unstable();
    pieces.dedup();
    pieces.len()
}
