//! Numbers by the cosine of a direction, at equidistant nodes, and points over the visible normals that they are computed with.

use crate::simd::truncate;

/// Nodes of a table, equidistant in cosθ from 0 to 1.
pub(super) const NODES: usize = 64;

/// Cosine of a node; the first is moved off the horizon.
pub(super) fn node(i: usize) -> f32 {
    (i as f32 / (NODES - 1) as f32).max(1e-6)
}

#[inline(always)]
pub(super) fn interpolate(table: &[f32; NODES], cos: f32) -> f32 {
    let x = cos.clamp(0.0, 1.0) * (NODES - 1) as f32;
    let i = (truncate(x) as usize).min(NODES - 2);
    let t = x - i as f32;
    table[i] + t * (table[i + 1] - table[i])
}

/// 2∫f(µ)µ dµ of the interpolated table, exactly.
pub(super) fn cosine_mean(table: &[f32; NODES]) -> f32 {
    let step = 1.0 / (NODES - 1) as f32;
    let piece = |i: usize| {
        let (a, b, x) = (table[i], table[i + 1], i as f32);
        (3.0 * x * (a + b) + a + 2.0 * b) / 3.0
    };
    (0..NODES - 1).map(piece).sum::<f32>() * step * step
}

/// Points of the quadrature over visible normals: half the turn (the other half is its mirror image) × radius.
const POINTS: [usize; 2] = [24, 64];

/// Random numbers of visible normals with their weights, which sum to 1.
pub(super) fn visible_normals() -> impl Iterator<Item = ([f32; 2], f32)> {
    points(POINTS[0]).flat_map(|(u0, w0)| points(POINTS[1]).map(move |(u1, w1)| ([0.5 * u0, u1], w0 * w1)))
}

/// Points and weights on [0, 1]: midpoints in s with u = s²(3 − 2s), dense at both ends, where normals are extreme.
fn points(n: usize) -> impl Iterator<Item = (f32, f32)> {
    let n = n as f32;
    // the weights 6s(1 − s)/n sum to this much
    let sum = 1.0 + 0.5 / (n * n);
    (0..n as usize).map(move |i| {
        let s = (i as f32 + 0.5) / n;
        (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / (n * sum))
    })
}
