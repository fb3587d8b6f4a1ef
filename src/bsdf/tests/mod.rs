//! Every kind against its contract. Materials are built as from a scene file.

mod chi2;
mod consistency;
mod energy;
mod lanes;
mod reference;
mod shading_normal;

use super::*;
use crate::bsdf::MicrofacetDistribution::{self, Beckmann, Ggx};
use crate::bsdf::{
    BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, DiffuseTransmitterParameters,
    NullParameters, PlasticParameters, PrincipledMaps, PrincipledParameters,
};
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};

const WHITE: ColorTexture = ColorTexture::Constant(Rgb::ONE);

/// A material and the colours it is looked at with.
struct Material {
    name: String,
    description: BsdfDescription,
    model: BsdfModel,
    colors: [Rgb; 2],
    /// Of the surface, where it is not the shading normal.
    normal: Vec3,
}

impl Material {
    fn new(name: impl Into<String>, description: BsdfDescription, two_sided: bool) -> Material {
        let model = BsdfModel::new(&description, two_sided, &mut BsdfTables::default()).unwrap();
        Material { name: name.into(), description, model, colors: [Rgb::ONE; 2], normal: Vec3::Z }
    }

    fn sided(&self, two_sided: bool) -> Material {
        Material::new(&self.name, self.description.clone(), two_sided)
            .colored(self.colors[0], self.colors[1])
            .turned(self.normal)
    }

    /// With a normal from a picture.
    fn turned(self, normal: Vec3) -> Material {
        Material { name: format!("{} about {normal}", self.name), normal, ..self }
    }

    fn colored(self, first: Rgb, second: Rgb) -> Material {
        Material { colors: [first, second], ..self }
    }

    fn bsdf(&self) -> Bsdf<'_> {
        self.model.at(self.colors).with_normal(self.normal)
    }
}

fn polar(theta: f32, phi: f32) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

const COPPER: (Rgb, Rgb) = (Rgb::new(0.200_438, 0.924_033, 1.102_21), Rgb::new(3.912_95, 2.452_85, 2.142_19));

fn diffuse() -> Material {
    let description = BsdfDescription::Diffuse(DiffuseParameters { reflectance: WHITE });
    Material::new("diffuse", description, true).colored(Rgb::new(0.8, 0.5, 0.2), Rgb::ZERO)
}

fn transmitter() -> Material {
    let description =
        BsdfDescription::DiffuseTransmitter(DiffuseTransmitterParameters { reflectance: WHITE, transmittance: WHITE });
    Material::new("transmitter", description, false).colored(Rgb::new(0.5, 0.4, 0.1), Rgb::new(0.3, 0.1, 0.2))
}

fn conductor(eta_k: Option<(Rgb, Rgb)>, kind: MicrofacetDistribution, alpha: f32) -> Material {
    let description = BsdfDescription::Conductor(ConductorParameters {
        eta_k,
        specular_reflectance: WHITE,
        alpha,
        distribution: kind,
        energy_conserving: false,
    });
    Material::new(format!("conductor {kind:?} {alpha}"), description, true)
}

/// A metal that loses nothing between its facets.
fn conserving_metal(eta_k: Option<(Rgb, Rgb)>, kind: MicrofacetDistribution, alpha: f32) -> Material {
    let metal = ConductorParameters {
        eta_k,
        alpha,
        distribution: kind,
        energy_conserving: true,
        ..ConductorParameters::default()
    };
    Material::new(format!("conserving conductor {kind:?} {alpha}"), metal.into(), true)
}

fn dielectric(ior: f32, kind: MicrofacetDistribution, alpha: f32, thin: bool) -> Material {
    let description = BsdfDescription::Dielectric(DielectricParameters {
        int_ior: ior,
        ext_ior: 1.0,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
        alpha,
        distribution: kind,
        thin,
    });
    Material::new(format!("dielectric {ior} {kind:?} {alpha} {thin}"), description, false)
}

fn plastic(kind: MicrofacetDistribution, alpha: f32, nonlinear: bool, specular: Rgb) -> Material {
    let description = BsdfDescription::Plastic(PlasticParameters {
        reflectance: WHITE,
        specular_reflectance: specular,
        int_ior: 1.5,
        ext_ior: 1.0,
        alpha,
        distribution: kind,
        nonlinear,
        energy_conserving: false,
        additive: false,
    });
    Material::new(format!("plastic {kind:?} {alpha} {nonlinear}"), description, true)
        .colored(Rgb::new(0.8, 0.4, 0.1), Rgb::ZERO)
}

/// A coat that takes from its base only what it reflects.
fn conserving(kind: MicrofacetDistribution, alpha: f32) -> Material {
    let description =
        PlasticParameters { alpha, distribution: kind, energy_conserving: true, ..PlasticParameters::default() };
    Material::new(format!("conserving {kind:?} {alpha}"), description.into(), true)
        .colored(Rgb::new(0.8, 0.4, 0.1), Rgb::ZERO)
}

/// A highlight beside a base.
fn additive(kind: MicrofacetDistribution, alpha: f32) -> Material {
    let half = PlasticParameters { additive: true, specular_reflectance: Rgb::splat(0.5), ..Default::default() };
    let description = PlasticParameters { alpha, distribution: kind, ..half };
    Material::new(format!("additive {kind:?} {alpha}"), description.into(), true)
        .colored(Rgb::new(0.5, 0.4, 0.1), Rgb::ZERO)
}

fn principled(set: PrincipledParameters) -> Material {
    Material::new(format!("{set:?}"), set.into(), true).colored(Rgb::new(0.8, 0.4, 0.1), Rgb::ZERO)
}

/// The floor of the staircase scene.
const TILES: PrincipledParameters = PrincipledParameters {
    base_color: WHITE,
    metallic: 0.745_455,
    roughness: 0.5,
    specular: 0.5,
    spec_tint: 0.0,
    clearcoat: 0.0,
    clearcoat_gloss: 0.0,
    sheen: 0.0,
    sheen_tint: 0.0,
    energy_conserving: false,
    maps: PrincipledMaps::NONE,
};

/// Every lobe of the principled model at once.
const ALL_LOBES: PrincipledParameters = PrincipledParameters {
    base_color: WHITE,
    metallic: 0.2,
    roughness: 0.3,
    specular: 0.7,
    spec_tint: 0.4,
    clearcoat: 0.8,
    clearcoat_gloss: 0.3,
    sheen: 0.5,
    sheen_tint: 0.6,
    energy_conserving: false,
    maps: PrincipledMaps::NONE,
};

/// Every kind with smooth lobes.
fn smooth_materials() -> Vec<Material> {
    let mut all = vec![diffuse(), transmitter(), plastic(Ggx, 0.0, true, Rgb::ONE)];
    for kind in [Ggx, Beckmann] {
        for alpha in [0.05, 0.25, 0.8] {
            all.push(conductor(Some(COPPER), kind, alpha));
            all.push(dielectric(1.5, kind, alpha, false));
            all.push(plastic(kind, alpha, true, Rgb::ONE));
            all.push(conserving(kind, alpha));
        }
        all.push(dielectric(1.1, kind, 0.2, false));
        all.push(dielectric(0.7, kind, 0.2, false));
    }
    all.push(plastic(Ggx, 0.1, false, Rgb::new(1.0, 0.5, 0.2)));
    all.push(principled(TILES));
    all.push(principled(ALL_LOBES));
    all.push(textured_principled(Rgb::new(0.6, 0.45, 0.3)));
    all.extend([0.25, 0.8].map(|alpha| conserving_metal(Some(COPPER), Ggx, alpha)));
    all.push(conserving_metal(Some(COPPER), Beckmann, 0.8));
    let conserving = PrincipledParameters { energy_conserving: true, metallic: 0.7, roughness: 0.6, ..ALL_LOBES };
    all.push(principled(conserving.clone()));
    all.push(pictured(conserving).colored(Rgb::new(0.8, 0.4, 0.1), Rgb::new(0.6, 0.45, 0.3)));
    all.extend([(Ggx, 0.25), (Beckmann, 0.05), (Beckmann, 0.8)].map(|(kind, alpha)| additive(kind, alpha)));
    all
}

/// Numbers of every lobe from pictures, which say this of metallic, roughness and specular.
fn textured_principled(shares: Rgb) -> Material {
    pictured(ALL_LOBES).colored(Rgb::new(0.8, 0.4, 0.1), shares)
}

/// With pictures for metallic and roughness.
fn pictured(set: PrincipledParameters) -> Material {
    let picture = || Some(ScalarTexture::Luminance(ImageTexture::new("a.png".into())));
    let maps = PrincipledMaps { metallic: picture(), roughness: picture(), specular: None };
    Material::new("textured principled", PrincipledParameters { maps, ..set }.into(), true)
}

/// Every kind that is all delta.
fn delta_materials() -> Vec<Material> {
    vec![
        conductor(Some(COPPER), Ggx, 0.0),
        conductor(None, Ggx, 0.0),
        dielectric(1.5, Ggx, 0.0, false),
        dielectric(1.5, Ggx, 0.0, true),
        Material::new("null", BsdfDescription::Null(NullParameters), false),
    ]
}

/// From the normal to grazing, above and below.
fn views() -> [Vec3; 6] {
    [Vec3::Z, polar(0.6, 1.0), polar(1.2, 2.0), polar(1.5, 4.0), polar(2.4, 5.0), polar(1.67, 0.3)]
}
