//! Where a picture is not black: what emits by a picture is a light only there.

use super::texels::Texels;
use crate::math::Rgb;

/// Texels along a side of a block.
const SIDE: usize = 16;

/// Which blocks of texels have one that is not black.
#[derive(Clone, Debug)]
pub(super) struct GlowMap {
    size: [usize; 2],
    columns: usize,
    lit: Vec<bool>,
}

impl GlowMap {
    pub(super) fn new(texels: &Texels) -> GlowMap {
        let (size, columns) = ([texels.width, texels.height], texels.width.div_ceil(SIDE));
        let mut lit = vec![false; columns * texels.height.div_ceil(SIDE)];
        for y in 0..texels.height {
            for x in 0..texels.width {
                let block = &mut lit[y / SIDE * columns + x / SIDE];
                *block = *block || texels.color(x, y).cmpgt(Rgb::ZERO).any();
            }
        }
        GlowMap { size, columns, lit }
    }

    /// Whether the picture, interpolated or not, is black in the box around these coordinates of it.
    pub(super) fn is_black_between(&self, uvs: &[[f32; 2]; 3]) -> bool {
        let range = |axis: usize| {
            let values = uvs.map(|uv| uv[axis]);
            let (low, high) = values.iter().fold((f32::MAX, f32::MIN), |(l, h), &x| (l.min(x), h.max(x)));
            values.iter().all(|x| x.is_finite()).then_some((f64::from(low), f64::from(high)))
        };
        let (Some(u), Some(v)) = (range(0), range(1)) else { return false };
        // rows are counted from the top, v from below
        let (columns, rows) = (blocks(u, self.size[0]), blocks((1.0 - v.1, 1.0 - v.0), self.size[1]));
        rows.iter().all(|row| columns.iter().all(|column| !self.lit[row * self.columns + column]))
    }
}

/// The blocks along an axis that texels between two coordinates are in, with the neighbours that are blended into them.
fn blocks((low, high): (f64, f64), texels: usize) -> Vec<usize> {
    let (first, last) = ((low * texels as f64).floor() - 2.0, (high * texels as f64).ceil() + 2.0);
    let count = texels.div_ceil(SIDE);
    if last - first + 1.0 >= texels as f64 || first.abs().max(last.abs()) > 1e15 {
        return (0..count).collect();
    }
    let mut found: Vec<usize> =
        (first as i64..=last as i64).map(|x| x.rem_euclid(texels as i64) as usize / SIDE).collect();
    found.sort_unstable();
    found.dedup();
    found
}
