//! What an artist sets, and the keys of it.

use super::{PrincipledLobes, PrincipledModel, TexturedPrincipledModel};
use crate::Result;
use crate::bsdf::model::{BsdfParameters, out_of_domain};
use crate::bsdf::{BsdfTables, Model};
use crate::document::{Key, UNIT, key};
use crate::fields::{FieldVisitor, Fields};
use crate::texture::{ColorTexture, ScalarTexture};

/// What an artist sets, every number in [0, 1]; names and defaults as of Burley.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipledParameters {
    pub base_color: ColorTexture,
    pub metallic: f32,
    pub roughness: f32,
    pub specular: f32,
    pub spec_tint: f32,
    pub clearcoat: f32,
    pub clearcoat_gloss: f32,
    pub sheen: f32,
    pub sheen_tint: f32,
    /// Light that the facets of metals send to each other comes back.
    pub energy_conserving: bool,
    pub maps: PrincipledMaps,
}

/// Pictures in the place of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipledMaps {
    pub metallic: Option<ScalarTexture>,
    pub roughness: Option<ScalarTexture>,
    pub specular: Option<ScalarTexture>,
}

impl PrincipledMaps {
    pub(crate) const NONE: PrincipledMaps = PrincipledMaps { metallic: None, roughness: None, specular: None };
}

impl Default for PrincipledParameters {
    fn default() -> PrincipledParameters {
        PrincipledParameters {
            base_color: ColorTexture::grey(0.5),
            metallic: 0.0,
            roughness: 0.5,
            specular: 0.5,
            spec_tint: 0.0,
            clearcoat: 0.0,
            clearcoat_gloss: 1.0,
            sheen: 0.0,
            sheen_tint: 0.5,
            energy_conserving: false,
            maps: PrincipledMaps::NONE,
        }
    }
}

impl PrincipledParameters {
    /// The keys of numbers that may be pictures, with their slots; in the order of [`PrincipledLobes::with`].
    fn shares(&mut self) -> [(Key, &mut f32, &mut Option<ScalarTexture>); 3] {
        let maps = &mut self.maps;
        [
            (key("metallic", "from dielectric to metal"), &mut self.metallic, &mut maps.metallic),
            (key("roughness", "α = roughness²"), &mut self.roughness, &mut maps.roughness),
            (key("specular", "strength of the dielectric reflection"), &mut self.specular, &mut maps.specular),
        ]
    }

    /// The keys of the other numbers, with their slots.
    fn numbers(&mut self) -> [(Key, &mut f32); 5] {
        [
            (key("spec_tint", "how far that takes the base's hue"), &mut self.spec_tint),
            (key("clearcoat", "strength of a second, clear coat"), &mut self.clearcoat),
            (key("clearcoat_gloss", "its gloss"), &mut self.clearcoat_gloss),
            (key("sheen", "grazing reflection of cloth"), &mut self.sheen),
            (key("sheen_tint", "how far that takes the base's hue"), &mut self.sheen_tint),
        ]
    }
}

impl Fields for PrincipledParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.texture(key("base_color", "albedo of a dielectric, reflection of a metal"), &mut self.base_color)?;
        self.shares().into_iter().try_for_each(|(key, number, map)| visitor.share(key, number, map))?;
        self.numbers().into_iter().try_for_each(|(key, slot)| visitor.number(key, UNIT, slot))?;
        let meaning = "light that the facets of a metal send to each other comes back, so that a rough metal is as bright as a smooth one \
                       (multiple scattering)";
        visitor.added_flag(key("energy_conserving", meaning), &mut self.energy_conserving)
    }
}

impl BsdfParameters for PrincipledParameters {
    const NUMBER: u32 = 6;
    const OPAQUE: bool = true;

    fn model(&self, tables: &mut BsdfTables) -> Result<Model> {
        let mut given = self.clone();
        let shares: Vec<(Key, f32)> = given.shares().map(|(key, share, _)| (key, *share)).into();
        let numbers = given.numbers().map(|(key, share)| (key, *share));
        for (key, share) in shares.into_iter().chain(numbers) {
            if !(0.0..=1.0).contains(&share) {
                return Err(out_of_domain(key.name, "between 0 and 1"));
            }
        }
        let lobes = PrincipledLobes::new(self);
        let metal = self.energy_conserving && (self.metallic > 0.0 || self.maps.metallic.is_some());
        let constant = self.maps.roughness.is_none();
        let loss = metal.then(|| if constant { tables.loss(&lobes.facets) } else { tables.losses() });
        let model = PrincipledModel { lobes, loss };
        Ok(if self.maps == PrincipledMaps::NONE { model.into() } else { TexturedPrincipledModel(model).into() })
    }
}
