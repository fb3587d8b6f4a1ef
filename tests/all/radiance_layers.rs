//! Layers of light add up to the picture, and hold what they say.

use crate::common::{Loaded, describe, load, own, written};
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

/// A floor under two lamps and a sky, each in a group of its own but the second lamp, which is in none.
fn grouped(key: &str, fill: &str, sky: &str, more: &[&str]) -> Rendering {
    let scene = format!(
        "[camera]\norigin = [0, 3, 6]\ntarget = [0, 0, 0]\n[film]\nwidth = 24\nheight = 16\n[[mesh]]\npath = 'm.obj'\n\
         [material.key]\ntype = 'diffuse'\nlight_group = 'key'\nemission = {key}\n\
         [[light]]\ntype = 'point'\nposition = [1, 2, 1]\nintensity = {fill}\n\
         [[light]]\ntype = 'constant'\nlight_group = 'sky'\nradiance = {sky}\n"
    );
    let obj = "v -3 0 -3\nv -3 0 3\nv 3 0 3\nv 3 0 -3\nv -1 2 0\nv -1 2 1\nv -2 2 1\nv -2 2 0\nf 1 2 3 4\nusemtl key\nf 8 7 6 5\n";
    let folder = written(&[("scene.toml", &scene), ("m.obj", obj)]);
    let Loaded { scene, settings } = load(&folder.path().join("scene.toml"), &[&["render.spp=64"][..], more].concat());
    render(&scene, &settings, &mut |_| true)
}

/// Groups are numbered by their names, after the lights that are in none.
#[test]
fn light_groups_are_what_their_lights_alone_would_give() {
    for method in ["guiding.method=none", "guiding.method=adaptive"] {
        let all = grouped("9", "5", "[0, 0.2, 0.5]", &[method, "render.layers=['light_groups']"]);
        assert_eq!(all.estimate.mean, grouped("9", "5", "[0, 0.2, 0.5]", &[method]).estimate.mean);
        let groups: Vec<&[Rgb]> = (0..3).map(|k| layer(&all, RadianceLayer::Group(k))).collect();
        let sum = (0..groups[0].len()).map(|i| groups.iter().map(|group| group[i]).sum::<Rgb>());
        assert!(difference(sum, &all.estimate.mean) < 1e-5, "{method}");
        let alone = [grouped("0", "5", "0", &[]), grouped("9", "0", "0", &[]), grouped("0", "0", "[0, 0.2, 0.5]", &[])];
        let mean = |picture: &[Rgb]| picture.iter().sum::<Rgb>() / picture.len() as f32;
        for (k, alone) in alone.iter().enumerate() {
            let (found, wanted) = (mean(groups[k]), mean(&alone.estimate.mean));
            let off = (found - wanted).abs().max_element() / wanted.max_element();
            // 25 000 paths, whose light varies by three times its mean at most: 0.02 is a standard error
            assert!(off < 0.1, "{method}, group {k}: {found} is not {wanted}");
        }
        assert!((mean(groups[1]) - mean(groups[0])).abs().max_element() > 0.3 * mean(groups[0]).max_element());
    }
}

#[test]
fn surroundings_are_in_one_group() {
    let scene = "[camera]\norigin = [0, 0, 3]\n[[mesh]]\npath = 'm.obj'\n\
        [[light]]\ntype = 'constant'\nradiance = 1\nlight_group = 'a'\n[[light]]\ntype = 'sun'\ndirection = [0, -1, 0]\nirradiance = 1\n";
    let folder = written(&[("scene.toml", scene), ("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    let error = describe(&folder.path().join("scene.toml"), &[]).load_scene(1).map(drop).unwrap_err().to_string();
    assert!(error.contains("must be in one group, not in `default` and `a`"), "{error}");
}
