//! The layers of a render's EXR.

use super::report::Context;
use crate::film::accumulate::Estimate;
use crate::film::ids::{IdCounts, KINDS, RANKS};
use crate::film::tile::Aovs;
use crate::film::{ExtraLayer, RadianceLayer};
use crate::image::Layer;
use crate::image::cryptomatte::Matte;
use crate::image::exr::DENOISED;
use crate::inspect::Layers;
use crate::math::Rgb;
use crate::render::Rendering;
use crate::scene::SceneNames;
use glam::Vec3;

/// All that is known of a render, pixel by pixel, with what was asked for beside: extra layers, what is denoised, what the
/// guide knows.
pub(super) fn layers(rendering: &Rendering, context: &Context) -> Vec<Layer> {
    let e = &rendering.estimate;
    let mut layers = always(e, context.scene.lights().has_surroundings());
    let origin = context.scene.origin().as_vec3();
    layers.extend(context.extra_layers.iter().filter_map(|&layer| extra(e, layer, origin)));
    layers.extend(e.layers.iter().filter_map(|(layer, mean)| light_group(context, *layer, mean)));
    layers.extend(mattes(context).iter().enumerate().flat_map(|(kind, matte)| matte.layers(RANKS, &coverage(e, kind))));
    layers.extend(context.denoised.iter().map(|denoised| Layer::color(DENOISED, &denoised.image.data)));
    layers.extend(context.guide_layers.iter().flat_map(Layers::channels));
    layers
}

/// What every EXR has. Alpha is 1 where something is seen, be it a background.
fn always(e: &Estimate, has_background: bool) -> Vec<Layer> {
    let alpha = |f: &Aovs| if has_background { 1.0 } else { f.met };
    vec![
        Layer::color("", &e.mean),
        Layer::scalar("", "A", e.features.iter().map(alpha).collect()),
        Layer::color("variance", &e.variance),
        Layer::color("albedo", &vectors(e, |f| f.albedo)),
        Layer::vector("Ns", &vectors(e, |f| f.normal)),
        Layer::scalar("", "Z", e.features.iter().map(Aovs::mean_depth).collect()),
        Layer::scalar("samples", "Y", (0..e.mean.len()).map(|i| e.count(i) as f32).collect()),
    ]
}

/// `origin` is where the scene's coordinates are counted from. `None` for light that was not kept apart, and for what is more than a layer.
fn extra(e: &Estimate, layer: ExtraLayer, origin: Vec3) -> Option<Layer> {
    let name = layer.name();
    match layer {
        ExtraLayer::Light(light) => {
            let (_, mean) = e.layers.iter().find(|(own, _)| *own == light)?;
            Some(Layer::color(name, mean))
        }
        ExtraLayer::Position => Some(Layer::vector(name, &vectors(e, |f| origin + f.mean_position()))),
        ExtraLayer::Cryptomatte | ExtraLayer::LightGroups => None,
        ExtraLayer::GeometricNormal => Some(Layer::vector(name, &vectors(e, |f| f.geometric_normal))),
    }
}

/// The light of a group.
fn light_group(context: &Context, layer: RadianceLayer, mean: &[Rgb]) -> Option<Layer> {
    let RadianceLayer::Group(number) = layer else { return None };
    let name = &context.scene.light_groups().names()[number as usize];
    Some(Layer::color(&format!("light_group_{name}"), mean))
}

/// Cryptomatte of objects and of materials, where it is asked for.
pub(super) fn mattes<'a>(context: &'a Context) -> Vec<Matte<'a>> {
    let SceneNames { materials, objects, .. } = context.scene.names();
    match context.extra_layers.contains(&ExtraLayer::Cryptomatte) {
        true => {
            vec![Matte { name: "CryptoObject", names: objects }, Matte { name: "CryptoMaterial", names: materials }]
        }
        false => Vec::new(),
    }
}

/// By pixel, numbers of one kind with the share of samples that met them.
fn coverage(e: &Estimate, kind: usize) -> Vec<Vec<(u32, f32)>> {
    let pixel = |(counts, samples): (&[IdCounts; KINDS], &u32)| {
        counts[kind].iter().map(|(id, count)| (id, f32::from(count) / *samples as f32)).collect()
    };
    e.ids.counts.iter().zip(&e.ids.samples).map(pixel).collect()
}

fn vectors(e: &Estimate, of: impl Fn(&Aovs) -> Vec3) -> Vec<Vec3> {
    e.features.iter().map(of).collect()
}
