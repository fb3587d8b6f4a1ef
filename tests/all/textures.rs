//! Pictures of all kinds on surfaces and in the sky. The scene is a square that fills the picture under a white sky of radiance 1,
//! so that a Lambertian surface of albedo a is seen as a.

use crate::common::{Loaded, describe, load, mean_color, written};
use std::path::Path;
use tempfile::TempDir;

const SCENE: &str = "[camera]\norigin = [0, 0, 2]\ntarget = [0, 0, 0]\nvfov = 40\n[film]\nwidth = 8\nheight = 8\n\
    [integrator]\nmax_depth = 3\nnext_event = false\n[guiding]\nmethod = 'none'\n[render]\nspp = 64\n[[mesh]]\npath = 'model.obj'\n";
const SKY: &str = "[[light]]\ntype = 'constant'\nradiance = 1\n";
const SQUARE: &str = "mtllib model.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3 4/4\n";

fn square(scene: &str, library: &str) -> TempDir {
    let scene = format!("{SCENE}{scene}");
    written(&[("scene.toml", &scene), ("model.obj", SQUARE), ("model.mtl", &format!("newmtl a\n{library}"))])
}

fn loaded(folder: &TempDir) -> Loaded {
    load(&folder.path().join("scene.toml"), &[])
}

/// Mean colours of the upper and of the lower half of the picture.
fn halves(loaded: &Loaded) -> [[f64; 3]; 2] {
    let picture = loaded.estimate(&loaded.settings);
    let (upper, lower) = picture.mean.split_at(picture.mean.len() / 2);
    [mean_color(upper), mean_color(lower)]
}

/// The sky is the same everywhere, so that each path that reaches it brings the albedo, and nothing is left to chance but rounding.
fn assert_near(found: [f64; 3], wanted: [f64; 3]) {
    let near = found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.003);
    assert!(near, "{found:?} is not {wanted:?}");
}

fn warnings(folder: &TempDir) -> Vec<String> {
    describe(&folder.path().join("scene.toml"), &[]).load_scene(1).unwrap().1
}

#[test]
fn a_targa_named_by_a_library_is_on_the_surface() {
    let folder = square(SKY, "Kd 1 1 1\nmap_Kd picture.png\n");
    let picture =
        image::RgbImage::from_fn(16, 16, |_, y| image::Rgb(if y < 8 { [200, 30, 30] } else { [30, 30, 200] }));
    picture.save_with_format(folder.path().join("picture.png"), image::ImageFormat::Tga).unwrap();
    let [upper, lower] = halves(&loaded(&folder));
    // the outer rows of texels blend into those of the repeated picture; the camera does not see them
    assert!((upper[0] - 0.578).abs() < 0.02 && (lower[2] - 0.578).abs() < 0.02, "{upper:?} {lower:?}");
    assert!((upper[2] - 0.013).abs() < 0.02 && (lower[0] - 0.013).abs() < 0.02, "{upper:?} {lower:?}");
}

#[test]
fn a_picture_that_cannot_be_read_is_a_warning_or_an_error_as_asked() {
    let folder = square(SKY, "Kd 0.8 0.6 0.4\nmap_Kd picture.jp2\nmap_d nothing.png\n");
    std::fs::write(
        folder.path().join("picture.jp2"),
        b"\0\0\0\x0cjP  \r\n\x87\nand so on, for more bytes than a header",
    )
    .unwrap();
    assert_near(halves(&loaded(&folder))[0], [0.4, 0.3, 0.2]);
    let told = warnings(&folder);
    let unusable = "picture.jp2: the picture of material `a` cannot be used: no picture that can be read: not PNG";
    assert!(told[0].contains(unusable), "{told:?}");
    assert!(told[1].contains("nothing.png: the picture of material `a` is missing"), "{told:?}");
    let strict = describe(&folder.path().join("scene.toml"), &["render.strict=true"]);
    let error = strict.load_scene(1).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains(unusable), "{error}");
    // a scene file's own pictures must be usable
    let named = "[material.a]\ntype = 'diffuse'\nreflectance = { texture = 'picture.jp2' }\n";
    let folder = square(&format!("{SKY}{named}"), "");
    std::fs::write(folder.path().join("picture.jp2"), b"no picture").unwrap();
    assert!(describe(&folder.path().join("scene.toml"), &[]).load_scene(1).is_err());
}

/// A 16-bit grey with a gamma of 1, which says that values are proportional to light.
#[test]
fn a_linear_png_is_not_decoded() {
    let folder = square(SKY, "Kd 1 1 1\nmap_Kd linear.png\n");
    let path = folder.path().join("linear.png");
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000));
    encoder.write_header().unwrap().write_image_data(&[0x80, 0].repeat(4)).unwrap();
    assert_near(halves(&loaded(&folder))[0], [0.5; 3]);
    assert_eq!(warnings(&folder), [""; 0]);
}

const GREY: &str = "Kd 0.5 0.5 0.5\n";

fn sky_of(name: &str) -> String {
    format!("[[light]]\ntype = 'environment'\npath = '{name}'\n")
}

#[test]
fn skies_are_radiance_pictures_too() {
    let folder = square(&sky_of("sky.hdr"), GREY);
    let texels = [128, 64, 32, 130].repeat(8 * 4);
    let file = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".as_slice(), &texels].concat();
    std::fs::write(folder.path().join("sky.hdr"), file).unwrap();
    assert_near(halves(&loaded(&folder))[0], [1.0, 0.5, 0.25]);
    assert_eq!(warnings(&folder), [""; 0]);
}

#[test]
fn skies_of_screen_colours_are_decoded_and_noted() {
    let folder = square(&sky_of("sky.png"), GREY);
    image::RgbImage::from_pixel(8, 4, image::Rgb([255, 188, 0])).save(folder.path().join("sky.png")).unwrap();
    assert_near(halves(&loaded(&folder))[0], [0.5, 0.5 * 0.5029, 0.0]);
    let told = warnings(&folder);
    assert!(matches!(&told[..], [one] if one.contains("sky.png: this picture is no radiance")), "{told:?}");
}

#[test]
fn a_sky_that_is_no_picture_is_an_error_that_says_so() {
    let folder = square(&sky_of("model.mtl"), GREY);
    let error = describe(Path::new(&folder.path().join("scene.toml")), &[]).load_scene(1).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("model.mtl: no picture that can be read: not PNG, JPEG, OpenEXR"), "{error}");
}
