//! `phototaxis render`, when all goes well.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use phototaxis::image::exr::{Attribute, ExrFile, read_layers};
use serde_json::Value;
use std::path::Path;

/// Renders a scene of the project, tiny, and returns what was printed.
fn render(here: &Path, name: &str, arguments: &[&str]) -> std::process::Output {
    let mut command = phototaxis(here);
    command.arg("render").arg(scene(name)).args(TINY).args(arguments).assert().code(0).get_output().clone()
}

fn channel<'a>(picture: &'a ExrFile, name: &str) -> &'a [f32] {
    let channels = &picture.channels;
    channels.get(name).unwrap_or_else(|| panic!("no {name} among {:?}", channels.keys()))
}

#[test]
fn the_exr_has_all_layers_with_plausible_values() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "8", "-o", "a.exr"]);
    let picture = read_layers(&here.path().join("a.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (16, 12));
    let all = |name: &str, holds: fn(f32) -> bool| {
        let values = channel(&picture, name);
        assert_eq!(values.len(), 16 * 12);
        assert!(values.iter().all(|&x| holds(x)), "{name}: {values:?}");
        assert!(values.iter().any(|&x| x != 0.0), "{name} is black");
    };
    for name in ["R", "G", "B", "variance.R", "variance.G", "variance.B"] {
        all(name, |x| x.is_finite() && x >= 0.0);
    }
    ["albedo.R", "albedo.G", "albedo.B"].into_iter().for_each(|name| all(name, |x| (0.0..=1.0).contains(&x)));
    ["Ns.X", "Ns.Y", "Ns.Z"].into_iter().for_each(|name| all(name, |x| x.abs() <= 1.0001));
    all("Z", |z| (0.0..2.0).contains(&z) || z >= 1e9);
    all("A", |a| (0.0..=1.0).contains(&a));
    all("samples.Y", |n| n.fract() == 0.0 && (1.0..=8.0).contains(&n));
    assert_eq!(picture.channels.len(), 15);
    for name in ["generatedBy", "sceneHash", "samplesPerPixel", "renderTimeSeconds", "seed", "scene"] {
        assert!(picture.attributes.contains_key(name), "{name} is missing in {:?}", picture.attributes);
    }
}

#[test]
fn the_layers_show_a_red_wall_on_the_left_and_a_green_one_on_the_right() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "8", "-o", "a.exr"]);
    let picture = read_layers(&here.path().join("a.exr")).unwrap();
    let redness = |facing: fn(f32) -> bool| {
        let [x, r, g] = ["Ns.X", "albedo.R", "albedo.G"].map(|name| channel(&picture, name));
        let wall: Vec<f32> = (0..x.len()).filter(|&i| facing(x[i])).map(|i| r[i] - g[i]).collect();
        assert!(wall.len() > 5, "only {} pixels of a side wall", wall.len());
        wall.iter().sum::<f32>() / wall.len() as f32
    };
    let (left, right) = (redness(|x| x > 0.9), redness(|x| x < -0.9));
    assert!(left > 0.1 && right < -0.1, "left wall {left}, right wall {right}");
}

/// A white square of side 1 at the origin, seen from 3 m above it; `light` lights it.
fn square(here: &Path, light: &str) -> ExrFile {
    let obj = "v -.5 -.5 0\nv .5 -.5 0\nv .5 .5 0\nv -.5 .5 0\nvn .6 0 .8\nf 1//1 2//1 3//1 4//1\n";
    std::fs::write(here.join("square.obj"), obj).unwrap();
    let toml = format!(
        "[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nvfov = 40\n[[mesh]]\npath = 'square.obj'\n{light}"
    );
    std::fs::write(here.join("square.toml"), toml).unwrap();
    let asked = ["square.toml", "--size", "32x32", "--spp", "4", "-o", "a.exr", "--layers", "P,N,direct"];
    phototaxis(here).arg("render").args(asked).assert().code(0);
    read_layers(&here.join("a.exr")).unwrap()
}

#[test]
fn layers_say_where_surfaces_are_and_where_there_is_nothing() {
    let here = folder();
    let picture = square(here.path(), "[[light]]\ntype = 'point'\nposition = [0, 0, 3]\nintensity = 9");
    let at = |name: &str, pixel: usize| channel(&picture, name)[pixel];
    let (middle, corner) = (16 * 32 + 16, 0);
    for (name, inside, outside) in [("A", 1.0, 0.0), ("N.Z", 1.0, 0.0), ("Ns.X", 0.6, 0.0), ("Ns.Z", 0.8, 0.0)] {
        assert!((at(name, middle) - inside).abs() < 1e-5 && at(name, corner) == outside, "{name}");
    }
    assert_eq!((at("Z", corner), at("P.X", corner)), (1e10, 0.0), "nothing is far away");
    let (x, y, z) = (at("P.X", middle), at("P.Y", middle), at("P.Z", middle));
    assert!(z.abs() < 1e-6 && (0.0..0.07).contains(&x) && (-0.07..0.0).contains(&y), "{x} {y} {z}");
    assert!((at("Z", middle) - (9.0 + x * x + y * y).sqrt()).abs() < 1e-3);
    assert!((at("direct.R", middle) - at("R", middle)).abs() < 1e-6 && at("R", middle) > 0.1);
    let edge = (0..32 * 32).map(|i| at("A", i)).find(|a| *a > 0.0 && *a < 1.0);
    assert!(edge.is_some(), "a pixel that the square covers in part");
}

#[test]
fn a_part_has_the_pixels_of_the_whole_and_says_where_it_is() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "4", "--guide", "none", "-o", "whole.exr"]);
    render(here.path(), "cornell.toml", &["--spp", "4", "--guide", "none", "-o", "part.exr", "--crop", "5,4,6,3"]);
    let [whole, part] = ["whole.exr", "part.exr"].map(|name| read_layers(&here.path().join(name)).unwrap());
    assert_eq!((part.width, part.height), (16, 12), "readers give the whole, black about the part");
    for i in 0..16 * 12 {
        let inside = (5..11).contains(&(i % 16)) && (4..7).contains(&(i / 16));
        assert_eq!(channel(&part, "G")[i], if inside { channel(&whole, "G")[i] } else { 0.0 }, "{i}");
    }
    let bytes = std::fs::read(here.path().join("part.exr")).unwrap();
    let window = |name: &[u8]| {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        let number = |k: usize| i32::from_le_bytes(bytes[at + 4 + 4 * k..at + 8 + 4 * k].try_into().unwrap());
        [number(0), number(1), number(2), number(3)]
    };
    assert_eq!(window(b"dataWindow\0box2i\0"), [5, 4, 10, 6]);
    assert_eq!(window(b"displayWindow\0box2i\0"), [0, 0, 15, 11]);
    let outside = phototaxis(here.path())
        .arg("render")
        .arg(scene("cornell.toml"))
        .args(TINY)
        .args(["--crop", "12,0,5,5"])
        .assert();
    assert!(
        stderr(outside.code(1).get_output()).contains("5 × 5 pixels at (12, 0) are no part of a picture of 16 × 12")
    );
}

#[test]
fn cryptomatte_names_what_a_pixel_shows() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "8", "-o", "a.exr", "--layers", "cryptomatte"]);
    let picture = read_layers(&here.path().join("a.exr")).unwrap();
    let manifest = |kind: &str| {
        let text = |name: &str, field: &str| match picture.attributes.get(&format!("{name}/{field}")) {
            Some(Attribute::Text(text)) => text.clone(),
            other => panic!("{name}/{field}: {other:?}"),
        };
        let prefix = picture.attributes.keys().filter_map(|key| key.strip_suffix("/manifest"));
        let prefix = prefix.filter(|prefix| text(prefix, "name") == kind).map(String::from).next().unwrap();
        assert_eq!(text(&prefix, "hash"), "MurmurHash3_32");
        serde_json::from_str::<std::collections::BTreeMap<String, String>>(&text(&prefix, "manifest")).unwrap()
    };
    let materials = manifest("CryptoMaterial");
    let id = |name: &str| f32::from_bits(u32::from_str_radix(&materials[name], 16).unwrap());
    let (first, share) = (channel(&picture, "CryptoMaterial00.R"), channel(&picture, "CryptoMaterial00.G"));
    let (r, g) = (channel(&picture, "albedo.R"), channel(&picture, "albedo.G"));
    let reds = (0..first.len()).filter(|&i| first[i] == id("red") && share[i] == 1.0);
    assert!(reds.clone().count() > 5 && reds.clone().all(|i| r[i] > 2.0 * g[i]), "{materials:?}");
    let sum = |i: usize| {
        ["00.G", "00.A", "01.G", "01.A", "02.G", "02.A"]
            .iter()
            .map(|c| channel(&picture, &format!("CryptoObject{c}"))[i])
            .sum::<f32>()
    };
    let alpha = channel(&picture, "A");
    assert!((0..alpha.len()).all(|i| (sum(i) - alpha[i]).abs() < 1e-6));
    let objects: Vec<String> = manifest("CryptoObject").into_keys().collect();
    assert_eq!(objects, ["room", "short_block", "tall_block"], "those that the OBJ file names");
}

#[test]
fn a_background_is_opaque() {
    let here = folder();
    let picture = square(here.path(), "[[light]]\ntype = 'constant'\nradiance = 1");
    assert!(channel(&picture, "A").iter().all(|&a| a == 1.0));
    assert_eq!(channel(&picture, "Z")[0], 1e10);
}

#[test]
fn png_and_json_are_written_where_asked() {
    let here = folder();
    let asked = ["--spp", "6", "-o", "a.png", "-o", "b.exr", "--json", "c.json", "--seed", "7"];
    let output = render(here.path(), "cornell.toml", &asked);
    assert_eq!(names(here.path()), ["a.png", "b.exr", "c.json"]);
    assert!(stderr(&output).contains("wrote a.png") && stderr(&output).contains("Msamples/s"), "{}", stderr(&output));
    assert_eq!(stdout(&output), "");
    let png = image::open(here.path().join("a.png")).unwrap().into_rgb8();
    assert_eq!(png.dimensions(), (16, 12));
    assert!(png.pixels().any(|p| p.0.iter().any(|&c| c > 50)));
    let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("c.json")).unwrap()).unwrap();
    check_report(&report);
}

/// What holds of the figures of `cornell`, 16 × 12 pixels, 6 samples, seed 7.
fn check_report(report: &Value) {
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} in {report}"));
    for (key, value) in [("schema", 2.0), ("seed", 7.0), ("width", 16.0), ("height", 12.0), ("triangles", 38.0)] {
        assert_eq!(number(key), value, "{key}");
    }
    assert_eq!((number("spp"), number("non_finite_samples")), (6.0, 0.0));
    assert_eq!((report["exit"].as_str(), report["guide"]["method"].as_str()), (Some("done"), Some("grid")));
    assert_eq!(report["phototaxis"].as_str(), Some(env!("CARGO_PKG_VERSION")));
    assert_eq!(report["scene_hash"].as_str().map(str::len), Some(16));
    assert!(number("spp_kept") >= 1.0 && number("spp_kept") <= 6.0);
    for key in [
        "threads",
        "embree_bytes",
        "build_wall_seconds",
        "render_wall_seconds",
        "render_cpu_seconds",
        "msamples_per_second",
    ] {
        assert!(number(key) > 0.0, "{key}");
    }
    let (paths, rays) = (16.0 * 12.0 * 6.0, number("rays"));
    assert!(rays >= paths && rays <= 16.0 * paths, "{rays} rays of {paths} paths");
    assert!((number("mean_path_length") - rays / paths).abs() < 1e-9);
    assert!(number("shadow_rays") > 0.0 && number("shadow_rays") <= rays);
    for share in ["zero_contribution_share", "embree_share"] {
        assert!((0.0..=1.0).contains(&number(share)), "{share}");
    }
    let iterations = report["iterations"].as_array().unwrap();
    let samples: u64 = iterations.iter().map(|i| i["spp"].as_u64().unwrap()).sum();
    assert_eq!(samples, 6);
    let seconds: f64 = iterations.iter().map(|i| i["wall_seconds"].as_f64().unwrap()).sum();
    assert!(seconds <= number("render_wall_seconds"));
}

#[test]
fn without_names_both_pictures_are_named_like_the_scene() {
    let here = folder();
    render(here.path(), "furnace.toml", &["--spp", "1"]);
    assert_eq!(names(here.path()), ["furnace.exr", "furnace.png"]);
}

#[test]
fn a_model_renders_without_a_scene_file() {
    let here = folder();
    render(here.path(), "cornell.obj", &["--spp", "4"]);
    let picture = read_layers(&here.path().join("cornell.exr")).unwrap();
    let seen = channel(&picture, "Z").iter().filter(|&&z| z > 0.0).count();
    assert!(seen > 20, "the automatic camera sees the model: {seen} of {} pixels", 16 * 12);
    assert!(channel(&picture, "R").iter().any(|&x| x > 0.0), "the model brings its own light");
}

#[test]
fn json_on_standard_output_is_all_that_is_there() {
    let here = folder();
    let output = render(here.path(), "cornell.toml", &["--spp", "6", "--seed", "7", "-o", "a.png", "--json", "-"]);
    check_report(&serde_json::from_slice(&output.stdout).unwrap());
}

#[test]
fn quiet_prints_nothing() {
    let here = folder();
    std::fs::write(here.path().join("odd.obj"), "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let run = |more: &[&str]| {
        let mut command = phototaxis(here.path());
        let arguments = ["render", "odd.obj", "--spp", "1", "-o", "a.exr"];
        command.args(arguments).args(TINY).args(more).assert().code(0).get_output().clone()
    };
    assert!(stderr(&run(&[])).contains("warning: odd.obj:1: "), "this model deserves a warning");
    let quiet = run(&["--quiet"]);
    assert_eq!((stdout(&quiet), stderr(&quiet)), (String::new(), String::new()));
}

#[test]
fn of_many_warnings_twenty_are_printed() {
    let here = folder();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let libraries: String = (0..50).map(|k| format!("mtllib none{k}.mtl\n")).collect();
    std::fs::write(here.path().join("a.obj"), format!("{libraries}{triangle}f 1 2 3\n")).unwrap();
    let mut command = phototaxis(here.path());
    let arguments = ["render", "a.obj", "--spp", "1", "-o", "a.exr"];
    let output = command.args(arguments).args(TINY).assert().code(0).get_output().clone();
    let warnings: Vec<String> =
        stderr(&output).lines().filter(|l| l.starts_with("warning: ")).map(String::from).collect();
    assert_eq!(warnings.len(), 21, "{warnings:?}");
    assert!(warnings[20].starts_with("warning: and 3"), "{}", warnings[20]);
}

#[test]
fn the_picture_depends_on_the_seed_but_not_on_the_threads() {
    let here = folder();
    let beauty = |arguments: &[&str]| {
        render(here.path(), "cornell.toml", &[&["--spp", "4", "-o", "a.exr"], arguments].concat());
        let picture = read_layers(&here.path().join("a.exr")).unwrap();
        ["R", "G", "B"].map(|name| channel(&picture, name).to_vec())
    };
    let first = beauty(&["--seed", "1", "--threads", "1"]);
    assert!(first == beauty(&["--seed", "1", "--threads", "3"]), "other threads, another picture");
    assert!(first != beauty(&["--seed", "2", "--threads", "1"]), "another seed, the same picture");
}

#[test]
fn flags_stand_for_keys_and_set_has_the_last_word() {
    let here = folder();
    let report = |arguments: &[&str]| -> Value {
        let output = render(here.path(), "cornell.toml", &[&["-o", "a.png", "--json", "-"], arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let plain = report(&["--guide", "none", "--spp", "3"]);
    assert_eq!((plain["guide"]["method"].as_str(), plain["guide"]["states"].as_u64()), (Some("none"), Some(0)));
    assert_eq!(plain["spp"], 3);
    assert_eq!(report(&["--spp", "3", "--set", "render.spp=5"])["spp"], 5);
    for method in ["adaptive", "grid"] {
        assert_eq!(report(&["--spp", "2", "--guide", method])["guide"]["method"], method);
    }
    let depth = report(&["--spp", "2", "--set", "integrator.max_depth=1"]);
    assert_eq!(depth["mean_path_length"].as_f64(), Some(1.0));
}

/// Models travel without their pictures: that is worth a warning, not a refusal.
#[test]
fn a_library_s_missing_picture_is_a_warning() {
    let here = folder();
    let write = |name: &str, text: &str| std::fs::write(here.path().join(name), text).unwrap();
    write("m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd nowhere.png\nmap_d nowhere.png\n");
    let arguments = ["render", "m.obj", "--spp", "1", "-o", "m.png"];
    let output = phototaxis(here.path()).args(arguments).args(TINY).assert().code(0).get_output().clone();
    assert!(stderr(&output).contains("nowhere.png: the picture of material `a` is missing"), "{}", stderr(&output));
}

/// The most memory that the program held while it rendered a square picture, where the system says so.
fn peak(here: &Path, side: u32) -> Option<u64> {
    let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin!("phototaxis"));
    let size = [format!("film.width={side}"), format!("film.height={side}"), "integrator.max_depth=2".into()];
    program.current_dir(here).arg("render").arg(scene("cornell.toml")).args(["-q", "--guide", "auto", "--spp", "9"]);
    let mut running = program.args(size.iter().flat_map(|text| ["--set", text])).spawn().unwrap();
    let status = format!("/proc/{}/status", running.id());
    let mut peak = None;
    while running.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak = peak.max(line.map(|kib| kib.parse::<u64>().unwrap() << 10));
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(running.wait().unwrap().success());
    peak
}

#[test]
fn a_render_takes_the_memory_that_is_said() {
    let here = folder();
    let (Some(small), Some(large)) = (peak(here.path(), 400), peak(here.path(), 1000)) else {
        eprintln!("SKIPPED: this system does not say how much memory a process held");
        return;
    };
    let per_pixel = (large - small) / (1000 * 1000 - 400 * 400);
    let said = phototaxis::film::accumulate::BYTES_PER_PIXEL;
    assert!((said / 2..=said).contains(&per_pixel), "{per_pixel} bytes a pixel, and {said} are said");
}
