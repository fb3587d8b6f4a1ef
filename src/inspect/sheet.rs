//! Pictures with their names, scales and a bar of colours, as a sheet that explains itself.

use crate::Result;
use crate::draw::{Anchor, FAINT, INK, Svg, pixels, wrapped};
use crate::image::Image;
use crate::math::Rgb;

/// Around the pictures, in pixels.
const LEFT: usize = 62;
const GAP: usize = 62;
const RIGHT: usize = 24;
const BELOW: usize = 34;
/// The bar's width, and that of its figures.
const BAR: usize = 16;
const FIGURES: usize = 66;
/// Height of a line of the note.
const LINE: usize = 15;
/// Width of a letter of the note, and of one of a picture's name, at most.
const NOTE_LETTER: usize = 6;
const NAME_LETTER: usize = 7;

/// A picture, its name and what stands at its edges.
pub(crate) struct Panel<'a> {
    pub(crate) name: &'a str,
    pub(crate) image: &'a Image,
    /// Places along the lower edge, from 0 at the left to 1, and along the left one, from 0 at the top.
    pub(crate) x: &'a [(f64, String)],
    pub(crate) y: &'a [(f64, String)],
}

/// What colours mean: the one of a place from 0, at the lower end, to 1, and figures beside places.
pub(crate) struct Bar<'a> {
    pub(crate) colour: fn(f32) -> Rgb,
    pub(crate) ticks: &'a [(f64, String)],
    pub(crate) label: &'a str,
}

/// The pictures side by side, below a title and a note, the bar on their right.
///
/// # Errors
/// A sheet that is too large to draw.
pub(crate) fn sheet(title: &str, note: &str, panels: &[Panel], bar: Option<&Bar>) -> Result<Image> {
    let tall = panels.iter().map(|p| p.image.height).max().unwrap_or(0);
    // a small picture still has room for its name
    let column = |p: &Panel| p.image.width.max(NAME_LETTER * p.name.chars().count());
    let pictures: usize = panels.iter().map(|p| column(p) + GAP).sum::<usize>() - GAP.min(panels.len() * GAP);
    let right = RIGHT + if bar.is_some() { GAP + BAR + FIGURES } else { 0 };
    let width = (LEFT + pictures + right).max(24 + 9 * title.chars().count());
    let lines = wrapped(note, (width - 32) / NOTE_LETTER);
    let top = 64 + LINE * lines.len();
    let height = top + tall + BELOW;
    let mut svg = Svg::card(width as f64, height as f64, title);
    svg.text((16.0, 27.0), 16.0, INK, Anchor::Start, title);
    for (k, line) in lines.iter().enumerate() {
        svg.text((16.0, 46.0 + (LINE * k) as f64), 11.5, FAINT, Anchor::Start, line);
    }
    let mut placed = Vec::new();
    let mut x = LEFT;
    for panel in panels {
        label(&mut svg, panel, (x, top));
        placed.push((x, panel.image));
        x += column(panel) + GAP;
    }
    let strip = bar.map(|bar| {
        scale(&mut svg, bar, (x, top), tall);
        Image {
            width: BAR,
            height: tall,
            data: (0..BAR * tall).map(|i| (bar.colour)(1.0 - ((i / BAR) as f32 + 0.5) / tall as f32)).collect(),
        }
    });
    placed.extend(strip.iter().map(|strip| (x, strip)));
    let mut sheet = drawn(&svg.finish())?;
    placed.iter().for_each(|(x, image)| paste(&mut sheet, image, (*x, top)));
    Ok(sheet)
}

/// A picture's name and the marks at its edges.
fn label(svg: &mut Svg, panel: &Panel, (x, y): (usize, usize)) {
    let (x, y) = (x as f64, y as f64);
    let (w, h) = (panel.image.width as f64, panel.image.height as f64);
    svg.text((x, y - 8.0), 12.5, INK, Anchor::Start, panel.name);
    for (at, text) in panel.x {
        svg.line((x + at * w, y + h), (x + at * w, y + h + 5.0), INK, 1.0, "");
        svg.text((x + at * w, y + h + 18.0), 11.5, INK, Anchor::Middle, text);
    }
    for (at, text) in panel.y {
        svg.line((x - 5.0, y + at * h), (x, y + at * h), INK, 1.0, "");
        svg.text((x - 9.0, y + at * h + 4.0), 11.5, INK, Anchor::End, text);
    }
}

fn scale(svg: &mut Svg, bar: &Bar, (x, y): (usize, usize), tall: usize) {
    let (x, y, h) = (x as f64, y as f64, tall as f64);
    svg.path(
        &[
            (x - 1.0, y - 1.0),
            (x + BAR as f64 + 1.0, y - 1.0),
            (x + BAR as f64 + 1.0, y + h + 1.0),
            (x - 1.0, y + h + 1.0),
            (x - 1.0, y - 1.0),
        ],
        FAINT,
        1.0,
        "",
    );
    for (at, text) in bar.ticks {
        let y = y + (1.0 - at) * h;
        svg.line((x + BAR as f64, y), (x + BAR as f64 + 5.0, y), INK, 1.0, "");
        svg.text((x + BAR as f64 + 9.0, y + 4.0), 11.5, INK, Anchor::Start, text);
    }
    svg.upwards((x - 10.0, y + 0.5 * h), 12.0, INK, bar.label);
}

/// The drawing in linear colours.
fn drawn(svg: &str) -> Result<Image> {
    let pixmap = pixels(svg, 1.0)?;
    let linear = |byte: u8| {
        let x = f32::from(byte) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    // round corners of the card are see-through: white paper shows
    let paper = |part: u8, alpha: u8| linear(part.saturating_add(255 - alpha));
    let data = pixmap
        .pixels()
        .iter()
        .map(|p| Rgb::new(paper(p.red(), p.alpha()), paper(p.green(), p.alpha()), paper(p.blue(), p.alpha())));
    Ok(Image { width: pixmap.width() as usize, height: pixmap.height() as usize, data: data.collect() })
}

fn paste(sheet: &mut Image, image: &Image, (x, y): (usize, usize)) {
    for row in 0..image.height {
        let at = (y + row) * sheet.width + x;
        sheet.data[at..at + image.width].copy_from_slice(&image.data[row * image.width..][..image.width]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_unchanged_among_letters_and_the_bar_goes_from_end_to_end() {
        let image = Image { width: 30, height: 40, data: (0..1200).map(|i| Rgb::splat(i as f32 / 1200.0)).collect() };
        let marks = [(0.5, "middle".to_string())];
        let panel = Panel { name: "ramp", image: &image, x: &marks, y: &marks };
        let bar =
            Bar { colour: |at| Rgb::new(at, 0.0, 0.0), ticks: &[(0.0, "0".into()), (1.0, "7".into())], label: "red" };
        let found = sheet("A title", "a note", &[panel], Some(&bar)).unwrap();
        let at = |x: usize, y: usize| found.data[y * found.width + x];
        let top = 64 + LINE;
        assert!((0..40).all(|y| (0..30).all(|x| at(LEFT + x, top + y) == image.data[y * 30 + x])));
        let strip = LEFT + 30 + GAP + 3;
        assert!(at(strip, top).x > 0.98 && at(strip, top + 39).x < 0.02 && at(strip, top + 20).y == 0.0);
        let dark = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
            y.clone().any(|y| x.clone().any(|x| at(x, y).x < 0.3))
        };
        assert!(dark(16..90, 12..30), "the title");
        assert!(dark(LEFT..LEFT + 30, top - 20..top - 5), "the name");
        assert!(dark(LEFT..LEFT + 30, top + 47..top + 60), "marks below");
        assert!(dark(strip + BAR..found.width, top..top + 40), "figures of the bar");
        assert_eq!(at(0, 0), Rgb::ONE);
    }

    #[test]
    fn a_tiny_picture_leaves_room_for_its_words() {
        let image = Image { width: 4, height: 3, data: vec![Rgb::ONE; 12] };
        let found = sheet(
            "A title that is long",
            "a note",
            &[Panel { name: "a long name", image: &image, x: &[], y: &[] }],
            None,
        );
        assert!(found.unwrap().width >= 24 + 9 * 20);
    }
}
