//! Random numbers: one small generator per path, seeded by what the path is, never by who runs it.

use crate::simd::{LANES, Lanes, Mask, Packing, pick};

/// PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms"),
/// XSH-RR output, one fixed stream. Its whole state is one word, so a batch of paths keeps it in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng(u64);

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
const INCREMENT: u64 = 1_442_695_040_888_963_407;

impl Rng {
    /// The generator of one path: the same `(seed, pixel, sample)` gives the same numbers on any thread.
    #[inline]
    pub(crate) fn for_path(seed: u64, pixel: u32, sample: u32) -> Rng {
        Rng(mix(mix(seed) ^ mix(((pixel as u64) << 32) | sample as u64)))
    }

    /// A generator for a further branch of the path, where it splits, counted from 1.
    #[inline]
    pub(crate) fn branch(&mut self, branch: u32) -> Rng {
        Rng::of_branch(self.next_u32(), branch)
    }

    #[inline(always)]
    fn of_branch(bits: u32, branch: u32) -> Rng {
        Rng::new((bits as u64) << 32 | branch as u64)
    }

    /// A generator for anything that is not a path.
    #[inline]
    pub fn new(seed: u64) -> Rng {
        Rng(mix(seed))
    }

    /// 32 uniform bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
        output(old)
    }

    /// Uniform in [0, 1), in steps of 2⁻²⁴: 1 is never returned.
    #[inline]
    pub fn f32(&mut self) -> f32 {
        unit_f32(self.next_u32())
    }

    /// Uniform in [0, 1), in steps of 2⁻⁵³, for what 24 bits are too few.
    #[inline]
    pub fn f64(&mut self) -> f64 {
        let high = self.next_u32();
        unit_f64(high, self.next_u32())
    }

    /// Two independent uniforms in [0, 1).
    #[inline]
    pub fn f32x2(&mut self) -> [f32; 2] {
        [self.f32(), self.f32()]
    }
}

/// Generators of a packet's paths, side by side: each gives the numbers that [`Rng`] by itself gives.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct RngLanes([u64; LANES]);

impl RngLanes {
    pub(crate) const ZERO: RngLanes = RngLanes([0; LANES]);

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Rng {
        Rng(self.0[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, rng: Rng) {
        self.0[lane] = rng.0;
    }

    /// Puts the generators that were chosen behind those which are there; see [`Packing::put`].
    #[inline(always)]
    pub(crate) fn pack(&self, packing: &Packing, [first, second]: [&mut RngLanes; 2]) {
        packing.put(&self.0, [&mut first.0, &mut second.0]);
    }

    /// `N` times 32 uniform bits for each that draws; the others stay as they are, and get any. Every state follows from the
    /// first, so that none waits for the one before.
    #[inline(always)]
    pub(crate) fn bits<const N: usize>(&mut self, draws: Mask) -> [[u32; LANES]; N] {
        let (mut bits, draws) = ([[0; LANES]; N], draws.lanes());
        for n in 0..N {
            let (multiplier, increment) = const { leaps::<N>() }[n];
            for k in 0..LANES {
                bits[n][k] = output(self.0[k].wrapping_mul(multiplier).wrapping_add(increment));
            }
        }
        let (multiplier, increment) = const { leap(N) };
        for k in 0..LANES {
            let next = self.0[k].wrapping_mul(multiplier).wrapping_add(increment);
            self.0[k] = pick(draws.has(k), next, self.0[k]);
        }
        bits
    }

    /// Generators for a further branch of each path that draws, which know nothing of those before: [`Rng::branch`].
    #[inline(always)]
    pub(crate) fn branch(&mut self, draws: Mask, branch: u32) -> RngLanes {
        let ([bits], mut branches) = (self.bits(draws), RngLanes::ZERO);
        for k in 0..LANES {
            branches.set(k, Rng::of_branch(bits[k], branch));
        }
        branches
    }

    /// As [`Rng::f32`] for each that draws.
    #[inline(always)]
    pub(crate) fn f32(&mut self, draws: Mask) -> Lanes {
        let [bits] = self.bits(draws);
        unit_f32_lanes(&bits)
    }

    /// As [`Rng::f32x2`] for each that draws.
    #[inline(always)]
    pub(crate) fn f32x2(&mut self, draws: Mask) -> [Lanes; 2] {
        let [a, b] = self.bits(draws);
        [unit_f32_lanes(&a), unit_f32_lanes(&b)]
    }

    /// As [`Rng::f32`] and then [`Rng::f64`] for each that draws.
    #[inline(always)]
    pub(crate) fn f32_f64(&mut self, draws: Mask) -> (Lanes, [f64; LANES]) {
        let [a, high, low] = self.bits(draws);
        (unit_f32_lanes(&a), unit_f64_lanes(&high, &low))
    }

    /// As [`Rng::f64`] and then [`Rng::f32x2`] for each that draws.
    #[inline(always)]
    pub(crate) fn f64_f32x2(&mut self, draws: Mask) -> ([f64; LANES], [Lanes; 2]) {
        let [high, low, a, b] = self.bits(draws);
        (unit_f64_lanes(&high, &low), [unit_f32_lanes(&a), unit_f32_lanes(&b)])
    }
}

/// What `steps` steps together make of a state: multiplier and increment.
const fn leap(steps: usize) -> (u64, u64) {
    let (mut multiplier, mut increment, mut step) = (1u64, 0u64, 0);
    while step < steps {
        multiplier = multiplier.wrapping_mul(MULTIPLIER);
        increment = increment.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
        step += 1;
    }
    (multiplier, increment)
}

/// [`leap`] by 0 to N − 1 steps.
const fn leaps<const N: usize>() -> [(u64, u64); N] {
    let (mut leaps, mut n) = ([(0, 0); N], 0);
    while n < N {
        leaps[n] = leap(n);
        n += 1;
    }
    leaps
}

/// The 32 bits that a state gives.
#[inline(always)]
fn output(state: u64) -> u32 {
    let xorshifted = (((state >> 18) ^ state) >> 27) as u32;
    xorshifted.rotate_right((state >> 59) as u32)
}

#[inline(always)]
fn unit_f32_lanes(bits: &[u32; LANES]) -> Lanes {
    let mut u = [0.0; LANES];
    for k in 0..LANES {
        u[k] = unit_f32(bits[k]);
    }
    u
}

#[inline(always)]
fn unit_f64_lanes(high: &[u32; LANES], low: &[u32; LANES]) -> [f64; LANES] {
    let mut u = [0.0; LANES];
    for k in 0..LANES {
        u[k] = unit_f64(high[k], low[k]);
    }
    u
}

#[inline(always)]
fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[inline(always)]
fn unit_f64(high: u32, low: u32) -> f64 {
    ((((high as u64) << 32) | low as u64) >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// A bijective 64-bit hash (the finaliser of SplitMix64, Steele et al. 2014).
#[inline]
pub(crate) fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generators_side_by_side_draw_as_each_alone() {
        let mut lanes = RngLanes::ZERO;
        let mut alone: Vec<Rng> = (0..LANES as u64).map(Rng::new).collect();
        (0..LANES).for_each(|k| lanes.set(k, alone[k]));
        for round in 0..30 {
            let draws = crate::simd::mask(|k| !(k + round).is_multiple_of(3));
            let (a, [b, c]) = lanes.f64_f32x2(draws);
            let ((d, e), f, [g, h]) = (lanes.f32_f64(draws), lanes.f32(draws), lanes.f32x2(draws));
            for k in (0..LANES).filter(|&k| draws.has(k)) {
                let rng = &mut alone[k];
                assert_eq!((a[k], [b[k], c[k]]), (rng.f64(), rng.f32x2()));
                assert_eq!((d[k], e[k], f[k], [g[k], h[k]]), (rng.f32(), rng.f64(), rng.f32(), rng.f32x2()));
            }
            let branches = lanes.branch(draws, 3);
            (0..LANES).filter(|&k| draws.has(k)).for_each(|k| assert_eq!(branches.get(k), alone[k].branch(3)));
            assert!((0..LANES).all(|k| lanes.get(k) == alone[k]), "who does not draw stays as they were");
        }
    }
}
