//! What an MTL library says of one material, as written.

use super::super::lines::{self, Fields};
use super::super::source::Fault;
use super::texture::{Channel, TextureStatement};
use super::{Notes, texture};
use crate::math::Rgb;
use crate::texture::{ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use std::path::Path;

/// The statements that mean something here. Numbers are finite, shares and colours in [0, 1], but `emission` and `ambient`.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Offset of its `newmtl`.
    pub(crate) at: usize,
    /// `Kd`
    pub(crate) diffuse: Option<Rgb>,
    /// `Ka`
    pub(crate) ambient: Option<Rgb>,
    /// `Ks`
    pub(crate) specular: Option<Rgb>,
    /// `Ke`, ≥ 0
    pub(crate) emission: Option<Rgb>,
    /// `Tf`
    pub(crate) filter: Option<Rgb>,
    /// `Ns`, ≥ 0
    pub(crate) exponent: Option<f32>,
    /// `Ni`, > 0
    pub(crate) ior: Option<f32>,
    /// `d`
    pub(crate) dissolve: Option<f32>,
    /// `Tr`
    pub(crate) transparency: Option<f32>,
    /// `Pr`
    pub(crate) roughness: Option<f32>,
    /// `Pm`
    pub(crate) metallic: Option<f32>,
    /// `Ps`
    pub(crate) sheen: Option<f32>,
    /// `Pc`
    pub(crate) coat: Option<f32>,
    /// `Pcr`
    pub(crate) coat_roughness: Option<f32>,
    /// `illum`
    pub(crate) illumination: Option<f32>,
    /// `map_Kd`
    pub(crate) diffuse_map: Option<ImageTexture>,
    /// `map_d`
    pub(crate) dissolve_map: Option<ScalarTexture>,
    /// `map_Ks`
    pub(crate) specular_map: Option<ScalarTexture>,
    /// `map_Pr`
    pub(crate) roughness_map: Option<ScalarTexture>,
    /// `map_Ns`
    pub(crate) exponent_map: Option<ScalarTexture>,
    /// `map_Pm`
    pub(crate) metallic_map: Option<ScalarTexture>,
    /// `map_Ke`
    pub(crate) emission_map: Option<ImageTexture>,
    /// `norm`, `map_Kn`
    pub(crate) normal_map: Option<ReliefTexture>,
    /// `bump`, `map_Bump`
    pub(crate) bump_map: Option<ReliefTexture>,
}

impl Record {
    /// Takes in one statement.
    pub(crate) fn set(&mut self, keyword: &[u8], line: &[u8], folder: &Path, notes: &mut Notes) -> Result<(), Fault> {
        let name = lines::excerpt(keyword);
        let mut statement = Statement { name: &name, fields: Fields::new(line, keyword.len()), notes };
        match &*name.to_ascii_lowercase() {
            "kd" => statement.set_colour(&mut self.diffuse, 1.0)?,
            "ks" => statement.set_colour(&mut self.specular, 1.0)?,
            "ke" => statement.set_colour(&mut self.emission, f32::MAX)?,
            "tf" => statement.set_colour(&mut self.filter, 1.0)?,
            "ns" => self.exponent = Some(statement.number(0.0, f32::MAX)?),
            "ni" => self.ior = statement.ior()?,
            "d" => self.dissolve = Some(statement.dissolve()?),
            "tr" => self.transparency = Some(statement.number(0.0, 1.0)?),
            "pr" => self.roughness = Some(statement.number(0.0, 1.0)?),
            "pm" => self.metallic = Some(statement.number(0.0, 1.0)?),
            "ka" => statement.set_colour(&mut self.ambient, f32::MAX)?,
            "ps" => self.sheen = Some(statement.number(0.0, 1.0)?),
            "pc" => self.coat = Some(statement.number(0.0, 1.0)?),
            "pcr" => self.coat_roughness = Some(statement.number(0.0, 1.0)?),
            "illum" => self.illumination = Some(statement.number(0.0, f32::MAX)?),
            "map_kd" => self.diffuse_map = statement.texture(folder)?,
            "map_ke" => self.emission_map = statement.texture(folder)?,
            "norm" | "map_kn" => self.normal_map = statement.relief(folder, ReliefKind::Normals)?,
            "bump" | "map_bump" => self.bump_map = statement.relief(folder, ReliefKind::NormalsOrTexelHeights)?,
            "map_d" => self.dissolve_map = statement.scalar(folder, Channel::Matte)?,
            "map_ks" => self.specular_map = statement.scalar(folder, Channel::Luminance)?,
            "map_pr" => self.roughness_map = statement.scalar(folder, Channel::Luminance)?,
            "map_pm" => self.metallic_map = statement.scalar(folder, Channel::Luminance)?,
            "map_ns" => self.exponent_map = statement.scalar(folder, Channel::Luminance)?,
            "sharpness" => {}
            _ => notes.once(format!("statement `{name}` is ignored")),
        }
        if let (Some(d), Some(tr)) = (self.dissolve, self.transparency)
            && (d + tr - 1.0).abs() > 1e-3
        {
            notes.once("`d` and `Tr` contradict each other; `d` counts");
        }
        Ok(())
    }
}

/// A statement while its arguments are read.
struct Statement<'a, 'n> {
    name: &'a str,
    fields: Fields<'a>,
    notes: &'n mut Notes,
}

impl Statement<'_, '_> {
    fn optional(&mut self) -> Result<Option<f32>, Fault> {
        self.fields.rest();
        let at = self.fields.at;
        match self.fields.number()? {
            Some(x) if !x.is_finite() => Err(Fault::new(at, format!("`{}`: not finite", self.name))),
            number => Ok(number),
        }
    }

    fn finite(&mut self) -> Result<f32, Fault> {
        let missing = format!("`{}` needs a number", self.name);
        self.optional()?.ok_or_else(|| Fault::new(self.fields.at, missing))
    }

    /// A number, brought into [`least`, `most`] with a warning.
    fn number(&mut self, least: f32, most: f32) -> Result<f32, Fault> {
        let number = self.finite()?;
        Ok(self.clamp(Rgb::splat(number), least, most).x)
    }

    fn clamp(&mut self, colour: Rgb, least: f32, most: f32) -> Rgb {
        let clamped = colour.clamp(Rgb::splat(least), Rgb::splat(most));
        if clamped != colour {
            let range = if most < f32::MAX { "[0, 1]" } else { "the numbers from 0 up" };
            self.notes.once(format!("`{}` is brought into {range}", self.name));
        }
        clamped
    }

    /// One number for a grey, or three.
    fn set_colour(&mut self, colour: &mut Option<Rgb>, most: f32) -> Result<(), Fault> {
        let first = self.fields.rest();
        if first.starts_with(b"spectral") || first.starts_with(b"xyz") {
            self.notes.once(format!("`{}` as a spectrum or in XYZ is ignored", self.name));
            return Ok(());
        }
        let red = self.finite()?;
        let rgb = match self.optional()? {
            None => Rgb::splat(red),
            Some(green) => Rgb::new(red, green, self.finite()?),
        };
        *colour = Some(self.clamp(rgb, 0.0, most));
        Ok(())
    }

    fn ior(&mut self) -> Result<Option<f32>, Fault> {
        let ior = self.finite()?;
        if ior <= 0.0 {
            self.notes.once("`Ni` that is not positive is ignored");
        }
        Ok((ior > 0.0).then_some(ior))
    }

    /// The angle-dependent form counts as a constant.
    fn dissolve(&mut self) -> Result<f32, Fault> {
        if self.fields.rest().starts_with(b"-halo") {
            self.notes.once("`d -halo` counts as `d`");
            self.fields.at += b"-halo".len();
        }
        self.number(0.0, 1.0)
    }

    /// A picture that is no relief.
    fn texture(&mut self, folder: &Path) -> Result<Option<ImageTexture>, Fault> {
        let Some(statement) = self.read_texture(folder)? else { return Ok(None) };
        self.without(statement.bump.is_some(), "-bm");
        self.without(statement.channel.is_some(), "-imfchan");
        Ok(Some(statement.image))
    }

    /// A picture of numbers.
    fn scalar(&mut self, folder: &Path, usual: Channel) -> Result<Option<ScalarTexture>, Fault> {
        let Some(statement) = self.read_texture(folder)? else { return Ok(None) };
        self.without(statement.bump.is_some(), "-bm");
        Ok(Some(statement.scalar(usual)))
    }

    /// Says that an option means nothing for this statement, where it is given.
    fn without(&mut self, given: bool, option: &str) {
        if given {
            self.notes.once(format!("option `{option}` of `{}` is ignored", self.name));
        }
    }

    fn relief(&mut self, folder: &Path, kind: ReliefKind) -> Result<Option<ReliefTexture>, Fault> {
        let Some(TextureStatement { image, bump, channel }) = self.read_texture(folder)? else { return Ok(None) };
        self.without(channel.is_some(), "-imfchan");
        Ok(Some(ReliefTexture { image, kind, strength: bump.unwrap_or(1.0) }))
    }

    fn read_texture(&mut self, folder: &Path) -> Result<Option<TextureStatement>, Fault> {
        let texture = texture::read(self.fields.rest(), folder, self.notes)
            .map_err(|fault| fault.shifted(self.fields.at as u64))?;
        if texture.is_none() {
            self.notes.once(format!("`{}` names no file", self.name));
        }
        Ok(texture)
    }
}
