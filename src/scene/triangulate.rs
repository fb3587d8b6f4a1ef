//! Polygons into triangles.
//!
//! The polygon is projected along its normal, which is Newell's, so that it need not be flat. Convex
//! ones become fans about the first corner; others lose an ear at a time (Meisters 1975; the bookkeeping is that of
//! O'Rourke, Computational Geometry in C, §1.6). Before any ear, corners go that enclose no area: doubled ones and the tips of
//! spikes, which run out and back along a line. n corners always become n − 2 triangles, wound like the polygon.

use glam::{DVec2, DVec3, Vec3};

/// Concave polygons of more corners are refused, for ears take time that grows with the square of their number.
pub(super) const LARGEST_CONCAVE: usize = 16_384;

/// The ears of a polygon of so many corners are looked for anew once, those of smaller ones more often, before any corner is cut
/// off: a polygon that crosses itself may have none.
const RESCANNED: usize = 20_000;

/// A spike is at most as wide as so many roundings of its coordinates to single precision, ...
const SPIKE_ROUNDINGS: f64 = 4.0;

/// ... or this share of its length: digits that were left off when the file was written make its sides cross. A slit of that shape
/// is filled, which is not seen.
const SPIKE_WIDTH: f64 = 1e-4;

/// Areas that differ by less, relatively, are the same but for rounding.
const SAME_AREA: f64 = 1e-6;

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

/// Cut along the diagonal through the reflex corner, if there is one. The other diagonal is the better one where its triangles have
/// less area: they tile the quadrilateral, and the first ones overlap.
fn quadrilateral(corners: [[f32; 3]; 4], out: &mut Vec<[usize; 3]>) {
    let plane = Plane::of(&corners);
    let [a, b, c, d] = corners.map(|corner| plane.project(corner));
    let turns = [cross(d, a, b), cross(a, b, c), cross(b, c, d), cross(c, d, a)];
    let mut odd_diagonal = false;
    if turns.iter().any(|&turn| turn <= 0.0) {
        let reflex = turns.map(|turn| turn < 0.0);
        odd_diagonal = reflex == [false, true, false, false] || reflex == [false, false, false, true];
        let areas = [turns[1].abs() + turns[3].abs(), turns[0].abs() + turns[2].abs()];
        let (chosen, other) = (areas[usize::from(odd_diagonal)], areas[usize::from(!odd_diagonal)]);
        odd_diagonal ^= other < chosen * (1.0 - SAME_AREA);
    }
    fan(4, usize::from(odd_diagonal), out);
}

fn polygon(corners: &[[f32; 3]], out: &mut Vec<[usize; 3]>) -> bool {
    let n = corners.len();
    let plane = Plane::of(corners);
    let points: Vec<Point> = corners.iter().map(|&corner| plane.project(corner)).collect();
    let spikes = Spikes::new(corners);
    if (0..n).all(|i| spikes.is_convex([points[(i + n - 1) % n], points[i], points[(i + 1) % n]])) {
        fan(n, 0, out);
    } else if n <= LARGEST_CONCAVE {
        Ears::new(&points, spikes).cut(out);
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

/// Tells corners that enclose an area from those that do not.
struct Spikes {
    /// What is not wider is one.
    width: f64,
}

impl Spikes {
    /// For a polygon with these corners.
    fn new(corners: &[[f32; 3]]) -> Spikes {
        let largest = corners.iter().flatten().fold(0.0f32, |largest, x| largest.max(x.abs()));
        let rounding = f64::from(largest) * f64::from(f32::EPSILON) * 0.5;
        Spikes { width: SPIKE_ROUNDINGS * rounding }
    }

    /// Whether the middle one of three corners in a row is at the place of another of them, or the tip of a spike.
    fn is_flat(&self, [before, corner, after]: [Point; 3]) -> bool {
        let edges = [before - corner, after - corner];
        if edges.contains(&Point::ZERO) {
            return true;
        }
        let length = edges[0].length().max(edges[1].length());
        let width = cross(before, corner, after).abs() / length;
        edges[0].dot(edges[1]) > 0.0 && width <= self.width.max(SPIKE_WIDTH * length)
    }

    /// Whether the polygon turns there as convex ones do, or goes straight on.
    fn is_convex(&self, corners: [Point; 3]) -> bool {
        let [before, corner, after] = corners;
        cross(before, corner, after) >= 0.0 && !self.is_flat(corners)
    }
}

/// What is left of a polygon while its ears are cut: a ring of corners.
struct Ears<'a> {
    points: &'a [Point],
    spikes: Spikes,
    before: Vec<usize>,
    after: Vec<usize>,
    /// Corners that can be cut. Cutting one changes only what its neighbours are.
    ear: Vec<bool>,
    /// Corners that may enclose no area.
    suspects: Vec<usize>,
    /// The corner where a spike came back, beside where it went out.
    foot: Option<usize>,
    left: usize,
    rescans: usize,
}

impl Ears<'_> {
    fn new(points: &[Point], spikes: Spikes) -> Ears<'_> {
        let n = points.len();
        let before = (0..n).map(|i| (i + n - 1) % n).collect();
        let after = (0..n).map(|i| (i + 1) % n).collect();
        let (ear, suspects, rescans) = (vec![false; n], (0..n).rev().collect(), (RESCANNED / n).max(8));
        Ears { points, spikes, before, after, ear, suspects, foot: None, left: n, rescans }
    }

    fn cut(mut self, out: &mut Vec<[usize; 3]>) {
        let mut at = 0;
        while let Some(i) = self.flat() {
            at = self.remove(i, out);
        }
        let found: Vec<usize> = self.ring(at).filter(|&i| self.is_ear(i)).collect();
        found.into_iter().for_each(|i| self.ear[i] = true);
        while self.left > 3 {
            let i = self.flat().unwrap_or_else(|| self.find(at));
            at = self.remove(i, out);
            for neighbour in [self.before[at], at] {
                self.ear[neighbour] = self.is_ear(neighbour);
            }
        }
        out.push([self.before[at], at, self.after[at]]);
    }

    /// Cuts corner `i` off; the one after it.
    fn remove(&mut self, i: usize, out: &mut Vec<[usize; 3]>) -> usize {
        let (before, after) = (self.before[i], self.after[i]);
        out.push([before, i, after]);
        self.after[before] = after;
        self.before[after] = before;
        self.left -= 1;
        self.suspects.extend([before, after]);
        after
    }

    /// A corner that encloses no area, while there are more than three.
    fn flat(&mut self) -> Option<usize> {
        if let Some(foot) = self.foot.take().filter(|_| self.left > 3) {
            return Some(foot);
        }
        while self.left > 3
            && let Some(i) = self.suspects.pop()
        {
            let corners = [self.before[i], i, self.after[i]].map(|k| self.points[k]);
            let there = self.after[self.before[i]] == i;
            if there && self.spikes.is_flat(corners) {
                let [before, tip, after] = corners;
                let missed = before.distance(after) <= SPIKE_WIDTH * before.distance(tip).max(after.distance(tip));
                self.foot = missed.then_some(self.after[i]);
                return Some(i);
            }
        }
        None
    }

    /// The next ear from `at` on. A polygon that crosses itself may have none: then the corner at which least is lost or gained.
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
        let area = |i: &usize| self.turn(*i).abs();
        self.ring(at).min_by(|i, j| area(i).total_cmp(&area(j))).unwrap_or(at)
    }

    /// The corners left, from `at` on.
    fn ring(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(at), |&i| Some(self.after[i])).take(self.left)
    }

    fn turn(&self, i: usize) -> f64 {
        cross(self.points[self.before[i]], self.points[i], self.points[self.after[i]])
    }

    /// Whether the triangle at corner `i` lies in the polygon: the corner is convex, and nothing of the polygon enters the
    /// triangle.
    fn is_ear(&self, i: usize) -> bool {
        let (before, after) = (self.before[i], self.after[i]);
        let ear = [before, i, after].map(|k| self.points[k]);
        let [a, b, c] = ear;
        cross(a, b, c) > 0.0 && !self.ring(after).any(|k| k != before && k != i && k != after && self.enters(k, ear))
    }

    /// Whether the polygon enters a triangle at its corner `k`. A reflex corner does from within it. One that is in line with
    /// its neighbours would be left on the edge of another triangle, where it is on the cut. One at the place of the triangle's
    /// corners does where its edges run into it; bridges to holes run along it.
    fn enters(&self, k: usize, [a, b, c]: [Point; 3]) -> bool {
        let p = self.points[k];
        let sides = [cross(a, b, p), cross(b, c, p), cross(c, a, p)];
        if sides.iter().any(|&side| side < 0.0) {
            return false;
        }
        let edges = [self.before[k], self.after[k]].map(|i| self.points[i] - p);
        let into = |along: Point, back: Point| {
            edges.iter().any(|edge| (along - p).perp_dot(*edge) > 0.0 && edge.perp_dot(back - p) > 0.0)
        };
        if p == a {
            into(b, c)
        } else if p == b {
            into(c, a)
        } else if p == c {
            into(a, b)
        } else {
            let turn = self.turn(k);
            turn < 0.0 || turn == 0.0 && sides[2] == 0.0
        }
    }
}
