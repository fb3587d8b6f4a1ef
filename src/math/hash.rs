//! Hashes of 32-bit words, for random numbers that are found by counting: `N` at a time, so that loops run in vectors.

/// Four words from four, each of which depends on every bit of all: PCG4D (Jarzynski & Olano 2020, "Hash Functions for GPU
/// Rendering"), and the high bits, which are the best, once more over the low ones. Word by word and side by side, they pass for
/// independent uniform numbers where one word of the input counts.
#[inline(always)]
pub(crate) fn hash4<const N: usize>(mut v: [[u32; N]; 4]) -> [[u32; N]; 4] {
    for k in 0..N {
        let [mut x, mut y, mut z, mut w] = v.map(|row| row[k].wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
        (x, y, z, w) = stirred([x, y, z, w]).into();
        (x, y, z, w) = (x ^ x >> 16, y ^ y >> 16, z ^ z >> 16, w ^ w >> 16);
        let stirred = stirred([x, y, z, w]);
        for (row, word) in v.iter_mut().zip(stirred) {
            row[k] = word ^ word >> 16;
        }
    }
    v
}

#[inline(always)]
fn stirred([mut x, mut y, mut z, mut w]: [u32; 4]) -> [u32; 4] {
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// A bijection of words in which every bit depends on all (Wellons 2018, "Prospecting for Hash Functions", `lowbias32`).
#[inline(always)]
pub(crate) fn hash1(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}
