//! How long a large OBJ or PLY takes and how much memory, from file to mesh, or to the first rays.
//!
//!     cargo bench --bench loading -- HOW FILE
//!     cargo bench --bench loading -- write TRIANGLES FILE.ply
//!
//! HOW is `tobj` or `ply-rs` (their load alone), `obj` or `ply` (this crate's load alone) or `scene` (load, acceleration structure,
//! everything a render needs). `write` makes a binary PLY to load. Each run is a process of its own, as the peak of memory is the process's.

use phototaxis::format;
use phototaxis::scene::{Scene, obj, ply};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{BeginList, PropertyAccess, PropertyAccessResult};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    if let [write, triangles, path] = &arguments[..]
        && write == "write"
    {
        write_ply(triangles.parse().expect("a number of triangles"), Path::new(path)).expect("a file");
        return ExitCode::SUCCESS;
    }
    let [how, path] = &arguments[..] else {
        // `cargo test --benches` and `cargo bench` without arguments have nothing to load.
        println!("usage: loading (tobj | obj | ply-rs | ply | scene) FILE");
        return ExitCode::SUCCESS;
    };
    let (start, path) = (Instant::now(), Path::new(path));
    let triangles = match how.as_str() {
        "tobj" => tobj_triangles(path),
        "obj" => obj::load(path).map(|obj| obj.mesh.triangles.len()).map_err(|e| e.to_string()),
        "ply-rs" => ply_rs_triangles(path),
        "ply" => ply::load(path).map(|ply| ply.mesh.triangles.len()).map_err(|e| e.to_string()),
        "scene" => scene_triangles(path).map_err(|e| e.to_string()),
        _ => Err(format!("{how}: neither tobj, obj, ply-rs, ply nor scene")),
    };
    match triangles {
        Ok(triangles) => {
            let seconds = start.elapsed().as_secs_f64();
            println!("{how}: {triangles} triangles in {seconds:.2} s, peak {} MiB", peak_memory() >> 20);
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn tobj_triangles(path: &Path) -> Result<usize, String> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let (models, _) = tobj::load_obj(path, &options).map_err(|e| e.to_string())?;
    Ok(models.iter().map(|model| model.mesh.indices.len() / 3).sum())
}

fn scene_triangles(path: &Path) -> phototaxis::Result<usize> {
    let (description, _) = format::load(path, &[])?;
    Ok(Scene::load(&description.scene, 0, description.render.build)?.0.triangles())
}

/// Bytes; 0 where the system does not say.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) << 10
}

/// A wavy field of so many triangles, with normals.
fn write_ply(triangles: usize, path: &Path) -> std::io::Result<()> {
    let side = ((triangles / 2) as f64).sqrt() as usize + 1;
    let (vertices, faces) = (side * side, 2 * (side - 1) * (side - 1));
    let mut file = BufWriter::new(File::create(path)?);
    write!(file, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n")?;
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(file, "property float {name}")?;
    }
    write!(file, "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n")?;
    for k in 0..vertices {
        let (x, y) = ((k % side) as f32, (k / side) as f32);
        for number in [x, y, (0.1 * x).sin() * (0.1 * y).cos(), 0.0, 0.0, 1.0] {
            file.write_all(&number.to_le_bytes())?;
        }
    }
    for cell in 0..(side - 1) * (side - 1) {
        let first = (cell / (side - 1) * side + cell % (side - 1)) as i32;
        let (right, above) = (first + 1, first + side as i32);
        for triangle in [[first, right, above + 1], [first, above + 1, above]] {
            file.write_all(&[3])?;
            triangle.iter().try_for_each(|index| file.write_all(&index.to_le_bytes()))?;
        }
    }
    file.flush()
}

/// The other reader at its best: numbers go straight into what is declared for them.
#[derive(Debug, Default)]
struct Vertex([f32; 6]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex::default()
    }

    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        let Some(place) = ["x", "y", "z", "nx", "ny", "nz"].iter().position(|known| *known == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[place] = value;
        PropertyAccessResult::Set
    }
}

#[derive(Debug, Default)]
struct Face(Vec<i32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }

    fn begin_list_int(&mut self, _name: &str, length: usize) -> BeginList<'_, i32> {
        self.0.reserve_exact(length);
        BeginList::Fill(&mut self.0)
    }
}

fn ply_rs_triangles(path: &Path) -> Result<usize, String> {
    let mut file = Reader::new(BufReader::new(File::open(path).map_err(|e| e.to_string())?));
    let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
    let header = vertices.read_header(&mut file).map_err(|e| e.to_string())?;
    let mut triangles = 0;
    for (name, element) in &header.elements {
        if name == "vertex" {
            let read = vertices.read_payload_for_element(&mut file, element, &header).map_err(|e| e.to_string())?;
            std::hint::black_box(read);
        } else {
            let read = faces.read_payload_for_element(&mut file, element, &header).map_err(|e| e.to_string())?;
            triangles = read.iter().map(|face| face.0.len().saturating_sub(2)).sum();
        }
    }
    Ok(triangles)
}
