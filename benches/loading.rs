//! How long a large OBJ takes and how much memory, from file to mesh, or to the first rays.
//!
//!     cargo bench --bench loading -- HOW FILE.obj
//!
//! HOW is `tobj` (its load alone), `obj` (this crate's load alone) or `scene` (load, acceleration structure, everything a
//! render needs). Each run is a process of its own, as the peak of memory is the process's.

use phototaxis::format;
use phototaxis::scene::{Scene, obj};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let [how, path] = &arguments[..] else {
        // `cargo test --benches` and `cargo bench` without arguments have nothing to load.
        println!("usage: loading (tobj | obj | scene) FILE.obj");
        return ExitCode::SUCCESS;
    };
    let (start, path) = (Instant::now(), Path::new(path));
    let triangles = match how.as_str() {
        "tobj" => tobj_triangles(path),
        "obj" => obj::load(path).map(|obj| obj.mesh.triangles.len()).map_err(|e| e.to_string()),
        "scene" => scene_triangles(path).map_err(|e| e.to_string()),
        _ => Err(format!("{how}: neither tobj, obj nor scene")),
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
    Ok(Scene::load(&description.scene, 0, description.render.robust)?.0.triangles())
}

/// Bytes; 0 where the system does not say.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes = line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    kibibytes.unwrap_or(0) << 10
}
