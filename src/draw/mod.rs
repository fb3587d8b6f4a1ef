//! Drawings: SVG files that are written element by element, pictures of them with letters, and axes with marks.

pub(crate) mod axis;
pub(crate) mod raster;
pub(crate) mod svg;

pub(crate) use axis::{Axis, short};
pub(crate) use raster::{pixels, png, tree};
pub(crate) use svg::{Anchor, COLORS, FAINT, GRID, INK, Svg, wrapped};
