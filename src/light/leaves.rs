//! What the light hierarchy is made of.

use super::Light;
use super::pattern::TrianglePattern;
use super::source::{Extent, LightSource};
use super::tree::{LightTree, Patch};
use super::triangle::AreaLight;
use crate::math::Rgb;

/// Triangles, their areas, and their patterns, of which there may be none at all.
type Emissive<'a> = (&'a [AreaLight], &'a [f64], &'a [Option<TrianglePattern>]);

/// Of all lights that shine: the triangles, and the others behind them.
pub(super) fn tree(emissive: Emissive, others: &[Light], scene_radius: f32) -> LightTree {
    let (triangles, ..) = emissive;
    let only = triangles.len() == 2 && others.is_empty();
    let mut near = patches(emissive, if only { f32::INFINITY } else { SMALL * scene_radius });
    let (mut far, first) = (Vec::new(), triangles.len() as u32);
    for (light, other) in (first..).zip(others) {
        match other.extent() {
            Extent::Near(bounds) => near.push(Patch { light, share: 1.0, bounds }),
            Extent::Far(bounds) => far.push((light, bounds)),
        }
    }
    near.retain(|patch| patch.bounds.intensity > 0.0);
    far.retain(|(_, light)| light.irradiance > 0.0);
    LightTree::new(&near, &far, triangles.len() + others.len())
}

/// Patches of a radius above this share of the scene's are two lights all the same: to points that are nearer to them than
/// their size, of which there are a thousandth or so, it matters which half is asked.
const SMALL: f32 = 1.0 / 32.0;

/// Two triangles that follow each other and are one flat patch are chosen as one light, where that is `small` or the only one.
fn patches((triangles, areas, patterns): Emissive, small: f32) -> Vec<Patch> {
    let pattern = |k: usize| patterns.get(k).and_then(Option::as_ref);
    let mut patches: Vec<Patch> = Vec::with_capacity(triangles.len());
    for (k, triangle) in triangles.iter().enumerate() {
        let bounds = triangle.bounds(areas[k], pattern(k).map_or(Rgb::ONE, TrianglePattern::mean));
        let plain = || pattern(k).is_none() && pattern(k - 1).is_none();
        let last =
            patches.last_mut().filter(|last| !last.is_pair() && plain() && triangle.continues(&triangles[k - 1]));
        let pair = last.as_deref().map(|last| last.with(&bounds, [areas[k - 1], areas[k]]));
        match (last, pair) {
            (Some(last), Some(pair)) if pair.bounds.radius <= small => *last = pair,
            _ => patches.push(Patch { light: k as u32, share: 1.0, bounds }),
        }
    }
    patches
}
