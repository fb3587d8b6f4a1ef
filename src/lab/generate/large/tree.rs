//! Trees of exactly as many triangles as asked for: a trunk, and leaves of one triangle each.

use super::stream::ObjStream;
use crate::math::rng::Rng;
use glam::DVec3;
use std::f64::consts::TAU;
use std::io;

/// Sides and rings of a trunk.
const SIDES: u64 = 6;
const RINGS: u64 = 4;
/// Triangles of a trunk.
const TRUNK: u64 = 2 * SIDES * RINGS;

/// What shape a tree has, in metres; it stands on y = 0.
#[derive(Clone, Copy)]
pub(crate) struct Tree {
    pub(crate) height: f64,
    pub(crate) trunk: f64,
    pub(crate) leaf: &'static str,
    /// Of the crown at a share of its height from 0 (lowest branches) to 1.
    pub(crate) radius: fn(f64) -> f64,
    /// Share of the height at which the crown begins.
    pub(crate) crown: f64,
    pub(crate) seed: u64,
}

/// A spruce: a cone of whorls.
pub(crate) const CONIFER: Tree = Tree {
    height: 11.0,
    trunk: 0.2,
    leaf: "needles",
    radius: |t| (1.0 - t) * (2.1 + 0.5 * (1.0 - (t * 9.0).fract())),
    crown: 0.13,
    seed: 1,
};

/// A round crown on a high stem.
pub(crate) const BROADLEAF: Tree = Tree {
    height: 8.0,
    trunk: 0.26,
    leaf: "leaves",
    radius: |t| 2.9 * (4.0 * t * (1.0 - t)).max(0.0).sqrt() * (0.85 + 0.15 * (t * 5.0).fract()),
    crown: 0.3,
    seed: 2,
};

/// Writes a tree of `triangles` triangles, more than a trunk has.
pub(crate) fn write(obj: &mut ObjStream, tree: &Tree, triangles: u64) -> io::Result<()> {
    trunk(obj, tree)?;
    let leaves = triangles.saturating_sub(TRUNK);
    obj.material(tree.leaf)?;
    let mut rng = Rng::new(tree.seed);
    // Leaves that cover the crown about three times, however many there are.
    let size = (3.0 * 40.0 / leaves.max(1) as f64).sqrt();
    for _ in 0..leaves {
        leaf(obj, tree, size, &mut rng)?;
    }
    Ok(())
}

/// A tapered prism, open at both ends.
fn trunk(obj: &mut ObjStream, tree: &Tree) -> io::Result<()> {
    obj.material("bark")?;
    let mut below = 0;
    for ring in 0..=RINGS {
        let t = ring as f64 / RINGS as f64;
        let mut first = 0;
        for side in 0..SIDES {
            let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
            let r = tree.trunk * (1.0 - 0.85 * t);
            let p = DVec3::new(r * cos, 0.9 * tree.height * t, -r * sin);
            let index = obj.vertex(p, [side as f64, 4.0 * t])?;
            first = if side == 0 { index } else { first };
        }
        for side in (0..SIDES).filter(|_| ring > 0) {
            let next = (side + 1) % SIDES;
            obj.triangle([below + side, below + next, first + next])?;
            obj.triangle([below + side, first + next, first + side])?;
        }
        below = first;
    }
    Ok(())
}

/// A triangle in the crown, mostly near its surface, that hangs outward.
fn leaf(obj: &mut ObjStream, tree: &Tree, size: f64, rng: &mut Rng) -> io::Result<()> {
    // more leaves where the crown is wide: reject heights by the radius there
    let widest = (0..20).map(|k| (tree.radius)(k as f64 / 20.0)).fold(0.0, f64::max);
    let t = loop {
        let t = rng.f64();
        if rng.f64() * widest < (tree.radius)(t) {
            break t;
        }
    };
    let side = loop {
        let d = DVec3::new(2.0 * rng.f64() - 1.0, 0.0, 2.0 * rng.f64() - 1.0);
        if (1e-3..=1.0).contains(&d.length()) {
            break d.normalize();
        }
    };
    let depth = rng.f64();
    let radius = (tree.radius)(t) * (1.0 - 0.6 * depth * depth);
    let y = tree.height * (tree.crown + (1.0 - tree.crown) * t) - 0.18 * radius;
    let tip = side * radius + DVec3::Y * y;
    let random = DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, rng.f64() - 0.5);
    let along = (side - DVec3::Y * 0.35 + random).normalize() * size * (0.7 + 0.6 * rng.f64());
    let across = along.cross(DVec3::Y + random).normalize() * size * 0.4;
    let a = obj.vertex(tip - along - across, [0.0, 0.0])?;
    obj.vertex(tip - along + across, [1.0, 0.0])?;
    obj.vertex(tip, [0.5, 1.0])?;
    obj.triangle([a, a + 1, a + 2])
}
