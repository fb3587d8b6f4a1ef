//! Which normals agree, one by one and bin by bin.

use crate::guiding::spatial::normal_bins::{FACE, NORMALS, bin_normal, normal_bin};
use glam::Vec3;
use std::sync::LazyLock;

/// cos 60°: the least cosine between normals that agree.
const LEAST: f32 = 0.5;

/// Slack of bounds on angles, in radians: far above the rounding of any dot product.
const SLACK: f32 = 1e-3;

/// Sets of normal bins, one bit each.
pub type Bins = u64;
const _: () = assert!(NORMALS <= Bins::BITS as usize);

/// Whether the unit normals of a point and of a site agree.
#[inline]
pub fn agree(n: Vec3, site: Vec3) -> bool {
    n.dot(site) > LEAST
}

/// What is known of a bin of query normals as a whole.
#[derive(Clone, Debug)]
pub struct Bin {
    centre: Vec3,
    /// The largest angle from the centre to a normal of the bin.
    radius: f32,
    /// The bins that hold any normal that agrees with any of this bin's.
    pub partners: Bins,
}

static BINS: LazyLock<Vec<Bin>> = LazyLock::new(|| {
    let shells: Vec<(Vec3, f32)> = (0..NORMALS).map(|bin| (bin_normal(bin), radius(bin))).collect();
    let near = |a: &(Vec3, f32), b: &(Vec3, f32)| angle(a.0, b.0) < LEAST.acos() + a.1 + b.1 + SLACK;
    let partners = |a: &(Vec3, f32)| shells.iter().enumerate().fold(0, |set, (i, b)| set | (near(a, b) as Bins) << i);
    shells.iter().map(|a| Bin { centre: a.0, radius: a.1, partners: partners(a) }).collect()
});

impl Bin {
    /// All bins, by number.
    pub fn all() -> &'static [Bin] {
        &BINS
    }

    /// Whether a site's normal agrees with all normals of the bin.
    pub fn surely(&self, site: Vec3) -> bool {
        angle(self.centre, site) + self.radius + SLACK < LEAST.acos()
    }

    /// Whether a site's normal agrees with any normal of the bin.
    pub fn maybe(&self, site: Vec3) -> bool {
        angle(self.centre, site) < LEAST.acos() + self.radius + SLACK
    }
}

fn angle(a: Vec3, b: Vec3) -> f32 {
    a.dot(b).clamp(-1.0, 1.0).acos()
}

/// A bin is a square on a face of the cube: its farthest normals are its corners.
fn radius(bin: usize) -> f32 {
    let centre = bin_normal(bin);
    let on_face = centre / centre.abs().max_element();
    let half = 1.0 / FACE as f32;
    let offsets = |v: f32| if v.abs() == 1.0 { [0.0, 0.0] } else { [-half, half] };
    let corners = offsets(on_face.x).into_iter().flat_map(|x| {
        offsets(on_face.y)
            .into_iter()
            .flat_map(move |y| offsets(on_face.z).into_iter().map(move |z| Vec3::new(x, y, z)))
    });
    corners.map(|d| angle(centre, (on_face + d).normalize())).fold(0.0, f32::max)
}

/// The bin of a normal.
#[inline]
pub fn bin(n: Vec3) -> usize {
    normal_bin(n)
}
