//! Textures: colours and numbers that are constant or of a picture.

use crate::Result;
use crate::format::xml::object::{Item, Object, Objects, Value};
use crate::image::picture::{self, Picture, Samples};
use crate::math::Rgb;
use crate::math::luminance;
use crate::texture::{ColorTexture, EmbeddedPicture, EmbeddedPictures, ImageTexture, ScalarTexture};
use glam::DAffine3;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Reads textures, and keeps pictures that are in no file.
pub(crate) struct Textures<'a> {
    pub(crate) objects: &'a Objects,
    embedded: RefCell<EmbeddedPictures>,
    /// The attribute of meshes that textures took.
    attribute: RefCell<Option<String>>,
}

/// What a texture is.
enum Found {
    Constant(Rgb),
    Image(ImageTexture),
    /// An attribute of the mesh, times this.
    Attribute(Rgb),
}

impl<'a> Textures<'a> {
    pub(crate) fn new(objects: &'a Objects) -> Textures<'a> {
        Textures { objects, embedded: RefCell::default(), attribute: RefCell::default() }
    }

    pub(crate) fn into_embedded(self) -> EmbeddedPictures {
        self.embedded.into_inner()
    }

    /// The attribute that textures took since this was asked last.
    pub(crate) fn take_attribute(&self) -> Option<String> {
        self.attribute.take()
    }

    /// A reflectance: constant colours beyond 1 are cut off, with a warning.
    pub(crate) fn color(&self, object: &Object, name: &str, default: f32) -> Result<ColorTexture> {
        let Some(item) = object.find(name) else { return Ok(ColorTexture::grey(default)) };
        Ok(match self.item(object, item)? {
            Found::Constant(color) => {
                if color.max_element() > 1.0 {
                    let message = format!("`{name}` of the {} is above 1 and reflects 1", object.label());
                    self.objects.warn(&item.at, message);
                }
                ColorTexture::Constant(color.min(Rgb::ONE))
            }
            Found::Image(image) => ColorTexture::Image(self.with_curve(image)?),
            Found::Attribute(tint) => ColorTexture::Vertex(tint),
        })
    }

    /// Radiance: a colour, and the picture that multiplies it.
    pub(crate) fn radiance(&self, object: &Object, name: &str) -> Result<(Rgb, Option<ImageTexture>)> {
        let Some(item) = object.find(name) else { return Ok((Rgb::ONE, None)) };
        match self.item(object, item)? {
            Found::Constant(color) => Ok((color, None)),
            Found::Image(image) => Ok((image.tint, Some(ImageTexture { tint: Rgb::ONE, ..self.with_curve(image)? }))),
            Found::Attribute(_) => Err(item.at.error("light of a mesh's attribute is not read")),
        }
    }

    /// A number, or a picture of such.
    pub(crate) fn scalar(&self, object: &Object, name: &str, default: f32) -> Result<ScalarTexture> {
        let Some(item) = object.find(name) else { return Ok(ScalarTexture::Constant(default)) };
        Ok(match self.item(object, item)? {
            Found::Constant(color) => ScalarTexture::Constant(luminance(color)),
            Found::Image(image) => ScalarTexture::Luminance(self.numbers(image)?),
            Found::Attribute(_) => Err(item.at.error("a number of a mesh's attribute is not read"))?,
        })
    }

    /// A number where no picture can be: the mean of one is taken, with a warning.
    pub(crate) fn number(&self, object: &Object, name: &str, default: f32) -> Result<f32> {
        let Some(item) = object.find(name) else { return Ok(default) };
        match self.item(object, item)? {
            Found::Constant(color) => Ok(luminance(color)),
            Found::Image(image) => {
                let mean = luminance(self.numbers(image)?.mean(&self.embedded.borrow(), true)?);
                self.warn_of_mean(object, name, format!("{mean:.3}"));
                Ok(mean)
            }
            Found::Attribute(_) => Err(item.at.error("a number of a mesh's attribute is not read")),
        }
    }

    /// A colour where no picture can be: likewise.
    pub(crate) fn constant(&self, object: &Object, name: &str, default: f32) -> Result<Rgb> {
        match self.color(object, name, default)? {
            ColorTexture::Constant(color) => Ok(color),
            ColorTexture::Image(image) => {
                let mean = image.mean(&self.embedded.borrow(), false)?;
                self.warn_of_mean(object, name, format!("{mean:.3}"));
                Ok(mean)
            }
            ColorTexture::Vertex(_) => Err(object.error(format!("`{name}` cannot be an attribute of the mesh here"))),
        }
    }

    fn warn_of_mean(&self, object: &Object, name: &str, mean: String) {
        let message =
            format!("`{name}` of the {} cannot be a picture here: its mean, {mean}, is taken", object.label());
        self.objects.warn(&object.at, message);
    }

    /// The picture of a texture that is an object of its own; a constant is one of a single texel.
    pub(crate) fn picture(&self, texture: &Rc<Object>) -> Result<ImageTexture> {
        match self.texture(texture, 0)? {
            Found::Image(image) => Ok(stored(image)),
            Found::Constant(color) => Ok(ImageTexture::new(self.embed(texture, [1, 1], color.to_array().to_vec()))),
            _ => Err(texture.error(format!("the {} is no picture", texture.label()))),
        }
    }

    fn item(&self, object: &Object, item: &Item) -> Result<Found> {
        match &item.value {
            Value::Number(grey) => self.checked(item, Rgb::splat(*grey as f32)),
            Value::Color(color) => self.checked(item, *color),
            _ => match self.objects.object(item)? {
                Some(texture) => self.texture(&texture, 0),
                None => Err(item.at.error(format!(
                    "`{}` of the {} must be a colour or a texture",
                    item.name,
                    object.label()
                ))),
            },
        }
    }

    fn checked(&self, item: &Item, color: Rgb) -> Result<Found> {
        if color.min_element() >= 0.0 && color.is_finite() {
            return Ok(Found::Constant(color));
        }
        Err(item.at.error(format!("`{}` must be 0 or more", item.name)))
    }

    fn texture(&self, texture: &Rc<Object>, depth: usize) -> Result<Found> {
        if depth > 16 {
            return Err(texture.error("this texture is within itself"));
        }
        let found = match texture.kind.as_str() {
            "bitmap" => Found::Image(self.bitmap(texture)?),
            "checkerboard" => Found::Image(self.checkerboard(texture)?),
            "scale" => {
                let inner = self.objects.child(texture, "texture")?;
                let inner = inner.ok_or_else(|| texture.error("the texture `scale` needs another texture"))?;
                scaled(self.texture(&inner, depth + 1)?, texture.color("scale", Rgb::ONE)?)
            }
            // numbers that are no colour
            "rawconstant" => Found::Constant(match texture.find("value").map(|item| &item.value) {
                Some(Value::Vector(numbers)) => numbers.as_vec3(),
                _ => texture.color("value", Rgb::ONE)?,
            }),
            "mesh_attribute" => self.attribute(texture)?,
            "uniform" | "d65" | "srgb" => {
                let name = if texture.kind == "srgb" { "color" } else { "value" };
                Found::Constant(texture.color(name, Rgb::ONE)?)
            }
            kind => return Err(texture.error(format!("the texture `{kind}` has no counterpart: use a bitmap"))),
        };
        self.objects.finish(texture);
        Ok(found)
    }

    /// An attribute of vertices or faces. A mesh has one here.
    fn attribute(&self, texture: &Object) -> Result<Found> {
        let name = texture.text("name")?.unwrap_or_default();
        if !["vertex_", "face_"].iter().any(|start| name.starts_with(start)) {
            return Err(texture.error("the `name` of an attribute begins with `vertex_` or `face_`"));
        }
        let scale = Rgb::splat(texture.number("scale", 1.0)? as f32);
        let known = self.attribute.replace(Some(name.to_string()));
        match known.filter(|known| known != name) {
            Some(known) => Err(texture.error(format!("`{name}` beside `{known}`: a mesh has one attribute here"))),
            None => Ok(Found::Attribute(scale)),
        }
    }

    fn bitmap(&self, texture: &Object) -> Result<ImageTexture> {
        let mut image = ImageTexture::new(texture.file()?.to_path_buf());
        if self.place(texture, &mut image)? {
            image.path = self.transposed(&image.path)?;
        }
        image.nearest = texture.text("filter_type")? == Some("nearest");
        image.clamp = match texture.text("wrap_mode")? {
            None | Some("repeat") => false,
            Some("clamp") => true,
            Some("mirror") => {
                image.mirror([true; 2], &mut self.embedded.borrow_mut())?;
                false
            }
            Some(other) => {
                self.objects.warn(&texture.at, format!("`wrap_mode` {other} is not known here: the picture repeats"));
                false
            }
        };
        let gamma = match texture.flag("raw", false)? {
            true => Some(1.0),
            false => texture.maybe_number("gamma")?.filter(|&gamma| gamma > 0.0),
        };
        if let Some(gamma) = gamma {
            image.path = PathBuf::from(format!("{}{CURVE}{gamma}", image.path.display()));
        }
        texture.ignore(&["format", "max_anisotropy", "cache", "accel"]);
        Ok(image)
    }

    /// A picture of four texels: `color0` is where both coordinates are in the same half.
    fn checkerboard(&self, texture: &Rc<Object>) -> Result<ImageTexture> {
        let colors = [("color0", 0.4), ("color1", 0.2)].map(|(name, default)| texture.color(name, Rgb::splat(default)));
        let [a, b] = colors;
        let (a, b) = (a?.to_array(), b?.to_array());
        let path = self.embed(texture, [2, 2], [a, b, b, a].concat());
        let mut image = ImageTexture { nearest: true, ..ImageTexture::new(path) };
        // four squares are the same when their columns are rows
        self.place(texture, &mut image)?;
        Ok(image)
    }

    /// Keeps the linear colours of a texture, row by row, as a picture. Returns the name that it is known by.
    fn embed(&self, texture: &Object, [width, height]: [usize; 2], colors: Vec<f32>) -> PathBuf {
        let samples = Samples::F32(colors);
        let picture = Picture { width, height, channels: 3, samples, notes: Vec::new() };
        let at = &texture.at;
        let path = PathBuf::from(format!("{}:{}:{}#{}", at.path.display(), at.line, at.column, texture.kind));
        self.embedded.borrow_mut().insert(path.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        path
    }

    /// `to_uv`, or the names before version 2; whether u and v of the picture change places. v counts from above there, and from below
    /// here: 1 − v.
    fn place(&self, texture: &Object, image: &mut ImageTexture) -> Result<bool> {
        let to_uv = texture.transform("to_uv")?.unwrap_or(DAffine3::IDENTITY);
        let both = texture.number("uv_scale", 1.0)?;
        let scale = [texture.number("uscale", both)?, texture.number("vscale", both)?];
        let offset = [texture.number("uoffset", 0.0)?, texture.number("voffset", 0.0)?];
        let [x, y] = [to_uv.matrix3.x_axis, to_uv.matrix3.y_axis];
        let (straight, across) = (x.x.abs().max(y.y.abs()), x.y.abs().max(y.x.abs()));
        // a quarter turn exchanges the two
        let turned = straight <= 1e-6 * across && across > 0.0;
        if !turned && across > 1e-6 * straight {
            let message = "a texture can be turned by quarters only: `to_uv` scales and moves it, and does not turn it";
            self.objects.warn(&texture.at, message);
        }
        let (tu, tv) = (to_uv.translation.x + offset[0], to_uv.translation.y + offset[1]);
        let (su, sv, ou, ov) = match turned {
            true => (x.y * scale[1], y.x * scale[0], tv, tu),
            false => (x.x * scale[0], y.y * scale[1], tu, tv),
        };
        image.scale = [su as f32, sv as f32];
        image.offset = [ou as f32, (1.0 - sv - ov) as f32];
        Ok(turned)
    }

    /// The picture as a colour: where its name ends in a curve, decoded by that, and embedded under this name.
    fn with_curve(&self, image: ImageTexture) -> Result<ImageTexture> {
        let name = image.path.to_string_lossy().into_owned();
        let Some((file, gamma)) = name.rsplit_once(CURVE) else { return Ok(image) };
        if !self.embedded.borrow().contains_key(&image.path) {
            let known = self.embedded.borrow().get(Path::new(file)).cloned();
            let picture = match known.as_deref() {
                Some(EmbeddedPicture::Decoded(picture)) => picture.clone(),
                _ => picture::load(Path::new(file))?,
            };
            let gamma: f32 = gamma.parse().unwrap_or(1.0);
            let picture = EmbeddedPicture::Decoded(picture.with_curve(|x| x.powf(gamma)));
            self.embedded.borrow_mut().insert(image.path.clone(), Arc::new(picture));
        }
        Ok(image)
    }

    /// The picture with the numbers that it stands for: unless it is `raw`, they are decoded as colours are.
    fn numbers(&self, image: ImageTexture) -> Result<ImageTexture> {
        if image.path.to_string_lossy().ends_with(&format!("{CURVE}1")) {
            return Ok(stored(image));
        }
        let mut image = self.with_curve(image)?;
        image.decode(&mut self.embedded.borrow_mut());
        Ok(image)
    }

    /// The picture with its columns as rows, under a name of its own.
    fn transposed(&self, path: &Path) -> Result<PathBuf> {
        let name = PathBuf::from(format!("{}{TURNED}", path.display()));
        if !self.embedded.borrow().contains_key(&name) {
            let picture = picture::load(path)?.transposed();
            self.embedded.borrow_mut().insert(name.clone(), Arc::new(EmbeddedPicture::Decoded(picture)));
        }
        Ok(name)
    }
}

/// The picture whose values count as they are stored, whatever curve its name ends in.
fn stored(image: ImageTexture) -> ImageTexture {
    match image.path.to_string_lossy().rsplit_once(CURVE) {
        Some((file, _)) => ImageTexture { path: PathBuf::from(file), ..image },
        None => image,
    }
}

/// What stands in names before the exponent of pictures that are decoded by another curve than the file says.
const CURVE: &str = "#gamma ";

/// The end of the names of pictures that are turned.
pub(crate) const TURNED: &str = "#turned";

fn scaled(found: Found, by: Rgb) -> Found {
    match found {
        Found::Constant(color) => Found::Constant(color * by),
        Found::Image(image) => Found::Image(ImageTexture { tint: image.tint * by, ..image }),
        Found::Attribute(tint) => Found::Attribute(tint * by),
    }
}
