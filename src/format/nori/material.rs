//! Materials.

use crate::Result;
use crate::bsdf::{
    BsdfDescription, DielectricParameters, DiffuseParameters, MicrofacetDistribution, MirrorParameters,
    PlasticParameters, PrincipledMaps, PrincipledParameters,
};
use crate::format::mitsuba::bsdf::{Materials, one_sided};
use crate::format::xml::object::Object;
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::ColorTexture;
use std::rc::Rc;

/// Indices of refraction of what nothing is said of.
const GLASS: f64 = 1.5046;
const AIR: f64 = 1.000_277;

pub(super) fn material(materials: &Materials, bsdf: &Rc<Object>) -> Result<MaterialDescription> {
    let objects = materials.objects;
    let described: BsdfDescription = match bsdf.kind.as_str() {
        "diffuse" => DiffuseParameters { reflectance: materials.textures.color(bsdf, "albedo", 0.5)? }.into(),
        "mirror" => {
            // a share of courses' own
            let specular_reflectance = materials.textures.color(bsdf, "albedo", 1.0)?;
            MirrorParameters { specular_reflectance }.into()
        }
        "dielectric" => {
            let [int_ior, ext_ior] = indices(bsdf)?;
            DielectricParameters { int_ior, ext_ior, ..Default::default() }.into()
        }
        "microfacet" => microfacet(materials, bsdf)?.into(),
        "phong" => phong(materials, bsdf)?.into(),
        "disney" => disney(materials, bsdf)?.into(),
        // names that courses have of Mitsuba
        _ => return materials.material(bsdf),
    };
    objects.finish(bsdf);
    Ok(one_sided(described))
}

fn indices(bsdf: &Object) -> Result<[f32; 2]> {
    let index = |name: &str, default: f64| -> Result<f32> {
        let index = bsdf.number(name, default)?;
        (index > 0.0).then_some(index as f32).ok_or_else(|| bsdf.error(format!("`{name}` must be greater than 0")))
    };
    Ok([index("int_ior", GLASS)?, index("ext_ior", AIR)?])
}

/// kd/π + (1 − max kd)·F·D·G/(4 cos cos), with Beckmann's facets.
fn microfacet(materials: &Materials, bsdf: &Object) -> Result<PlasticParameters> {
    let [int_ior, ext_ior] = indices(bsdf)?;
    let reflectance = materials.textures.color(bsdf, "kd", 0.5)?;
    let largest = match &reflectance {
        ColorTexture::Constant(color) => color.max_element(),
        _ => {
            materials.objects.warn(&bsdf.at, "the share of the highlight beside a picture is that beside grey of 0.5");
            0.5
        }
    };
    let alpha = bsdf.number("alpha", 0.1)? as f32;
    Ok(PlasticParameters {
        reflectance,
        specular_reflectance: Rgb::splat(1.0 - largest),
        int_ior,
        ext_ior,
        alpha: alpha.clamp(1e-4, 1.0),
        distribution: MicrofacetDistribution::Beckmann,
        additive: true,
        ..Default::default()
    })
}

/// kd/π + ks·(n + 2)/2π·cosⁿ, which reflects ks at right angles: so do facets of α = √(2/(n + 2)) (Walter et al. 2007, §5.2) of the index
/// (1 + √ks)/(1 − √ks).
fn phong(materials: &Materials, bsdf: &Object) -> Result<PlasticParameters> {
    let what = "facets with a highlight of about its width and strength are taken";
    materials.objects.warn(&bsdf.at, format!("the bsdf `phong` has no counterpart: {what}"));
    let spelt =
        |names: &[&'static str]| names.iter().copied().find(|name| bsdf.find(name).is_some()).unwrap_or(names[0]);
    let exponent = bsdf.number(spelt(&["exponent", "n", "shininess"]), 30.0)?.max(0.0);
    let specular = bsdf.color(spelt(&["ks", "specular", "specular_reflectance"]), Rgb::splat(0.2))?;
    let names = ["kd", "diffuse", "diffuse_reflectance", "albedo"];
    let reflectance = materials.textures.color(bsdf, spelt(&names), 0.5)?;
    let level = specular.max_element().clamp(1e-4, 0.9);
    let root = level.sqrt();
    Ok(PlasticParameters {
        reflectance,
        specular_reflectance: (specular / level).min(Rgb::ONE),
        int_ior: (1.0 + root) / (1.0 - root),
        alpha: ((2.0 / (exponent + 2.0)).sqrt() as f32).clamp(1e-4, 1.0),
        distribution: MicrofacetDistribution::Beckmann,
        additive: true,
        ..Default::default()
    })
}

/// Burley's model under the names of his paper.
fn disney(materials: &Materials, bsdf: &Object) -> Result<PrincipledParameters> {
    for name in ["anisotropic", "subsurface", "flatness", "spec_trans"] {
        if bsdf.number(name, 0.0)? != 0.0 {
            materials.objects.warn(&bsdf.at, format!("`{name}` of `disney` has no counterpart: 0 is taken"));
        }
    }
    let share = |name: &str, default: f64| bsdf.number(name, default).map(|x| x.clamp(0.0, 1.0) as f32);
    let tint = if bsdf.find("spec_tint").is_some() { "spec_tint" } else { "specular_tint" };
    Ok(PrincipledParameters {
        base_color: materials.textures.color(bsdf, "base_color", 0.5)?,
        metallic: share("metallic", 0.0)?,
        roughness: share("roughness", 0.5)?,
        specular: share("specular", 0.5)?,
        spec_tint: share(tint, 0.0)?,
        clearcoat: share("clearcoat", 0.0)?,
        clearcoat_gloss: share("clearcoat_gloss", 0.0)?,
        sheen: share("sheen", 0.0)?,
        sheen_tint: share("sheen_tint", 0.0)?,
        energy_conserving: false,
        maps: PrincipledMaps::NONE,
    })
}
