use super::*;
use crate::geometry::mesh::ABSENT;
use crate::image::srgb;
use crate::math::rng::Rng;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use std::io::Cursor;

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

fn parsed(bytes: &[u8]) -> Result<Model> {
    parse(Source::Memory(bytes.into()), Path::new("a.ply"), Wanted::Any)
}

/// A file while it is written.
struct Writer {
    format: &'static str,
    bytes: Vec<u8>,
}

impl Writer {
    /// The header is `header`, after its line `format`.
    fn new(format: &'static str, header: &str) -> Writer {
        Writer { format, bytes: format!("ply\nformat {format} 1.0\n{header}end_header\n").into_bytes() }
    }

    /// A thing: its numbers with their types.
    fn put(&mut self, numbers: &[(&str, f64)]) {
        for &(kind, x) in numbers {
            if self.format == "ascii" {
                self.bytes.extend(format!("{x} ").bytes());
                continue;
            }
            let mut number = match kind {
                "char" => (x as i8).to_le_bytes().to_vec(),
                "uchar" => (x as u8).to_le_bytes().to_vec(),
                "short" => (x as i16).to_le_bytes().to_vec(),
                "ushort" => (x as u16).to_le_bytes().to_vec(),
                "int" => (x as i32).to_le_bytes().to_vec(),
                "uint" => (x as u32).to_le_bytes().to_vec(),
                "float" => (x as f32).to_le_bytes().to_vec(),
                _ => x.to_le_bytes().to_vec(),
            };
            if self.format == "binary_big_endian" {
                number.reverse();
            }
            self.bytes.append(&mut number);
        }
        if self.format == "ascii" {
            self.bytes.push(b'\n');
        }
    }

    fn load(&self) -> Result<Model> {
        parsed(&self.bytes)
    }
}

/// A file of vertices that are numbers of one type, and one triangle of the first three.
fn of_vertices(format: &'static str, properties: &[&str], kind: &str, vertices: &[&[f64]]) -> Writer {
    let lines: String = properties.iter().map(|name| format!("property {kind} {name}\n")).collect();
    let header =
        format!("element vertex {}\n{lines}element face 1\nproperty list uchar int vertex_indices\n", vertices.len());
    let mut writer = Writer::new(format, &header);
    for vertex in vertices {
        writer.put(&vertex.iter().map(|&x| (kind, x)).collect::<Vec<_>>());
    }
    writer.put(&[("uchar", 3.0), ("int", 0.0), ("int", 1.0), ("int", 2.0)]);
    writer
}

/// Every type of number, elements and lists that mean nothing here, a triangle, a quadrilateral and a concave pentagon.
fn everything(format: &'static str) -> Writer {
    let mut w = Writer::new(
        format,
        "comment made by hand\nobj_info nothing\n\
         element camera 2\nproperty list ushort short views\nproperty int8 zoom\n\
         element vertex 6\nproperty uint8 red\nproperty double z\nproperty list uchar double extra\nproperty float nx\nproperty \
         float ny\nproperty float nz\nproperty float x\nproperty int16 y\nproperty uchar green\nproperty uchar blue\nproperty uint t\n\
         property float s\n\
         element face 4\nproperty int16 flags\nproperty list uint32 ushort vertex_index\nproperty list uchar float weights\n\
         element edge 1\nproperty int a\n",
    );
    w.put(&[("ushort", 2.0), ("short", -7.0), ("short", 300.0), ("char", -1.0)]);
    w.put(&[("ushort", 0.0), ("char", 5.0)]);
    for (k, [x, y, z]) in
        [[0.0, 0.0, 0.5], [4.0, 0.0, 0.5], [4.0, 4.0, 0.5], [2.0, 1.0, 0.5], [0.0, 4.0, 0.5], [9.0, -9.0, 0.25]]
            .into_iter()
            .enumerate()
    {
        w.put(&[("uchar", 51.0 * k as f64), ("double", z)]);
        if format == "ascii" {
            w.bytes.pop();
        }
        w.put(&[
            ("uchar", 1.0),
            ("double", 1e300),
            ("float", 0.0),
            ("float", 0.0),
            ("float", 2.0),
            ("float", x),
            ("short", y),
        ]);
        if format == "ascii" {
            w.bytes.pop();
        }
        w.put(&[("uchar", 255.0), ("uchar", 0.0), ("uint", k as f64), ("float", 0.125)]);
    }
    for face in [&[0.0, 1.0, 5.0][..], &[1.0, 2.0, 4.0, 3.0], &[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0, 1.0]] {
        let mut numbers = vec![("short", -1.0), ("uint", face.len() as f64)];
        numbers.extend(face.iter().map(|&index| ("ushort", index)));
        numbers.extend([("uchar", 1.0), ("float", 0.5)]);
        w.put(&numbers);
    }
    w.put(&[("int", 1.0)]);
    w
}

#[test]
fn all_encodings_say_the_same() {
    for format in FORMATS {
        let Model { mesh, origin, material_names, materials, warnings, .. } = everything(format).load().unwrap();
        assert_eq!(mesh.positions[5], [9.0, -9.0, 0.25], "{format}");
        assert_eq!(mesh.positions[3], [2.0, 1.0, 0.5]);
        assert_eq!(mesh.triangles[..3], [[0, 1, 5], [1, 2, 4], [1, 4, 3]], "{format}");
        assert_eq!(mesh.triangles.len(), 1 + 2 + 3, "the concave pentagon is three, and two corners are none");
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| glam::Vec3::from(mesh.positions[i as usize]));
            0.5 * (b - a).cross(c - a).z
        };
        assert_eq!(mesh.triangles[3..].iter().map(area).sum::<f32>(), 16.0 - 6.0);
        assert!(mesh.triangles[3..].iter().all(|t| area(t) > 0.0));
        let normals = mesh.normals.as_ref().unwrap();
        assert_eq!((normals.values[1], &normals.indices), ([0.0, 0.0, 2.0], &Indices::OfPositions));
        assert_eq!(mesh.uvs.as_ref().unwrap().values[4], [0.125, 4.0]);
        assert_eq!(mesh.colors.as_ref().unwrap().values()[2], [srgb::DECODE_8[102], 1.0, 0.0]);
        assert_eq!(mesh.materials, vec![0; 6]);
        assert_eq!((origin, &material_names[..], materials.len()), (DVec3::ZERO, &[String::new()][..], 0));
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn truncated_files_are_refused_at_a_byte_or_a_line() {
    for format in FORMATS {
        let whole = everything(format).bytes;
        let body = memchr::memmem::find(&whole, b"end_header\n").unwrap() + 11;
        for length in 0..whole.len() - 1 {
            let loaded = parsed(&whole[..length]);
            // the last line of numbers may lose digits and still be one
            let digits = format == "ascii" && length >= whole.len() - 3;
            assert!(digits || loaded.is_err(), "{format}: {length} of {} bytes", whole.len());
            let Err(error) = loaded else { continue };
            let message = error.to_string();
            let place = if format == "ascii" || length < body { "a.ply:" } else { "a.ply: byte " };
            assert!(message.starts_with(place), "{message}");
        }
    }
}

#[test]
fn random_damage_never_panics() {
    let mut rng = Rng::new(7);
    for format in FORMATS {
        let whole = everything(format).bytes;
        for _ in 0..20_000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + rng.next_u32() % 4 {
                let at = rng.next_u32() as usize % bytes.len();
                bytes[at] = rng.next_u32() as u8;
            }
            _ = parsed(&bytes).map(drop);
        }
    }
}

#[test]
fn texture_coordinates_go_by_many_names() {
    for names in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]] {
        let properties = [names[1], "x", "y", "z", names[0]];
        let vertices: [&[f64]; 3] =
            [&[0.5, 0.0, 0.0, 0.0, 0.25], &[0.0, 1.0, 0.0, 0.0, 1.0], &[0.0, 0.0, 1.0, 0.0, 1.0]];
        let model = of_vertices("binary_big_endian", &properties, "float", &vertices).load().unwrap();
        assert_eq!(model.mesh.uvs.unwrap().values[0], [0.25, 0.5]);
    }
}

#[test]
fn whole_colours_are_srgb_and_fractions_are_linear() {
    let colors = |kind, scale: f64| {
        let vertices: Vec<Vec<f64>> = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
            .iter()
            .map(|[x, y]| vec![*x, *y, 0.0, 0.2 * scale, 0.6 * scale, scale])
            .collect();
        let vertices: Vec<&[f64]> = vertices.iter().map(Vec::as_slice).collect();
        let properties = ["x", "y", "z", "red", "green", "blue"];
        of_vertices("binary_little_endian", &properties, kind, &vertices).load().unwrap().mesh.colors
    };
    let srgb = [0.2, 0.6, 1.0].map(srgb::decode);
    for (kind, scale, wanted) in
        [("uchar", 255.0, srgb), ("ushort", 65535.0, srgb), ("int", 255.0, srgb), ("double", 1.0, [0.2, 0.6, 1.0])]
    {
        let found = colors(kind, scale).unwrap().values()[1];
        assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 1e-6), "{kind}: {found:?}");
    }
    let white: Vec<&[f64]> = vec![&[0.0, 0.0, 0.0, 255.0, 255.0, 255.0]; 3];
    let model = of_vertices("ascii", &["x", "y", "z", "red", "green", "blue"], "uchar", &white).load().unwrap();
    assert_eq!(model.mesh.colors, None, "white throughout says nothing");
}

#[test]
fn faces_may_have_coordinates_of_their_own_and_a_comment_a_picture() {
    for format in FORMATS {
        let header = "comment TextureFile my skin.png\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 3\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n";
        let mut w = Writer::new(format, header);
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            w.put(&[("float", x), ("float", y), ("float", 0.0)]);
        }
        let int = |x: f64| ("int", x);
        let uv = |x: f64| ("float", x);
        w.put(&[
            ("uchar", 3.0),
            int(0.0),
            int(1.0),
            int(2.0),
            ("uchar", 6.0),
            uv(0.5),
            uv(0.0),
            uv(1.0),
            uv(0.0),
            uv(1.0),
            uv(0.25),
        ]);
        w.put(&[("uchar", 3.0), int(0.0), int(2.0), int(3.0), ("uchar", 0.0)]);
        w.put(
            &[("uchar", 4.0), int(0.0), int(1.0), int(2.0), int(3.0), ("uchar", 8.0)]
                .into_iter()
                .chain([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7].map(uv))
                .collect::<Vec<_>>(),
        );
        let model = w.load().unwrap();
        let uvs = model.mesh.uvs.as_ref().unwrap();
        assert_eq!(uvs.corners(&model.mesh.triangles, 0), Some([[0.5, 0.0], [1.0, 0.0], [1.0, 0.25]]), "{format}");
        assert_eq!(uvs.corners(&model.mesh.triangles, 1), None);
        assert_eq!(uvs.corners(&model.mesh.triangles, 3).unwrap()[2], [0.6, 0.7]);
        let crate::bsdf::BsdfDescription::Diffuse(diffuse) = &model.materials[""].bsdf else { panic!() };
        assert_eq!(diffuse.reflectance, ColorTexture::Image(ImageTexture::new("my skin.png".into())));
    }
}

/// Three vertices with an attribute of one number and a colour, a triangle, and a quadrilateral, with two attributes.
fn painted(format: &'static str, vertex_color: f64) -> Writer {
    let header = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float heat_x\n\
                  property uchar red\nproperty uchar green\nproperty uchar blue\n\
                  element face 2\nproperty uchar red\nproperty list uchar int vertex_indices\nproperty uchar green\n\
                  property uchar blue\nproperty uchar alpha\nproperty double tone_0\nproperty double tone_1\nproperty double tone_2\nproperty float mark_r\n";
    let mut w = Writer::new(format, header);
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        let heat = 0.25 + 0.5 * x;
        w.put(&[
            ("float", x),
            ("float", y),
            ("float", 0.0),
            ("float", heat),
            ("uchar", vertex_color),
            ("uchar", 255.0),
            ("uchar", 255.0),
        ]);
    }
    for (corners, shade) in [(&[0.0, 1.0, 2.0][..], 102.0), (&[0.0, 1.0, 2.0, 3.0], 204.0)] {
        let mut face = vec![("uchar", shade), ("uchar", corners.len() as f64)];
        face.extend(corners.iter().map(|&corner| ("int", corner)));
        face.extend([("uchar", 0.0), ("uchar", 255.0), ("uchar", 7.0)]);
        face.extend([("double", shade / 408.0), ("double", 0.75), ("double", 2.0), ("float", 0.5)]);
        w.put(&face);
    }
    w
}

#[test]
fn colours_may_be_of_faces_and_attributes_have_names() {
    for format in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        std::fs::write(&path, painted(format, 51.0).bytes).unwrap();
        let named = |name: &str| load_with(&path, name).map(|model| model.mesh.colors.unwrap());
        let [dark, bright] = [102, 204].map(|stored: usize| [srgb::DECODE_8[stored], 0.0, 1.0]);
        let of_faces = MeshColors::OfFaces(vec![dark, bright, bright]);
        assert_eq!(
            painted(format, 255.0).load().unwrap().mesh.colors.unwrap(),
            of_faces,
            "{format}: white says nothing"
        );
        let of_vertices = MeshColors::OfVertices(vec![[srgb::DECODE_8[51], 1.0, 1.0]; 4]);
        assert_eq!(painted(format, 51.0).load().unwrap().mesh.colors.unwrap(), of_vertices, "{format}");
        assert_eq!(named("face_color").unwrap(), of_faces, "{format}");
        assert_eq!(named("vertex_color").unwrap(), of_vertices, "{format}");
        let tones = vec![[0.25, 0.75, 1.0], [0.5, 0.75, 1.0], [0.5, 0.75, 1.0]];
        assert_eq!(named("face_tone").unwrap(), MeshColors::OfFaces(tones), "{format}");
        assert_eq!(named("face_mark_color").unwrap(), MeshColors::OfFaces(vec![[0.5; 3]; 3]), "{format}");
        let heat = [0.25, 0.75, 0.75, 0.25].map(|grey| [grey; 3]);
        assert_eq!(named("vertex_heat").unwrap(), MeshColors::OfVertices(heat.to_vec()), "{format}");
        for name in ["face_heat", "vertex_tone", "face_mark", "heat", "vertex_", "face_x"] {
            let message = named(name).unwrap_err().to_string();
            assert!(message.contains(&format!("a.ply: there is no attribute `{name}`")), "{format}: {message}");
        }
    }
}

/// Faces with the colour of their number, of so many corners each.
fn striped(corners: &[usize]) -> Writer {
    let header = format!(
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nproperty float red\nproperty float green\nproperty float blue\n\
         element edge 9\nproperty double a\n",
        corners.len()
    );
    let mut w = Writer::new("binary_little_endian", &header);
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        w.put(&[("float", x), ("float", y), ("float", 0.0)]);
    }
    for (k, &count) in corners.iter().enumerate() {
        let mut face = vec![("uchar", count as f64)];
        face.extend((0..count).map(|corner| ("int", corner as f64)));
        face.extend([("float", k as f64 / 16.0); 3]);
        w.put(&face);
    }
    (0..9).for_each(|k| w.put(&[("double", f64::from(k))]));
    w
}

/// Faces are taken to be as long as the first; where they are not, they are looked at one by one.
#[test]
fn colours_are_those_of_their_faces_whatever_faces_are_like() {
    for corners in [&[3, 3, 3][..], &[4, 4, 4], &[4, 3, 3, 3], &[3, 4, 3, 2, 3], &[3, 2, 4]] {
        let mesh = striped(corners).load().unwrap().mesh;
        let expected = corners.iter().enumerate().flat_map(|(k, &count)| vec![[k as f32 / 16.0; 3]; count - 2]);
        assert_eq!(mesh.colors.unwrap(), MeshColors::OfFaces(expected.collect()), "{corners:?}");
    }
}

#[test]
fn faults_are_named_with_their_place() {
    let body = |properties: &str, body: &str| format!("ply\nformat ascii 1.0\n{properties}end_header\n{body}");
    let mesh = |faces: &str, numbers: &str| {
        let header =
            format!("element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n{faces}");
        body(&header, &format!("0 0 0\n1 0 0\n\n0 1 0\n{numbers}"))
    };
    let indices = "property list uchar int vertex_indices\n";
    let cases = [
        ("obj\n".to_string(), "a.ply:1: not a PLY file"),
        ("ply\nformat ascii 1.0\n".to_string(), "a.ply:2: the header has no end"),
        ("ply\nend_header\n".to_string(), "a.ply:2: the header does not say its `format`"),
        ("ply\nformat ascii 2.0\n".to_string(), "a.ply:2: version 2.0"),
        ("ply\nformat xml 1.0\n".to_string(), "a.ply:2: unknown format `xml`"),
        (body("property float x\n", ""), "a.ply:3: the property `x` belongs to no element"),
        (body("element vertex -1\n", ""), "a.ply:3: `-1` is not a number of elements"),
        (body("element vertex 1\nelement vertex 1\n", ""), "a.ply:4: there are two elements `vertex`"),
        (body("element vertex 1\nproperty float x\nproperty float x\n", ""), "a.ply:5: there are two properties `x`"),
        (body("element vertex 1\nproperty half x\n", ""), "a.ply:4: unknown type `half`"),
        (body("element vertex 1\nproperty list float int x\n", ""), "a.ply:4: the length of the list `x`"),
        (body("whatever\n", ""), "a.ply:3: `whatever` is no line"),
        (body("element vertex 1\nproperty float x\nproperty float z\n", "0 0\n"), "a.ply: vertices have no `y`"),
        (body("", ""), "a.ply: there are no vertices"),
        (body("element tristrips 1\nproperty list int int a\n", "1 1\n"), "a.ply: strips of triangles"),
        (mesh("property int a\n", "0\n"), "a.ply: faces have no list"),
        (mesh("property list uchar float vertex_indices\n", "3 0 1 2\n"), "a.ply: `vertex_indices` must be whole"),
        (mesh(indices, "3 0 1\n"), "a.ply:14: `face` 0 of 1: the line ends here"),
        (mesh(indices, "3 0 1 2 7\n"), "a.ply:14: `face` 0 of 1: more numbers"),
        (mesh(indices, "3 0 1 3\n"), "a.ply:14: `face` 0 of 1: there is no vertex 3: the file has 3"),
        (mesh(indices, "3 0 1 -1\n"), "there is no vertex -1"),
        (mesh(indices, "3 0 1 0.5\n"), "there is no vertex 0.5"),
        (mesh(indices, "-3 0 1 2\n"), "a.ply:14: `face` 0 of 1: -3 is not the length"),
        (mesh(indices, "3 0 one 2\n"), "a.ply:14: `face` 0 of 1: `one` is not a number"),
        (mesh(indices, ""), "a.ply:14: `face` 0 of 1: the file ends here"),
        (mesh(indices, "3 0 1 2\n").replace("1 0 0\n", "1 nan 0\n"), "a.ply:11: vertex 1 is not finite"),
    ];
    for (text, wanted) in cases {
        let message = parsed(text.as_bytes()).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}\nis not\n{wanted}\nof\n{text}");
    }
    let mut binary = of_vertices(
        "binary_little_endian",
        &["x", "y", "z"],
        "float",
        &[&[0.0; 3], &[1.0; 3], &[f64::INFINITY, 0.0, 0.0]],
    );
    let start = memchr::memmem::find(&binary.bytes, b"end_header\n").unwrap() + 11;
    let message = binary.load().unwrap_err().to_string();
    assert_eq!(
        message,
        format!("a.ply: byte {}: vertex 2 is not finite or beyond 1e12, and a face uses it", start + 24)
    );
    binary.bytes.truncate(start + 30);
    let message = binary.load().unwrap_err().to_string();
    assert_eq!(message, format!("a.ply: byte {}: the file ends in `vertex` 2 of 3", start + 24));
}

#[test]
fn line_ends_of_all_systems_are_read() {
    let text = String::from_utf8(everything("ascii").bytes).unwrap();
    let wanted = everything("ascii").load().unwrap().mesh;
    for ending in ["\r\n", "\r", "\n\n"] {
        let ended = text.replace('\n', if ending == "\n\n" { "\n" } else { ending });
        // empty lines may stand between numbers, not in the header
        let ended = match (ending, ended.split_once("end_header\n")) {
            ("\n\n", Some((header, body))) => format!("{header}end_header\n{}", body.replace('\n', "\n\n")),
            _ => ended,
        };
        let mesh = parsed(ended.as_bytes()).unwrap().mesh;
        assert_eq!(
            (mesh.positions, mesh.triangles),
            (wanted.positions.clone(), wanted.triangles.clone()),
            "{ending:?}"
        );
    }
}

#[test]
fn what_no_face_uses_may_be_broken() {
    let nan = f64::NAN;
    let properties = ["x", "y", "z", "nx", "ny", "nz", "s", "t"];
    let vertices: [&[f64]; 4] = [
        &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        &[nan, 1e30, 0.0, nan, 0.0, 1.0, nan, 0.0],
    ];
    for format in FORMATS {
        let model = of_vertices(format, &properties, "double", &vertices).load().unwrap();
        let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
        let wanted = [
            "a.ply: 1 vertices are not finite or beyond 1e12, but no face uses them",
            "a.ply: 2 normals have no direction; 1 triangles go without",
            "a.ply: 1 texture coordinates are not finite; 0 triangles go without",
        ];
        assert_eq!(warnings, wanted);
        assert!(model.mesh.normals.is_none());
        assert_eq!(model.mesh.uvs.unwrap().indices, Indices::Own(vec![[0, 1, 2]]));
        assert_eq!(model.mesh.positions[3], [0.0; 3]);
    }
}

#[test]
fn coordinates_far_from_0_keep_their_digits() {
    let corner = |x: f64, y: f64| [500_000.0 + x, 5_400_000.0 + y, 0.0];
    let far = [corner(0.0, 0.0), corner(0.125, 0.0), corner(0.0, 0.125)];
    for stray in [None, Some([0.0; 3])] {
        let vertices: Vec<&[f64]> = far.iter().chain(&stray).map(|v| &v[..]).collect();
        let model = of_vertices("binary_big_endian", &["x", "y", "z"], "double", &vertices).load().unwrap();
        for (read, written) in model.mesh.positions.iter().zip(far) {
            let place = glam::Vec3::from(*read).as_dvec3() + model.origin;
            assert!((place - DVec3::from(written)).length() < 1e-6, "{place}");
        }
    }
}

#[test]
fn a_cloud_of_points_is_an_empty_mesh_with_a_warning() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
    let model = parsed(text.as_bytes()).unwrap();
    assert!(model.mesh.triangles.is_empty());
    assert_eq!(model.warnings[0].to_string(), "a.ply: 1 vertices and no faces: nothing is seen of it");
}

/// Vertices and faces of a rough field in more than one block, of whose cells one in `cut` is cut into triangles.
fn field(format: &'static str, cut: usize) -> Writer {
    const SIDE: usize = 180;
    let cells = (SIDE - 1) * (SIDE - 1);
    let cut = |cell: usize| cell.is_multiple_of(cut);
    let faces = cells + (0..cells).filter(|&cell| cut(cell)).count();
    let header = format!(
        "element vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uchar uint vertex_indices\n",
        SIDE * SIDE
    );
    let (mut w, mut rng) = (Writer::new(format, &header), Rng::new(1));
    for k in 0..SIDE * SIDE {
        w.put(&[("float", (k % SIDE) as f64), ("float", (k / SIDE) as f64), ("float", f64::from(rng.f32()))]);
    }
    for cell in 0..cells {
        let first = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
        let [a, b, c, d] = [first, first + 1, first + SIDE + 1, first + SIDE].map(|i| ("uint", i as f64));
        if cut(cell) {
            w.put(&[("uchar", 3.0), a, b, c]);
            w.put(&[("uchar", 3.0), a, c, d]);
        } else {
            w.put(&[("uchar", 4.0), a, b, c, d]);
        }
    }
    w
}

/// What another reader makes of the same bytes: positions, and corners of faces.
fn by_another(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<Vec<u32>>) {
    let ply = Parser::<DefaultElement>::new().read_ply(&mut Cursor::new(bytes)).unwrap();
    let number = |element: &DefaultElement, name: &str| match element[name] {
        Property::Float(x) => x,
        _ => panic!("{name} is no float"),
    };
    let positions = ply.payload["vertex"].iter().map(|v| ["x", "y", "z"].map(|name| number(v, name))).collect();
    let corners = |face: &DefaultElement| match &face["vertex_indices"] {
        Property::ListUInt(corners) => corners.clone(),
        other => panic!("{other:?}"),
    };
    (positions, ply.payload["face"].iter().map(corners).collect())
}

#[test]
fn large_files_are_what_another_reader_makes_of_them() {
    for (format, cut) in FORMATS.into_iter().flat_map(|format| [(format, 1), (format, 3)]) {
        let w = field(format, cut);
        let (mesh, (positions, faces)) = (w.load().unwrap().mesh, by_another(&w.bytes));
        let file = tempfile::NamedTempFile::with_suffix(".ply").unwrap();
        std::fs::write(file.path(), &w.bytes).unwrap();
        let read = load(file.path()).unwrap().mesh;
        assert_eq!((&read.positions, &read.triangles), (&mesh.positions, &mesh.triangles), "as a file");
        assert_eq!(mesh.positions, positions, "{format}");
        let mut next = 0;
        for corners in faces {
            let of_face = &mesh.triangles[next..next + corners.len() - 2];
            next += corners.len() - 2;
            let mut used: Vec<u32> = of_face.iter().flatten().copied().collect();
            used.sort_unstable();
            used.dedup();
            let mut corners = corners;
            corners.sort_unstable();
            assert_eq!(used, corners);
        }
        assert_eq!(next, mesh.triangles.len());
        assert!(mesh.triangles.iter().all(|t| !t.contains(&ABSENT)));
    }
}
