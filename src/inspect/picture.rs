//! Functions of direction as pictures.

use crate::image::Image;
use crate::math::Frame;
use crate::math::Rgb;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Pixels along the height of a picture.
const HEIGHT: usize = 256;
/// What is no direction, or one that is not known; darker than paper, and of no grey.
const NOTHING: Rgb = Rgb::new(0.02, 0.04, 0.1);

/// A value for every direction, `None` where there is none.
pub(crate) struct Chart {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<Option<f32>>,
}

impl Chart {
    /// All directions in world space: u = atan2(x, −z)/2π, v = acos(y)/π, as environment lights have it; +y on top.
    pub(crate) fn lat_long(value: impl Fn(Vec3) -> Option<f32>) -> Chart {
        let (width, height) = (2 * HEIGHT, HEIGHT);
        Chart::new(width, height, |x, y| {
            let (phi, theta) = (TAU * x / width as f32, PI * y / height as f32);
            let (sin, cos) = theta.sin_cos();
            value(Vec3::new(sin * phi.sin(), cos, -sin * phi.cos()))
        })
    }

    /// The hemisphere about the frame's normal, which is in the middle, by Lambert's equal-area map; `s` points right and
    /// `t` up.
    pub(crate) fn disk(frame: &Frame, value: impl Fn(Vec3) -> Option<f32>) -> Chart {
        Chart::new(HEIGHT, HEIGHT, |x, y| {
            let p = Vec2::new(x, HEIGHT as f32 - y) * (2.0 / HEIGHT as f32) - 1.0;
            let r2 = p.length_squared();
            let local = (p * (2.0 - r2).max(0.0).sqrt()).extend(1.0 - r2);
            if r2 < 1.0 { value(frame.to_world(local)) } else { None }
        })
    }

    /// `value` is asked for the middles of the pixels.
    fn new(width: usize, height: usize, value: impl Fn(f32, f32) -> Option<f32>) -> Chart {
        let middle = |i: usize| (i % width, i / width);
        let at = |i: usize| value(middle(i).0 as f32 + 0.5, middle(i).1 as f32 + 0.5);
        Chart { width, height, values: (0..width * height).map(at).collect() }
    }

    /// The values, with 0 for none.
    pub(crate) fn or_zero(&self) -> Vec<f32> {
        self.values.iter().map(|value| value.unwrap_or(0.0)).collect()
    }
}

impl Chart {
    /// The values as greys of which `white` is the brightest; a colour that is no grey where there is none.
    pub(crate) fn picture(&self, white: f32) -> Image {
        let colour = |value: &Option<f32>| value.map_or(NOTHING, |value| Rgb::splat(value / white));
        Image { width: self.width, height: self.height, data: self.values.iter().map(colour).collect() }
    }
}
