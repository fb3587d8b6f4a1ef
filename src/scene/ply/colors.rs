//! Which numbers of vertices or of faces are colours.

use super::header::{Element, Kind};
use crate::image::srgb;
use rayon::prelude::*;

/// Which colours of a file become those of the mesh.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted<'a> {
    /// Those of vertices, and where these say nothing those of faces.
    Any,
    /// The attribute of vertices with this name.
    Vertices(&'a str),
    Faces(&'a str),
}

impl<'a> Wanted<'a> {
    /// What Mitsuba calls `vertex_NAME` or `face_NAME`.
    pub(crate) fn named(attribute: &'a str) -> Option<Wanted<'a>> {
        let of_vertices = attribute.strip_prefix("vertex_").map(Wanted::Vertices);
        of_vertices.or_else(|| attribute.strip_prefix("face_").map(Wanted::Faces))
    }

    pub(crate) fn of_vertices(self) -> Option<&'a str> {
        match self {
            Wanted::Any => Some(COLOR),
            Wanted::Vertices(name) => Some(name),
            Wanted::Faces(_) => None,
        }
    }

    pub(crate) fn of_faces(self) -> Option<&'a str> {
        match self {
            Wanted::Any => Some(COLOR),
            Wanted::Faces(name) => Some(name),
            Wanted::Vertices(_) => None,
        }
    }
}

/// The attribute that goes by names without an underscore, too.
const COLOR: &str = "color";

/// Names of the numbers of [`COLOR`].
const NAMES: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["r", "g", "b"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];

/// What is behind the underscore in names of the numbers of other attributes.
const ENDS: [[&str; 3]; 3] = [["x", "y", "z"], ["0", "1", "2"], ["1", "2", "3"]];

/// The same of attributes whose names end in `_color`, in the place of this end.
const COLOR_ENDS: [&str; 3] = ["r", "g", "b"];

/// The properties of an element that are a colour.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    /// Of red, green and blue; of a single number, which is a grey, thrice the same.
    properties: [usize; 3],
    kind: Kind,
}

impl Channels {
    /// Those of the attribute `name`: of three numbers, or of one.
    pub(crate) fn of(element: &Element, name: &str) -> Option<Channels> {
        let scalar = |wanted: &str| element.properties.iter().position(|p| p.name == wanted && p.length.is_none());
        let three = |names: &[String; 3]| {
            let [r, g, b] = names.each_ref().map(|name| scalar(name));
            Some([r?, g?, b?])
        };
        let own = NAMES.iter().filter(|_| name == COLOR).map(|names| names.map(str::to_string));
        let ends = ENDS.map(|ends| ends.map(|end| format!("{name}_{end}")));
        let colored = name.strip_suffix("_color").map(|name| COLOR_ENDS.map(|end| format!("{name}_{end}")));
        let all: Vec<[String; 3]> = own.chain(ends).chain(colored).collect();
        let grey = |names: &[String; 3]| scalar(&names[0]).map(|property| [property; 3]);
        let properties = all.iter().find_map(three).or_else(|| all.iter().find_map(grey))?;
        Some(Channels { properties, kind: element.properties[properties[0]].kind })
    }

    /// Which channel, the first of a grey, a property is.
    #[inline(always)]
    pub(crate) fn channel(&self, property: usize) -> Option<usize> {
        self.properties.iter().position(|&known| known == property)
    }

    /// The colour whose channels have been read.
    #[inline(always)]
    pub(crate) fn color(&self, [red, green, blue]: [f64; 3]) -> [f32; 3] {
        let grey = self.properties[0] == self.properties[1];
        let stored = if grey { [red; 3] } else { [red, green, blue] };
        stored.map(|channel| self.linear(channel))
    }

    /// White throughout is what programs write that know no colours, as bytes.
    pub(crate) fn say_nothing(&self, colors: &[[f32; 3]]) -> bool {
        self.kind.is_whole() && colors.par_iter().all(|color| *color == [1.0; 3])
    }

    /// A channel: linear, in [0, 1]. Whole numbers are stored in sRGB, others are linear.
    fn linear(&self, stored: f64) -> f32 {
        let share = |largest: f64| (stored / largest).clamp(0.0, 1.0) as f32;
        match self.kind {
            _ if stored.is_nan() => 1.0,
            Kind::F32 | Kind::F64 => share(1.0),
            Kind::I16 | Kind::U16 => srgb::decode(share(65535.0)),
            Kind::U8 => srgb::DECODE_8[stored.clamp(0.0, 255.0) as usize],
            _ => srgb::decode(share(255.0)),
        }
    }
}
