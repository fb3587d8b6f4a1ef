//! Small valid pictures in every form that readers know, and what is written in such files.

use base64::Engine as _;
use exr::prelude::*;
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;

pub const PNG_WORDS: [&[u8]; 16] = [
    b"IHDR",
    b"PLTE",
    b"IDAT",
    b"IEND",
    b"tRNS",
    b"gAMA",
    b"iCCP",
    b"zTXt",
    b"iTXt",
    b"acTL",
    b"fcTL",
    b"fdAT",
    b"sRGB",
    b"eXIf",
    b"\0\0\0\0",
    b"\x78\x9c",
];

pub const JPEG_WORDS: [&[u8]; 20] = [
    b"\xff\xd8",
    b"\xff\xd9",
    b"\xff\xc0",
    b"\xff\xc1",
    b"\xff\xc2",
    b"\xff\xc3",
    b"\xff\xc4",
    b"\xff\xc9",
    b"\xff\xda",
    b"\xff\xdb",
    b"\xff\xdd",
    b"\xff\xd0",
    b"\xff\xe1",
    b"\xff\xee",
    b"\xff\xfe",
    b"\xff\x00",
    b"Adobe",
    b"Exif\0\0",
    b"ICC_PROFILE\0",
    b"\x11\x08\xff\xff\xff\xff",
];

pub const EXR_WORDS: [&[u8]; 20] = [
    b"channels\0",
    b"chlist\0",
    b"compression\0",
    b"dataWindow\0",
    b"displayWindow\0",
    b"box2i\0",
    b"lineOrder\0",
    b"tiles\0",
    b"tiledesc\0",
    b"chunkCount\0",
    b"type\0",
    b"deepscanline",
    b"deeptile",
    b"scanlineimage",
    b"tiledimage",
    b"multiView\0",
    b"\xff\xff\xff\x7f",
    b"\0\0\x01\0",
    b"\0\0\0\0",
    b"name\0",
];

/// A picture of 7 × 5 pixels in every form that PNG has for it.
pub fn png() -> Vec<Vec<u8>> {
    let ramp: Vec<u8> = (0..7 * 5 * 8u32).map(|i| (i * 41) as u8).collect();
    let wide: Vec<u16> = ramp.iter().map(|&x| u16::from(x) * 257).collect();
    let bytes = |channels: usize| ramp[..35 * channels].to_vec();
    let words = |channels: usize| wide[..35 * channels].to_vec();
    let pictures: [DynamicImage; 8] = [
        image::GrayImage::from_raw(7, 5, bytes(1)).unwrap().into(),
        image::GrayAlphaImage::from_raw(7, 5, bytes(2)).unwrap().into(),
        image::RgbImage::from_raw(7, 5, bytes(3)).unwrap().into(),
        image::RgbaImage::from_raw(7, 5, bytes(4)).unwrap().into(),
        image::ImageBuffer::<image::Luma<u16>, _>::from_raw(7, 5, words(1)).unwrap().into(),
        image::ImageBuffer::<image::LumaA<u16>, _>::from_raw(7, 5, words(2)).unwrap().into(),
        image::ImageBuffer::<image::Rgb<u16>, _>::from_raw(7, 5, words(3)).unwrap().into(),
        image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(7, 5, words(4)).unwrap().into(),
    ];
    pictures.iter().map(|picture| written(picture, ImageFormat::Png)).chain([palette()]).collect()
}

/// Two bits a pixel, interlaced, with a palette and what is transparent of it.
fn palette() -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8], data: &[u8]| {
        png.extend((data.len() as u32).to_be_bytes());
        png.extend([name, data, &[0; 4]].concat());
    };
    chunk(b"IHDR", &[0, 0, 0, 5, 0, 0, 0, 3, 2, 3, 0, 0, 1]);
    chunk(b"gAMA", &[0, 0, 0xb1, 0x8f]);
    chunk(b"PLTE", &[255, 0, 0, 0, 255, 0, 0, 0, 255]);
    chunk(b"tRNS", &[255, 128]);
    // the passes of Adam7 for 5 × 3 pixels: each row begins with its filter, none
    let rows = [0, 0, 0, 0x40, 0, 0x80, 0, 0x18, 0, 0x10, 0, 0x40, 0, 0x18, 0x40];
    let mut stored = vec![0x78, 0x01, 1, rows.len() as u8, 0, !(rows.len() as u8), 0xff];
    stored.extend(rows);
    stored.extend([0; 4]);
    chunk(b"IDAT", &stored);
    chunk(b"IEND", &[]);
    mend_png(&mut png);
    png
}

/// Puts the checksums right of all chunks that can be found.
pub fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes(head.try_into().unwrap()) as usize;
        let Some(sum) = bytes.get(at + 4..at + 8 + length).map(crc32fast::hash) else { return };
        let Some(place) = bytes.get_mut(at + 8 + length..at + 12 + length) else { return };
        place.copy_from_slice(&sum.to_be_bytes());
        at += 12 + length;
    }
}

/// Sequential ones, and progressive ones in colour and in grey with restarts, which the crate `jpeg-encoder` wrote.
pub fn jpeg() -> Vec<Vec<u8>> {
    let color = image::RgbImage::from_fn(19, 13, |x, y| image::Rgb([x as u8 * 9, y as u8 * 9, (x * y) as u8]));
    let grey = image::GrayImage::from_fn(9, 17, |x, y| image::Luma([(x * 20 + y) as u8]));
    let mut files = vec![written(&color.into(), ImageFormat::Jpeg), written(&grey.into(), ImageFormat::Jpeg)];
    for text in [PROGRESSIVE_COLOR, PROGRESSIVE_GREY] {
        files.push(base64::engine::general_purpose::STANDARD.decode(text).unwrap());
    }
    files
}

fn written(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    picture.write_to(&mut file, format).unwrap();
    file.into_inner()
}

/// Each way of compression, in lines and in tiles, in several parts and with a window of its own.
pub fn exr() -> Vec<Vec<u8>> {
    let lossless =
        [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PXR24];
    let blocky = [Compression::PIZ, Compression::B44, Compression::B44A];
    let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 4))];
    let encodings = lossless.into_iter().chain(blocky).flat_map(|compression| {
        blocks.map(|blocks| Encoding { compression, blocks, line_order: LineOrder::Increasing })
    });
    encodings.enumerate().map(|(k, encoding)| exr_file(encoding, 1 + k % 2)).collect()
}

fn exr_file(encoding: Encoding, parts: usize) -> Vec<u8> {
    let size = Vec2(11, 9);
    let float = |i: usize| 0.25 * i as f32;
    let part = |k: usize| {
        let name =
            |channel: &str| Text::from(if k == 0 { channel.to_string() } else { format!("id.{channel}") }.as_str());
        let channels = [
            AnyChannel::new(name("R"), FlatSamples::F16((0..99).map(|i| f16::from_f32(float(i))).collect())),
            AnyChannel::new(name("G"), FlatSamples::F32((0..99).map(float).collect())),
            AnyChannel::new(name("B"), FlatSamples::U32((0..99).collect())),
        ];
        let mut attributes = LayerAttributes::named(format!("part {k}").as_str());
        attributes.layer_position = Vec2(k as i32, -(k as i32));
        Layer { channel_data: AnyChannels::sort(channels.into_iter().collect()), attributes, size, encoding }
    };
    let attributes = ImageAttributes::with_size(size);
    let mut file = Cursor::new(Vec::new());
    let layers = (0..parts).map(part).collect::<Layers<_>>();
    Image { attributes, layer_data: layers }.write().non_parallel().to_buffered(&mut file).unwrap();
    file.into_inner()
}

const PROGRESSIVE_COLOR: &str = "/9j/4AAQSkZJRgABAgAAAQABAAD/wgARCAARABQDACIAAREBAhEB/9sAQwAbEhQXFBEbFxYXHhwbIChCKyglJShROj0wQmBVZWRfVV1baniZgWpxkHNbXYW1hpCeo6utq2eAvMm6pseZqKuk/9sAQwEcHh4oIyhOKytOpG5dbqSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSk/8QAGAAAAwEBAAAAAAAAAAAAAAAAAAECAwX/xAArEAACAQIBCQkAAAAAAAAAAAABEQAhMQIDEhMyQWFxkfAiM0NRYnKBsfH/xAAXAQADAQAAAAAAAAAAAAAAAAAAAQIE/8QAHBEBAAEEAwAAAAAAAAAAAAAAAAECAyExMkFh/9oACAEAAAAAAOY1YaZx/9oACAEBEQAAABJ//9oACAECEQAAACa1f//aAAgBAAABFAAgLOXZuoiQVreYgwDF4mYqIBEEsVhwgG9LMw6K+Vwlmt9g9xmDuTwEymseJn//2gAIAQERARQAjOmel7gq2//aAAgBAhEBFAD1Pqjta4Q//9oACAEAABUpAF1RV/Y2b/bWyEdV3iekzeZ//9oACAEBERUpAED/2gAIAQIRFSkAD//aAAgBAAAqPwB8oucjHzEY5JP/2gAIAQERKj8AD//aAAgBAhEqPwAP/9k=";

const PROGRESSIVE_GREY: &str = "/9j/4AAQSkZJRgABAgAAAQABAAD/wgALCAARABQBABEA/9sAQwAbEhQXFBEbFxYXHhwbIChCKyglJShROj0wQmBVZWRfVV1baniZgWpxkHNbXYW1hpCeo6utq2eAvMm6pseZqKuk/9sAQwEcHh4oIyhOKytOpG5dbqSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSkpKSk/8QAGAAAAwEBAAAAAAAAAAAAAAAAAQIDBAX/xAAnEAABBAEBBgcAAAAAAAAAAAABAAIDESEEIjE0QWGxEzNxcoHh8P/dAAQAAv/aAAgBAAAAAADmr//Q5o//0ebH/9Llt//Tn//aAAgBAAABFABgEWpcyth2QComEtk0535Atf/QhlLY6NgjBBUpuOOUb2mjj//RktszJQMPFErVHw5jVU/aC//SHAv+FLwsfvC//9PT+UF//9oACAEAABUpAMUVXoV//9Bcl//R5j6/c//S6hdCv//TX//aAAgBAAAqPwC0v//QXdf/0eytf//SS//TX//Z";
