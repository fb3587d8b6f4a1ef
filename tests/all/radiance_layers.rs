//! Layers of light add up to the picture, and hold what they say.

use crate::common::{Loaded, own};
use phototaxis::film::RadianceLayer;
use phototaxis::math::Rgb;
use phototaxis::render::{Rendering, render};

const SIZE: [&str; 3] = ["film.width=48", "film.height=32", "render.spp=24"];
const ALL: &str = "render.layers=['emission', 'direct', 'indirect']";

fn rendered(more: &[&str]) -> Rendering {
    let Loaded { scene, settings } = own("cornell", &[&SIZE[..], more].concat());
    render(&scene, &settings, &mut |_| true)
}

fn layer(rendering: &Rendering, layer: RadianceLayer) -> &[Rgb] {
    let found = rendering.estimate.layers.iter().find(|(own, _)| *own == layer);
    found.map(|(_, mean)| &mean[..]).unwrap()
}

/// The largest difference, relative to the brighter of the two and to the mean of the picture.
fn difference(a: impl Iterator<Item = Rgb>, b: &[Rgb]) -> f32 {
    let floor = b.iter().map(|c| c.max_element()).sum::<f32>() / b.len() as f32;
    a.zip(b).map(|(a, b)| (a - *b).abs().max_element() / (b.max_element() + floor)).fold(0.0, f32::max)
}

#[test]
fn layers_add_up_to_the_picture_and_leave_it_as_it_is() {
    for method in ["none", "grid", "adaptive", "sdtree", "auto"] {
        for combine in ["all", "inverse-variance", "last"] {
            let (method, combine) = (format!("guiding.method={method}"), format!("render.combine={combine}"));
            let with = rendered(&[&method, &combine, ALL]);
            let without = rendered(&[&method, &combine]);
            assert_eq!(with.estimate.mean, without.estimate.mean, "{method}, {combine}");
            let sum = |i: usize| with.estimate.layers.iter().map(|(_, mean)| mean[i]).sum::<Rgb>();
            let apart = difference((0..with.estimate.mean.len()).map(sum), &with.estimate.mean);
            assert!(apart < 1e-5, "{method}, {combine}: {apart}");
            let missing = difference(layer(&with, RadianceLayer::Direct).iter().copied(), &with.estimate.mean);
            assert!(missing > 0.1, "a sum with a layer missing would be seen: {missing}");
        }
    }
}

#[test]
fn shorter_paths_alone_give_the_layers_of_shorter_paths() {
    for next_event in ["integrator.next_event=true", "integrator.next_event=false"] {
        let all = rendered(&["guiding.method=none", next_event, ALL]);
        let (emission, direct) = (layer(&all, RadianceLayer::Emission), layer(&all, RadianceLayer::Direct));
        let one = rendered(&["guiding.method=none", next_event, "integrator.max_depth=1"]);
        assert!(difference(emission.iter().copied(), &one.estimate.mean) < 1e-5);
        assert!(emission.iter().any(|c| *c != Rgb::ZERO), "the lamp is in the picture");
        let two = rendered(&["guiding.method=none", next_event, "integrator.max_depth=2"]);
        let both = emission.iter().zip(direct).map(|(a, b)| *a + *b);
        assert!(difference(both, &two.estimate.mean) < 1e-5, "{next_event}");
    }
}
