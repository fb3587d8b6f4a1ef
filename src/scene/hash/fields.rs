//! The canonical bytes of materials and lights: their fields, one after the other.

use super::Canon;
use crate::Result;
use crate::document::{Bounds, Key};
use crate::fields::{Choice, FieldVisitor, Fields};
use crate::math::Rgb;
use crate::scene::description::{BlendDescription, MaterialDescription};
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use glam::{Affine3A, DVec3, Vec3};
use std::path::{Path, PathBuf};

/// Writes fields. Their keys and domains have no part in the hash.
pub(super) struct CanonicalFields<'a> {
    pub(crate) canon: &'a mut Canon,
    /// Hash of a picture's content.
    pub(crate) picture: &'a mut dyn FnMut(&Path) -> Result<u64>,
}

impl CanonicalFields<'_> {
    pub(crate) fn material(&mut self, material: &MaterialDescription) -> Result<()> {
        let MaterialDescription {
            bsdf,
            two_sided,
            opacity,
            emission,
            emission_map,
            emission_two_sided,
            relief,
            blend,
            ..
        } = material;
        self.canon.u32(bsdf.number());
        bsdf.clone().fields(self)?;
        self.canon.flag(*two_sided);
        match opacity {
            None => self.canon.u32(0),
            Some(texture) => self.scalar(texture)?,
        }
        self.canon.vector(*emission);
        self.canon.flag(*emission_two_sided);
        // what came later is written only where it is, so that older scenes keep their numbers
        emission_map.as_ref().map_or(Ok(()), |image| self.image(4, image))?;
        blend.as_ref().map_or(Ok(()), |blend| self.blend(blend))?;
        let Some(ReliefTexture { image, kind, strength }) = relief else { return Ok(()) };
        self.canon.u32(match kind {
            ReliefKind::Normals => 5,
            ReliefKind::Heights => 6,
            ReliefKind::TexelHeights => 7,
            ReliefKind::NormalsOrTexelHeights => 8,
            ReliefKind::NormalsDown => 9,
        });
        self.canon.floats([*strength]);
        self.image(9, image)
    }

    fn blend(&mut self, blend: &BlendDescription) -> Result<()> {
        self.canon.u32(21);
        self.scalar(&blend.weight)?;
        blend.parts.iter().try_for_each(|part| self.material(&part.material))
    }

    fn scalar(&mut self, texture: &ScalarTexture) -> Result<()> {
        match texture {
            ScalarTexture::Constant(share) => {
                self.canon.u32(1);
                self.canon.floats([*share]);
                Ok(())
            }
            ScalarTexture::Image(image) => self.image(2, image),
            ScalarTexture::Luminance(image) => self.image(3, image),
            ScalarTexture::Channel(image, channel) => self.image(10 + *channel as u32, image),
        }
    }

    fn image(&mut self, kind: u32, image: &ImageTexture) -> Result<()> {
        let ImageTexture { path, scale, offset, nearest, tint, clamp } = image;
        self.canon.u32(kind);
        self.canon.u64((self.picture)(path)?);
        self.canon.floats(*scale);
        self.canon.floats(*offset);
        self.canon.flag(*nearest);
        self.canon.vector(*tint);
        if *clamp {
            self.canon.u32(1);
        }
        Ok(())
    }
}

impl FieldVisitor for CanonicalFields<'_> {
    type Error = crate::Error;

    fn flag(&mut self, _: Key, slot: &mut bool) -> Result<()> {
        self.canon.flag(*slot);
        Ok(())
    }

    fn added_flag(&mut self, _: Key, slot: &mut bool) -> Result<()> {
        if *slot {
            self.canon.u32(20);
        }
        Ok(())
    }

    fn number(&mut self, _: Key, _: Bounds, slot: &mut f32) -> Result<()> {
        self.canon.floats([*slot]);
        Ok(())
    }

    fn share(&mut self, _: Key, number: &mut f32, map: &mut Option<ScalarTexture>) -> Result<()> {
        self.canon.floats([*number]);
        map.as_ref().map_or(Ok(()), |map| self.scalar(map))
    }

    fn color(&mut self, _: Key, _: Bounds, slot: &mut Rgb) -> Result<()> {
        self.canon.vector(*slot);
        Ok(())
    }

    fn choice<T: Choice>(&mut self, _: Key, slot: &mut T) -> Result<()> {
        self.canon.u32(slot.number() as u32);
        Ok(())
    }

    fn texture(&mut self, _: Key, slot: &mut ColorTexture) -> Result<()> {
        match slot {
            ColorTexture::Constant(color) => {
                self.canon.u32(1);
                self.canon.vector(*color);
                Ok(())
            }
            ColorTexture::Image(image) => self.image(2, image),
            ColorTexture::Vertex(tint) => {
                self.canon.u32(4);
                self.canon.vector(*tint);
                Ok(())
            }
        }
    }

    fn color_pair(&mut self, _: [(Key, Bounds); 2], slot: &mut Option<(Rgb, Rgb)>) -> Result<()> {
        self.canon.flag(slot.is_some());
        slot.iter().for_each(|(a, b)| [a, b].into_iter().for_each(|v| self.canon.vector(*v)));
        Ok(())
    }

    fn position(&mut self, _: Key, slot: &mut DVec3) -> Result<()> {
        self.canon.vector(slot.as_vec3());
        Ok(())
    }

    fn direction(&mut self, _: Key, slot: &mut Vec3) -> Result<()> {
        self.canon.vector(*slot);
        Ok(())
    }

    fn orientation(&mut self, _: Key, _: Key, slot: &mut Affine3A) -> Result<()> {
        self.canon.transform(*slot);
        Ok(())
    }

    fn picture(&mut self, _: Key, slot: &mut PathBuf) -> Result<()> {
        let hash = (self.picture)(slot)?;
        self.canon.u64(hash);
        Ok(())
    }
}
