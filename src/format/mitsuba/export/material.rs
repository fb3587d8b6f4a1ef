//! Materials as Mitsuba's plug-ins, where those are the same models.

use super::xml::Element;
use crate::bsdf::{BsdfDescription, MicrofacetDistribution};
use crate::math::Rgb;
use crate::scene::description::{BlendDescription, MaterialDescription};
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};

/// The BSDF with this id, or what of it Mitsuba does not have.
pub(crate) fn bsdf(material: &MaterialDescription, id: &str) -> Result<Element, String> {
    if material.emission_map.is_some() {
        return Err("emission from a picture".into());
    }
    if material.emission_two_sided && material.emission != Rgb::ZERO {
        return Err("emission on both sides".into());
    }
    Ok(scattering(material)?.attribute("id", id))
}

fn scattering(material: &MaterialDescription) -> Result<Element, String> {
    let opaque = matches!(&material.opacity, None | Some(ScalarTexture::Constant(1.0)));
    if !opaque {
        return Err("opacity: Mitsuba's `mask` counts as a bounce and stops shadow rays".into());
    }
    if material.relief.is_some() {
        return Err("normals from a picture".into());
    }
    match &material.blend {
        None => single(material),
        Some(blend) => self::blend(blend),
    }
}

fn single(material: &MaterialDescription) -> Result<Element, String> {
    if crate::bsdf::share_textures(&material.bsdf).is_some() {
        return Err("numbers from pictures".into());
    }
    let model = model(&material.bsdf)?;
    let turned = material.two_sided && material.bsdf.bsdf_type().is_opaque();
    Ok(if turned { Element::new("bsdf").kind("twosided").child(model) } else { model })
}

fn blend(blend: &BlendDescription) -> Result<Element, String> {
    let weight = match &blend.weight {
        ScalarTexture::Constant(weight) => Element::new("float").attribute("name", "weight").attribute("value", weight),
        ScalarTexture::Luminance(image) => bitmap("weight", image)?.value("boolean", "raw", true),
        _ => return Err("a weight of one channel of a picture".into()),
    };
    let mut mixed = plugin("blendbsdf").child(weight);
    for part in blend.parts.iter() {
        if matches!((&part.material.blend, &part.material.bsdf), (None, BsdfDescription::Null(_))) {
            return Err("opacity: Mitsuba's `null` counts as a bounce and stops shadow rays".into());
        }
        mixed = mixed.child(scattering(&part.material)?);
    }
    Ok(mixed)
}

/// Whether any of its colours is a picture.
pub(crate) fn textured(material: &MaterialDescription) -> bool {
    if let Some(blend) = &material.blend {
        return blend.weight.image().is_some() || blend.parts.iter().any(|part| textured(&part.material));
    }
    let textures = crate::bsdf::color_textures(&material.bsdf);
    textures.into_iter().flatten().any(|texture| matches!(texture, ColorTexture::Image(_)))
}

/// The plug-in with its parameters.
fn model(bsdf: &BsdfDescription) -> Result<Element, String> {
    use BsdfDescription as D;
    match bsdf {
        D::Diffuse(d) => Ok(plugin("diffuse").child(color("reflectance", &d.reflectance)?)),
        D::Mirror(m) => {
            let metal = conductor(None, plugin("conductor"));
            Ok(metal.child(color("specular_reflectance", &m.specular_reflectance)?))
        }
        D::Conductor(c) if c.energy_conserving && c.alpha > 0.0 => Err("a rough metal that conserves energy".into()),
        D::Conductor(c) => {
            let metal = conductor(c.eta_k, rough(["conductor", "roughconductor"], c.alpha, c.distribution));
            Ok(metal.child(color("specular_reflectance", &c.specular_reflectance)?))
        }
        D::Dielectric(d) => {
            // equal indices bend nothing, however rough the interface
            let alpha = if d.int_ior == d.ext_ior { 0.0 } else { d.alpha };
            let smooth = if d.thin { "thindielectric" } else { "dielectric" };
            let glass = indices(rough([smooth, "roughdielectric"], alpha, d.distribution), d.int_ior, d.ext_ior);
            let glass = glass.color("specular_reflectance", d.specular_reflectance);
            Ok(glass.color("specular_transmittance", d.specular_transmittance))
        }
        D::Plastic(p) if p.additive && p.alpha > 0.0 && !p.energy_conserving => Err("a coat beside its base".into()),
        D::Plastic(p) if p.energy_conserving && p.alpha > 0.0 => Err("a rough coat that conserves energy".into()),
        D::Plastic(p) => {
            let coat = indices(rough(["plastic", "roughplastic"], p.alpha, p.distribution), p.int_ior, p.ext_ior);
            let coat = coat.color("specular_reflectance", p.specular_reflectance);
            let coat = coat.value("boolean", "nonlinear", p.nonlinear);
            Ok(coat.child(color("diffuse_reflectance", &p.reflectance)?))
        }
        D::Principled(p) if p.energy_conserving && p.metallic > 0.0 => {
            Err("a rough metal that conserves energy".into())
        }
        D::Principled(p) => {
            let model = plugin("principled").float("metallic", p.metallic).float("roughness", p.roughness);
            let model = model.float("specular", p.specular).float("spec_tint", p.spec_tint);
            let model = model.float("clearcoat", p.clearcoat).float("clearcoat_gloss", p.clearcoat_gloss);
            let model = model.float("sheen", p.sheen).float("sheen_tint", p.sheen_tint);
            Ok(model.child(color("base_color", &p.base_color)?))
        }
        D::Null(_) => Ok(plugin("null")),
        other => Err(format!("the type `{}`", other.bsdf_type().name())),
    }
}

fn plugin(kind: &str) -> Element {
    Element::new("bsdf").kind(kind)
}

fn conductor(eta_k: Option<(Rgb, Rgb)>, metal: Element) -> Element {
    match eta_k {
        None => metal.string("material", "none"),
        Some((eta, k)) => metal.color("eta", eta).color("k", k),
    }
}

fn indices(plugin: Element, int_ior: f32, ext_ior: f32) -> Element {
    plugin.float("int_ior", int_ior).float("ext_ior", ext_ior)
}

/// The plug-in for smooth surfaces, or that for rough ones with its microfacets.
fn rough([smooth, rough]: [&str; 2], alpha: f32, distribution: MicrofacetDistribution) -> Element {
    if alpha == 0.0 {
        return plugin(smooth);
    }
    let name = match distribution {
        MicrofacetDistribution::Ggx => "ggx",
        MicrofacetDistribution::Beckmann => "beckmann",
    };
    plugin(rough).string("distribution", name).float("alpha", alpha)
}

fn color(name: &str, texture: &ColorTexture) -> Result<Element, String> {
    match texture {
        ColorTexture::Constant(color) => Ok(Element::rgb(name, *color)),
        ColorTexture::Image(image) => bitmap(name, image),
        // its meshes are written without them
        ColorTexture::Vertex(_) => Err("colours of vertices".into()),
    }
}

/// Mitsuba's v points down in the picture and, by its reader of OBJ files, on surfaces too: v′ = 1 − v.
fn bitmap(name: &str, image: &ImageTexture) -> Result<Element, String> {
    if image.tint != Rgb::ONE {
        return Err(format!("a tinted texture ({})", image.path.display()));
    }
    let path = std::path::absolute(&image.path).unwrap_or_else(|_| image.path.clone());
    let ([su, sv], [ou, ov]) = (image.scale, image.offset);
    let step = |kind: &str, x: f32, y: f32| Element::new(kind).attribute("x", x).attribute("y", y);
    let to_uv = Element::new("transform").attribute("name", "to_uv");
    Ok(Element::new("texture")
        .kind("bitmap")
        .attribute("name", name)
        .string("filename", &path.to_string_lossy())
        .string("filter_type", if image.nearest { "nearest" } else { "bilinear" })
        .string("wrap_mode", "repeat")
        .child(to_uv.child(step("scale", su, sv)).child(step("translate", ou, 1.0 - sv - ov))))
}
