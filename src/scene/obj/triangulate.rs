//! Polygons into triangles.
//!
//! The polygon is projected along its normal, which is Newell's, so that it need not be flat. Convex
//! ones become fans about the first corner; others lose an ear at a time (Meisters 1975; the bookkeeping is that of
//! O'Rourke, Computational Geometry in C, §1.6). n corners always become n − 2 triangles, wound like the polygon.

use glam::{DVec2, DVec3, Vec3};

/// Concave polygons of more corners are refused, for ears take time that grows with the square of their number.
pub(super) const LARGEST_CONCAVE: usize = 16_384;

/// How often the ears of a polygon that crosses itself are looked for anew before any corner is cut off.
const RESCANS: usize = 8;

type Point = DVec2;

/// Appends the triangles of the polygon with these corners to `out`, as indices of corners. False if it is refused.
/// Any input is safe: where corners coincide, or edges cross, some triangles are degenerate or overlap.
pub(super) fn triangulate(corners: &[[f32; 3]], out: &mut Vec<[usize; 3]>) -> bool {
    match *corners {
        [] | [_] | [_, _] => {}
        [_, _, _] => out.push([0, 1, 2]),
        [a, b, c, d] => quadrilateral([a, b, c, d], out),
        _ => return polygon(corners, out),
    }
    true
}

/// Cut along the diagonal through the reflex corner, if there is one.
fn quadrilateral(corners: [[f32; 3]; 4], out: &mut Vec<[usize; 3]>) {
    let plane = Plane::of(&corners);
    let [a, b, c, d] = corners.map(|corner| plane.project(corner));
    let reflex = [cross(d, a, b), cross(a, b, c), cross(b, c, d), cross(c, d, a)].map(|x| x < 0.0);
    let odd_diagonal = reflex == [false, true, false, false] || reflex == [false, false, false, true];
    fan(4, usize::from(odd_diagonal), out);
}

fn polygon(corners: &[[f32; 3]], out: &mut Vec<[usize; 3]>) -> bool {
    let n = corners.len();
    let plane = Plane::of(corners);
    let points: Vec<Point> = corners.iter().map(|&corner| plane.project(corner)).collect();
    let reflex = |i: usize| cross(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) < 0.0;
    if !(0..n).any(reflex) {
        fan(n, 0, out);
    } else if n <= LARGEST_CONCAVE {
        Ears::new(&points).cut(out);
    } else {
        return false;
    }
    true
}

fn fan(n: usize, first: usize, out: &mut Vec<[usize; 3]>) {
    out.extend((1..n - 1).map(|i| [first, (first + i) % n, (first + i + 1) % n]));
}

/// A plane through the first corner of a polygon, seen from the side from which that runs counter-clockwise.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Plane {
    fn of(corners: &[[f32; 3]]) -> Plane {
        let origin = Vec3::from(corners[0]).as_dvec3();
        let edge = |corner: [f32; 3]| Vec3::from(corner).as_dvec3() - origin;
        // Twice the area vector. A polygon without area has no side from which it looks better.
        let normal: DVec3 = corners.windows(2).map(|w| edge(w[0]).cross(edge(w[1]))).sum();
        let (u, v) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
        Plane { origin, axes: [u, v] }
    }

    fn project(&self, corner: [f32; 3]) -> Point {
        let edge = Vec3::from(corner).as_dvec3() - self.origin;
        DVec2::from(self.axes.map(|axis| edge.dot(axis)))
    }
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b - a).perp_dot(c - a)
}

/// What is left of a polygon while its ears are cut: a ring of corners.
struct Ears<'a> {
    points: &'a [Point],
    before: Vec<usize>,
    after: Vec<usize>,
    /// Corners that can be cut. Cutting one changes only what its neighbours are.
    ear: Vec<bool>,
    left: usize,
    rescans: usize,
}

impl Ears<'_> {
    fn new(points: &[Point]) -> Ears<'_> {
        let n = points.len();
        let before = (0..n).map(|i| (i + n - 1) % n).collect();
        let after = (0..n).map(|i| (i + 1) % n).collect();
        let mut ears = Ears { points, before, after, ear: vec![false; n], left: n, rescans: RESCANS };
        for i in 0..n {
            ears.ear[i] = ears.is_ear(i);
        }
        ears
    }

    fn cut(mut self, out: &mut Vec<[usize; 3]>) {
        let mut at = 0;
        while self.left > 3 {
            let i = self.find(at);
            let (before, after) = (self.before[i], self.after[i]);
            out.push([before, i, after]);
            self.after[before] = after;
            self.before[after] = before;
            self.left -= 1;
            self.ear[before] = self.is_ear(before);
            self.ear[after] = self.is_ear(after);
            at = after;
        }
        out.push([self.before[at], at, self.after[at]]);
    }

    /// The next ear from `at` on. A polygon that crosses itself may have none: then a convex corner, or `at`.
    fn find(&mut self, at: usize) -> usize {
        if let Some(i) = self.ring(at).find(|&i| self.ear[i]) {
            return i;
        }
        if self.rescans > 0 {
            self.rescans -= 1;
            let found: Vec<usize> = self.ring(at).filter(|&i| self.is_ear(i)).collect();
            found.iter().for_each(|&i| self.ear[i] = true);
            if let Some(&i) = found.first() {
                return i;
            }
        }
        self.ring(at).find(|&i| self.turn(i) > 0.0).unwrap_or(at)
    }

    /// The corners left, from `at` on.
    fn ring(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(at), |&i| Some(self.after[i])).take(self.left)
    }

    fn turn(&self, i: usize) -> f64 {
        cross(self.points[self.before[i]], self.points[i], self.points[self.after[i]])
    }

    /// Whether the triangle at corner `i` lies in the polygon: the corner is not reflex and no reflex corner is in the
    /// triangle. Corners at the same place as one of the triangle's do not count: bridges to holes run along them.
    fn is_ear(&self, i: usize) -> bool {
        let (before, after) = (self.before[i], self.after[i]);
        let [a, b, c] = [before, i, after].map(|k| self.points[k]);
        let turn = cross(a, b, c);
        if turn <= 0.0 {
            return turn == 0.0;
        }
        let inside = |p: Point| cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
        !self.ring(after).any(|k| {
            let p = self.points[k];
            inside(p) && self.turn(k) < 0.0 && p != a && p != b && p != c
        })
    }
}
