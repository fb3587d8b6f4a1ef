//! How good a view is, and which one is the best.

use super::Search;
use super::candidates::Candidate;
use super::light::arriving;
use super::pieces::{Piece, Sight, count};
use crate::geometry::Ray;
use crate::math::rng::Rng;
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// The picture in small: blocks across and upwards, and rays along the side of a block.
const BLOCKS: [usize; 2] = [8, 4];
const SIDE: usize = 8;
/// Paths from each block that look for light.
const PATHS: usize = 16;
/// Views are as good where they differ by less than this share: rays see no smaller differences.
const ALIKE: f32 = 0.05;
/// Azimuth and elevation in degrees from which objects are customarily shown: a little from the side and from above.
const CUSTOMARY: (f32, f32) = (27.0, 17.0);

/// What a view shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rating {
    /// Pieces of the model's surface that are seen in blocks of the picture in which light was found.
    pub(super) pieces: usize,
    /// Share of the paths that found light.
    pub(super) light: f32,
}

impl Search<'_> {
    /// The best of the views: most of the surface is seen where light arrives; among those that are alike, where most light
    /// arrives; and among those, from where it is customary. In rooms, only what is `of_interest` counts.
    pub(super) fn best(&self, views: &[Candidate], of_interest: Option<&FxHashSet<Piece>>) -> (Candidate, Rating) {
        let rated: Vec<(Candidate, Rating)> =
            views.par_iter().map(|view| (*view, self.rate(view, of_interest))).collect();
        let most = rated.iter().map(|(_, rating)| rating.pieces).max().unwrap_or(0) as f32;
        let seen = rated.iter().filter(|(_, rating)| rating.pieces as f32 >= most * (1.0 - ALIKE));
        let brightest = seen.clone().map(|(_, rating)| rating.light).fold(0.0, f32::max);
        let bright = seen.filter(|(_, rating)| rating.light >= brightest * (1.0 - ALIKE));
        let customary = self.axes.direction(CUSTOMARY.0.to_radians(), CUSTOMARY.1.to_radians());
        let best = bright.reduce(|best, view| {
            let usual = |(view, _): &(Candidate, Rating)| -view.gaze.forward.dot(customary);
            if usual(view) > usual(best) { view } else { best }
        });
        *best.expect("there is a view from each place that is given, and from outside where none is")
    }

    /// What the view shows, by rays through a small picture and paths from its blocks.
    pub(super) fn rate(&self, view: &Candidate, of_interest: Option<&FxHashSet<Piece>>) -> Rating {
        let (mut rng, mut found) = (Rng::new(0), 0);
        let mut shown: Vec<Sight> = Vec::new();
        for block in 0..BLOCKS[0] * BLOCKS[1] {
            let directions = block_directions(view, block);
            let lit = (0..PATHS).filter(|k| {
                let dir = directions[k * directions.len() / PATHS + k % SIDE / 2];
                arriving(self.scene, Ray { org: view.origin, dir, tfar: f32::INFINITY }, &mut rng) > 0.0
            });
            let lit = lit.count();
            found += lit;
            if lit > 0 {
                shown.extend(self.pieces.seen(self.scene, view.origin, &directions).into_iter().flatten());
            }
        }
        let pieces = shown.into_iter().map(|sight| sight.piece);
        Rating {
            pieces: count(pieces.filter(|piece| of_interest.is_none_or(|these| these.contains(piece)))),
            light: found as f32 / (PATHS * BLOCKS[0] * BLOCKS[1]) as f32,
        }
    }
}

/// Through the middles of the small picture's pixels in a block, row by row.
fn block_directions(view: &Candidate, block: usize) -> Vec<Vec3> {
    let corner = [block % BLOCKS[0] * SIDE, block / BLOCKS[0] * SIDE];
    let at = |k: usize, along: usize| (2 * k + 1) as f32 / (BLOCKS[along] * SIDE) as f32 - 1.0;
    let pixel = |k: usize| view.gaze.through([at(corner[0] + k % SIDE, 0), at(corner[1] + k / SIDE, 1)]);
    (0..SIDE * SIDE).map(pixel).collect()
}
