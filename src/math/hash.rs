//! Hashes of 32-bit words, for random numbers that are found by counting: `N` at a time, so that loops run in vectors.

/// Four words from four, each of which depends on every bit of all: PCG4D (Jarzynski & Olano 2020, "Hash Functions for GPU
/// Rendering"), and the high bits, which are the best, once more over the low ones. Word by word and side by side, they pass for
/// independent uniform numbers where one word of the input counts.
#[inline(always)]
pub(crate) fn hash4<const N: usize>([a, b, c, d]: [&[u32; N]; 4]) -> [[u32; N]; 4] {
    let [mut p, mut q, mut r, mut s] = [[0; N]; 4];
    // rows by themselves: arrays of rows, handed over whole, would keep this loop from running in vectors
    for k in 0..N {
        let (x, y, z, w) = stirred(congruent(a[k]), congruent(b[k]), congruent(c[k]), congruent(d[k]));
        let (x, y, z, w) = stirred(x ^ x >> 16, y ^ y >> 16, z ^ z >> 16, w ^ w >> 16);
        (p[k], q[k], r[k], s[k]) = (x ^ x >> 16, y ^ y >> 16, z ^ z >> 16, w ^ w >> 16);
    }
    [p, q, r, s]
}

#[inline(always)]
fn congruent(x: u32) -> u32 {
    x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
}

#[inline(always)]
fn stirred(mut x: u32, mut y: u32, mut z: u32, mut w: u32) -> (u32, u32, u32, u32) {
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    (x, y, z, w)
}

/// A bijection of words in which every bit depends on all (Wellons 2018, "Prospecting for Hash Functions", `lowbias32`).
#[inline(always)]
pub(crate) fn hash1(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}
