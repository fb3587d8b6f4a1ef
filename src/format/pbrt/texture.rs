//! Textures: colours and numbers that are constant or of a picture.

use super::parameters::{Parameters, Values};
use super::spectrum::Role;
use super::world::World;
use crate::Result;
use crate::error::SourceLocation;
use crate::image::picture::{self, Picture, Samples};
use crate::math::{Rgb, luminance};
use crate::texture::{ColorTexture, EmbeddedPicture, EmbeddedPictures, ImageTexture, ScalarTexture};
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// Textures may be within each other so deep.
const DEEPEST: usize = 16;

/// Reads textures, and keeps pictures that are in no file.
pub(super) struct Textures<'a> {
    world: &'a World,
    embedded: RefCell<EmbeddedPictures>,
}

/// What a texture is.
#[derive(Clone)]
pub(super) enum Found {
    Constant(Rgb),
    Image(ImageTexture),
}

impl<'a> Textures<'a> {
    pub(crate) fn new(world: &'a World) -> Textures<'a> {
        Textures { world, embedded: RefCell::default() }
    }

    pub(crate) fn into_embedded(self) -> EmbeddedPictures {
        self.embedded.into_inner()
    }

    /// A reflectance: constant colours beyond 1 are cut off, with a warning.
    pub(crate) fn color(&self, p: &Parameters, name: &str, default: f32) -> Result<ColorTexture> {
        Ok(self.maybe_color(p, name)?.unwrap_or_else(|| ColorTexture::grey(default)))
    }

    /// The same; `None` where nothing is said.
    pub(crate) fn maybe_color(&self, p: &Parameters, name: &str) -> Result<Option<ColorTexture>> {
        let Some(at) = p.find(name).map(|found| found.at.clone()) else { return Ok(None) };
        Ok(self.found(p, name, false)?.map(|found| match found {
            Found::Image(image) => ColorTexture::Image(image),
            Found::Constant(color) => {
                if color.max_element() > 1.0 {
                    self.world.warnings.add(&at, format!("`{name}` of {} is above 1 and reflects 1", p.label()));
                }
                ColorTexture::Constant(color.min(Rgb::ONE))
            }
        }))
    }

    /// A colour where no picture can be: the mean of one is taken, with a warning.
    pub(crate) fn constant(&self, p: &Parameters, name: &str, default: Rgb) -> Result<Rgb> {
        match self.found(p, name, false)? {
            None => Ok(default),
            Some(Found::Constant(color)) => Ok(color),
            Some(Found::Image(image)) => self.mean(p, name, &image),
        }
    }

    /// A number where no picture can be.
    pub(crate) fn number(&self, p: &Parameters, name: &str, default: f32) -> Result<f32> {
        match self.found(p, name, true)? {
            None => Ok(default),
            Some(Found::Constant(color)) => Ok(luminance(color)),
            Some(Found::Image(image)) => Ok(luminance(self.mean(p, name, &image)?)),
        }
    }

    /// The mean of a picture that stands where none can be.
    fn mean(&self, p: &Parameters, name: &str, image: &ImageTexture) -> Result<Rgb> {
        let mean = image.mean(&self.embedded.borrow(), false)?;
        let message = format!("`{name}` of {} cannot be a picture here: its mean, {mean:.3}, is taken", p.label());
        self.world.warnings.add(&p.at, message);
        Ok(mean)
    }

    /// What a parameter is, in the directive itself or as a texture.
    pub(crate) fn found(&self, p: &Parameters, name: &str, float: bool) -> Result<Option<Found>> {
        self.parameter(p, name, float, 0)
    }

    fn parameter(&self, p: &Parameters, name: &str, float: bool, depth: usize) -> Result<Option<Found>> {
        let Some(found) = p.find(name) else { return Ok(None) };
        match (&found.values, found.kind.as_str()) {
            (Values::Texts(texts), "texture") if texts.len() == 1 => {
                self.named(&texts[0], float, &found.at, depth).map(Some)
            }
            _ if float => Ok(p.maybe_number(name)?.map(|number| Found::Constant(Rgb::splat(number as f32)))),
            _ => Ok(self.world.color(p, name, Role::Reflectance)?.map(Found::Constant)),
        }
    }

    /// The texture of this name.
    pub(crate) fn named(&self, name: &str, float: bool, at: &SourceLocation, depth: usize) -> Result<Found> {
        let (first, second) = match float {
            true => (&self.world.float_textures, &self.world.textures),
            false => (&self.world.textures, &self.world.float_textures),
        };
        match first.get(name).or_else(|| second.get(name)) {
            Some(texture) => self.texture(texture, float, depth),
            None => Err(at.error(format!("there is no texture \"{name}\""))),
        }
    }

    fn texture(&self, p: &Rc<Parameters>, float: bool, depth: usize) -> Result<Found> {
        if depth > DEEPEST {
            return Err(p.error("this texture is within itself"));
        }
        let input = |name: &str, default: f32| -> Result<Found> {
            Ok(self.parameter(p, name, float, depth + 1)?.unwrap_or(Found::Constant(Rgb::splat(default))))
        };
        let found = match p.plugin.as_str() {
            "constant" => input("value", 1.0)?,
            "imagemap" => Found::Image(self.image(p, float)?),
            "scale" => {
                let names = if p.find("tex1").is_some() { ["tex1", "tex2"] } else { ["tex", "scale"] };
                // what scales may be a number among colours
                let [a, b] = names.map(|name| input(name, 1.0));
                self.product(p, a?, b?)
            }
            "mix" => self.mix(p, input("tex1", 0.0)?, input("tex2", 1.0)?)?,
            "checkerboard" => self.checkerboard(p, input("tex1", 1.0)?, input("tex2", 0.0)?)?,
            kind => {
                self.world.warnings.add(&p.at, format!("the texture \"{kind}\" has no counterpart: 0.5 is taken"));
                return Ok(Found::Constant(Rgb::splat(0.5)));
            }
        };
        p.finish(&self.world.warnings);
        Ok(found)
    }

    fn product(&self, p: &Parameters, a: Found, b: Found) -> Found {
        match (a, b) {
            (Found::Constant(a), Found::Constant(b)) => Found::Constant(a * b),
            (Found::Image(image), Found::Constant(color)) | (Found::Constant(color), Found::Image(image)) => {
                Found::Image(ImageTexture { tint: image.tint * color, ..image })
            }
            (Found::Image(first), Found::Image(_)) => {
                self.world.warnings.add(&p.at, "a product of two pictures has no counterpart: the first is taken");
                Found::Image(first)
            }
        }
    }

    fn mix(&self, p: &Parameters, a: Found, b: Found) -> Result<Found> {
        let share = self.number(p, "amount", 0.5)?.clamp(0.0, 1.0);
        Ok(match (a, b) {
            (Found::Constant(a), Found::Constant(b)) => Found::Constant(a * (1.0 - share) + b * share),
            (a, b) => {
                self.world
                    .warnings
                    .add(&p.at, "a mixture with a picture has no counterpart: what has more weight is taken");
                if share > 0.5 { b } else { a }
            }
        })
    }

    fn image(&self, p: &Parameters, float: bool) -> Result<ImageTexture> {
        let name = p.text("filename")?.ok_or_else(|| p.error("an imagemap needs `filename`"))?;
        let mut image = ImageTexture::new(self.world.file(name));
        self.place(p, &mut image)?;
        image.tint = Rgb::splat(p.number("scale", 1.0)? as f32);
        image.nearest = p.text("filter")? == Some("point");
        image.clamp = match p.text("wrap")?.unwrap_or("repeat") {
            "repeat" => false,
            "clamp" => true,
            other => {
                let message = format!("`wrap` {other} is not known here: the picture's edge goes on");
                self.world.warnings.add(&p.at, message);
                true
            }
        };
        let invert = p.flag("invert", false)?;
        let linear = p.text("encoding")? == Some("linear") || !p.flag("gamma", true)?;
        // numbers that are stored by the curve of sRGB are decoded there too
        let encoded = name.to_lowercase().ends_with(".png") || self.world.old && name.to_lowercase().ends_with(".tga");
        let (numbers, straight) = (float && encoded && !linear, linear && !float);
        if invert || numbers || straight {
            image.path = self.changed(image.path, [invert, numbers, straight])?;
        }
        p.ignore(&["maxanisotropy", "trilinear"]);
        Ok(image)
    }

    /// The picture with its light inverted, as one of numbers, and with its values as they are stored; under a name of its own.
    fn changed(&self, path: PathBuf, [invert, numbers, straight]: [bool; 3]) -> Result<PathBuf> {
        let name = PathBuf::from(format!("{}#{}{}{}", path.display(), invert as u8, numbers as u8, straight as u8));
        if self.embedded.borrow().contains_key(&name) {
            return Ok(name);
        }
        let mut picture = picture::load(&path)?;
        if straight {
            picture = picture.with_curve(|x| x);
        }
        if numbers && picture.channels % 2 == 1 {
            // an alpha channel counts as it is stored
            let grey = picture.colors().iter().map(|color| color.element_sum() / 3.0).collect();
            picture = Picture { channels: 1, samples: Samples::F32(grey), ..picture };
        }
        if invert {
            picture = picture.mapped(|x| 1.0 - x);
        }
        self.embedded.borrow_mut().insert(name.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        Ok(name)
    }

    /// A picture of four texels: `tex1` is where both coordinates have an even whole part.
    fn checkerboard(&self, p: &Parameters, a: Found, b: Found) -> Result<Found> {
        let (Found::Constant(a), Found::Constant(b)) = (&a, &b) else {
            self.world.warnings.add(&p.at, "a checkerboard of pictures has no counterpart: the first is taken");
            return Ok(a);
        };
        if p.number("dimension", 2.0)? != 2.0 {
            self.world
                .warnings
                .add(&p.at, "a checkerboard in space has no counterpart: the mean of its colours is taken");
            return Ok(Found::Constant((*a + *b) * 0.5));
        }
        p.ignore(&["aamode"]);
        let (a, b) = (a.to_array(), b.to_array());
        let samples = Samples::F32([b, a, a, b].concat());
        let picture = Picture { width: 2, height: 2, channels: 3, samples, notes: Vec::new() };
        let at = &p.at;
        let path = PathBuf::from(format!("{}:{}:{}#checkerboard", at.path.display(), at.line, at.column));
        self.embedded.borrow_mut().insert(path.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        let mut image = ImageTexture { nearest: true, ..ImageTexture::new(path) };
        self.place(p, &mut image)?;
        (image.scale, image.offset) = (image.scale.map(|x| 0.5 * x), image.offset.map(|x| 0.5 * x));
        Ok(Found::Image(image))
    }

    /// v counts from below, here and there.
    fn place(&self, p: &Parameters, image: &mut ImageTexture) -> Result<()> {
        if let Some(mapping) = p.text("mapping")?.filter(|mapping| *mapping != "uv") {
            let message = format!("the mapping {mapping} is not known here: texture coordinates are taken");
            self.world.warnings.add(&p.at, message);
            p.ignore(&["v1", "v2"]);
        }
        let pair = |names: [&str; 2], default: f64| -> Result<[f32; 2]> {
            Ok([p.number(names[0], default)? as f32, p.number(names[1], default)? as f32])
        };
        image.scale = pair(["uscale", "vscale"], 1.0)?;
        image.offset = pair(["udelta", "vdelta"], 0.0)?;
        Ok(())
    }
}

/// What a number is: of a picture, its alpha channel where it has one.
pub(super) fn scalar(found: Found) -> ScalarTexture {
    match found {
        Found::Constant(color) => ScalarTexture::Constant(luminance(color)),
        Found::Image(image) => ScalarTexture::Image(image),
    }
}
