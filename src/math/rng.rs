//! Random numbers: one small generator per path, seeded by what the path is, never by who runs it.

use super::lanes::{LANES, Lanes, Mask};

/// PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms"),
/// XSH-RR output, one fixed stream. Its whole state is one word, so a batch of paths keeps it in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng(u64);

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
const INCREMENT: u64 = 1_442_695_040_888_963_407;

impl Rng {
    /// The generator of one path: the same `(seed, pixel, sample)` gives the same numbers on any thread.
    #[inline]
    pub fn for_path(seed: u64, pixel: u32, sample: u32) -> Rng {
        Rng(mix(mix(seed) ^ mix(((pixel as u64) << 32) | sample as u64)))
    }

    /// A generator for anything that is not a path.
    pub fn new(seed: u64) -> Rng {
        Rng(mix(seed))
    }

    /// 32 uniform bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
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
pub struct RngLanes([u64; LANES]);

impl RngLanes {
    pub const ZERO: RngLanes = RngLanes([0; LANES]);

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Rng {
        Rng(self.0[lane])
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, rng: Rng) {
        self.0[lane] = rng.0;
    }

    /// 32 uniform bits for each that draws; the others stay as they are, and get any.
    #[inline(always)]
    fn next_u32(&mut self, draws: &Mask) -> [u32; LANES] {
        let mut bits = [0; LANES];
        for k in 0..LANES {
            let mut rng = self.get(k);
            bits[k] = rng.next_u32();
            self.0[k] = if draws[k] { rng.0 } else { self.0[k] };
        }
        bits
    }

    /// As [`Rng::f32`] for each that draws.
    #[inline(always)]
    pub fn f32(&mut self, draws: &Mask) -> Lanes {
        let bits = self.next_u32(draws);
        let mut u = [0.0; LANES];
        for k in 0..LANES {
            u[k] = unit_f32(bits[k]);
        }
        u
    }

    /// As [`Rng::f64`] for each that draws.
    #[inline(always)]
    pub fn f64(&mut self, draws: &Mask) -> [f64; LANES] {
        let (high, low) = (self.next_u32(draws), self.next_u32(draws));
        let mut u = [0.0; LANES];
        for k in 0..LANES {
            u[k] = unit_f64(high[k], low[k]);
        }
        u
    }
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
pub fn mix(mut x: u64) -> u64 {
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
            let draws = super::super::lanes::mask(|k| !(k + round).is_multiple_of(3));
            let (wide, single) = (lanes.f64(&draws), lanes.f32(&draws));
            for k in (0..LANES).filter(|&k| draws[k]) {
                assert_eq!((wide[k], single[k]), (alone[k].f64(), alone[k].f32()));
            }
            assert!((0..LANES).all(|k| lanes.get(k) == alone[k]), "who does not draw stays as they were");
        }
    }
}
