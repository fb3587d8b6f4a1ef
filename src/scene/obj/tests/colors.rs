//! Colours behind the coordinates of vertices.

use super::load_text;
use crate::image::srgb::decode;
use crate::math::Rgb;
use crate::scene::description::MaterialDescription;
use crate::texture::ColorTexture;

fn colors(text: &str) -> Option<Vec<[f32; 3]>> {
    let [whole, blocks] = [1 << 20, 10].map(|block| load_text(text, block).unwrap().mesh.colors);
    assert_eq!(whole, blocks, "the blocks decide nothing");
    whole.map(|colors| colors.values().to_vec())
}

const FACE: &str = "f 1 2 3\n";

fn assert_colors(vertices: &str, expected: [[f32; 3]; 3]) {
    let found = colors(&format!("{vertices}{FACE}")).unwrap_or_else(|| panic!("no colours in {vertices}"));
    assert_eq!(found, expected.map(|stored| stored.map(decode)), "{vertices}");
}

#[test]
fn numbers_are_shares_or_from_0_to_255_in_srgb() {
    let expected = [[0.8, 0.2, 0.0], [1.0, 0.6, 0.4], [0.2, 0.2, 1.0]];
    assert_colors("v 0 0 0 .8 .2 0\nv 1 0 0 1 .6 .4\nv 0 1 0 .2 .2 1 # note\n", expected);
    assert_colors("v 0 0 0 204 51 0\nv 1 0 0 255 153 102\nv 0 1 0 51 51 255\n", expected);
    assert_colors("v 0 0 0 0 0 1\nv 1 0 0 1 0 0\nv 0 1 0 1 1 1\n", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0; 3]]);
    // shares beyond the range are brought into it
    assert_colors("v 0 0 0 1.5 -2 .5\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\n", [[1.0, 0.0, 0.5], [1.0; 3], [0.0; 3]]);
}

#[test]
fn a_fourth_number_is_alpha_or_a_weight_before() {
    let expected = [[0.8, 0.2, 0.0], [1.0, 0.6, 0.4], [0.2, 0.2, 0.5]];
    assert_colors("v 0 0 0 .8 .2 0 1\nv 1 0 0 1 .6 .4 1\nv 0 1 0 .2 .2 .5 .7\n", expected);
    assert_colors("v 0 0 0 1 .8 .2 0\nv 1 0 0 1 1 .6 .4\nv 0 1 0 1 .2 .2 .5\n", expected);
    // red throughout, opaque
    assert_colors(
        "v 0 0 0 1 0 0 1\nv 1 0 0 1 0 .2 1\nv 0 1 0 1 0 0 1\n",
        [[1.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 0.0, 0.0]],
    );
}

#[test]
fn weights_and_white_throughout_say_nothing() {
    for numbers in ["", " 1", " 0.5", " 1 1", " 1 1 1", " 255 255 255", " 1 1 1 1", " nan 0 0"] {
        assert_eq!(colors(&format!("v 0 0 0{numbers}\nv 1 0 0{numbers}\nv 0 1 0{numbers}\n{FACE}")), None, "{numbers}");
    }
}

#[test]
fn vertices_without_a_colour_are_white() {
    assert_colors("v 0 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0\n", [[1.0; 3], [0.0, 0.5, 0.0], [1.0; 3]]);
}

#[test]
fn colours_multiply_what_a_library_says_but_for_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let library = "newmtl plain\nKd .5 1 .25\nnewmtl black\nKd 0 0 0\nnewmtl picture\nKd 1 1 1\nmap_Kd a.png\n\
                   newmtl shiny\nKd .5 .5 .5\nKs .5 .5 .5\nNs 100\nnewmtl metal\nKd .9 .8 .7\nPm 1\n";
    std::fs::write(folder.path().join("m.mtl"), library).unwrap();
    let path = folder.path().join("m.obj");
    let text = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nusemtl plain\nf 1 2 3\n";
    let textures = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let materials = crate::scene::obj::load(&path).unwrap().materials;
        ["plain", "black", "picture", "shiny", "metal"].map(|name| {
            let [first, second] = crate::bsdf::color_textures(&materials[name].bsdf);
            assert!(!matches!(second, Some(ColorTexture::Vertex(_))), "{name}: highlights have no part in it");
            first.unwrap()
        })
    };
    let [plain, black, picture, shiny, metal] = textures(text);
    assert_eq!(plain, ColorTexture::Vertex(Rgb::new(0.5, 1.0, 0.25)));
    assert_eq!(black, ColorTexture::Vertex(Rgb::ONE));
    assert!(matches!(picture, ColorTexture::Image(_)));
    assert_eq!(shiny, ColorTexture::Vertex(Rgb::splat(0.5)));
    assert_eq!(metal, ColorTexture::Vertex(Rgb::new(0.9, 0.8, 0.7)));
    let without = textures(&text.replace(" 1 0 0\n", "\n").replace(" 0 1 0\n", "\n").replace(" 0 0 1\n", "\n"));
    assert!(!without.iter().any(|texture| matches!(texture, ColorTexture::Vertex(_))));
    assert_eq!(MaterialDescription::unknown(false), MaterialDescription::default());
}
