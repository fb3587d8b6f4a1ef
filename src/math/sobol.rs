//! Points of the four-dimensional Sobol' sequence, shuffled and scrambled by hashes (Burley 2020, "Practical Hash-based Owen
//! Scrambling"): whoever knows a point's number, and the seeds of its set, has its coordinates without any state.
//!
//! Numbers are worked on with their bits turned round, the highest first, as a hash of Laine and Karras (2011, "Stratified
//! Sampling for Stochastic Transparency") carries from low bits to high ones, and a scramble goes the other way.

/// Dimensions of the sequence.
pub(crate) const DIMENSIONS: usize = 4;

/// By dimension and bit of the index: the coordinate's bits that this bit of the index flips, turned round.
const DIRECTIONS: [[u32; 32]; DIMENSIONS] =
    [van_der_corput(), directions([1, 0, 0], 1, 0), directions([1, 3, 0], 2, 1), directions([1, 3, 1], 3, 1)];

/// Random bits that make a set of points differ from others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seeds<const N: usize> {
    /// Of the order in which the points come.
    pub(crate) shuffle: [u32; N],
    /// Of the coordinates.
    pub(crate) scramble: [[u32; N]; DIMENSIONS],
}

/// The dimensions `0..D` of points of as many sets, each by its number in its set, in steps of 2⁻³² of the unit interval.
/// `bits` is at least the number of bits of the highest number; the points do not depend on it otherwise.
///
/// Of a set with random seeds any 2ᵐ points from number 0 on, or from a multiple of 2ᵐ, are a randomised (t, m, 4)-net: t is 0
/// for dimensions 0 and 1 together, and 3 for all four.
#[inline(always)]
pub(crate) fn points<const D: usize, const N: usize>(number: &[u32; N], bits: u32, seeds: &Seeds<N>) -> [[u32; N]; D] {
    let mut order = [0; N];
    for k in 0..N {
        // The order of 0 is taken off, which leaves the high bits at 0 and makes the sum below short. It adds the same word
        // to all points of a set, and a scrambled set has the same distribution with that word and without.
        let shuffle = seeds.shuffle[k];
        order[k] = scrambled(number[k].reverse_bits(), shuffle) ^ scrambled(0, shuffle);
    }
    let mut x = if D <= 2 { plane(&order) } else { sums(&order, bits) };
    for d in 0..D {
        for k in 0..N {
            x[d][k] = scrambled(x[d][k], seeds.scramble[d][k]).reverse_bits();
        }
    }
    x
}

/// The first two coordinates at most, turned round as the numbers are. A bit of the second is the sum of those bits of the number
/// whose places hold its own place (Pascal's triangle modulo 2), which five steps add up. Sums bit by bit would become jumps here.
#[inline(always)]
fn plane<const D: usize, const N: usize>(order: &[u32; N]) -> [[u32; N]; D] {
    let mut x = [[0; N]; D];
    for k in 0..N {
        let mut sum = order[k].reverse_bits();
        x[0][k] = sum;
        sum ^= sum >> 16;
        sum ^= sum >> 8 & 0x00ff_00ff;
        sum ^= sum >> 4 & 0x0f0f_0f0f;
        sum ^= sum >> 2 & 0x3333_3333;
        sum ^= sum >> 1 & 0x5555_5555;
        x[D - 1][k] = if D == 2 { sum } else { x[0][k] };
    }
    x
}

/// The same of all dimensions, bit by bit.
#[inline(always)]
fn sums<const D: usize, const N: usize>(order: &[u32; N], bits: u32) -> [[u32; N]; D] {
    let mut x = [[0; N]; D];
    // dimension by dimension, as a loop over lanes with several sums in it becomes jumps
    for bit in 0..bits {
        for (d, sums) in x.iter_mut().enumerate() {
            let direction = DIRECTIONS[d][bit as usize % 32];
            for k in 0..N {
                sums[k] ^= ((order[k] << bit) as i32 >> 31) as u32 & direction;
            }
        }
    }
    x
}

/// A hash in which each bit depends on those below it alone, with the constants of Vegdahl (2021, "Building a Better LK Hash"):
/// of a number that is turned round, it is a nested uniform scramble (Owen 1995).
#[inline(always)]
fn scrambled(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Dimension 0: bits of the index from the other end, turned round.
const fn van_der_corput() -> [u32; 32] {
    let (mut directions, mut bit) = ([0; 32], 0);
    while bit < 32 {
        directions[bit] = 1 << bit;
        bit += 1;
    }
    directions
}

/// Direction numbers, turned round, of the primitive polynomial of degree `s` with the inner coefficients `a`, from the first
/// numbers `m` (Joe & Kuo 2008, "Constructing Sobol Sequences with Better Two-Dimensional Projections").
const fn directions(m: [u32; 3], s: usize, a: u32) -> [u32; 32] {
    let (mut v, mut bit) = ([0u32; 32], 0);
    while bit < 32 {
        v[bit] = if bit < s {
            m[bit] << (31 - bit)
        } else {
            let (mut sum, mut back) = (v[bit - s] ^ v[bit - s] >> s, 1);
            while back < s {
                sum ^= (a >> (s - 1 - back) & 1) * v[bit - back];
                back += 1;
            }
            sum
        };
        bit += 1;
    }
    let mut bit = 0;
    while bit < 32 {
        v[bit] = v[bit].reverse_bits();
        bit += 1;
    }
    v
}

#[cfg(test)]
#[path = "sobol_tests.rs"]
mod tests;
