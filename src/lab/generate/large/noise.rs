//! Gradient noise for landscapes, by integers and basic arithmetic alone: the same numbers on every machine.

use crate::math::rng::mix;

/// Noise over the plane (Perlin 2002, "Improving Noise"), with gradients from a hash instead of a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) seed: u64,
}

impl Noise {
    /// In about [−1, 1], smooth (C²), 0 at whole coordinates; features are about 1 wide.
    pub(crate) fn at(self, x: f64, z: f64) -> f64 {
        let (column, row) = (x.floor(), z.floor());
        let (fx, fz) = (x - column, z - row);
        let corner = |i: i64, j: i64| {
            let [gx, gz] = self.gradient(column as i64 + i, row as i64 + j);
            gx * (fx - i as f64) + gz * (fz - j as f64)
        };
        let (s, t) = (fade(fx), fade(fz));
        let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
        lerp(lerp(corner(0, 0), corner(1, 0), s), lerp(corner(0, 1), corner(1, 1), s), t)
    }

    /// `octaves` of noise, each twice as fine as the last and `gain` times as strong; the first is 1 wide.
    pub(crate) fn fractal(self, x: f64, z: f64, octaves: u32, gain: f64) -> f64 {
        let (mut sum, mut amplitude, mut frequency) = (0.0, 1.0, 1.0);
        for octave in 0..octaves {
            let layer = Noise { seed: self.seed.wrapping_add(octave as u64) };
            sum += amplitude * layer.at(x * frequency, z * frequency);
            amplitude *= gain;
            frequency *= 2.0;
        }
        sum
    }

    fn gradient(self, column: i64, row: i64) -> [f64; 2] {
        let bits = mix(mix(self.seed ^ mix(column as u64)).wrapping_add(row as u64));
        [bits as u32, (bits >> 32) as u32].map(|half| half as f64 * (2.0 / u32::MAX as f64) - 1.0)
    }
}

/// Perlin's quintic, whose first two derivatives vanish at 0 and 1.
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}
