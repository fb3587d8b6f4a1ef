//! What a record means to a path tracer.
//!
//! MTL describes shading models of its time, and exporters agree on little more than `Kd`. docs/mtl.md lists how each statement is
//! read, and by whose usage. In short: `Kd` is what the surface reflects, a highlight of strength `Ks` lies over it without making
//! it darker than `Kd`; metals are those of Blender (`Ka` as the metallic share), of the PBR extension (`Pm`), or mirrors of the
//! colour `Ks`; `d` is partial coverage; what both lets light pass and refracts is glass.

use super::record::Record;
use crate::bsdf::{
    BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, PlasticParameters, PrincipledMaps,
    PrincipledParameters,
};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};

/// Where a file gives none that could refract.
const DEFAULT_IOR: f32 = 1.5;

/// Of a material without `Kd`, as of [`MaterialDescription::default`].
const DEFAULT_DIFFUSE: Rgb = Rgb::splat(0.5);

/// Where a file says nothing about it: Blender's default.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// The largest exponent, which means a mirror.
const LARGEST_EXPONENT: f32 = 1000.0;

/// Of a coat's reflection, whose square is its reflectance: coats of an index beyond 10 are metals.
const LARGEST_AMPLITUDE: f32 = 9.0 / 11.0;

/// The coat of plastic is not smoother: the largest exponent is the format's end rather than a perfect surface.
const LEAST_PLASTIC_ALPHA: f32 = 1e-3;

impl Record {
    /// The material. Opaque ones scatter on both sides; emission leaves the side of the winding.
    pub(crate) fn describe(&self) -> MaterialDescription {
        let glass = self.is_glass();
        MaterialDescription {
            bsdf: if glass { self.dielectric() } else { self.opaque() },
            two_sided: !glass,
            opacity: if glass { None } else { self.opacity() },
            emission: self.emission_factor(),
            emission_map: self.emission_map.clone(),
            emission_two_sided: false,
            light_group: None,
            relief: self.normal_map.as_ref().or(self.bump_map.as_ref()).cloned(),
            blend: None,
        }
    }

    fn opaque(&self) -> BsdfDescription {
        if self.is_mirror() && !self.has_share_maps() {
            return self.mirror();
        }
        let metallic = self.metallic_share();
        let layered = [self.sheen, self.coat].into_iter().any(|share| share > Some(0.0)) || self.has_share_maps();
        if metallic == 1.0 && !layered {
            conductor(self.metal_colour(), self.roughness())
        } else if metallic > 0.0 || layered {
            self.principled(metallic)
        } else if self.has_highlight() {
            self.plastic()
        } else {
            DiffuseParameters { reflectance: self.diffuse_colour() }.into()
        }
    }

    /// Whether a picture says how rough, metallic or bright the highlight is.
    fn has_share_maps(&self) -> bool {
        [&self.metallic_map, &self.roughness_map, &self.exponent_map, &self.specular_map]
            .into_iter()
            .any(Option::is_some)
    }

    /// What it says of pictures that come to nothing, each with the reason.
    pub(super) fn unused_maps(&self) -> impl Iterator<Item = &'static str> {
        let glass = self.is_glass();
        [
            (glass && self.has_share_maps(), "`map_Ks`, `map_Ns`, `map_Pr` and `map_Pm` are ignored, as it is glass"),
            (
                !glass && self.roughness_map.is_some() && self.exponent_map.is_some(),
                "`map_Ns` is ignored beside `map_Pr`",
            ),
            (
                self.normal_map.is_some() && self.bump_map.is_some(),
                "`bump` (or `map_Bump`) is ignored beside `norm` (or `map_Kn`)",
            ),
        ]
        .into_iter()
        .filter_map(|(unused, message)| unused.then_some(message))
    }

    /// `Pm`, or what Blender writes for it: `Ka`, grey, beside an illumination model that reflects.
    fn metallic_share(&self) -> f32 {
        let of_blender = self.blender_metallic().filter(|_| self.reflects());
        self.metallic.or(of_blender).unwrap_or(0.0)
    }

    /// A `Ka` that is a share. Other programs write black there, or the diffuse colour again.
    fn blender_metallic(&self) -> Option<f32> {
        let ambient = self.ambient.filter(|&ambient| ambient == Rgb::splat(ambient.x) && ambient != Rgb::ZERO);
        ambient.filter(|_| self.ambient != self.diffuse).map(|ambient| ambient.x.min(1.0))
    }

    /// Whether the illumination model traces reflections, and no light passes.
    fn reflects(&self) -> bool {
        self.illumination_in(&[3.0, 5.0, 8.0])
    }

    /// By the format's own words, `Ks` is the colour of what illumination models 3, 5 and 8 reflect. The surface is taken for a
    /// mirror where nothing says otherwise and that outshines what `Kd` scatters.
    fn is_mirror(&self) -> bool {
        let strength = |colour: Option<Rgb>| colour.map_or(0.0, |colour| colour.max_element());
        let dark = self.diffuse_map.is_none() && strength(self.diffuse) <= strength(self.specular);
        let unsaid = self.metallic.is_none() && self.blender_metallic().is_none();
        self.reflects() && unsaid && (dark || self.specular.is_none_or(|specular| specular == Rgb::ZERO))
    }

    fn mirror(&self) -> BsdfDescription {
        let specular = self.specular.filter(|&specular| specular != Rgb::ZERO);
        let colour = specular.map_or_else(|| self.diffuse_colour(), ColorTexture::Constant);
        conductor(colour, self.roughness.unwrap_or(0.0))
    }

    /// `Kd`; older exporters have it in `Ks` alone.
    fn metal_colour(&self) -> ColorTexture {
        let in_specular = self.diffuse == Some(Rgb::ZERO) && self.diffuse_map.is_none();
        let specular = self.specular.filter(|_| in_specular).map(ColorTexture::Constant);
        specular.unwrap_or_else(|| self.diffuse_colour())
    }

    /// What is a metal in part, or has a sheen or a coat.
    fn principled(&self, metallic: f32) -> BsdfDescription {
        let principled = PrincipledParameters {
            base_color: if metallic > 0.0 || self.metallic_map.is_some() {
                self.metal_colour()
            } else {
                self.diffuse_colour()
            },
            metallic,
            roughness: self.roughness(),
            specular: self.specular_level(),
            sheen: self.sheen.unwrap_or(0.0),
            clearcoat: self.coat.unwrap_or(0.0),
            clearcoat_gloss: 1.0 - self.coat_roughness.unwrap_or(0.0),
            maps: PrincipledMaps {
                metallic: self.metallic_map.clone(),
                roughness: self.roughness_map.clone().or(self.exponent_map.clone()),
                specular: self.specular_map.clone(),
            },
            energy_conserving: true,
            ..PrincipledParameters::default()
        };
        principled.into()
    }

    /// `illum` 0 and 1 have none by the format's words; `Pr` speaks of nothing else.
    fn has_highlight(&self) -> bool {
        let phong = self.specular.is_some_and(|specular| specular != Rgb::ZERO) && self.exponent > Some(0.0);
        let physical = self.roughness.is_some() && self.specular != Some(Rgb::ZERO);
        physical || phong && !self.illumination_in(&[0.0, 1.0])
    }

    /// Strength of the highlight: the mean of `Ks`, where 0.5 is the reflection of the surface's index of refraction (Blender,
    /// Burley 2012).
    fn specular_level(&self) -> f32 {
        self.specular.map_or(0.5, |specular| specular.element_sum() / 3.0)
    }

    fn is_glass(&self) -> bool {
        let refracts = self.ior.is_none_or(|ior| (ior - 1.0).abs() > 1e-3);
        let filters = self.share_stopped() < 1.0 && self.filter.is_some();
        let models = self.illumination_in(&[4.0, 6.0, 7.0, 9.0]);
        refracts && (models && self.lets_light_pass() || filters) && self.dissolve_map.is_none()
    }

    /// Some programs write illumination models with refraction for every material, paint and all.
    fn lets_light_pass(&self) -> bool {
        let black = self.diffuse == Some(Rgb::ZERO) && self.diffuse_map.is_none();
        self.share_stopped() < 1.0 || self.filter.is_some_and(|filter| filter != Rgb::ZERO) || black
    }

    fn dielectric(&self) -> BsdfDescription {
        let glass = DielectricParameters {
            int_ior: self.ior.unwrap_or(DEFAULT_IOR),
            specular_transmittance: self.filter.unwrap_or(Rgb::ONE),
            alpha: self.roughness.map_or(0.0, |roughness| roughness * roughness),
            ..DielectricParameters::default()
        };
        glass.into()
    }

    /// The coat lets through what the base then reflects as `Kd`: no light is lost between them, so that the whole reflects
    /// Kd(1 − E) + E with E the albedo of the coat.
    fn plastic(&self) -> BsdfDescription {
        let roughness = self.roughness();
        let ior = self.ior.filter(|&ior| ior > 1.0).unwrap_or(DEFAULT_IOR);
        let plastic = PlasticParameters {
            reflectance: self.diffuse_colour(),
            int_ior: scaled_ior(ior, 2.0 * self.specular_level()),
            alpha: (roughness * roughness).max(LEAST_PLASTIC_ALPHA),
            energy_conserving: true,
            ..PlasticParameters::default()
        };
        plastic.into()
    }

    /// `map_Kd` times `Kd`. Exporters that leave `Kd` black beside a map mean the map, which is what Blender shows.
    fn diffuse_colour(&self) -> ColorTexture {
        match &self.diffuse_map {
            None => ColorTexture::Constant(self.diffuse.unwrap_or(DEFAULT_DIFFUSE)),
            Some(map) => {
                let colour = self.diffuse.filter(|&colour| colour != Rgb::ZERO).unwrap_or(Rgb::ONE);
                ColorTexture::Image(ImageTexture { tint: map.tint * colour, ..map.clone() })
            }
        }
    }

    /// `Ke`. Where it is black beside a map, the map alone says what glows, which is what Blender shows.
    fn emission_factor(&self) -> Rgb {
        let unsaid = if self.emission_map.is_some() { Rgb::ONE } else { Rgb::ZERO };
        self.emission.filter(|&emission| emission != Rgb::ZERO).unwrap_or(unsaid)
    }

    /// `map_d` times `d`; a map beside `d 0` counts alone, as with `map_Kd`.
    fn opacity(&self) -> Option<ScalarTexture> {
        let stopped = self.share_stopped();
        match &self.dissolve_map {
            None => (stopped < 1.0).then_some(ScalarTexture::Constant(stopped)),
            Some(map) => {
                let factor = if stopped > 0.0 { stopped } else { 1.0 };
                Some(scaled(map, factor))
            }
        }
    }

    fn share_stopped(&self) -> f32 {
        if self.is_inverted() {
            return 1.0;
        }
        self.dissolve.or(self.transparency.map(|tr| 1.0 - tr)).unwrap_or(1.0)
    }

    /// Whether `Tr 1` is written for an opaque material, as by MeshLab and programs of photogrammetry: nothing else says that light
    /// passes, and by the format's words nobody would see the surface.
    pub(super) fn is_inverted(&self) -> bool {
        let passes = self.filter.is_some() || self.illumination_in(&[4.0, 6.0, 7.0, 9.0]);
        self.transparency == Some(1.0) && self.dissolve.is_none() && self.dissolve_map.is_none() && !passes
    }

    /// Whether nobody can see it: no part of it stops light, and it neither refracts nor emits.
    pub(super) fn is_invisible(&self) -> bool {
        self.share_stopped() == 0.0 && self.dissolve_map.is_none() && !self.is_glass()
    }

    /// `Pr`, or what Blender writes as `Ns` = 1000 (1 − roughness)².
    fn roughness(&self) -> f32 {
        let from_exponent = |ns: f32| 1.0 - (ns.min(LARGEST_EXPONENT) / LARGEST_EXPONENT).sqrt();
        self.roughness.or(self.exponent.map(from_exponent)).unwrap_or(DEFAULT_ROUGHNESS)
    }

    fn illumination_in(&self, models: &[f32]) -> bool {
        self.illumination.is_some_and(|illum| models.contains(&illum))
    }
}

/// A picture of numbers times a factor.
fn scaled(texture: &ScalarTexture, factor: f32) -> ScalarTexture {
    let times = |image: &ImageTexture| ImageTexture { tint: image.tint * factor, ..image.clone() };
    match texture {
        ScalarTexture::Constant(share) => ScalarTexture::Constant(share * factor),
        ScalarTexture::Image(image) => ScalarTexture::Image(times(image)),
        ScalarTexture::Luminance(image) => ScalarTexture::Luminance(times(image)),
        ScalarTexture::Channel(image, channel) => ScalarTexture::Channel(times(image), *channel),
    }
}

/// A metal that reflects `colour` at every angle, however rough it is.
fn conductor(colour: ColorTexture, roughness: f32) -> BsdfDescription {
    let (alpha, other) = (roughness * roughness, ConductorParameters::default());
    ConductorParameters { specular_reflectance: colour, alpha, energy_conserving: true, ..other }.into()
}

/// The index of refraction of which the reflection at normal incidence is `factor` times that of `ior`.
fn scaled_ior(ior: f32, factor: f32) -> f32 {
    let amplitude = ((ior - 1.0) / (ior + 1.0) * factor.sqrt()).min(LARGEST_AMPLITUDE);
    (1.0 + amplitude) / (1.0 - amplitude)
}
