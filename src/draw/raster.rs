//! Drawings as pixels.

use crate::{Error, Result};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};
use std::sync::{Arc, LazyLock};

/// Pixels of a PNG for each unit of the SVG.
const SCALE: f32 = 2.0;

/// The one font that drawings are written in; it comes with the program, so that they look the same everywhere.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().next().and_then(|face| face.families.first()).map(|(name, _)| name.clone());
    fonts.set_sans_serif_family(family.unwrap_or_default());
    Arc::new(fonts)
});

/// What an SVG consists of, its letters as outlines.
///
/// # Errors
/// [`Error::Scene`] for text that is no SVG.
pub(crate) fn tree(svg: &str) -> Result<Tree> {
    let options = Options { fontdb: FONTS.clone(), ..Options::default() };
    Tree::from_str(svg, &options).map_err(|e| fault(e.to_string()))
}

/// The SVG's pixels at so many for each of its units.
///
/// # Errors
/// [`Error::Scene`] for text that is no SVG, or one that is too large.
pub(crate) fn pixels(svg: &str, scale: f32) -> Result<Pixmap> {
    let tree = tree(svg)?;
    let (width, height) = ((tree.size().width() * scale).ceil() as u32, (tree.size().height() * scale).ceil() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| fault(format!("{width} × {height} pixels")))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels)
}

/// The bytes of a PNG file with what the SVG shows, at twice its size; `says` tells where it comes from.
///
/// # Errors
/// As of [`pixels`].
pub(crate) fn png(svg: &str, says: &str) -> Result<Vec<u8>> {
    let pixels = pixels(svg, SCALE)?;
    let straight: Vec<u8> = pixels
        .pixels()
        .iter()
        .flat_map(|p| {
            let p = p.demultiply();
            [p.red(), p.green(), p.blue(), p.alpha()]
        })
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let failed = |e: png::EncodingError| fault(e.to_string());
    encoder.add_itxt_chunk("Comment".into(), says.into()).map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&straight).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

fn fault(what: String) -> Error {
    Error::Scene(format!("a chart could not be drawn: {what}"))
}
