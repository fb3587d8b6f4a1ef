//! Materials as Mitsuba's plug-ins, where those are the same models.

use super::xml::Element;
use crate::bsdf::{BsdfDescription, MicrofacetDistribution};
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ImageTexture, ScalarTexture};

/// The BSDF with this id, or what of it Mitsuba does not have.
pub fn bsdf(material: &MaterialDescription, id: &str) -> Result<Element, String> {
    let opaque = matches!(&material.opacity, None | Some(ScalarTexture::Constant(1.0)));
    if !opaque {
        return Err("opacity: Mitsuba's `mask` counts as a bounce and stops shadow rays".into());
    }
    if material.emission_two_sided && material.emission != Rgb::ZERO {
        return Err("emission on both sides".into());
    }
    let model = model(&material.bsdf)?;
    let transmits = matches!(material.bsdf, BsdfDescription::Dielectric { .. } | BsdfDescription::Null);
    let turned = material.two_sided && !transmits;
    let whole = if turned { Element::new("bsdf").kind("twosided").child(model) } else { model };
    Ok(whole.attribute("id", id))
}

/// Whether any of its colours is a picture.
pub fn textured(material: &MaterialDescription) -> bool {
    let textures = crate::bsdf::color_textures(&material.bsdf);
    textures.into_iter().flatten().any(|texture| matches!(texture, ColorTexture::Image(_)))
}

fn model(bsdf: &BsdfDescription) -> Result<Element, String> {
    use BsdfDescription as D;
    match *bsdf {
        D::Diffuse { ref reflectance } => Ok(plugin("diffuse").child(color("reflectance", reflectance)?)),
        D::DiffuseTransmitter { .. } => Err("a diffuse transmitter".into()),
        D::Conductor { eta_k, ref specular_reflectance, alpha, distribution } => {
            let metal = conductor(eta_k, rough(["conductor", "roughconductor"], alpha, distribution));
            Ok(metal.child(color("specular_reflectance", specular_reflectance)?))
        }
        D::Dielectric { int_ior, ext_ior, specular_reflectance, specular_transmittance, alpha, distribution, thin } => {
            // equal indices bend nothing, however rough the interface
            let alpha = if int_ior == ext_ior { 0.0 } else { alpha };
            let smooth = if thin { "thindielectric" } else { "dielectric" };
            let glass = indices(rough([smooth, "roughdielectric"], alpha, distribution), int_ior, ext_ior);
            let glass = glass.color("specular_reflectance", specular_reflectance);
            Ok(glass.color("specular_transmittance", specular_transmittance))
        }
        D::Plastic { ref reflectance, specular_reflectance, int_ior, ext_ior, alpha, distribution, nonlinear } => {
            let coat = indices(rough(["plastic", "roughplastic"], alpha, distribution), int_ior, ext_ior);
            let coat =
                coat.color("specular_reflectance", specular_reflectance).value("boolean", "nonlinear", nonlinear);
            Ok(coat.child(color("diffuse_reflectance", reflectance)?))
        }
        D::Principled {
            ref base_color,
            metallic,
            roughness,
            specular,
            spec_tint,
            clearcoat,
            clearcoat_gloss,
            sheen,
            sheen_tint,
        } => Ok(plugin("principled")
            .float("metallic", metallic)
            .float("roughness", roughness)
            .float("specular", specular)
            .float("spec_tint", spec_tint)
            .float("clearcoat", clearcoat)
            .float("clearcoat_gloss", clearcoat_gloss)
            .float("sheen", sheen)
            .float("sheen_tint", sheen_tint)
            .child(color("base_color", base_color)?)),
        D::Null => Ok(plugin("null")),
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
