//! Pictures of all kinds on surfaces and in the sky.

use crate::common::square::{SKY, assert_near, halves, loaded, square};
use crate::common::{describe, mean_color};
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::render::Settings;
use phototaxis::stats::ztest::{p_value, z_one_mean};
use std::path::Path;
use tempfile::TempDir;

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

/// A texel that leans by 45° along u.
const LEANING: [u8; 3] = [218, 128, 218];

fn leaning(folder: &TempDir, name: &str) {
    image::RgbImage::from_pixel(4, 4, image::Rgb(LEANING)).save(folder.path().join(name)).unwrap();
}

fn sun(x: f32) -> String {
    format!("[[light]]\ntype = 'directional'\ndirection = [{x}, 0, -1]\nirradiance = 3.14159265\n")
}

/// Lit along the normal a surface of albedo ½ is as bright as ½ of the irradiance over π, and black from the other side. Light
/// travels towards −x where `direction` says so, and comes from +x then.
#[test]
fn a_normal_map_leans_the_surface() {
    let statements = ["norm n.png", "map_Kn n.png", "map_Bump -bm 1 n.png", "bump n.png"];
    for statement in statements {
        for (x, wanted) in [(-1.0, 0.5), (1.0, 0.0)] {
            let folder = square(&sun(x), &format!("Kd 0.5 0.5 0.5\n{statement}\n"));
            leaning(&folder, "n.png");
            let mut loaded = loaded(&folder);
            loaded.settings.integrator.next_event = true;
            let [found, _] = halves(&loaded);
            assert!((found[0] - wanted).abs() < 0.006, "{statement}, from {x}: {found:?} is not {wanted}");
            assert_eq!(warnings(&folder), [""; 0]);
        }
    }
    let material = "[material.a]\ntype = 'diffuse'\nreflectance = 0.5\nnormal_map = { texture = 'n.png' }\n";
    let folder = square(&format!("{}{material}", sun(-1.0)), "");
    leaning(&folder, "n.png");
    let mut loaded = loaded(&folder);
    loaded.settings.integrator.next_event = true;
    assert!((halves(&loaded)[0][0] - 0.5).abs() < 0.006);
}

/// Heights that rise to the right by a unit of length over a unit of length face −x.
#[test]
fn a_bump_map_leans_the_surface() {
    for (x, wanted) in [(1.0, 0.5), (-1.0, 0.0)] {
        let material =
            "[material.a]\ntype = 'diffuse'\nreflectance = 0.5\nbump_map = { texture = 'h.png', height = 2 }\n";
        let folder = square(&format!("{}{material}", sun(x)), "");
        // 256 levels over the whole width of two units of length
        image::GrayImage::from_fn(256, 1, |x, _| image::Luma([x as u8])).save(folder.path().join("h.png")).unwrap();
        let mut loaded = loaded(&folder);
        loaded.settings.integrator.next_event = true;
        let [found, _] = halves(&loaded);
        assert!((found[0] - wanted).abs() < 0.006, "from {x}: {found:?} is not {wanted}");
    }
}

/// A white surface under a white sky is white, however its normals lean and from wherever it is seen.
#[test]
fn a_white_relief_is_white() {
    for camera in ["", "origin = [1.5, 0.5, 0.4]\nvfov = 5\n", "origin = [-1.5, 0.2, -0.3]\nvfov = 5\n"] {
        let folder = square(SKY, "Kd 1 1 1\nnorm n.png\n");
        let noise =
            |x: u32, y: u32| image::Rgb([(x * 97 + y * 31) as u8, (x * 59 + y * 83) as u8, 128 + (x * 37 % 128) as u8]);
        image::RgbImage::from_fn(32, 32, noise).save(folder.path().join("n.png")).unwrap();
        let path = folder.path().join("scene.toml");
        let scene = std::fs::read_to_string(&path).unwrap();
        let moved = if camera.is_empty() {
            scene
        } else {
            scene.replace("origin = [0, 0, 2]\n", camera).replace("vfov = 40\n", "")
        };
        std::fs::write(&path, moved).unwrap();
        for half in halves(&loaded(&folder)) {
            assert_near(half, [1.0; 3]);
        }
    }
}

/// What a relief shows does not depend on how light is found: glossy, diffuse and clear ones, in the light of a lamp.
#[test]
fn reliefs_look_alike_however_light_is_found() {
    const LAMP: &str = "v 0.2 -0.5 1\nv 0.9 -0.5 1\nv 0.9 0.5 1\nv 0.2 0.5 1\nusemtl lamp\nf 4 3 2 1\n";
    let ways: [fn(&mut Settings); 4] = [
        |s| s.integrator.next_event = false,
        |s| s.integrator.mis = false,
        |_| {},
        |s| s.guiding.method = GuidingMethod::Grid,
    ];
    for kind in ["type = 'diffuse'", "type = 'principled'\nroughness = 0.4", "type = 'plastic'\nalpha = 0.2"] {
        let material = format!("[material.a]\n{kind}\nnormal_map = {{ texture = 'n.png' }}\n");
        let lamp = "[material.lamp]\ntype = 'diffuse'\nemission = 5\n[[mesh]]\npath = 'lamp.obj'\n";
        let folder = square(&format!("{material}{lamp}"), "");
        std::fs::write(folder.path().join("lamp.obj"), LAMP).unwrap();
        let wave = |x: u32, y: u32| {
            image::Rgb([(128.0 + 90.0 * (x as f32).sin()) as u8, (128.0 + 90.0 * (y as f32).sin()) as u8, 210])
        };
        image::RgbImage::from_fn(16, 16, wave).save(folder.path().join("n.png")).unwrap();
        let mut loaded = loaded(&folder);
        (loaded.settings.integrator.next_event, loaded.settings.render.spp) = (true, 4096);
        let found = ways.map(|change| {
            let mut settings = loaded.settings.clone();
            change(&mut settings);
            let picture = loaded.estimate(&settings);
            let variance: f64 = picture.variance.iter().map(|v| f64::from(v.x)).sum();
            (mean_color(&picture.mean)[0], variance.sqrt() / picture.variance.len() as f64)
        });
        println!("{kind}: {found:?}");
        let (mean, error) = found[2];
        for (other, deviation) in [found[0], found[1], found[3]] {
            let z = z_one_mean(other, deviation.hypot(error), mean);
            assert!(p_value(z) > 1e-5, "{kind}: {found:?}");
            assert!(
                p_value(z_one_mean(1.1 * other, deviation.hypot(error), mean)) < 1e-5,
                "{kind}: a tenth goes unseen: {found:?}"
            );
        }
    }
}

/// Numbers of a material from a picture are those numbers: rough and smooth, metal and not, in a scene file and a library.
#[test]
fn numbers_of_a_material_come_from_pictures() {
    let scene = format!("{SKY}[material.a]\ntype = 'principled'\nbase_color = [0.8, 0.5, 0.2]\n");
    let mean = |folder: &TempDir| {
        image::RgbImage::from_pixel(2, 2, image::Rgb([51, 102, 153])).save(folder.path().join("n.png")).unwrap();
        let mut loaded = loaded(folder);
        loaded.settings.render.spp = 512;
        halves(&loaded)[0]
    };
    let picture = |channel: &str| format!("{{ texture = 'n.png', channel = '{channel}' }}");
    let keys = |r: &str, m: &str| format!("{scene}roughness = {r}\nmetallic = {m}\n");
    let by_pictures = mean(&square(&keys(&picture("green"), &picture("blue")), ""));
    let by_numbers = mean(&square(&keys("0.4", "0.6"), ""));
    for (a, b) in by_pictures.into_iter().zip(by_numbers) {
        assert!((a - b).abs() < 1e-6, "{by_pictures:?} is not {by_numbers:?}");
    }
    let others = mean(&square(&keys(&picture("red"), "0"), ""));
    assert!((others[0] - by_numbers[0]).abs() > 0.02, "{others:?} is {by_numbers:?}");
    let library = "Kd 0.8 0.5 0.2\nmap_Pr -imfchan g n.png\nmap_Pm -imfchan b n.png\n";
    let by_library = mean(&square(SKY, library));
    let conserving = format!("{}energy_conserving = true\n", keys(&picture("green"), &picture("blue")));
    let by_pictures = mean(&square(&conserving, ""));
    for (a, b) in by_library.into_iter().zip(by_pictures) {
        assert!((a - b).abs() < 1e-6, "{by_library:?} is not {by_pictures:?}");
    }
}

/// `-clamp on` lets the edge of a picture go on where it would repeat.
#[test]
fn clamped_pictures_do_not_repeat() {
    for (option, wanted) in [("-clamp on", [1.0, 0.0, 0.0]), ("-clamp off", [0.0, 0.0, 1.0])] {
        // all of the surface is to the right of the picture
        let folder = square(SKY, &format!("Kd 1 1 1\nmap_Kd {option} -s 0.01 1 1 -o 1.25 0 0 t.png\n"));
        let color = |x: u32, _| image::Rgb(if x == 1 { [255, 0, 0] } else { [0, 0, 255] });
        image::RgbImage::from_fn(2, 1, color).save(folder.path().join("t.png")).unwrap();
        let found = halves(&loaded(&folder))[0];
        assert!(found.iter().zip(wanted).all(|(a, b): (&f64, f64)| (a - b).abs() < 0.05), "{option}: {found:?}");
        assert_eq!(warnings(&folder), [""; 0]);
    }
}
