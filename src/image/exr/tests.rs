use super::*;
use crate::image::Image;
use crate::math::Rgb;
use ::exr::prelude::{SampleType, f16};
use proptest::prelude::*;
use std::path::PathBuf;
use tempfile::TempDir;

/// Different values everywhere, some of them awkward.
fn ramp(width: usize, height: usize, start: f32) -> Image {
    let at = |i: usize| Rgb::new(start + i as f32, -0.1 * i as f32, 1e-30 / (1.0 + i as f32));
    Image { width, height, data: (0..width * height).map(at).collect() }
}

fn layers(width: usize, height: usize) -> Vec<Layer> {
    let pixels = width * height;
    vec![
        Layer::color("", &ramp(width, height, 1.5).data),
        Layer::vector("N", &ramp(width, height, 9.0).data),
        Layer::scalar("Z", "", (0..pixels).map(|i| i as f32).collect()),
        Layer::scalar("samples", "Y", vec![64.0; pixels]),
    ]
}

fn metadata() -> Metadata {
    let extra = [
        ("note".to_owned(), Attribute::Text("Umlaut ä".to_owned())),
        ("trainingIterations".to_owned(), Attribute::Int(-7)),
        ("guidingTime".to_owned(), Attribute::Float(0.25)),
    ];
    Metadata {
        scene_hash: "0123abcd".to_owned(),
        samples_per_pixel: 64,
        render_time_seconds: 12.5,
        seed: u64::MAX,
        extra: extra.into_iter().collect(),
    }
}

/// A file in a folder that lives as long as the first value.
fn place_for(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn round_trip(window: &Window, layers: Vec<Layer>) -> ExrFile {
    let (_folder, path) = place_for("picture.exr");
    write(&path, window, layers, &metadata()).unwrap();
    read_layers(&path).unwrap()
}

#[test]
fn pixels_and_metadata_survive() {
    let file = round_trip(&Window::full(37, 19), layers(37, 19));
    assert_eq!((file.width, file.height), (37, 19));
    let names: Vec<&str> = file.channels.keys().map(String::as_str).collect();
    assert_eq!(names, ["B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "samples.Y"]);
    for layer in layers(37, 19) {
        for (suffix, values) in &layer.channels {
            assert_eq!(&file.channels[&layer.channel_name(suffix)], values);
        }
    }
    let mut wanted = metadata().extra;
    wanted.insert("sceneHash".to_owned(), Attribute::Text("0123abcd".to_owned()));
    wanted.insert("samplesPerPixel".to_owned(), Attribute::Int(64));
    wanted.insert("renderTimeSeconds".to_owned(), Attribute::Float(12.5));
    wanted.insert("seed".to_owned(), Attribute::Text("18446744073709551615".to_owned()));
    let version = format!("phototaxis {}", env!("CARGO_PKG_VERSION"));
    wanted.insert("generatedBy".to_owned(), Attribute::Text(version));
    assert_eq!(file.attributes, wanted);
}

#[test]
fn the_file_is_one_part_of_sorted_floats_in_zip() {
    let (_folder, path) = place_for("picture.exr");
    write(&path, &Window::full(5, 40), layers(5, 40), &metadata()).unwrap();
    let meta = ::exr::meta::MetaData::read_from_file(&path, true).unwrap();
    assert_eq!(meta.headers.len(), 1);
    let header = &meta.headers[0];
    assert_eq!(header.compression, Compression::ZIP16);
    assert!(header.channels.list.iter().all(|channel| channel.sample_type == SampleType::F32));
    assert!(header.channels.list.is_sorted_by_key(|channel| channel.name.clone()));
}

#[test]
fn a_stored_part_lies_where_it_was_cut_from() {
    let window = Window { width: 6, height: 5, left: 2, top: 1, stored_width: 3, stored_height: 2 };
    let part = ramp(3, 2, 1.5);
    let file = round_trip(&window, vec![Layer::color("", &part.data)]);
    assert_eq!((file.width, file.height), (6, 5));
    for (y, x) in (0..5).flat_map(|y| (0..6).map(move |x| (y, x))) {
        let stored = (2..5).contains(&x) && (1..3).contains(&y);
        let wanted = if stored { part.pixel(x - 2, y - 1).x } else { 0.0 };
        assert_eq!(file.channels["R"][y * 6 + x], wanted, "column {x}, row {y}");
    }
}

#[test]
fn what_is_stored_outside_of_the_picture_is_cut_off() {
    let stored = |left, top| Window { width: 2, height: 2, left, top, stored_width: 4, stored_height: 3 };
    let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
    let read = |window| {
        let layer = Layer::scalar("Z", "", values.clone());
        round_trip(&window, vec![layer]).channels["Z"].clone()
    };
    assert_eq!(read(stored(-1, -1)), [5.0, 6.0, 9.0, 10.0]);
    assert_eq!(read(stored(1, 1)), [0.0, 0.0, 0.0, 0.0]);
    assert_eq!(read(stored(-3, 0)), [3.0, 0.0, 7.0, 0.0]);
    assert_eq!(read(stored(5, -9)), [0.0; 4]);
}

#[test]
fn what_cannot_be_stored_is_refused_and_leaves_the_old_file() {
    let (_folder, path) = place_for("picture.exr");
    std::fs::write(&path, "old").unwrap();
    let refusal = |window: &Window, layers, metadata: &Metadata| {
        let error = write(&path, window, layers, metadata).unwrap_err().to_string();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        error
    };
    let window = Window::full(2, 2);
    let depth = |name: &str, count| Layer::scalar(name, "", vec![0.0; count]);
    let plain = Metadata::default();
    let error = refusal(&window, vec![depth("Z", 5)], &plain);
    assert!(error.contains("channel Z has 5 values for 4 pixels"), "{error}");
    let error = refusal(&window, vec![depth("Z", 4), depth("Z", 4)], &plain);
    assert!(error.contains("channel Z occurs twice"), "{error}");
    for name in ["", "tie\0fe", "größe", &"long".repeat(64)] {
        let error = refusal(&window, vec![depth(name, 4)], &plain);
        assert!(error.contains("cannot name a channel"), "{error}");
    }
    refusal(&Window::full(0, 2), vec![depth("Z", 0)], &plain);
    for (name, why) in [("seed", "occurs twice"), ("compression", "reserved"), ("\n", "name a")] {
        let extra = BTreeMap::from([(name.to_owned(), Attribute::Int(1))]);
        let metadata = Metadata { extra, ..Metadata::default() };
        let error = refusal(&window, vec![depth("Z", 4)], &metadata);
        assert!(error.contains(why), "{error}");
    }
    let many = Metadata { samples_per_pixel: 1 << 31, ..Metadata::default() };
    refusal(&window, vec![depth("Z", 4)], &many);
}

/// A file of several parts and sample types, as other programs write them.
fn write_foreign(path: &Path, compression: Compression) {
    let encoding =
        file::Encoding { compression, blocks: file::Blocks::Tiles(Vec2(16, 16)), line_order: LineOrder::Increasing };
    let part = |name: &str, channels: Vec<(&str, file::FlatSamples)>| file::Layer {
        channel_data: file::AnyChannels::sort(
            channels.into_iter().map(|(name, data)| file::AnyChannel::new(name, data)).collect(),
        ),
        attributes: LayerAttributes::named(name),
        size: Vec2(20, 20),
        encoding,
    };
    let halves = (0..400).map(|i| f16::from_f32(i as f32 / 4.0)).collect();
    let parts = vec![
        part("beauty", vec![("R", file::FlatSamples::F16(halves))]),
        part(
            "id",
            vec![("Y", file::FlatSamples::U32((0..400).collect())), ("id.A", file::FlatSamples::F32(vec![0.5; 400]))],
        ),
    ];
    let attributes = ImageAttributes::with_size((20, 20));
    file::Image { attributes, layer_data: parts.into_iter().collect::<file::Layers<_>>() }
        .write()
        .to_file(path)
        .unwrap();
}

#[test]
fn halves_integers_tiles_and_parts_are_read() {
    let (_folder, path) = place_for("foreign.exr");
    for compression in [Compression::PIZ, Compression::RLE, Compression::Uncompressed] {
        write_foreign(&path, compression);
        let file = read_layers(&path).unwrap();
        let names: Vec<&str> = file.channels.keys().map(String::as_str).collect();
        assert_eq!(names, ["R", "id.A", "id.Y"]);
        for i in 0..400 {
            assert_eq!(file.channels["R"][i], i as f32 / 4.0);
            assert_eq!(file.channels["id.Y"][i], i as f32);
        }
        assert_eq!(file.channels["id.A"], [0.5; 400]);
    }
    let error = read_rgb(&path).unwrap_err().to_string();
    assert!(error.ends_with("foreign.exr: lacks channel G, B; has R, id.A, id.Y"), "{error}");
}

#[test]
fn limits_hold_before_memory_is_taken() {
    let (_folder, path) = place_for("big.exr");
    let part = |width, height| Window { width, height, left: 0, top: 0, stored_width: 2, stored_height: 2 };
    let error = |window: &Window| {
        let depth = Layer::scalar("Z", "", vec![0.0; 4]);
        write(&path, window, vec![depth], &Metadata::default()).unwrap();
        read_layers(&path).unwrap_err().to_string()
    };
    assert!(error(&part(65_537, 2)).contains("no side may exceed 65536"));
    assert!(error(&part(65_536, 65_536)).contains("at most 4096 MiB"));
    write(&path, &Window::full(8, 8), layers(8, 8), &metadata()).unwrap();
    // Eight channels of 64 floats.
    assert!(read_limited(&path, 8 * 64 * 4).is_ok());
    assert!(read_limited(&path, 8 * 64 * 4 - 1).is_err());
}

#[test]
fn files_that_are_not_there_or_not_exr_are_named() {
    let (folder, path) = place_for("text.exr");
    std::fs::write(&path, "no picture at all").unwrap();
    for path in [path, folder.path().join("missing.exr"), folder.path().to_path_buf()] {
        let error = read_layers(&path).unwrap_err().to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
    }
}

#[test]
fn references_of_the_scenes_are_read() {
    let Some(references) = crate::image::tests::scene_files("reference.exr") else { return };
    for path in references {
        let file = read_layers(&path).unwrap();
        let image = read_rgb(&path).unwrap();
        assert_eq!((file.width, file.height), (image.width, image.height));
        assert!(image.data.iter().all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0));
        assert!(file.channels["variance.G"].iter().all(|&variance| variance >= 0.0));
        assert!(image.data.iter().any(|pixel| pixel.y > 0.0), "{} is black", path.display());
    }
}

/// The bytes of a small file.
fn packed(packing: Packing) -> Vec<u8> {
    pack(&Window::full(20, 20), layers(20, 20), &metadata(), packing).0.unwrap()
}

#[test]
fn a_loosely_packed_file_holds_the_same() {
    let (_folder, path) = place_for("loose.exr");
    let [tight, loose] = [Packing::Tight, Packing::Loose].map(|packing| {
        std::fs::write(&path, packed(packing)).unwrap();
        read_layers(&path).unwrap()
    });
    assert!(tight.channels == loose.channels && tight.attributes == loose.attributes);
    assert!(packed(Packing::Loose).len() > packed(Packing::Tight).len());
}

/// Puts other numbers into the attribute of that name and type.
fn forge(file: &mut [u8], attribute: &str, numbers: &[i32]) {
    let head = [attribute.as_bytes(), &(4 * numbers.len() as i32).to_le_bytes()].concat();
    let at = file.windows(head.len()).position(|part| part == head).expect("the header has it") + head.len();
    for (to, number) in file[at..].chunks_exact_mut(4).zip(numbers) {
        to.copy_from_slice(&number.to_le_bytes());
    }
}

#[test]
fn sizes_that_a_file_cannot_hold_are_refused_before_memory_is_asked_for() {
    let (_folder, path) = place_for("claim.exr");
    let mut bytes = packed(Packing::Tight);
    forge(&mut bytes, "dataWindow\0box2i\0", &[0, 0, 7999, 7999]);
    forge(&mut bytes, "displayWindow\0box2i\0", &[0, 0, 7999, 7999]);
    forge(&mut bytes, "chunkCount\0int\0", &[7999 / 16 + 1]);
    std::fs::write(&path, &bytes).unwrap();
    // 8 channels of 4 bytes, by the 1032 of DEFLATE
    let error = read_layers(&path).unwrap_err().to_string();
    assert!(error.contains("claim.exr: damaged: its pixels need at least 1.89 MiB, and the file has "), "{error}");
}

#[test]
fn what_a_file_can_hold_at_most_is_never_less_than_what_writers_put_there() {
    let (_folder, path) = place_for("dense.exr");
    let pixels = 512 * 512;
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ] {
        let encoding =
            file::Encoding { compression, blocks: file::Blocks::ScanLines, line_order: LineOrder::Increasing };
        let channels = [
            file::AnyChannel::new("R", file::FlatSamples::F16(vec![f16::ONE; pixels])),
            file::AnyChannel::new("G", file::FlatSamples::F32(vec![1.0; pixels])),
            file::AnyChannel::new("B", file::FlatSamples::U32(vec![0; pixels])),
        ];
        let channels = file::AnyChannels::sort(channels.into_iter().collect());
        let layer = file::Layer::new((512, 512), LayerAttributes::named("flat"), encoding, channels);
        file::Image::from_layer(layer).write().to_file(&path).unwrap();
        let file = read_layers(&path).unwrap_or_else(|error| panic!("{compression:?}: {error}"));
        assert!(file.channels["G"].iter().all(|&g| g == 1.0));
    }
}

/// Valid files of our own and of others, to be damaged.
fn valid_files() -> Vec<Vec<u8>> {
    let (_folder, path) = place_for("valid.exr");
    let mut files = vec![packed(Packing::Tight)];
    for compression in [Compression::PIZ, Compression::PXR24, Compression::B44] {
        write_foreign(&path, compression);
        files.push(std::fs::read(&path).unwrap());
    }
    files
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn noise_never_panics(noise in proptest::collection::vec(any::<u8>(), 0..600), valid_start in any::<bool>()) {
        let (_folder, path) = place_for("noise.exr");
        let mut bytes = if valid_start { valid_files()[0][..300].to_vec() } else { Vec::new() };
        bytes.extend(noise);
        std::fs::write(&path, bytes).unwrap();
        prop_assert!(read_limited(&path, 1 << 24).is_err());
    }

    #[test]
    fn damage_never_panics(damage in proptest::collection::vec(any::<(prop::sample::Index, u8)>(), 1..20), cut in any::<Option<prop::sample::Index>>()) {
        let (_folder, path) = place_for("damaged.exr");
        for mut bytes in valid_files() {
            for (at, value) in &damage {
                let at = at.index(bytes.len());
                bytes[at] = *value;
            }
            if let Some(cut) = &cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            std::fs::write(&path, bytes).unwrap();
            if let Err(error) = read_limited(&path, 1 << 24) {
                prop_assert!(error.to_string().contains("damaged.exr"));
            }
        }
    }
}
