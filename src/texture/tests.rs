use super::*;
use crate::image::exr::{Metadata, Window};
use crate::image::{Layer, srgb};
use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageBuffer, RgbImage, RgbaImage};
use proptest::prelude::*;
use tempfile::TempDir;

fn place_for(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn through_file(picture: impl Into<DynamicImage>) -> Texture {
    let (_folder, path) = place_for("picture.png");
    picture.into().save(&path).unwrap();
    Texture::load(&path).unwrap()
}

/// Three columns, two rows, every texel of another colour.
fn stored(x: u32, y: u32) -> [u8; 3] {
    [40 * (x + 3 * y) as u8 + 10, 200 - 30 * x as u8, 100 * y as u8 + 20]
}

fn small() -> Texture {
    through_file(RgbImage::from_fn(3, 2, |x, y| image::Rgb(stored(x, y))))
}

fn linear(rgb: [u8; 3]) -> Rgb {
    Rgb::from_array(rgb.map(|value| srgb::decode(f32::from(value) / 255.0)))
}

fn assert_close(value: Rgb, wanted: Rgb) {
    assert!((value - wanted).abs().max_element() < 2e-6, "{value} is not {wanted}");
}

#[test]
fn texel_centres_have_the_texels_colour_and_v_points_up() {
    let texture = small();
    for (x, y) in (0..2).flat_map(|y| (0..3).map(move |x| (x, y))) {
        let centre = [(x as f32 + 0.5) / 3.0, 1.0 - (y as f32 + 0.5) / 2.0];
        for nearest in [false, true] {
            assert_close(texture.color(centre, nearest), linear(stored(x, y)));
        }
    }
    // The corner at the origin belongs to the first texel of the file's last row.
    assert_eq!(texture.color([0.0, 0.0], true), linear(stored(0, 1)));
    assert_eq!(texture.color([0.0, 0.999], true), linear(stored(0, 0)));
    assert_eq!(texture.color([0.999, 0.0], true), linear(stored(2, 1)));
    assert_eq!(texture.size(), [3, 2]);
}

#[test]
fn bilinear_values_are_means_of_decoded_neighbours() {
    let texture = small();
    let all: [Rgb; 4] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| linear(stored(x, y)));
    assert_close(texture.color([1.0 / 3.0, 0.5], false), (all[0] + all[1] + all[2] + all[3]) / 4.0);
    // A quarter of the way from the first to the second column, in the upper row.
    let wanted = 0.75 * all[0] + 0.25 * all[1];
    assert_close(texture.color([0.75 / 3.0, 0.75], false), wanted);
    // At the corner all four corners of the picture meet.
    let corners = [(0, 0), (2, 0), (0, 1), (2, 1)].map(|(x, y)| linear(stored(x, y)));
    let mean = corners.into_iter().sum::<Rgb>() / 4.0;
    for corner in [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-3.0, 7.0]] {
        assert_close(texture.color(corner, false), mean);
    }
}

#[test]
fn values_agree_with_mitsuba() {
    // `bitmap` of Mitsuba 3.9.1 on the same picture at (u, 1 − v), since its own v points down.
    let texture = small();
    let bilinear = [
        ([0.4, 0.7], [0.055_749_3, 0.454_659, 0.025_077_9]),
        ([0.95, 0.1], [0.368_185, 0.372_616, 0.133_573]),
        ([2.3, 1.7], [0.042_594_4, 0.507_34, 0.025_077_9]),
        ([0.0, 1.0], [0.243_246, 0.419_916, 0.097_408_1]),
    ];
    for (uv, wanted) in bilinear {
        let (value, wanted) = (texture.color(uv, false), Rgb::from_array(wanted));
        assert!((value - wanted).abs().max_element() < 3e-6, "{uv:?}: {value} is not {wanted}");
    }
    let value = texture.color([0.4, 0.7], true);
    assert!((value - Rgb::new(0.031_896, 0.401_978, 0.006_995_4)).abs().max_element() < 3e-6);
}

#[test]
fn extreme_coordinates_give_finite_colours() {
    let texture = small();
    let inside = |c: Rgb| c.is_finite() && c.min_element() >= 0.0 && c.max_element() <= 1.0;
    for x in [-1e-9, 1.0 - 1e-7, 1e9, -1e30, f32::MAX, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE] {
        for nearest in [false, true] {
            assert!(inside(texture.color([x, 0.3], nearest)) && inside(texture.color([0.3, x], nearest)));
        }
    }
    assert_eq!(texture.color([f32::NAN, 0.2], false), texture.color([0.0, 0.2], false));
}

#[test]
fn scalars_are_alpha_or_stored_luminance() {
    let pixel = [0.5 / 1.0, 0.5];
    let rgb = through_file(RgbImage::from_pixel(1, 1, image::Rgb([51, 102, 204])));
    assert!((rgb.scalar(pixel, false) - (0.2126 * 0.2 + 0.7152 * 0.4 + 0.0722 * 0.8)).abs() < 1e-6);
    let rgba = through_file(RgbaImage::from_pixel(1, 1, image::Rgba([51, 102, 204, 128])));
    assert_eq!(rgba.scalar(pixel, true), 128.0 / 255.0);
    assert_close(rgba.color(pixel, true), linear([51, 102, 204]));
    let grey = through_file(GrayImage::from_pixel(1, 1, image::Luma([51])));
    assert_eq!(grey.scalar(pixel, false), 0.2);
    assert_close(grey.color(pixel, false), linear([51; 3]));
    let grey_alpha = through_file(GrayAlphaImage::from_pixel(1, 1, image::LumaA([51, 255])));
    assert_eq!(grey_alpha.scalar(pixel, false), 1.0);
    assert_close(grey_alpha.color(pixel, false), linear([51; 3]));
    assert_eq!([&rgb, &rgba, &grey, &grey_alpha].map(Texture::bytes), [3, 4, 1, 2]);
}

#[test]
fn sixteen_bits_are_kept() {
    let pixel = image::Rgba([1u16, 32_896, 65_535, 257]);
    let texture = through_file(ImageBuffer::from_pixel(2, 2, pixel));
    let wanted = [1.0, 32_896.0, 65_535.0].map(|value| srgb::decode(value / 65_535.0));
    assert_close(texture.color([0.1, 0.9], false), Rgb::from_array(wanted));
    assert_eq!(texture.scalar([0.1, 0.9], false), 257.0 / 65_535.0);
    assert_eq!(texture.bytes(), 32);
}

#[test]
fn palettes_are_resolved() {
    // Two texels, red and blue, one bit each.
    let chunks: [&[u8]; 5] = [
        &[137, 80, 78, 71, 13, 10, 26, 10],
        b"\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x01\x03\0\0\0\xce\xec\xed\xc9",
        b"\0\0\0\x06PLTE\xff\0\0\0\0\xff\x6c\xa1\xfd\x8e",
        b"\0\0\0\nIDAT\x78\xda\x63\x70\0\0\0\x42\0\x41\x84\xbf\x8e\x62",
        b"\0\0\0\0IEND\xae\x42\x60\x82",
    ];
    let (_folder, path) = place_for("palette.png");
    std::fs::write(&path, chunks.concat()).unwrap();
    let texture = Texture::load(&path).unwrap();
    assert_eq!(texture.color([0.25, 0.5], true), Rgb::X);
    assert_eq!(texture.color([0.75, 0.5], true), Rgb::Z);
}

#[test]
fn openexr_is_linear_and_must_be_finite() {
    let (_folder, path) = place_for("picture.exr");
    let write = |layers| {
        let window = Window::full(2, 1);
        crate::image::exr::write(&path, &window, layers, &Metadata::default()).unwrap();
        Texture::load(&path)
    };
    let pixels = [Rgb::new(3.0, 0.5, 0.0), Rgb::ONE];
    let alpha = Layer::scalar("", "A", vec![0.25, 1.0]);
    let texture = write(vec![Layer::color("", &pixels), alpha]).unwrap();
    assert_eq!(texture.color([0.25, 0.5], false), pixels[0]);
    assert_eq!(texture.scalar([0.25, 0.5], false), 0.25);
    let grey = write(vec![Layer::scalar("", "Y", vec![2.0, 4.0])]).unwrap();
    assert_eq!(grey.color([0.5, 0.5], false), Rgb::splat(3.0));
    let error = write(vec![Layer::scalar("", "Y", vec![2.0, f32::NAN])]).unwrap_err().to_string();
    assert!(error.ends_with("picture.exr: the texel in column 1, row 0 is not finite"), "{error}");
    let error = write(vec![Layer::scalar("Z", "", vec![2.0, 1.0])]).unwrap_err().to_string();
    assert!(error.ends_with("lacks channel R"), "{error}");
}

#[test]
fn mean_and_opacity_describe_all_texels() {
    let texture = small();
    let texels = (0..2).flat_map(|y| (0..3).map(move |x| linear(stored(x, y))));
    assert_close(texture.mean(), texels.sum::<Rgb>() / 6.0);
    assert!(!texture.is_opaque());
    assert!(through_file(RgbImage::from_pixel(2, 2, image::Rgb([255; 3]))).is_opaque());
    let mut mask = RgbaImage::from_pixel(3, 3, image::Rgba([9, 9, 9, 255]));
    assert!(through_file(mask.clone()).is_opaque());
    mask.put_pixel(2, 2, image::Rgba([255, 255, 255, 254]));
    assert!(!through_file(mask).is_opaque());
}

#[test]
fn a_map_scales_offsets_and_tints() {
    let (folder, path) = place_for("picture.png");
    RgbImage::from_fn(3, 2, |x, y| image::Rgb(stored(x, y))).save(&path).unwrap();
    let mut cache = TextureCache::default();
    let plain = ImageTexture {
        path: path.clone(),
        scale: [1.0, 1.0],
        offset: [0.0, 0.0],
        nearest: true,
        tint: Rgb::ONE,
        clamp: false,
    };
    let tint = Rgb::new(0.5, 2.0, 0.0);
    let changed = ImageTexture {
        // The same file by another name.
        path: folder.path().join(".").join("picture.png"),
        scale: [2.0, -1.0],
        offset: [0.25, 0.5],
        nearest: false,
        tint,
        clamp: false,
    };
    let [plain, changed] = [plain, changed].map(|image| cache.resolve(&image).unwrap());
    assert_eq!((plain.index, changed.index, cache.textures().len()), (0, 0, 1));
    let textures = cache.into_textures();
    let uv = [0.3, 0.6];
    assert_eq!(plain.color(&textures, uv), textures[0].color(uv, true));
    assert_eq!(plain.scalar(&textures, uv), textures[0].scalar(uv, true));
    let moved = [0.3 * 2.0 + 0.25, -0.6 + 0.5];
    assert_eq!(changed.color(&textures, uv), textures[0].color(moved, false) * tint);
    let grey = 0.2126 * 0.5 + 0.7152 * 2.0;
    let scalar = changed.scalar(&textures, uv);
    assert!((scalar - textures[0].scalar(moved, false) * grey).abs() < 1e-6);
    assert_eq!(changed.mean(&textures), textures[0].mean() * tint);
}

#[test]
fn unusable_files_are_named() {
    let (folder, path) = place_for("text.png");
    std::fs::write(&path, "no picture at all").unwrap();
    let mut cache = TextureCache::default();
    for path in [path, folder.path().join("missing.jpg"), folder.path().to_path_buf()] {
        for error in [Texture::load(&path).unwrap_err(), cache.get(&path).unwrap_err()] {
            let error = error.to_string();
            assert!(error.starts_with(&path.display().to_string()), "{error}");
        }
    }
    assert!(cache.textures().is_empty());
}

#[test]
fn huge_pictures_are_refused_by_their_header() {
    let (_folder, path) = place_for("huge.png");
    RgbImage::new(65_537, 1).save(&path).unwrap();
    let error = Texture::load(&path).unwrap_err().to_string();
    assert!(error.ends_with("65537 × 1 pixels; no side may exceed 65536"), "{error}");
    // Sizes in the header of a small file; its checksum is over the chunk's type and data.
    let mut bytes = Vec::new();
    let cursor = std::io::Cursor::new(&mut bytes);
    RgbImage::new(1, 1).write_with_encoder(image::codecs::png::PngEncoder::new(cursor)).unwrap();
    let mut claim = |side: u16| {
        let side = side.to_be_bytes();
        bytes[16..24].copy_from_slice(&[[0, 0], side, [0, 0], side].concat());
        let checksum = crc32(&bytes[12..29]).to_be_bytes();
        bytes[29..33].copy_from_slice(&checksum);
        std::fs::write(&path, &bytes).unwrap();
        Texture::load(&path).unwrap_err().to_string()
    };
    let error = claim(0x8000);
    assert!(error.ends_with("takes 3072 MiB when decoded; at most 1024 MiB are allowed"), "{error}");
    // as much as is allowed, and far more than such a file can hold
    let error = claim(0x4800);
    assert!(error.contains("huge.png: damaged: its pixels need at least 40.2 KiB, and the file has "), "{error}");
}

/// Decoders of JPEG fill up what is missing, and take seconds for it.
#[test]
fn small_files_of_large_jpegs_are_refused() {
    let (_folder, path) = place_for("claim.jpg");
    RgbImage::new(16, 16).save(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let frame = bytes.windows(2).position(|pair| pair == [0xff, 0xc0]).expect("a sequential frame");
    bytes[frame + 5..frame + 9].copy_from_slice(&[0x20, 0, 0x20, 0]);
    std::fs::write(&path, &bytes).unwrap();
    let error = Texture::load(&path).unwrap_err().to_string();
    assert!(error.contains("claim.jpg: damaged: its pixels need at least 128 KiB, and the file has "), "{error}");
}

/// The checksum of PNG chunks, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), bit))
}

#[test]
fn pictures_of_the_scenes_are_read() {
    for (suffix, size) in [("leaf.png", [365, 271]), ("wood.jpg", [2048, 910])] {
        let Some(files) = crate::image::tests::scene_files(suffix) else { return };
        assert_eq!(Texture::load(&files[0]).unwrap().size(), size);
    }
    for suffix in [".png", ".jpg"] {
        for path in crate::image::tests::scene_files(suffix).unwrap() {
            let mean = Texture::load(&path).unwrap().mean();
            assert!(mean.min_element() >= 0.0 && mean.max_element() <= 1.0, "{}", path.display());
        }
    }
}

fn valid_files() -> [Vec<u8>; 2] {
    let picture: DynamicImage = RgbImage::from_fn(24, 24, |x, y| image::Rgb([x as u8 * 9, y as u8 * 9, 99])).into();
    [image::ImageFormat::Png, image::ImageFormat::Jpeg].map(|format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damage_never_panics(damage in proptest::collection::vec(any::<(prop::sample::Index, u8)>(), 1..20), cut in any::<Option<prop::sample::Index>>()) {
        let (_folder, path) = place_for("damaged");
        for mut bytes in valid_files() {
            for (at, value) in &damage {
                let at = at.index(bytes.len());
                bytes[at] = *value;
            }
            if let Some(cut) = &cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            std::fs::write(&path, bytes).unwrap();
            if let Err(error) = Texture::load(&path) {
                prop_assert!(error.to_string().contains("damaged"));
            }
        }
    }

    #[test]
    fn interpolation_stays_between_the_texels(u in -4.0f32..4.0, v in -4.0f32..4.0) {
        let texel = |x, y| image::Rgb([(x * 80) as u8, (y * 120 + 10) as u8, 77]);
        let picture = RgbImage::from_fn(3, 2, texel);
        let samples = crate::image::picture::Samples::U8(picture.into_raw(), srgb::DECODE_8.clone());
        let texture = Texture::new(Texels { width: 3, height: 2, channels: 3, data: samples });
        let color = texture.color([u, v], false);
        let (low, high) = (linear([0, 10, 77]), linear([160, 130, 77]));
        prop_assert!(color.cmpge(low - 1e-6).all() && color.cmple(high + 1e-6).all());
        prop_assert_eq!(color.z, low.z);
    }
}

/// What is called black between coordinates is black wherever it is looked at; what lies well beside the one bright texel is.
#[test]
fn black_parts_of_a_picture_are_known() {
    let mut picture = RgbImage::new(75, 40);
    picture.put_pixel(50, 9, image::Rgb([0, 9, 0]));
    let texture = through_file(picture);
    let (map, textures) = (
        TextureMap { index: 0, scale: [1.0; 2], offset: [0.0; 2], nearest: false, tint: Rgb::ONE, clamp: false },
        [texture],
    );
    let mut rng = crate::math::rng::Rng::new(3);
    let (mut dark, mut lit) = (0, 0);
    for _ in 0..400 {
        let at = [rng.f32() * 6.0 - 3.0, rng.f32() * 6.0 - 3.0];
        let size = rng.f32().powi(3);
        let corner = |rng: &mut crate::math::rng::Rng| [at[0] + size * rng.f32(), at[1] + size * rng.f32()];
        let uvs = [corner(&mut rng), corner(&mut rng), corner(&mut rng)];
        if !map.is_black_between(&textures, uvs) {
            lit += 1;
            continue;
        }
        dark += 1;
        for _ in 0..300 {
            let [b, c] = crate::math::warp::square_to_triangle(rng.f32x2());
            let uv = [0, 1].map(|i| uvs[0][i] * (1.0 - b - c) + uvs[1][i] * b + uvs[2][i] * c);
            assert_eq!(map.color(&textures, uv), Rgb::ZERO, "{uv:?} in {uvs:?}");
        }
    }
    assert!(dark > 150 && lit > 60, "{dark} dark, {lit} lit");
    let at = |u: f32, v: f32| [[u, v], [u + 0.01, v], [u, v + 0.01]];
    assert!(map.is_black_between(&textures, at(0.1, 0.75)) && map.is_black_between(&textures, at(0.67, 0.2)));
    assert!(!map.is_black_between(&textures, at(0.67, 0.75)) && !map.is_black_between(&textures, at(-0.33, 3.75)));
    assert!(!map.is_black_between(&textures, [[f32::NAN, 0.0]; 3]));
    assert_eq!(map.peak(&textures), linear([9, 9, 9]).x);
    assert!((map.texels_between(&textures, [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]) - 3000.0).abs() < 1e-6);
}
