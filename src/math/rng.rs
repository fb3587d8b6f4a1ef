//! Random numbers: one small generator per path, seeded by what the path is, never by who runs it.

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
        (self.next_u32() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in [0, 1), in steps of 2⁻⁵³, for what 24 bits are too few.
    #[inline]
    pub fn f64(&mut self) -> f64 {
        let high = (self.next_u32() as u64) << 32;
        ((high | self.next_u32() as u64) >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Two independent uniforms in [0, 1).
    #[inline]
    pub fn f32x2(&mut self) -> [f32; 2] {
        [self.f32(), self.f32()]
    }
}

/// A bijective 64-bit hash (the finaliser of SplitMix64, Steele et al. 2014).
#[inline]
pub fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
