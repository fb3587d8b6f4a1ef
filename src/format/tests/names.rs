//! Names of materials, and changes to what libraries say of them: both are known only once the models are read.

use crate::bsdf::{BsdfDescription, color_textures};
use crate::format;
use crate::math::Rgb;
use crate::scene::LoadedAssets;
use crate::scene::description::MaterialDescription;
use crate::texture::{ColorTexture, ScalarTexture};
use std::collections::BTreeMap;
use std::path::PathBuf;

const LIBRARY: &str = "newmtl Floor\nKd .5 .4 .3\nKs .5 .5 .5\nNs 250\nd .5\nnewmtl Lamp\nKd 0 0 0\nKe 3 3 3\n\
                       newmtl Chrome\nKd .9 .9 .9\nPm 1\nPr .2\nnewmtl Satin\nKd .5 .5 .5\nPs .5\nnewmtl Spare\nKd 1 0 0\n";

/// A model with a library, in a folder of its own.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Files {
        let files = Files(tempfile::tempdir().unwrap());
        let uses =
            ["Floor", "Lamp", "Chrome", "Satin", "Nowhere"].map(|name| format!("usemtl {name}\nf 1 2 3\n")).concat();
        files.write("m.obj", &format!("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{uses}"));
        files.write("m.mtl", LIBRARY);
        files
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The materials of the model alone, or what is wrong.
    fn model(&self, set: &[&str]) -> Result<BTreeMap<String, MaterialDescription>, String> {
        materials(self.0.path().join("m.obj"), set)
    }

    /// The same of a scene file beside it.
    fn scene(&self, text: &str, set: &[&str]) -> Result<BTreeMap<String, MaterialDescription>, String> {
        materials(self.write("scene.toml", text), set)
    }
}

fn materials(path: PathBuf, set: &[&str]) -> Result<BTreeMap<String, MaterialDescription>, String> {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    let loaded = format::load(&path, &set).and_then(|(file, _)| LoadedAssets::of(&file.scene));
    let folder = format!("{}/", path.parent().unwrap().display());
    let loaded = loaded.map_err(|error| error.to_string().replace(&folder, ""))?;
    Ok(loaded.names.into_iter().zip(loaded.materials).collect())
}

fn color(material: &MaterialDescription) -> ColorTexture {
    color_textures(&material.bsdf)[0].clone().unwrap()
}

const MESH: &str = "[[mesh]]\npath = \"m.obj\"\n";

#[test]
fn one_colour_changes_and_the_rest_stays() {
    let files = Files::new();
    let before = files.model(&[]).unwrap();
    let set = [
        "material.Floor.reflectance=[0.1, 0.2, 0.3]",
        "material.Lamp.emission=[1, 2, 3]",
        "material.Lamp.emission_two_sided=true",
    ];
    let text = format!(
        "{MESH}[material.Floor]\nreflectance = [0.1, 0.2, 0.3]\n[material.Lamp]\nemission = [1, 2, 3]\nemission_two_sided = true\n"
    );
    for after in [files.model(&set).unwrap(), files.scene(&text, &[]).unwrap(), files.scene(MESH, &set).unwrap()] {
        let BsdfDescription::Plastic(mut floor) = after["Floor"].bsdf.clone() else { panic!("{:?}", after["Floor"]) };
        assert_eq!(floor.reflectance, ColorTexture::Constant(Rgb::new(0.1, 0.2, 0.3)));
        floor.reflectance = color(&before["Floor"]);
        assert_eq!(BsdfDescription::Plastic(floor), before["Floor"].bsdf, "the highlight stays");
        assert_eq!(after["Floor"].opacity, Some(ScalarTexture::Constant(0.5)));
        assert_ne!(after["Lamp"], before["Lamp"]);
        let lamp = MaterialDescription {
            emission: before["Lamp"].emission,
            emission_two_sided: false,
            light_group: None,
            ..after["Lamp"].clone()
        };
        assert_eq!(lamp, before["Lamp"]);
        assert_eq!(after["Satin"], before["Satin"]);
    }
}

#[test]
fn changes_come_one_after_the_other() {
    let files = Files::new();
    let text = format!("{MESH}[material.Floor]\nreflectance = 0.25\nalpha = 0.5\n");
    let both = files.scene(&text, &["material.Floor.alpha=0.75", "material.Floor.int_ior=1.25"]).unwrap();
    let BsdfDescription::Plastic(floor) = &both["Floor"].bsdf else { panic!("{:?}", both["Floor"]) };
    assert_eq!((&floor.reflectance, floor.alpha, floor.int_ior), (&ColorTexture::grey(0.25), 0.75, 1.25));
    let replaced = files.scene(&text, &["material.Floor.type=mirror"]).unwrap();
    assert!(matches!(replaced["Floor"].bsdf, BsdfDescription::Mirror(_)), "a type starts anew");
    assert_eq!(replaced["Floor"].opacity, None);
}

#[test]
fn reflectance_is_the_colour_of_whatever_a_library_means() {
    let files = Files::new();
    let grey = ColorTexture::grey(0.25);
    for name in ["Floor", "Chrome", "Satin", "Nowhere"] {
        let before = files.model(&[]).unwrap();
        let after = files.model(&[&format!("material.{name}.reflectance=0.25")]).unwrap();
        assert_eq!((color(&after[name]), after[name].bsdf.bsdf_type()), (grey.clone(), before[name].bsdf.bsdf_type()));
    }
    let wrong = files.model(&["material.Chrome.int_ior=2"]).unwrap_err();
    assert!(
        wrong.starts_with("--set 'material.Chrome.int_ior=2': `int_ior` is not a key of type `conductor`, but of"),
        "{wrong}"
    );
}

#[test]
fn names_that_exist_nowhere_are_errors_at_their_place() {
    let files = Files::new();
    let cases = [
        ("material.Flor.type=diffuse", "no model has a material `Flor`: did you mean `Floor`?"),
        ("material.Flor.reflectance=0.5", "no model has a material `Flor`: did you mean `Floor`?"),
        (
            "material.Zinnober.emission=1",
            "no model has a material `Zinnober`: known are `Chrome`, `Floor`, `Lamp`, `Nowhere`, `Satin` and `Spare`",
        ),
    ];
    for (set, message) in cases {
        assert_eq!(files.model(&[set]).unwrap_err(), format!("--set '{set}': {message}"));
        assert_eq!(files.scene(MESH, &[set]).unwrap_err(), format!("--set '{set}': {message}"));
    }
    let cases = [
        (
            "[material.Lmap]\ntype = \"mirror\"\n",
            "scene.toml:3:11: no model has a material `Lmap`: did you mean `Lamp`?",
        ),
        ("[material.Lmap]\nemission = 1\n", "scene.toml:3:11: no model has a material `Lmap`: did you mean `Lamp`?"),
        ("[material.Floor]\nreflectance = 2\n", "scene.toml:4:15: `reflectance` must be between 0 and 1, found 2"),
        (
            "[material.Floor]\nalhpa = 0.1\n",
            "scene.toml:4:1: unknown key `alhpa` in [material.Floor]: did you mean `alpha`?",
        ),
        (
            "material = \"Gold\"\n[material.Bold]\ntype = \"mirror\"\n",
            "scene.toml:3:12: no material `Gold` is described: did you mean `Bold`?",
        ),
        (
            "material = \"Gold\"\n[material.Gold]\nreflectance = 1\n",
            "scene.toml:3:12: no material `Gold` is described: known are \
          `Chrome`, `Floor`, `Lamp`, `Satin` and `Spare`",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(files.scene(&format!("{MESH}{text}"), &[]).unwrap_err(), message, "{text}");
    }
}

#[test]
fn names_in_files_of_other_programs_are_warnings() {
    let files = Files::new();
    let path = files.write(
        "scene.json",
        r#"{"obj": "m.obj", "materials": {"Flor": {"type": "mirror"}, "Lamp": {"type": "mirror"}}}"#,
    );
    let (file, _) = format::load(&path, &[]).unwrap();
    let warnings = LoadedAssets::of(&file.scene).unwrap().warnings;
    let names: Vec<&String> = warnings.iter().filter(|warning| warning.starts_with("no model has")).collect();
    assert_eq!(names, ["no model has a material `Flor`: did you mean `Floor`?"]);
}

#[test]
fn names_that_exist_somewhere_are_none() {
    let files = Files::new();
    // used without a library's word, in the library and not used, and the scene file's own for a whole mesh
    assert!(files.model(&["material.Nowhere.type=mirror", "material.Spare.type=mirror"]).is_ok());
    let own =
        format!("{MESH}material = \"Gold\"\n[material.Gold]\ntype = \"mirror\"\n[material.Spare]\nreflectance = 1\n");
    assert_eq!(files.scene(&own, &[]).unwrap().keys().collect::<Vec<_>>(), ["Gold"]);
    let of_library = files.scene(&format!("{MESH}material = \"Spare\"\n"), &[]).unwrap();
    assert_eq!(color(&of_library["Spare"]), ColorTexture::Constant(Rgb::X));
}
