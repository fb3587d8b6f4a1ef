use super::*;
use crate::image::exr::{self, Metadata, Window};
use crate::image::{Layer, srgb};
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Rgb32FImage, RgbImage, RgbaImage};
use moxcms::{ColorProfile, ToneReprCurve};
use std::io::Cursor;
use std::path::PathBuf;
use tempfile::TempDir;

/// Three columns and two rows.
fn stored(x: u32, y: u32) -> [u8; 3] {
    [40 * (x + 3 * y) as u8 + 10, 200 - 30 * x as u8, 100 * y as u8 + 20]
}

fn decoded(rgb: [u8; 3]) -> Rgb {
    Rgb::from_array(rgb.map(|value| srgb::decode(f32::from(value) / 255.0)))
}

/// A file whose name says nothing true of what is in it.
fn file(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.pcx");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn read(bytes: &[u8]) -> Picture {
    let (_folder, path) = file(bytes);
    load(&path).unwrap()
}

fn encoded(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn every_format_is_read_whatever_its_name_says() {
    let picture = RgbImage::from_fn(3, 2, |x, y| image::Rgb(stored(x, y)));
    let formats = [
        ImageFormat::Png,
        ImageFormat::Bmp,
        ImageFormat::Tga,
        ImageFormat::Tiff,
        ImageFormat::WebP,
        ImageFormat::Pnm,
        ImageFormat::Qoi,
    ];
    for format in formats {
        let read = read(&encoded(picture.clone(), format));
        let wanted: Vec<Rgb> = (0..6).map(|i| decoded(stored(i % 3, i / 3))).collect();
        assert_eq!((read.width, read.height, read.colors(), read.notes), (3, 2, wanted, vec![]), "{format:?}");
    }
    let alpha = RgbaImage::from_fn(16, 16, |_, _| image::Rgba([200, 100, 50, 255]));
    for format in [ImageFormat::Gif, ImageFormat::Ico] {
        let read = read(&encoded(alpha.clone(), format));
        assert_eq!((read.channels, read.colors()[17]), (3, decoded([200, 100, 50])), "{format:?}: no alpha is made up");
    }
    let wide = ImageBuffer::<image::Rgba<u16>, _>::from_pixel(2, 1, image::Rgba([65535u16, 257, 0, 65535]));
    let read = read(&encoded(wide, ImageFormat::Farbfeld));
    assert_eq!(read.colors()[1], Rgb::new(1.0, srgb::decode(1.0 / 255.0), 0.0));
}

#[test]
fn a_dds_of_one_block_is_read() {
    let mut bytes = b"DDS ".to_vec();
    let mut header = [0u32; 31];
    (header[0], header[1], header[2], header[3]) = (124, 0x81007, 4, 4);
    (header[18], header[19], header[20]) = (32, 4, u32::from_le_bytes(*b"DXT1"));
    header[26] = 0x1000;
    header.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    // red (5:6:5) at all sixteen texels
    bytes.extend([0x00, 0xf8, 0x00, 0x00, 0, 0, 0, 0]);
    let read = read(&bytes);
    assert_eq!((read.width, read.height, read.colors()[15]), (4, 4, Rgb::X));
}

#[test]
fn what_is_no_picture_is_not_taken_for_a_tga() {
    for text in ["newmtl a\nKd 1 1 1\n# a library of materials", "8BPS\0\x01\0\0\0\0\0\0\0\x03\0\0\0\x01\0\0\0\x01"] {
        let (_folder, path) = file(text.as_bytes());
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains("picture.pcx: no picture that can be read: not PNG, JPEG, "), "{error}");
    }
}

/// A PNG with more chunks, before its pixels.
fn with_chunks(png: &[u8], chunks: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut bytes = png[..33].to_vec();
    for (name, data) in chunks {
        let body = [&name[..], data].concat();
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(&body);
        bytes.extend(crc32fast::hash(&body).to_be_bytes());
    }
    [&bytes, &png[33..]].concat()
}

fn gamma(scaled: u32) -> (&'static [u8; 4], Vec<u8>) {
    (b"gAMA", scaled.to_be_bytes().to_vec())
}

/// The chunk `iCCP` of a profile, stored without compression.
fn profile(profile: &ColorProfile) -> (&'static [u8; 4], Vec<u8>) {
    let data = profile.encode().unwrap();
    let (mut a, mut b) = (1u32, 0u32);
    for &byte in &data {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    let length = data.len() as u16;
    let mut chunk = b"any name\0\0\x78\x01\x01".to_vec();
    chunk.extend(length.to_le_bytes());
    chunk.extend((!length).to_le_bytes());
    chunk.extend(&data);
    chunk.extend((b << 16 | a).to_be_bytes());
    (b"iCCP", chunk)
}

fn with_curve(curve: ToneReprCurve) -> ColorProfile {
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    for own in [&mut profile.red_trc, &mut profile.green_trc, &mut profile.blue_trc] {
        *own = Some(curve.clone());
    }
    profile
}

#[test]
fn chunks_of_a_png_say_what_its_values_mean_in_the_order_of_the_specification() {
    let grey = encoded(RgbImage::from_pixel(1, 1, image::Rgb([128; 3])), ImageFormat::Png);
    let v = 128.0f32 / 255.0;
    let of_srgb = srgb::decode(v);
    let (linear, intent) = (gamma(100_000), (b"sRGB", vec![0]));
    let points = |transfer: u8| (b"cICP", vec![1, transfer, 0, 1]);
    let linear_profile = profile(&with_curve(ToneReprCurve::Lut(vec![])));
    let srgb_profile = profile(&ColorProfile::new_srgb());
    let squared = profile(&with_curve(ToneReprCurve::Lut(vec![512])));
    let cases: [(&[_], f32); 12] = [
        (&[], of_srgb),
        (std::slice::from_ref(&linear), v),
        (&[gamma(45_455)], of_srgb),
        (&[gamma(50_000)], v * v),
        (&[intent.clone(), linear.clone()], of_srgb),
        (std::slice::from_ref(&linear_profile), v),
        (&[srgb_profile.clone(), linear.clone()], of_srgb),
        (std::slice::from_ref(&squared), v * v),
        (&[linear_profile.clone(), gamma(45_455)], v),
        (&[points(8), srgb_profile.clone()], v),
        (&[points(13), linear.clone()], of_srgb),
        (&[points(4)], of_srgb),
    ];
    for (chunks, wanted) in cases {
        let read = read(&with_chunks(&grey, chunks));
        let names: Vec<_> = chunks.iter().map(|(name, _)| String::from_utf8_lossy(&name[..])).collect();
        assert!((read.colors()[0].x - wanted).abs() < 1e-4, "{names:?}: {} is not {wanted}", read.colors()[0]);
        assert_eq!(read.notes, [""; 0], "{names:?}");
    }
}

#[test]
fn sixteen_bits_are_decoded_by_the_gamma_without_loss() {
    let picture = ImageBuffer::<image::Luma<u16>, _>::from_fn(3, 1, |x, _| image::Luma([32_768 + x as u16]));
    let read = read(&with_chunks(&encoded(picture, ImageFormat::Png), &[gamma(100_000)]));
    let wanted = [0, 1, 2].map(|x| Rgb::splat((32_768 + x) as f32 / 65_535.0));
    assert_eq!(read.colors(), wanted);
    assert!(matches!(read.samples, Samples::U16(..)));
}

#[test]
fn what_cannot_be_honoured_is_noted() {
    let grey = encoded(RgbImage::from_pixel(1, 1, image::Rgb([128; 3])), ImageFormat::Png);
    let white = srgb::decode(128.0 / 255.0);
    // the primaries of Adobe RGB
    let numbers = [31_270u32, 32_900, 64_000, 33_000, 21_000, 71_000, 15_000, 6_000];
    let other = (b"cHRM", numbers.iter().flat_map(|n| n.to_be_bytes()).collect());
    let broken = (b"iCCP", b"broken\0\0\x78\x01\x01\x02\0\xfd\xff\x41\x42\0\xc6\0\x84".to_vec());
    let cases: [(&[_], &str); 4] = [
        (&[gamma(45_455), other], "other primaries than sRGB"),
        (&[profile(&ColorProfile::new_adobe_rgb())], "other primaries than sRGB"),
        (&[gamma(1)], "means nothing"),
        (&[broken], "its colour profile cannot be used; it is read as sRGB"),
    ];
    for (chunks, wanted) in cases {
        let read = read(&with_chunks(&grey, chunks));
        assert!(matches!(&read.notes[..], [note] if note.contains(wanted)), "{:?} for {wanted}", read.notes);
        assert!((read.colors()[0].x - white).abs() < 0.01);
    }
}

#[test]
fn profiles_of_other_formats_count_too() {
    use image::ImageEncoder;
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
    encoder.set_icc_profile(with_curve(ToneReprCurve::Lut(vec![])).encode().unwrap()).unwrap();
    encoder.write_image(&[100; 64 * 3], 8, 8, image::ExtendedColorType::Rgb8).unwrap();
    let color = read(&bytes).colors()[9];
    assert!((color - Rgb::splat(100.0 / 255.0)).abs().max_element() < 1.5 / 255.0, "{color}");
}

#[test]
fn floats_are_linear() {
    let picture = Rgb32FImage::from_pixel(2, 2, image::Rgb([0.5, 7.0, 0.25]));
    let read = read(&encoded(picture, ImageFormat::Tiff));
    assert_eq!((read.colors()[3], read.channels), (Rgb::new(0.5, 7.0, 0.25), 3));
}

#[test]
fn radiance_pictures_are_read_with_their_exposure_undone() {
    let file = |header: &str| [header.as_bytes(), b"\n-Y 1 +X 2\n", &[128, 64, 32, 130, 1, 2, 3, 0]].concat();
    let plain = read(&file("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"));
    assert_eq!((plain.colors(), plain.notes), (vec![Rgb::new(2.0, 1.0, 0.5), Rgb::ZERO], vec![]));
    assert_eq!(read(&file("#?RGBE\n")).colors()[0], Rgb::new(2.0, 1.0, 0.5));
    let exposed = read(&file("#?RADIANCE\nEXPOSURE=2\nEXPOSURE=2\nCOLORCORR=1 2 1\n"));
    assert_eq!(exposed.colors()[0], Rgb::new(0.5, 0.125, 0.125));
    assert!(exposed.notes[0].contains("exposure of [4.0, 8.0, 4.0]"), "{:?}", exposed.notes);
    let (_folder, path) = super::tests::file(&file("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n"));
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("no picture that can be read") && error.contains("xyze"), "{error}");
}

#[test]
fn a_layer_of_an_exr_is_found_or_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let layer = |name: &str, value: f32| Layer::color(name, &[Rgb::new(value, 0.0, 1.0)]);
    let write = |layers: Vec<Layer>| exr::write(&path, &Window::full(1, 1), layers, &Metadata::default()).unwrap();
    let red = |path: &std::path::Path| load(path).map(|read| (read.colors()[0].x, read.notes));
    write(vec![layer("only", 3.0)]);
    assert_eq!(red(&path).unwrap(), (3.0, vec![]));
    write(vec![layer("a", 1.0), layer("View Layer.Combined", 2.0), Layer::scalar("depth", "Z", vec![9.0])]);
    let (value, notes) = red(&path).unwrap();
    assert!(value == 2.0 && notes[0].contains("`View Layer.Combined` is read; FILE.exr:LAYER"), "{notes:?}");
    assert_eq!(red(&folder.path().join("layers.exr:a")).unwrap(), (1.0, vec![]));
    let error = red(&folder.path().join("layers.exr:b")).unwrap_err().to_string();
    assert!(error.contains("no layer `b` of colours; layers of colours: [\"View Layer.Combined\", \"a\"]"), "{error}");
    write(vec![layer("", 5.0), layer("a", 1.0)]);
    assert_eq!(red(&path).unwrap(), (5.0, vec![]));
    write(vec![Layer::scalar("depth", "Z", vec![9.0])]);
    assert!(red(&path).unwrap_err().to_string().ends_with("lacks channel R"));
}

/// Files that claim more than there is memory for or than they can hold, and ends that are missing.
#[test]
fn claims_of_headers_are_held_against_limits() {
    let radiance = |w: u32, h: u32| format!("#?RADIANCE\n\n-Y {h} +X {w}\n").into_bytes();
    let portable = |w: u32, h: u32| format!("P6 {w} {h} 255\n").into_bytes();
    let mut targa = encoded(GrayImage::new(4, 4), ImageFormat::Tga);
    targa[12..16].copy_from_slice(&[0xff; 4]);
    let mut gif = encoded(RgbaImage::new(4, 4), ImageFormat::Gif);
    gif[6..10].copy_from_slice(&[0xff; 4]);
    let mut short = encoded(RgbImage::from_fn(9, 9, |x, y| image::Rgb([x as u8, y as u8, 7])), ImageFormat::Tga);
    short.truncate(short.len() / 2);
    let cases = [
        (short, "damaged: the file ends before the picture does"),
        (radiance(1 << 20, 1), "no side may exceed 65536"),
        (radiance(60_000, 60_000), "takes 41198 MiB when decoded; at most 1024 MiB are allowed"),
        (radiance(6_000, 6_000), "damaged: its pixels need at least"),
        (portable(60_000, 60_000), "takes 10299 MiB when decoded"),
        (portable(9_000, 9_000), "damaged: its pixels need at least"),
        (targa, "takes 4095 MiB when decoded"),
        (gif, "takes 16383 MiB when decoded"),
        (radiance(0, 5), "the picture is empty"),
    ];
    for (bytes, wanted) in cases {
        let (_folder, path) = file(&bytes);
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}, not {wanted}");
    }
}

#[test]
fn damage_to_any_format_is_an_error_and_not_a_panic() {
    let picture = RgbImage::from_fn(24, 24, |x, y| image::Rgb([x as u8 * 9, y as u8 * 9, 99]));
    let formats = [
        ImageFormat::Bmp,
        ImageFormat::Tga,
        ImageFormat::Tiff,
        ImageFormat::Gif,
        ImageFormat::WebP,
        ImageFormat::Pnm,
        ImageFormat::Qoi,
    ];
    let mut rng = crate::math::rng::Rng::for_place(7, 1, 2);
    let mut refused = 0;
    for format in formats {
        let whole = encoded(picture.clone(), format);
        for _ in 0..60 {
            let mut bytes = whole.clone();
            for _ in 0..4 {
                let at = (rng.f32() * bytes.len() as f32) as usize;
                bytes[at.min(whole.len() - 1)] = (rng.f32() * 256.0) as u8;
            }
            bytes.truncate((rng.f32() * 2.0 * bytes.len() as f32) as usize);
            let (_folder, path) = file(&bytes);
            refused += usize::from(load(&path).is_err());
        }
    }
    assert!(refused > 100, "{refused} of 420 damaged files were refused");
}

#[test]
fn every_second_copy_is_mirrored() {
    let samples = Samples::F32((1..=6).map(|x| x as f32).collect());
    let picture = Picture { width: 3, height: 2, channels: 1, samples, notes: Vec::new() };
    let values = |picture: Picture| match picture.samples {
        Samples::F32(values) => (picture.width, picture.height, values),
        _ => unreachable!(),
    };
    let across = vec![1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 4.0, 5.0, 6.0, 6.0, 5.0, 4.0];
    assert_eq!(values(picture.mirrored([true, false])), (6, 2, across));
    let up = vec![4.0, 5.0, 6.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    assert_eq!(values(picture.mirrored([false, true])), (3, 4, up));
    assert_eq!(values(picture.transposed()), (2, 3, vec![1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
    assert_eq!(picture.mean(), Rgb::splat(3.5));
    assert_eq!(picture.mirrored([true, true]).mean(), Rgb::splat(3.5));
}
