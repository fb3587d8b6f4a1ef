//! As much of XML as a scene of Mitsuba's takes.

use crate::math::Rgb;
use glam::Vec3;
use std::fmt::{self, Display, Formatter};

/// A tag with its attributes and what stands in it.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    tag: String,
    attributes: String,
    children: Vec<Element>,
}

impl Element {
    pub(crate) fn new(tag: &str) -> Element {
        Element { tag: tag.to_owned(), attributes: String::new(), children: Vec::new() }
    }

    pub(crate) fn attribute(mut self, name: &str, value: impl Display) -> Element {
        self.attributes.push_str(&format!(" {name}=\"{}\"", escape(&value.to_string())));
        self
    }

    /// The plug-in's name.
    pub(crate) fn kind(self, name: &str) -> Element {
        self.attribute("type", name)
    }

    pub(crate) fn child(mut self, child: Element) -> Element {
        self.children.push(child);
        self
    }

    pub(crate) fn value(self, tag: &str, name: &str, value: impl Display) -> Element {
        self.child(Element::new(tag).attribute("name", name).attribute("value", value))
    }

    pub(crate) fn float(self, name: &str, value: f32) -> Element {
        self.value("float", name, value)
    }

    pub(crate) fn integer(self, name: &str, value: i64) -> Element {
        self.value("integer", name, value)
    }

    pub(crate) fn string(self, name: &str, value: &str) -> Element {
        self.value("string", name, value)
    }

    pub(crate) fn color(self, name: &str, value: Rgb) -> Element {
        self.child(Element::rgb(name, value))
    }

    /// A colour by itself.
    pub(crate) fn rgb(name: &str, value: Rgb) -> Element {
        Element::new("rgb").attribute("name", name).attribute("value", numbers(value))
    }

    fn write(&self, f: &mut Formatter, depth: usize) -> fmt::Result {
        let (indent, Element { tag, attributes, children }) = ("    ".repeat(depth), self);
        if children.is_empty() {
            return writeln!(f, "{indent}<{tag}{attributes}/>");
        }
        writeln!(f, "{indent}<{tag}{attributes}>")?;
        children.iter().try_for_each(|child| child.write(f, depth + 1))?;
        writeln!(f, "{indent}</{tag}>")
    }
}

impl Display for Element {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        self.write(f, 0)
    }
}

/// Text as it stands in an attribute.
fn escape(text: &str) -> String {
    let visible: String = text.chars().filter(|c| !c.is_control()).collect();
    visible.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Three numbers as Mitsuba takes them.
pub(crate) fn numbers(v: Vec3) -> String {
    v.to_array().map(|x| x.to_string()).join(", ")
}
