//! Properties of objects: numbers, colours, spectra and transforms.

use super::object::{Item, Value};
use super::{Reader, Source, color, snake, transform};
use crate::Result;
use crate::document::read_text;
use crate::math::Rgb;
use roxmltree::Node;

impl Reader<'_> {
    /// `shines`: it is a property of an emitter.
    pub(super) fn property(&mut self, source: &Source, node: Node, shines: bool) -> Result<Item> {
        let tag = node.tag_name().name();
        let name = self.attribute(source, node, "name")?.map(|name| snake(&name));
        let value = |reader: &Reader<'_>| reader.needed(source, node, "value");
        let bad = |what: &str, text: &str| source.fault(node, format!("`{text}` is not {what}"));
        let parsed = match tag {
            "ref" => Value::Ref(self.needed(source, node, "id")?),
            "string" if name.as_deref() == Some("filename") => Value::File(self.find_file(source, &value(self)?)),
            "string" => Value::Text(value(self)?),
            "boolean" => match value(self)?.to_lowercase().as_str() {
                "true" => Value::Flag(true),
                "false" => Value::Flag(false),
                other => return Err(bad("true or false", other)),
            },
            "float" | "integer" => {
                let text = value(self)?;
                let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
                Value::Number(number.ok_or_else(|| bad("a number", &text))?)
            }
            "point" | "vector" => Value::Vector(self.vector(source, node, 0.0)?),
            "rgb" | "srgb" | "color" => {
                let text = value(self)?;
                Value::Color(color::rgb(&text, tag == "srgb").ok_or_else(|| bad("a colour", &text))?)
            }
            "spectrum" => self.spectrum(source, node, shines && !self.dialect.is_old())?,
            "blackbody" => {
                let text = self.needed(source, node, "temperature")?;
                let kelvin = self.number(source, node, text.trim().trim_end_matches(['k', 'K']))?;
                if !(1.0..=1e6).contains(&kelvin) {
                    return Err(bad("a temperature in kelvin", &text));
                }
                let scale = match self.attribute(source, node, "scale")? {
                    Some(text) => self.number(source, node, &text)?,
                    None => 1.0,
                };
                // W/(sr·m²·nm)
                let seen = color::seen(color::black_body(kelvin)).map(|x| x.max(0.0) * scale * color::peak(kelvin));
                Value::Color(Rgb::from(seen.map(|x| x as f32)))
            }
            "transform" => Value::Transform(self.transform(source, node)?),
            _ => return Err(source.fault(node, format!("<{tag}> is not known"))),
        };
        let name = match (name, tag) {
            (Some(name), _) => name,
            (None, "ref") => String::new(),
            (None, _) => return Err(source.fault(node, format!("<{tag}> needs a `name`"))),
        };
        Ok(Item::new(name, source.place(node), parsed))
    }

    fn spectrum(&self, source: &Source, node: Node, even: bool) -> Result<Value> {
        let text = match self.attribute(source, node, "filename")? {
            Some(name) => read_text(&self.find_file(source, &name))?,
            None => self.needed(source, node, "value")?,
        };
        // as many numbers as colours had, before version 2
        if self.dialect.is_old()
            && let Some(&[r, g, b]) = color::numbers(&text).as_deref()
        {
            return Ok(Value::Color(Rgb::from([r, g, b].map(|x| x as f32))));
        }
        let bad = || source.fault(node, "the spectrum must be a number, or pairs of a wavelength in nm and a number");
        color::spectrum(&text, even).map(Value::Color).ok_or_else(bad)
    }

    /// `x`, `y` and `z`, or `value` with one number or three.
    fn vector(&self, source: &Source, node: Node, default: f64) -> Result<glam::DVec3> {
        if let Some(text) = self.attribute(source, node, "value")? {
            let numbers = color::numbers(&text);
            return match numbers.as_deref() {
                Some([x]) => Ok(glam::DVec3::splat(*x)),
                Some([x, y, z]) => Ok(glam::DVec3::new(*x, *y, *z)),
                Some([x, y]) => Ok(glam::DVec3::new(*x, *y, default)),
                _ => Err(source.fault(node, format!("`{text}` is not three numbers"))),
            };
        }
        let mut found = [default; 3];
        for (slot, name) in found.iter_mut().zip(["x", "y", "z"]) {
            if let Some(text) = self.attribute(source, node, name)? {
                *slot = self.number(source, node, &text)?;
            }
        }
        Ok(found.into())
    }

    fn three(&self, source: &Source, node: Node, text: &str) -> Result<glam::DVec3> {
        let found = color::numbers(text).and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        found.map(Into::into).ok_or_else(|| source.fault(node, format!("`{text}` is not three numbers")))
    }

    fn number(&self, source: &Source, node: Node, text: &str) -> Result<f64> {
        let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| source.fault(node, format!("`{text}` is not a number")))
    }

    /// Steps one after the other, the first one first.
    fn transform(&self, source: &Source, node: Node) -> Result<glam::DAffine3> {
        let mut all = glam::DAffine3::IDENTITY;
        for step in node.children().filter(Node::is_element) {
            let fault = |message: &str| source.fault(step, message);
            let next = match step.tag_name().name() {
                "translate" => glam::DAffine3::from_translation(self.vector(source, step, 0.0)?),
                "scale" => glam::DAffine3::from_scale(self.vector(source, step, 1.0)?),
                "rotate" => {
                    let angle = self.needed(source, step, "angle")?;
                    let angle = self.number(source, step, &angle)?;
                    let axis = match self.attribute(source, step, "axis")? {
                        Some(text) => self.three(source, step, &text)?,
                        None => self.vector(source, step, 0.0)?,
                    };
                    transform::rotation(axis, angle).ok_or_else(|| fault("the axis of a rotation is not zero"))?
                }
                "lookat" | "lookAt" => {
                    let point = |name: &str| -> Result<Option<glam::DVec3>> {
                        let Some(text) = self.attribute(source, step, name)? else { return Ok(None) };
                        self.three(source, step, &text).map(Some)
                    };
                    let (origin, target, up) = (point("origin")?, point("target")?, point("up")?);
                    let (Some(origin), Some(target)) = (origin, target) else {
                        return Err(fault("<lookat> needs `origin` and `target`"));
                    };
                    transform::look_at(origin, target, up)
                        .ok_or_else(|| fault("origin, target and up of <lookat> span no view"))?
                }
                "matrix" => {
                    let text = self.needed(source, step, "value")?;
                    let found = color::numbers(&text).and_then(|numbers| transform::matrix(&numbers));
                    found.ok_or_else(|| fault("a matrix is 9 or 16 numbers, the last row 0 0 0 1"))?
                }
                other => return Err(fault(&format!("<{other}> is no step of a transform"))),
            };
            all = next * all;
        }
        if !all.is_finite() {
            return Err(source.fault(node, "this transform is not finite"));
        }
        Ok(all)
    }
}
