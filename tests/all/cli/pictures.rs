//! Pictures for people: exposure, tone, names, sizes, other pictures of a render, denoising, and what is said meanwhile.

use super::{TINY, folder, names, phototaxis, scene, stderr, stdout};
use phototaxis::image::exr::{Attribute, ExrFile, read_layers};
use phototaxis::image::png;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// Runs the program and asks for this exit code.
fn run(here: &Path, code: i32, arguments: &[&str]) -> Output {
    phototaxis(here).args(arguments).assert().code(code).get_output().clone()
}

/// Renders a scene of the project, tiny.
fn render(here: &Path, name: &str, arguments: &[&str]) -> Output {
    let path = scene(name);
    run(here, 0, &[&["render", path.to_str().unwrap()], &TINY[..], arguments].concat())
}

fn read(here: &Path, name: &str) -> ExrFile {
    read_layers(&here.join(name)).unwrap()
}

fn pixels(here: &Path, name: &str) -> image::RgbImage {
    image::open(here.join(name)).unwrap().into_rgb8()
}

/// Mean of the stored values of a PNG.
fn brightness(picture: &image::RgbImage) -> f64 {
    let sum: f64 = picture.pixels().flat_map(|p| p.0).map(f64::from).sum();
    sum / f64::from(3 * picture.width() * picture.height())
}

/// `cornell.obj` with its lamp as many times as bright.
fn model(here: &Path, brighter: f32) {
    std::fs::copy(scene("cornell.obj"), here.join("cornell.obj")).unwrap();
    let text = std::fs::read_to_string(scene("cornell.mtl")).unwrap();
    let lamp = |line: &str| {
        let Some(light) = line.trim().strip_prefix("Ke ") else { return line.to_string() };
        let light: Vec<f32> = light.split_whitespace().map(|x| x.parse().unwrap()).collect();
        format!("Ke {} {} {}", light[0] * brighter, light[1] * brighter, light[2] * brighter)
    };
    let text: Vec<String> = text.lines().map(lamp).collect();
    assert!(text.iter().any(|line| line.starts_with("Ke ")), "the model has a lamp");
    std::fs::write(here.join("cornell.mtl"), text.join("\n")).unwrap();
}

#[test]
fn a_model_s_picture_is_as_bright_whatever_its_lamp() {
    let here = folder();
    let picture = |brighter: f32| {
        model(here.path(), brighter);
        run(here.path(), 0, &[&["render", "cornell.obj", "--spp", "4"], &TINY[..]].concat());
        pixels(here.path(), "cornell.png")
    };
    let (dim, plain, bright) = (picture(1.0 / 1024.0), picture(1.0), picture(4096.0));
    assert!((30.0..200.0).contains(&brightness(&plain)), "{}", brightness(&plain));
    // Factors are powers of two, and stops are found to a hundredth.
    let off = |a: &image::RgbImage| a.iter().zip(plain.iter()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off(&dim) <= Some(1) && off(&bright) <= Some(1), "{:?} {:?}", off(&dim), off(&bright));
}

#[test]
fn what_was_shown_is_said_in_the_png_the_exr_and_the_report() {
    let here = folder();
    let asked = ["--spp", "2", "--exposure", "-1.5", "--tone", "agx", "-o", "a.exr", "-o", "a.png", "--json", "a.json"];
    render(here.path(), "cornell.toml", &asked);
    let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
    assert_eq!((report["exposure_stops"].as_f64(), report["tone"].as_str()), (Some(-1.5), Some("agx")));
    assert_eq!(report["exposure_auto"].as_bool(), Some(false));
    let text = |keyword| png::text(&here.path().join("a.png"), keyword);
    assert_eq!((text("Exposure").as_deref(), text("Tone").as_deref()), (Some("-1.5"), Some("agx")));
    let shown = read(here.path(), "a.exr");
    assert_eq!(shown.attributes["viewExposure"], Attribute::Float(-1.5));
    assert_eq!(shown.attributes["viewTone"], Attribute::Text("agx".into()));
    render(here.path(), "cornell.toml", &["--spp", "2", "-o", "b.exr"]);
    assert_eq!(shown.channels, read(here.path(), "b.exr").channels, "the EXR stays linear and unexposed");
}

#[test]
fn keys_of_the_scene_file_are_shown_too() {
    let here = folder();
    let png = |arguments: &[&str]| {
        render(here.path(), "cornell.toml", &[&["--spp", "2", "-o", "a.png"], arguments].concat());
        pixels(here.path(), "a.png")
    };
    let plain = png(&[]);
    assert_eq!(png(&["--set", "film.tone=aces"]), png(&["--tone", "aces"]));
    assert_eq!(png(&["--set", "film.exposure=auto"]), png(&["--exposure", "auto"]));
    assert_ne!(png(&["--tone", "aces"]), plain);
    assert_eq!(png(&["--exposure", "0", "--tone", "srgb"]), plain, "a scene file's picture is as it was");
}

#[test]
fn image_makes_the_same_png_again_and_any_other() {
    let here = folder();
    let asked = ["--spp", "4", "--exposure", "0.5", "--tone", "agx", "-o", "a.exr", "-o", "a.png"];
    render(here.path(), "cornell.toml", &asked);
    run(here.path(), 0, &["image", "a.exr", "-o", "again.png"]);
    assert_eq!(pixels(here.path(), "again.png"), pixels(here.path(), "a.png"));
    let asked = ["image", "a.exr", "-o", "b.png", "--exposure", "-2", "--tone", "srgb"];
    let said = stderr(&run(here.path(), 0, &asked));
    assert!(said.contains("wrote b.png: 16 × 12 pixels, exposure -2 stops, tone srgb"), "{said}");
    render(here.path(), "cornell.toml", &["--spp", "4", "--exposure", "-2", "-o", "c.png"]);
    assert_eq!(pixels(here.path(), "b.png"), pixels(here.path(), "c.png"));
}

#[test]
fn image_crops_scales_and_takes_layers() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "4", "-o", "a.exr"]);
    let whole = read(here.path(), "a.exr");
    let asked = ["image", "a.exr", "-o", "part.exr", "-o", "part.png", "--crop", "2,3,8,6", "--scale", "50%"];
    run(here.path(), 0, &asked);
    let part = read(here.path(), "part.exr");
    assert_eq!((part.width, part.height, part.channels.len()), (4, 3, whole.channels.len()));
    assert_eq!(pixels(here.path(), "part.png").dimensions(), (4, 3));
    assert_eq!(part.attributes, whole.attributes);
    let mean = [(2, 3), (3, 3), (2, 4), (3, 4)].iter().map(|(x, y)| whole.channels["R"][y * 16 + x]).sum::<f32>() / 4.0;
    assert!((part.channels["R"][0] - mean).abs() <= 1e-6 * mean, "{} and {mean}", part.channels["R"][0]);

    run(here.path(), 0, &["image", "a.exr", "-o", "albedo.exr", "-o", "albedo.png", "--layer", "albedo"]);
    let albedo = read(here.path(), "albedo.exr");
    assert_eq!(albedo.channels["R"], whole.channels["albedo.R"], "the layer's colours are the picture's");
    assert_eq!((albedo.channels.len(), &albedo.attributes["layer"]), (3, &Attribute::Text("albedo".into())));
    let stored = |x: f32| (phototaxis::image::srgb::encode(x) * 255.0).round() as u8;
    assert_eq!(pixels(here.path(), "albedo.png").get_pixel(5, 5).0[1], stored(albedo.channels["G"][5 * 16 + 5]));
    for layer in ["beauty", "Ns", "A", "Z", "samples", "variance", "albedo.G"] {
        run(here.path(), 0, &["image", "a.exr", "-o", "layer.png", "--layer", layer]);
    }
    run(here.path(), 0, &["image", "a.exr", "-o", "normals.png", "--layer", "Ns"]);
    let byte = |x: f32| ((x * 0.5 + 0.5) * 255.0).round() as u8;
    let wanted = ["Ns.X", "Ns.Y", "Ns.Z"].map(|name| byte(whole.channels[name][70]));
    assert_eq!(pixels(here.path(), "normals.png").get_pixel(70 % 16, 70 / 16).0, wanted);
}

#[test]
fn image_lists_what_there_is() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "2", "-o", "a.exr"]);
    let list = stdout(&run(here.path(), 0, &["image", "a.exr", "--list"]));
    for word in ["16 × 12", "beauty", "R G B", "albedo", "X Y Z", "Z ", "samples", "variance", "viewTone: srgb"] {
        assert!(list.contains(word), "{word} is missing in:\n{list}");
    }
    assert_eq!(names(here.path()), ["a.exr"]);
}

#[test]
fn image_refuses_what_would_harm_or_do_nothing() {
    let here = folder();
    render(here.path(), "cornell.toml", &["--spp", "1", "-o", "a.exr"]);
    let before = std::fs::read(here.path().join("a.exr")).unwrap();
    std::fs::hard_link(here.path().join("a.exr"), here.path().join("link.exr")).unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&["-o", "a.exr"], "--force"),
        (&["-o", "link.exr"], "--force"),
        (&["-o", "b.exr", "--exposure", "1"], "stays linear"),
        (&["-o", "b.png", "--layer", "Ns", "--tone", "agx"], "no light"),
        (&["-o", "b.png", "--layer", "nope"], "`albedo`"),
        (&["-o", "b.png", "--crop", "10,0,7,1"], "16 × 12"),
        (&["-o", "b.png", "--scale", "200%"], "smaller"),
        (&["-o", "b.jpg"], ".exr or .png"),
        (&["-o", "nowhere/b.png"], "folder does not exist"),
    ];
    for (arguments, word) in cases {
        let said = stderr(&run(here.path(), 1, &[&["image", "a.exr"], arguments].concat()));
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
    assert!(stderr(&run(here.path(), 2, &["image", "a.exr"])).contains("--output"));
    assert_eq!(std::fs::read(here.path().join("a.exr")).unwrap(), before);
    run(here.path(), 0, &["image", "a.exr", "-o", "a.exr", "--scale", "50%", "--force"]);
    assert_eq!(read(here.path(), "a.exr").width, 8);
}

#[test]
fn default_names_are_the_folder_s_and_never_another_scene_s() {
    let here = folder();
    for room in ["kitchen", "bath"] {
        std::fs::create_dir(here.path().join(room)).unwrap();
        std::fs::copy(scene("cornell.obj"), here.path().join(room).join("scene.obj")).unwrap();
        std::fs::copy(scene("cornell.obj"), here.path().join(room).join("room.obj")).unwrap();
        std::fs::copy(scene("cornell.mtl"), here.path().join(room).join("cornell.mtl")).unwrap();
    }
    let go = |name: &str, more: &[&str]| {
        let output = run(here.path(), 0, &[&["render", name, "--spp", "1"], &TINY[..], more].concat());
        let pictures: Vec<String> = names(here.path()).into_iter().filter(|name| name.contains('.')).collect();
        (pictures, stderr(&output))
    };
    go("kitchen/scene.obj", &[]);
    assert_eq!(go("bath/scene.obj", &[]).0, ["bath.exr", "bath.png", "kitchen.exr", "kitchen.png"]);
    for name in names(here.path()).iter().filter(|name| name.contains('.')) {
        std::fs::remove_file(here.path().join(name)).unwrap();
    }
    go("kitchen/room.obj", &[]);
    let first = std::fs::read(here.path().join("room.png")).unwrap();
    let (pictures, said) = go("bath/room.obj", &[]);
    assert_eq!(pictures, ["room-2.exr", "room-2.png", "room.exr", "room.png"]);
    assert!(said.contains("note: ") && said.contains("room-2.exr"), "{said}");
    assert_eq!(std::fs::read(here.path().join("room.png")).unwrap(), first);
    assert_eq!(go("kitchen/room.obj", &[]).0, pictures, "its own picture is replaced");
    assert_eq!(go("bath/room.obj", &[]).0, pictures);
    // A PNG alone is somebody's picture too.
    std::fs::remove_file(here.path().join("room.exr")).unwrap();
    assert_eq!(go("bath/room.obj", &[]).0, ["room-2.exr", "room-2.png", "room.png"]);
    assert_eq!(go("bath/room.obj", &["--force"]).0, ["room-2.exr", "room-2.png", "room.exr", "room.png"]);
}

#[test]
fn sizes_times_and_counts_are_written_as_people_do() {
    let here = folder();
    let path = scene("cornell.toml");
    let report = |arguments: &[&str]| -> Value {
        let fixed = ["render", path.to_str().unwrap(), "-o", "a.png", "-q", "--json", "-"];
        serde_json::from_slice(&run(here.path(), 0, &[&fixed, arguments].concat()).stdout).unwrap()
    };
    let small = report(&["--size", "20x10", "--scale", "50%", "--spp", "0.004k"]);
    assert_eq!((small["width"].as_u64(), small["height"].as_u64()), (Some(10), Some(5)));
    assert_eq!(small["spp"], 4);
    let timed = report(&["--size", "8x8", "--time", "300ms"]);
    assert!(timed["render_wall_seconds"].as_f64().unwrap() < 60.0);
    for (option, value) in [("--size", "20"), ("--scale", "0%"), ("--spp", "1.5"), ("--time", "1x"), ("--tone", "film")]
    {
        let said = stderr(&run(here.path(), 2, &["render", "a.obj", option, value]));
        assert!(said.contains(value), "{said}");
    }
}

#[test]
fn a_wrong_option_names_the_right_key() {
    let here = folder();
    let said = |option: &str| stderr(&run(here.path(), 2, &["render", "a.obj", option, "3"]));
    assert!(said("--width").contains("--size WIDTHxHEIGHT or --set film.width=…"), "{}", said("--width"));
    assert!(said("--widht").contains("--size"), "{}", said("--widht"));
    assert!(said("--max-depth").contains("--set integrator.max_depth=…"), "{}", said("--max-depth"));
    assert!(said("--exposur").contains("--exposure"), "{}", said("--exposur"));
}

#[test]
fn progress_for_programs_is_json_line_by_line() {
    let here = folder();
    let output = render(here.path(), "cornell.toml", &["--spp", "2", "-o", "a.png", "--progress", "json"]);
    let lines: Vec<Value> = stderr(&output).lines().map(|line| serde_json::from_str(line).expect(line)).collect();
    let stages: Vec<&str> = lines.iter().filter_map(|line| line["stage"].as_str()).collect();
    // However short a stage is, it is told of.
    let mut told = stages.clone();
    told.dedup();
    assert_eq!(told, ["loading", "textures", "building", "rendering", "writing"], "{stages:?}");
    assert!(lines.iter().any(|line| line["message"].as_str().is_some_and(|text| text == "wrote a.png")));
    let silent = render(here.path(), "cornell.toml", &["--spp", "2", "-o", "a.png", "--progress", "json", "-q"]);
    assert_eq!(stderr(&silent), "");
}

#[test]
fn nothing_is_said_of_a_guide_where_there_is_none() {
    let here = folder();
    for guide in ["none", "auto"] {
        let said = stderr(&render(here.path(), "furnace.toml", &["--guide", guide, "--spp", "4", "-o", "a.png"]));
        assert!(!said.contains("guide"), "{guide}: {said}");
    }
    let said = stderr(&render(here.path(), "cornell.toml", &["--guide", "grid", "--spp", "4", "-o", "a.png"]));
    assert!(said.contains("the guide learnt"), "{said}");
}

/// Whether the denoising library is here; says so where it is not.
fn has_denoiser() -> bool {
    let denoiser = phototaxis::denoise::Denoiser::new(1);
    denoiser.map_err(|error| eprintln!("SKIPPED: {error}")).is_ok()
}

#[test]
fn without_the_library_denoising_is_refused_before_rendering() {
    let here = folder();
    let mut command = phototaxis(here.path());
    command.env("OIDN_DIR", here.path()).args(["render", "--denoise", "-o", "a.png"]).arg(scene("cornell.toml"));
    let said = stderr(&command.assert().code(1).get_output().clone());
    for word in ["libOpenImageDenoise.so.2", "OIDN_DIR", "pip install pyoidn"] {
        assert!(said.contains(word), "{word} is missing in: {said}");
    }
    assert!(names(here.path()).is_empty());
}

#[test]
fn denoising_adds_a_layer_and_is_what_the_png_shows() {
    if !has_denoiser() {
        return;
    }
    let here = folder();
    let asked = ["--set", "film.width=64", "--set", "film.height=48", "--spp", "4", "--guide", "none"];
    let asked = [&asked[..], &["-o", "a.exr", "-o", "a.png", "--json", "a.json", "--denoise"]].concat();
    render(here.path(), "cornell.toml", &asked);
    let picture = read(here.path(), "a.exr");
    let report: Value = serde_json::from_slice(&std::fs::read(here.path().join("a.json")).unwrap()).unwrap();
    assert!(report["denoise_seconds"].as_f64().unwrap() > 0.0);
    assert!(report["denoiser"].as_str().unwrap().starts_with("Open Image Denoise 2."));
    let roughness = |name: &str| {
        let values = &picture.channels[name];
        let steps = values.chunks(64).flat_map(|row| row.windows(2)).map(|pair| f64::from((pair[1] - pair[0]).abs()));
        steps.sum::<f64>()
    };
    assert!(roughness("denoised.G") < 0.6 * roughness("G"), "{} of {}", roughness("denoised.G"), roughness("G"));
    run(here.path(), 0, &["image", "a.exr", "-o", "again.png"]);
    assert_eq!(pixels(here.path(), "again.png"), pixels(here.path(), "a.png"), "a PNG shows what the render's showed");
    run(here.path(), 0, &["image", "a.exr", "-o", "late.exr", "-o", "late.png", "--denoise"]);
    let late = read(here.path(), "late.exr");
    assert_eq!((late.channels.len(), &late.channels["R"]), (picture.channels.len(), &picture.channels["R"]));

    run(here.path(), 0, &["image", "a.exr", "-o", "denoised.exr", "--layer", "denoised"]);
    let error = |code: i32, arguments: &[&str]| {
        let output = run(here.path(), code, &[&["error", "--reference", "a.exr"], arguments].concat());
        format!("{}{}", stderr(&output), stdout(&output))
    };
    assert!(error(0, &["a.exr"]).contains("\"mse\": 0.0"), "the picture itself is measured");
    for refused in [&["denoised.exr"][..], &["a.exr", "--layer", "denoised"]] {
        assert!(error(1, refused).contains("--allow-denoised"), "{refused:?}");
        let told = error(0, &[refused, &["--allow-denoised"]].concat());
        assert!(told.contains("\"mse\"") && !told.contains("\"mse\": 0.0"), "{told}");
    }
    let reference = run(here.path(), 1, &["error", "a.exr", "--reference", "denoised.exr"]);
    assert!(stderr(&reference).contains("--allow-denoised"));
}
