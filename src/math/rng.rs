//! Random numbers in sequence, from a small generator. The numbers of paths are found without one, by the integrator's sampler.

/// PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms"),
/// XSH-RR output, one fixed stream. Its whole state is one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng(u64);

const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
const INCREMENT: u64 = 1_442_695_040_888_963_407;

impl Rng {
    /// The generator of one place: the same `(seed, pixel, sample)` gives the same numbers on any thread.
    #[inline]
    pub(crate) fn for_place(seed: u64, pixel: u32, sample: u32) -> Rng {
        Rng(mix(mix(seed) ^ mix(((pixel as u64) << 32) | sample as u64)))
    }

    /// A generator for anything else.
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

/// The 32 bits that a state gives.
#[inline(always)]
fn output(state: u64) -> u32 {
    let xorshifted = (((state >> 18) ^ state) >> 27) as u32;
    xorshifted.rotate_right((state >> 59) as u32)
}

/// Uniform in [0, 1), in steps of 2⁻²⁴, from as many bits.
#[inline(always)]
pub(crate) fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The same in steps of 2⁻⁵³.
#[inline(always)]
pub(crate) fn unit_f64(high: u32, low: u32) -> f64 {
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
