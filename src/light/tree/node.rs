//! A node: up to sixteen children side by side, and how important each is to a point.

use super::bounds::Cluster;
use crate::simd::{LANES, Lanes, Vec3Lanes, pick};
use glam::Vec3;

/// Children of a node, a lane each. Those that are not there have no intensity.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Node {
    centre: Vec3Lanes,
    radius: Lanes,
    thickness: Lanes,
    axis: Vec3Lanes,
    cos_spread: Lanes,
    sin_spread: Lanes,
    /// At most this counts as 1/d²: distances within the sphere are as its radius.
    inverse_square: Lanes,
    /// A share of that of the brightest child, so that no brightness is beyond an `f32`.
    intensity: Lanes,
    two_sided: [u32; LANES],
    links: [u32; LANES],
}

/// One child of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Child {
    centre: Vec3,
    radius: f32,
    thickness: f32,
    axis: Vec3,
    cos_spread: f32,
    sin_spread: f32,
    inverse_square: f32,
    intensity: f32,
    two_sided: bool,
}

/// Where a child leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    Node(u32),
    Light(u32),
}

/// Marks the links of lights.
const LIGHT: u32 = 1 << 31;

/// By how much angles may be wrong: sines come from cosines, which have 24 bits.
const ANGLE_ERROR: f32 = 1.0 / 1024.0;

/// Distances below the root of this number count as it. Its inverse times [`LANES`] is still within an `f32`.
const LEAST_SQUARE: f32 = 1e-36;

impl Node {
    pub const EMPTY: Node = Node {
        centre: Vec3Lanes::ZERO,
        radius: [0.0; LANES],
        thickness: [0.0; LANES],
        axis: Vec3Lanes::ZERO,
        cos_spread: [0.0; LANES],
        sin_spread: [0.0; LANES],
        inverse_square: [0.0; LANES],
        intensity: [0.0; LANES],
        two_sided: [0; LANES],
        links: [LIGHT; LANES],
    };

    /// `unit`: of the children's intensities.
    pub fn set(&mut self, k: usize, child: &Cluster, link: Link, unit: f64) {
        let cos = child.cos_spread;
        self.centre.set(k, child.centre);
        self.radius[k] = child.radius;
        self.thickness[k] = child.thickness;
        self.axis.set(k, child.axis);
        (self.cos_spread[k], self.sin_spread[k]) = (cos, (1.0 - cos * cos).max(0.0).sqrt());
        self.inverse_square[k] = 1.0 / (child.radius * child.radius).max(LEAST_SQUARE);
        // what has light keeps some
        self.intensity[k] = ((child.intensity / unit) as f32).max(f32::MIN_POSITIVE);
        self.two_sided[k] = child.two_sided.into();
        self.set_link(k, link);
    }

    pub fn set_link(&mut self, k: usize, link: Link) {
        self.links[k] = match link {
            Link::Node(node) => node,
            Link::Light(light) => light | LIGHT,
        };
    }

    /// Gives the lights other numbers.
    pub fn rename(&mut self, name: impl Fn(u32) -> u32) {
        for k in 0..self.count() {
            if let Link::Light(light) = self.link(k) {
                self.set_link(k, Link::Light(name(light)));
            }
        }
    }

    /// Where child `k` leads to.
    #[inline(always)]
    pub fn link(&self, k: usize) -> Link {
        let link = self.links[k];
        if link & LIGHT == 0 { Link::Node(link) } else { Link::Light(link & !LIGHT) }
    }

    /// The children that are there come first.
    pub fn count(&self) -> usize {
        self.intensity.iter().take_while(|intensity| **intensity > 0.0).count()
    }

    #[inline(always)]
    pub fn child(&self, k: usize) -> Child {
        Child {
            centre: self.centre.get(k),
            radius: self.radius[k],
            thickness: self.thickness[k],
            axis: self.axis.get(k),
            cos_spread: self.cos_spread[k],
            sin_spread: self.sin_spread[k],
            inverse_square: self.inverse_square[k],
            intensity: self.intensity[k],
            two_sided: self.two_sided[k] != 0,
        }
    }

    /// [`Child::importance`] of all children.
    #[inline(always)]
    pub fn importances(&self, p: Vec3, n: Vec3) -> Lanes {
        let (mut all, oriented) = ([0.0; LANES], n != Vec3::ZERO);
        for (k, importance) in all.iter_mut().enumerate() {
            *importance = self.child(k).importance(p, n, oriented);
        }
        all
    }
}

impl Child {
    /// Stands for all of a cluster, as one that is as bright as can be: where its importance is 0, so is that of each part.
    pub fn whole(cluster: &Cluster) -> Child {
        let mut node = Node::EMPTY;
        node.set(0, cluster, Link::Light(0), cluster.intensity);
        node.child(0)
    }

    /// An estimate of the irradiance at the point `p` from the lights of this child (as Conty Estevez & Kulla 2018, section
    /// 4.3, with simpler bounds): 0 only where none of them sends light to the side of `n`, or, unless `oriented`, to `p` at
    /// all. Without jumps, so that loops over children or points run in vectors.
    #[inline(always)]
    pub fn importance(&self, p: Vec3, n: Vec3, oriented: bool) -> f32 {
        let to = self.centre - p;
        let square = to.length_squared();
        let square = pick(square > LEAST_SQUARE, square, LEAST_SQUARE);
        let inverse = 1.0 / square.sqrt();
        let wi = to * inverse;
        // sine of the angle under which the sphere is seen; 1 from within
        let size = self.radius * inverse + ANGLE_ERROR;
        let size = pick(size < 1.0, size, 1.0);
        let rest = 1.0 - size * size;
        // the least angle between the lights' axes and the direction from the sphere's centre to `p`
        let cos = -self.axis.dot(wi);
        let cos = pick(self.two_sided, cos.abs(), cos);
        let off = pick(cos < self.cos_spread, cos * self.cos_spread + sine(cos) * self.sin_spread, 1.0);
        let (emitted, received) = (widened(off, size, rest), widened(wi.dot(n), size, rest));
        let received = pick(oriented, received, 1.0);
        // each light shines from a plane, which is no more than the thickness behind the centre
        let shines = off + (self.thickness * inverse + ANGLE_ERROR) > 0.0;
        let lit = shines & (emitted > 0.0) & (received > 0.0);
        let square = inverse * inverse;
        let square = pick(square < self.inverse_square, square, self.inverse_square);
        pick(lit, self.intensity * (emitted * received) * square, 0.0)
    }
}

/// Stands for the cosine of an angle less another, of which the sine is `size`, and `rest` the square of the cosine: positive
/// wherever that is. cos(α − β) = cosα·cosβ + sinα·sinβ, where sinα ≤ 1, and cosβ ≥ cos²β lies between `rest` and 1.
#[inline(always)]
fn widened(cos: f32, size: f32, rest: f32) -> f32 {
    let cos = cos * rest + size;
    pick(cos < 1.0, cos, 1.0)
}

#[inline(always)]
pub(super) fn sine(cos: f32) -> f32 {
    let square = 1.0 - cos * cos;
    pick(square > 0.0, square, 0.0).sqrt()
}

/// Cosine of the difference of two angles, at least 0: of one less another.
#[inline(always)]
pub(super) fn less(cos: f32, sin: f32, cos_less: f32, sin_less: f32) -> f32 {
    pick(cos < cos_less, cos * cos_less + sin * sin_less, 1.0)
}
