//! Polygons into triangles.
//!
//! The polygon is projected along the largest component of its normal (Newell's, so that it need not be flat). Convex
//! ones become fans about the first corner; others lose an ear at a time (Meisters 1975; the bookkeeping is that of
//! O'Rourke, Computational Geometry in C, §1.6). n corners always become n − 2 triangles, wound like the polygon.

/// Concave polygons of more corners are refused, for ears take time that grows with the square of their number.
pub(super) const LARGEST_CONCAVE: usize = 16_384;

/// How often the ears of a polygon that crosses itself are looked for anew before any corner is cut off.
const RESCANS: usize = 8;

type Point = [f64; 2];

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
    let axes = axes(&corners);
    let [a, b, c, d] = corners.map(|corner| project(corner, axes));
    let reflex = [cross(d, a, b), cross(a, b, c), cross(b, c, d), cross(c, d, a)].map(|x| x < 0.0);
    let odd_diagonal =
        reflex == [false, true, false, false] || reflex == [false, false, false, true];
    fan(4, usize::from(odd_diagonal), out);
}

fn polygon(corners: &[[f32; 3]], out: &mut Vec<[usize; 3]>) -> bool {
    let n = corners.len();
    let axes = axes(corners);
    let points: Vec<Point> = corners.iter().map(|&corner| project(corner, axes)).collect();
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

/// The coordinates to keep, in the order in which the polygon runs counter-clockwise.
fn axes(corners: &[[f32; 3]]) -> [usize; 2] {
    let normal = newell(corners);
    let axis =
        (0..3).fold(0, |best, k| if normal[k].abs() > normal[best].abs() { k } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 { [v, u] } else { [u, v] }
}

fn project(corner: [f32; 3], axes: [usize; 2]) -> Point {
    axes.map(|k| f64::from(corner[k]))
}

/// Twice the area vector: the sum of cross products of successive corners, relative to the first.
fn newell(corners: &[[f32; 3]]) -> [f64; 3] {
    let origin = corners[0].map(f64::from);
    let edge = |c: [f32; 3]| [0, 1, 2].map(|k| f64::from(c[k]) - origin[k]);
    corners.windows(2).fold([0.0; 3], |sum, pair| {
        let (a, b) = (edge(pair[0]), edge(pair[1]));
        [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            sum[k] + a[i] * b[j] - a[j] * b[i]
        })
    })
}

/// Twice the signed area of a triangle, positive if counter-clockwise.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
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
        let mut ears =
            Ears { points, before, after, ear: vec![false; n], left: n, rescans: RESCANS };
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
        let inside =
            |p: Point| cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
        !self.ring(after).any(|k| {
            let p = self.points[k];
            inside(p) && self.turn(k) < 0.0 && p != a && p != b && p != c
        })
    }
}
