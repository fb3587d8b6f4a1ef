//! Things as written, field by field.
//!
//! What is described by keys (a BSDF, a light) declares each field once, in [`Fields::fields`], with its key, its domain and
//! its slot. All who walk over the fields are visitors: the reader of scene files, the hash of a scene, those who look for
//! textures, an exporter. A new field is one line where its thing is described.

use crate::document::{Bounds, Key};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ScalarTexture};
use glam::{Affine3A, DVec3, Vec3};
use std::convert::Infallible;
use std::path::PathBuf;

/// A thing that has fields.
pub(crate) trait Fields {
    /// Shows all fields to the visitor, in an order that never changes.
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error>;
}

/// Walks over fields. It may change what is in the slots.
pub(crate) trait FieldVisitor {
    type Error;

    fn flag(&mut self, key: Key, slot: &mut bool) -> Result<(), Self::Error>;
    fn number(&mut self, key: Key, bounds: Bounds, slot: &mut f32) -> Result<(), Self::Error>;
    /// A number in [0, 1], or a picture of such in its place.
    fn share(&mut self, key: Key, number: &mut f32, map: &mut Option<ScalarTexture>) -> Result<(), Self::Error>;
    fn color(&mut self, key: Key, bounds: Bounds, slot: &mut Rgb) -> Result<(), Self::Error>;
    fn choice<T: Choice>(&mut self, key: Key, slot: &mut T) -> Result<(), Self::Error>;
    /// A reflectance or transmittance: each channel is in [0, 1].
    fn texture(&mut self, key: Key, slot: &mut ColorTexture) -> Result<(), Self::Error>;
    /// Two colours of which both are given or neither.
    fn color_pair(&mut self, keys: [(Key, Bounds); 2], slot: &mut Option<(Rgb, Rgb)>) -> Result<(), Self::Error>;
    /// A point in world space, as it is written.
    fn position(&mut self, key: Key, slot: &mut DVec3) -> Result<(), Self::Error>;
    /// A unit vector in world space; another length may be written, but for zero.
    fn direction(&mut self, key: Key, slot: &mut Vec3) -> Result<(), Self::Error>;
    /// A rotation, with or without a mirroring: by an angle about +y in degrees, or by a matrix in its place.
    fn orientation(&mut self, angle: Key, matrix: Key, slot: &mut Affine3A) -> Result<(), Self::Error>;
    /// A picture in a file: linear radiance.
    fn picture(&mut self, key: Key, slot: &mut PathBuf) -> Result<(), Self::Error>;

    /// A flag that is younger than scenes' hashes: `false` leaves them as they were.
    fn added_flag(&mut self, key: Key, slot: &mut bool) -> Result<(), Self::Error> {
        self.flag(key, slot)
    }

    /// That fields go together. `message` says what is wrong where they do not; it is about the first of `keys` that is
    /// given.
    fn check(&mut self, _holds: bool, _keys: &[&str], _message: &str) -> Result<(), Self::Error> {
        Ok(())
    }
}

/// One of a list of values with names.
pub(crate) trait Choice: Copy + PartialEq + 'static {
    /// A value's place in the list stands for it in a scene's hash: new ones come last.
    const NAMES: &'static [(&'static str, Self)];

    /// The value's place in the list.
    fn number(self) -> usize {
        Self::NAMES.iter().position(|(_, value)| *value == self).unwrap_or(Self::NAMES.len())
    }
}

/// Calls `each` with every texture, in the order of the fields.
pub(crate) fn each_texture(fields: &mut impl Fields, each: impl FnMut(&mut ColorTexture)) {
    let Ok(()) = fields.fields(&mut Textures(each, |_: &mut f32, _: &mut Option<ScalarTexture>| ()));
}

/// Calls `each` with every number that may be a picture, and that picture, in the order of the fields.
pub(crate) fn each_share(fields: &mut impl Fields, each: impl FnMut(&mut f32, &mut Option<ScalarTexture>)) {
    let Ok(()) = fields.fields(&mut Textures(|_: &mut ColorTexture| (), each));
}

struct Textures<F, G>(F, G);

impl<F: FnMut(&mut ColorTexture), G: FnMut(&mut f32, &mut Option<ScalarTexture>)> FieldVisitor for Textures<F, G> {
    type Error = Infallible;

    fn texture(&mut self, _: Key, slot: &mut ColorTexture) -> Result<(), Infallible> {
        (self.0)(slot);
        Ok(())
    }

    fn share(&mut self, _: Key, number: &mut f32, map: &mut Option<ScalarTexture>) -> Result<(), Infallible> {
        (self.1)(number, map);
        Ok(())
    }

    fn flag(&mut self, _: Key, _: &mut bool) -> Result<(), Infallible> {
        Ok(())
    }

    fn number(&mut self, _: Key, _: Bounds, _: &mut f32) -> Result<(), Infallible> {
        Ok(())
    }

    fn color(&mut self, _: Key, _: Bounds, _: &mut Rgb) -> Result<(), Infallible> {
        Ok(())
    }

    fn choice<T: Choice>(&mut self, _: Key, _: &mut T) -> Result<(), Infallible> {
        Ok(())
    }

    fn color_pair(&mut self, _: [(Key, Bounds); 2], _: &mut Option<(Rgb, Rgb)>) -> Result<(), Infallible> {
        Ok(())
    }

    fn position(&mut self, _: Key, _: &mut DVec3) -> Result<(), Infallible> {
        Ok(())
    }

    fn direction(&mut self, _: Key, _: &mut Vec3) -> Result<(), Infallible> {
        Ok(())
    }

    fn orientation(&mut self, _: Key, _: Key, _: &mut Affine3A) -> Result<(), Infallible> {
        Ok(())
    }

    fn picture(&mut self, _: Key, _: &mut PathBuf) -> Result<(), Infallible> {
        Ok(())
    }
}
