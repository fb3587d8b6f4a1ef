//! Charts as PDF, for papers: one page of the chart's size, all of it vectors. Letters are outlines, so that no font needs to be
//! embedded.

use crate::draw::tree;
use crate::{Error, Result};
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish as _, Name, Pdf, Rect, Ref, TextStr};
use resvg::tiny_skia::{PathSegment, Point, Transform};
use resvg::usvg::{FillRule, Group, LineCap, LineJoin, Node, Paint, Path};
use std::collections::BTreeMap;

/// Points for each pixel of the SVG: 72 and 96 of them are an inch.
const POINTS: f32 = 0.75;

/// The bytes of a PDF file with what the SVG shows; `says` is its subject.
///
/// # Errors
/// [`Error::Scene`] for text that is no SVG, and for what charts have none of: pictures, gradients, clips.
pub(crate) fn pdf(svg: &str, title: &str, says: &str) -> Result<Vec<u8>> {
    let tree = tree(svg)?;
    let (width, height) = (POINTS * tree.size().width(), POINTS * tree.size().height());
    let mut page = Page { content: Content::new(), alphas: BTreeMap::new() };
    page.content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]);
    page.group(tree.root())?;
    Ok(page.file(width, height, title, says))
}

struct Page {
    content: Content,
    /// Numbers of graphics states by their opacity, in 1/1000.
    alphas: BTreeMap<u16, usize>,
}

impl Page {
    fn file(self, width: f32, height: f32, title: &str, says: &str) -> Vec<u8> {
        let [catalog, pages, page, content, info] = [1, 2, 3, 4, 5].map(Ref::new);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut sheet = pdf.page(page);
        sheet.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(content);
        let mut resources = sheet.resources();
        let mut states = resources.ext_g_states();
        for (alpha, number) in &self.alphas {
            let opacity = f32::from(*alpha) / 1000.0;
            states
                .insert(Name(state(*number).as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>()
                .non_stroking_alpha(opacity)
                .stroking_alpha(opacity);
        }
        states.finish();
        resources.finish();
        sheet.finish();
        pdf.stream(content, &self.content.finish());
        pdf.document_info(info).title(TextStr(title)).subject(TextStr(says)).creator(TextStr("Phototaxis"));
        pdf.finish()
    }

    fn group(&mut self, group: &Group) -> Result<()> {
        if group.clip_path().is_some() || group.mask().is_some() || !group.filters().is_empty() {
            return Err(unknown());
        }
        self.content.save_state().transform(matrix(group.transform()));
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) => self.path(path)?,
                Node::Text(text) => self.group(text.flattened())?,
                Node::Image(_) => return Err(unknown()),
            }
        }
        self.content.restore_state();
        Ok(())
    }

    fn path(&mut self, path: &Path) -> Result<()> {
        if let Some(fill) = path.fill() {
            let [r, g, b] = colour(fill.paint())?;
            self.opacity(fill.opacity().get());
            self.content.set_fill_rgb(r, g, b);
            self.outline(path);
            match fill.rule() {
                FillRule::NonZero => self.content.fill_nonzero(),
                FillRule::EvenOdd => self.content.fill_even_odd(),
            };
        }
        if let Some(stroke) = path.stroke() {
            let [r, g, b] = colour(stroke.paint())?;
            self.opacity(stroke.opacity().get());
            self.content.set_stroke_rgb(r, g, b).set_line_width(stroke.width().get());
            self.content.set_line_cap(match stroke.linecap() {
                LineCap::Butt => LineCapStyle::ButtCap,
                LineCap::Round => LineCapStyle::RoundCap,
                LineCap::Square => LineCapStyle::ProjectingSquareCap,
            });
            self.content.set_line_join(match stroke.linejoin() {
                LineJoin::Round => LineJoinStyle::RoundJoin,
                LineJoin::Bevel => LineJoinStyle::BevelJoin,
                LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
            });
            self.content.set_dash_pattern(stroke.dasharray().unwrap_or(&[]).iter().copied(), stroke.dashoffset());
            self.outline(path);
            self.content.stroke();
        }
        Ok(())
    }

    /// Chooses the graphics state of an opacity.
    fn opacity(&mut self, alpha: f32) {
        let next = self.alphas.len();
        let number = *self.alphas.entry((1000.0 * alpha).round() as u16).or_insert(next);
        self.content.set_parameters(Name(state(number).as_bytes()));
    }

    fn outline(&mut self, path: &Path) {
        let mut last = Point::zero();
        for segment in path.data().segments() {
            match segment {
                PathSegment::MoveTo(p) => _ = self.content.move_to(p.x, p.y),
                PathSegment::LineTo(p) => _ = self.content.line_to(p.x, p.y),
                // PDF has cubic curves alone
                PathSegment::QuadTo(c, p) => {
                    let third =
                        |from: Point| (from.x + (c.x - from.x) * 2.0 / 3.0, from.y + (c.y - from.y) * 2.0 / 3.0);
                    let ((x1, y1), (x2, y2)) = (third(last), third(p));
                    self.content.cubic_to(x1, y1, x2, y2, p.x, p.y);
                }
                PathSegment::CubicTo(a, b, p) => _ = self.content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y),
                PathSegment::Close => _ = self.content.close_path(),
            }
            if let PathSegment::MoveTo(p)
            | PathSegment::LineTo(p)
            | PathSegment::QuadTo(_, p)
            | PathSegment::CubicTo(_, _, p) = segment
            {
                last = p;
            }
        }
    }
}

/// Name of a graphics state.
fn state(number: usize) -> String {
    format!("a{number}")
}

fn matrix(t: Transform) -> [f32; 6] {
    [t.sx, t.ky, t.kx, t.sy, t.tx, t.ty]
}

fn colour(paint: &Paint) -> Result<[f32; 3]> {
    let Paint::Color(c) = paint else { return Err(unknown()) };
    Ok([c.red, c.green, c.blue].map(|part| f32::from(part) / 255.0))
}

fn unknown() -> Error {
    Error::Scene("a chart could not be written as PDF: it holds more than lines, areas and letters".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_letters_and_opacities_are_there_and_pictures_are_refused() {
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"96\" height=\"48\"><path d=\"M1 1Q5 5 9 1\" \
                   stroke=\"#ff0000\" fill=\"none\" stroke-dasharray=\"5 4\"/><rect width=\"9\" height=\"9\" \
                   fill=\"#00ff00\" fill-opacity=\"0.5\"/><text x=\"5\" y=\"30\" font-size=\"12\">A</text></svg>";
        let file = pdf(svg, "A title", "made by a test").unwrap();
        let text = String::from_utf8_lossy(&file);
        assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
        for part in
            ["/MediaBox [0 0 72 36]", "1 0 0 RG", "[5 4] 0 d", "0 1 0 rg", "/ca 0.5", "(A title)", "(made by a test)"]
        {
            assert!(text.contains(part), "{part} is missing in {text}");
        }
        let curves = |text: &str| text.matches(" c\n").count();
        let mute = pdf(&svg.replace(">A<", "><"), "t", "s").unwrap();
        assert!(file.len() > mute.len() && curves(&text) >= 1, "letters are outlines");
        let clipped = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\"><defs><linearGradient id=\"g\"><stop \
                       offset=\"0\" stop-color=\"red\"/><stop offset=\"1\" stop-color=\"blue\"/></linearGradient></defs>\
                       <rect width=\"9\" height=\"9\" fill=\"url(#g)\"/></svg>";
        assert!(pdf(clipped, "t", "s").is_err());
    }
}
