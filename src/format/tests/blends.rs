//! `type = "blend"` in scene files.

use super::parsed;
use crate::bsdf::BsdfDescription;
use crate::scene::description::{BlendDescription, MaterialDescription};
use crate::texture::ScalarTexture;

const PARTS: &str = "[material.B]\ntype = 'mirror'\n[material.C]\ntype = 'conductor'\nalpha = 0.2\n";

fn blend(material: &MaterialDescription) -> &BlendDescription {
    material.blend.as_ref().unwrap()
}

fn alpha(material: &MaterialDescription) -> f32 {
    let BsdfDescription::Conductor(conductor) = &material.bsdf else { panic!("{material:?}") };
    conductor.alpha
}

#[test]
fn parts_are_found_wherever_they_stand_in_the_file() {
    let text = format!(
        "[material.A]\ntype = 'blend'\nmaterials = ['D', 'C']\nemission = 2\nopacity = 0.5\n{PARTS}[material.D]\ntype = 'blend'\n\
         materials = ['C', 'B']\nweight = {{ texture = 'w.png' }}\n"
    );
    let materials = parsed(&text, &[]).unwrap().scene.materials;
    let (a, d) = (&materials["A"], blend(&materials["D"]));
    assert_eq!((a.emission.x, &a.opacity), (2.0, &Some(ScalarTexture::Constant(0.5))));
    assert_eq!(blend(a).weight, ScalarTexture::Constant(0.5));
    assert!(matches!(&d.weight, ScalarTexture::Luminance(image) if image.path.ends_with("w.png")), "{d:?}");
    assert_eq!((&blend(a).parts[0].material, &blend(a).parts[1].material), (&materials["D"], &materials["C"]));
    assert_eq!((alpha(&d.parts[0].material), &d.parts[1].material), (0.2, &materials["B"]));
}

#[test]
fn overrides_reach_blends_and_what_they_are_mixed_of() {
    let text = format!("{PARTS}[material.A]\ntype = 'blend'\nmaterials = ['B', 'C']\nopacity = 0.5\n");
    let a = |set: &[&str]| parsed(&text, set).map(|file| file.scene.materials["A"].clone());
    let before = a(&[]).unwrap();
    assert_eq!(alpha(&blend(&before).parts[1].material), 0.2);
    let changed = a(&["material.C.alpha=0.4", "material.A.weight=0.9"]).unwrap();
    assert_eq!(
        (alpha(&blend(&changed).parts[1].material), &blend(&changed).weight),
        (0.4, &ScalarTexture::Constant(0.9))
    );
    assert_eq!(changed.opacity, Some(ScalarTexture::Constant(0.5)));
    let other = a(&["material.A.materials=['C', 'C']"]).unwrap();
    assert_eq!(blend(&other).parts[0], blend(&other).parts[1]);
    let single = a(&["material.A.type=mirror"]).unwrap();
    assert_eq!((&single.blend, &single.bsdf), (&None, &BsdfDescription::Mirror(Default::default())));
    for (set, wanted) in [
        ("material.C.emission=1", "--set 'material.C.emission=1': `C` is mixed with another material and emits"),
        ("material.B={ type = 'blend', materials = ['A', 'C'] }", "is a blend within itself"),
    ] {
        let message = a(&[set]).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn what_is_wrong_with_a_blend_is_said_where_it_stands() {
    let blend = |keys: &str| format!("{PARTS}[material.A]\ntype = 'blend'\n{keys}\n");
    for (text, wanted) in [
        (blend(""), "[material.A] needs `materials`"),
        (blend("materials = ['B']"), "8:13: `materials` must be the names of two materials"),
        (blend("materials = 'B'"), "8:13: `materials` must be the names of two materials"),
        (blend("materials = ['B', 3]"), "8:19: `materials` must be a string"),
        (blend("materials = ['B', 'Z']"), "8:19: there is no material `Z` with a `type` in this file"),
        (blend("materials = ['B', 'A']"), "8:19: `A` is a blend within itself"),
        (blend("materials = ['B', 'C']\nweight = 2"), "9:10: `weight` must be between 0 and 1"),
        (
            blend("materials = ['B', 'C']\nwieght = 1"),
            "9:1: unknown key `wieght` in [material.A]: did you mean `weight`",
        ),
        (blend("materials = ['B', 'C']\ntwo_sided = true"), "9:1: `two_sided` is not a key of type `blend`, but of"),
        (blend("materials = ['B', 'C']\nalpha = 1"), "9:1: `alpha` is not a key of type `blend`, but of"),
        (format!("{PARTS}weight = 0.5\n"), "6:1: `weight` is not a key of type `conductor`, but of `blend`"),
        (
            format!("{PARTS}emission = 1\n[material.A]\ntype = 'blend'\nmaterials = ['B', 'C']\n"),
            "9:19: `C` is mixed with another material and emits: `emission` is a key of the blend",
        ),
        ("[material.A]\ntype = 'blent'".into(), "2:8: unknown type `blent` in [material.A]: did you mean `blend`"),
    ] {
        let message = parsed(&text, &[]).unwrap_err().to_string();
        assert!(message.starts_with("dir/s.toml:") && message.contains(wanted), "{message}\nis not\n{wanted}");
    }
}
