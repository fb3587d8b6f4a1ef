//! What charts of one row a thing share: their size, and the axis below the rows.

use crate::draw::Axis;
use crate::draw::{Anchor, GRID, INK, Svg};

pub(super) const WIDTH: f64 = 760.0;
/// Above the rows, and below them.
pub(super) const TOP: f64 = 62.0;
pub(super) const BOTTOM: f64 = 54.0;
pub(super) const ROW: f64 = 22.0;
/// Room for figures on the right.
pub(super) const FIGURES: f64 = 150.0;

/// The part of a chart that the rows fill.
pub(super) struct Frame {
    pub(crate) axis: Axis,
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

impl Frame {
    /// Where a value lies.
    pub(crate) fn at(&self, value: f64) -> f64 {
        self.left + self.axis.place(value) * (self.right - self.left)
    }

    pub(crate) fn axis(&self, svg: &mut Svg, label: &str) {
        for (value, text) in self.axis.ticks() {
            let x = self.at(value);
            svg.line((x, self.top), (x, self.bottom), GRID, 1.0, "");
            svg.text((x, self.bottom + 17.0), 11.5, INK, Anchor::Middle, &text);
        }
        svg.text((0.5 * (self.left + self.right), self.bottom + 40.0), 12.5, INK, Anchor::Middle, label);
    }
}
