use super::*;
use crate::bsdf::{
    BsdfDescription, ConductorParameters, DielectricParameters, DiffuseParameters, MicrofacetDistribution,
    PlasticParameters, PrincipledMaps, PrincipledParameters,
};
use crate::math::Rgb;
use crate::texture::{ColorTexture, ImageTexture, ReliefKind, ReliefTexture, ScalarTexture};
use proptest::prelude::*;

fn library(text: impl AsRef<[u8]>) -> Result<(Materials, Vec<Warning>)> {
    let (mut materials, mut warnings) = (Materials::new(), Vec::new());
    let path = Path::new("folder/test.mtl");
    load_library(path, text.as_ref().to_vec(), &mut materials, &mut warnings)?;
    Ok((materials, warnings))
}

/// The one material with these statements, which raise no warning.
fn material(statements: &str) -> MaterialDescription {
    let (materials, warnings) = library(format!("newmtl m\n{statements}\n")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    materials["m"].clone()
}

fn messages(text: &str) -> Vec<(usize, String)> {
    library(text).unwrap().1.into_iter().map(|w| (w.line, w.message)).collect()
}

fn constant(r: f32, g: f32, b: f32) -> ColorTexture {
    ColorTexture::Constant(Rgb::new(r, g, b))
}

fn image(file: &str) -> ImageTexture {
    ImageTexture::new(Path::new("folder").join(file))
}

fn diffuse(reflectance: ColorTexture) -> BsdfDescription {
    BsdfDescription::Diffuse(DiffuseParameters { reflectance })
}

fn metal(specular_reflectance: ColorTexture, alpha: f32) -> BsdfDescription {
    let (distribution, energy_conserving) = (MicrofacetDistribution::Ggx, true);
    ConductorParameters { eta_k: None, specular_reflectance, alpha, distribution, energy_conserving }.into()
}

#[test]
fn diffuse_materials() {
    let plain = MaterialDescription::default();
    assert_eq!(material(""), plain);
    assert_eq!(material("Kd 0.1 0.2 0.3 # note").bsdf, diffuse(constant(0.1, 0.2, 0.3)));
    assert_eq!(material("  KD\t.25\r").bsdf, diffuse(constant(0.25, 0.25, 0.25)));
    // Not a highlight: `illum 1`, no exponent, no specular colour.
    for matt in ["Ks 1 1 1\nNs 50\nillum 1", "Ks 1 1 1\nillum 2", "Ns 50\nillum 2", "illum 2\nKs 0 0 0\nNs 9"] {
        assert_eq!(material(matt), plain, "{matt}");
    }
}

#[test]
fn lights_emit_on_one_side() {
    let light = material("Kd 0 0 0\nKe 17 12 4");
    assert_eq!(light.emission, Rgb::new(17.0, 12.0, 4.0));
    assert!(!light.emission_two_sided && light.two_sided);
    assert_eq!(light.bsdf, diffuse(constant(0.0, 0.0, 0.0)));
}

fn plastic(reflectance: ColorTexture, int_ior: f32, alpha: f32) -> BsdfDescription {
    let other = PlasticParameters::default();
    PlasticParameters { reflectance, int_ior, alpha, energy_conserving: true, ..other }.into()
}

#[test]
fn plastic_materials() {
    let of = |more: &str| material(&format!("Kd .2 .4 .6\n{more}")).bsdf;
    let near = |found: BsdfDescription, int_ior: f32, alpha: f32| {
        let BsdfDescription::Plastic(found) = found else { panic!("{found:?}") };
        assert!((found.int_ior - int_ior).abs() < 1e-5 && (found.alpha - alpha).abs() < 1e-6, "{found:?}");
        assert_eq!(
            BsdfDescription::Plastic(found.clone()),
            plastic(constant(0.2, 0.4, 0.6), found.int_ior, found.alpha)
        );
    };
    near(of("Ks .5 .5 .5\nillum 2\nNs 250\nNi 1.3"), 1.3, 0.25);
    near(of("Ks .5 .5 .5\nillum 2\nNs 250\nNi 1"), 1.5, 0.25);
    near(of("Ks .5 .5 .5\nNs 1e6"), 1.5, 1e-3);
    near(of("Ks .5 .5 .5\nillum 2\nNs 10\nPr 0.5"), 1.5, 0.25);
    // twice the reflection of an index of 1.5, 0.08, is that of 1.78879
    near(of("Ks 1\nNs 250"), 1.788_789, 0.25);
    // the extension alone, and what Cinema 4D writes for paint
    near(of("Pr .5\nPm 0"), 1.5, 0.25);
    near(of("Ka 1 1 1\nKs .5\nNs 250\nillum 7"), 1.5, 0.25);
}

fn principled(base_color: ColorTexture, metallic: f32, roughness: f32) -> BsdfDescription {
    BsdfDescription::Principled(PrincipledParameters {
        base_color,
        metallic,
        roughness,
        energy_conserving: true,
        ..PrincipledParameters::default()
    })
}

#[test]
fn metals() {
    // as Blender writes them, wholly and in part
    let gold = "Ns 250\nKa 1 1 1\nKd 0.9 0.6 0.1\nKs 0.5 0.5 0.5\nNi 1.45\nd 1\nillum 3";
    assert_eq!(material(gold).bsdf, metal(constant(0.9, 0.6, 0.1), 0.25));
    assert_eq!(material("Ns 250\nKa .5\nKd .3\nKs .5\nillum 3").bsdf, principled(constant(0.3, 0.3, 0.3), 0.5, 0.5));
    // by the words of the format
    assert_eq!(material("Kd .1\nKs .9 .8 .7\nillum 5").bsdf, metal(constant(0.9, 0.8, 0.7), 0.0));
    assert_eq!(material("Ka .1\nKd .1\nKs .9\nillum 5").bsdf, metal(constant(0.9, 0.9, 0.9), 0.0));
    assert_eq!(material("Kd .1\nKs .9\nNs 10\nillum 3\nPr .5").bsdf, metal(constant(0.9, 0.9, 0.9), 0.25));
    assert_eq!(material("Kd .1 .2 .3\nillum 8").bsdf, metal(constant(0.1, 0.2, 0.3), 0.0));
    // the extension
    assert_eq!(material("Kd .1 .2 .3\nKs .5\nPm 1\nNs 250").bsdf, metal(constant(0.1, 0.2, 0.3), 0.25));
    assert_eq!(material("Kd 0\nKs .5\nPm .5\nPr .1").bsdf, principled(constant(0.5, 0.5, 0.5), 0.5, 0.1));
    assert_eq!(material("map_Kd a.png\nPm 1").bsdf, metal(ColorTexture::Image(image("a.png")), 0.25));
    let coated = material("Kd .1\nPr .2\nPc 1\nPcr .25\nPs .5").bsdf;
    let BsdfDescription::Principled(p) = coated else { panic!("{coated:?}") };
    assert_eq!((p.metallic, p.clearcoat, p.clearcoat_gloss, p.sheen), (0.0, 1.0, 0.75, 0.5));
}

#[test]
fn what_nobody_would_see_is_named() {
    let said = messages("newmtl scan\nmap_Kd a.png\nTr 1\nillum 1\nnewmtl ghost\nd 0\nnewmtl leaf\nd 0\nmap_d b.png\n");
    let said: Vec<(usize, &str)> = said.iter().map(|(line, message)| (*line, message.as_str())).collect();
    assert!(matches!(said[..], [(1, a), (5, b)] if a.contains("`scan`: `Tr 1`") && b.contains("`ghost`")), "{said:?}");
    let (materials, _) = library("newmtl scan\nmap_Kd a.png\nTr 1\nillum 1\n").unwrap();
    assert_eq!(materials["scan"].opacity, None);
    // by the format's words where something else says that light passes
    assert!(matches!(material("Tr 1\nTf 1 1 1\nNi 1.5").bsdf, BsdfDescription::Dielectric(_)));
}

#[test]
fn libraries_may_be_in_utf_16() {
    let text = "newmtl m\nKd .1 .2 .3\n";
    for (mark, bytes) in [([0xff, 0xfe], u16::to_le_bytes as fn(u16) -> [u8; 2]), ([0xfe, 0xff], u16::to_be_bytes)] {
        let written: Vec<u8> = mark.into_iter().chain(text.encode_utf16().flat_map(bytes)).collect();
        let (materials, _) = library(written).unwrap();
        assert_eq!(materials["m"].bsdf, diffuse(constant(0.1, 0.2, 0.3)));
    }
}

#[test]
fn glass() {
    let glass = |int_ior, tint, alpha| {
        BsdfDescription::Dielectric(DielectricParameters {
            int_ior,
            ext_ior: 1.0,
            specular_reflectance: Rgb::ONE,
            specular_transmittance: tint,
            alpha,
            distribution: MicrofacetDistribution::Ggx,
            thin: false,
        })
    };
    for illum in [4, 6, 7, 9] {
        let found = material(&format!("Kd .1\nKs 1\nd 0\nNi 1.33\nillum {illum}"));
        assert_eq!(found.bsdf, glass(1.33, Rgb::ONE, 0.0));
        assert_eq!((found.two_sided, found.opacity), (false, None));
    }
    assert_eq!(material("illum 7\nTr .5").bsdf, glass(1.5, Rgb::ONE, 0.0));
    assert_eq!(material("illum 7\nKd 0\nKs 1").bsdf, glass(1.5, Rgb::ONE, 0.0));
    assert_eq!(material("Tr .9\nTf 1 .5 0\nPr .5").bsdf, glass(1.5, Rgb::new(1.0, 0.5, 0.0), 0.25));
    // What Maya writes for an opaque material, a cut-out, and a filter that nothing passes.
    for opaque in [
        "Kd .5\nillum 4\nTf 1 1 1\nNi 1.0",
        "map_d a.png\nillum 9\nNi 1.5",
        "d 1\nTf 1 1 1\nNi 1.5",
        "illum 7",
        "illum 9\nd 1",
    ] {
        assert_eq!(material(opaque).bsdf, MaterialDescription::default().bsdf, "{opaque}");
    }
}

#[test]
fn partial_coverage() {
    let opacity = |text: &str| material(text).opacity;
    assert_eq!(opacity("d 0.25"), Some(ScalarTexture::Constant(0.25)));
    assert_eq!(opacity("Tr 0.25"), Some(ScalarTexture::Constant(0.75)));
    assert_eq!(opacity("d 0.5\nNi 1\nillum 4"), Some(ScalarTexture::Constant(0.5)));
    assert_eq!(opacity("d 1"), None);
    assert_eq!(opacity("map_d a.png"), Some(ScalarTexture::Image(image("a.png"))));
    assert_eq!(opacity("d 0\nmap_d a.png"), opacity("map_d a.png"));
    let half = ImageTexture { tint: Rgb::splat(0.5), ..image("a.png") };
    assert_eq!(opacity("map_d a.png\nd .5"), Some(ScalarTexture::Image(half)));
}

#[test]
fn maps_multiply_colours_that_are_not_black() {
    let tinted = |statements: &str| match material(statements).bsdf {
        BsdfDescription::Diffuse(DiffuseParameters { reflectance: ColorTexture::Image(image) }) => image.tint,
        other => panic!("{other:?}"),
    };
    assert_eq!(tinted("map_Kd a.png"), Rgb::ONE);
    assert_eq!(tinted("map_Kd a.png\nKd 0 0 0"), Rgb::ONE);
    assert_eq!(tinted("Kd 1 .5 0\nmap_Kd -mm 0 0.5 a.png"), Rgb::new(0.5, 0.25, 0.0));
}

#[test]
fn reliefs_are_normals_or_whatever_their_picture_shows() {
    let relief = |statements: &str| material(statements).relief;
    let of = |file: &str, kind, strength| Some(ReliefTexture { image: image(file), kind, strength });
    assert_eq!(relief("norm n.png"), of("n.png", ReliefKind::Normals, 1.0));
    let (materials, warnings) = library("newmtl m\nmap_Kn -bm 0.5 n.png\nbump b.png").unwrap();
    assert_eq!(materials["m"].relief, of("n.png", ReliefKind::Normals, 0.5));
    assert!(warnings[0].message.contains("is ignored beside `norm`"), "{warnings:?}");
    for statement in ["map_Bump", "bump", "map_bump"] {
        let found = relief(&format!("{statement} -bm 2.5 b.png"));
        assert_eq!(found, of("b.png", ReliefKind::NormalsOrTexelHeights, 2.5));
    }
    assert_eq!(relief("Kd 1 1 1"), None);
    assert_eq!(messages("newmtl a\nmap_Kd -bm 2 a.png"), [(2, "option `-bm` of `map_Kd` is ignored".to_string())]);
}

#[test]
fn shares_come_from_pictures() {
    let shares = |statements: &str| match material(statements).bsdf {
        BsdfDescription::Principled(p) => (p.base_color.clone(), p.roughness, p.maps),
        other => panic!("{statements}: {other:?}"),
    };
    let luminance = |file: &str| Some(ScalarTexture::Luminance(image(file)));
    let (base, roughness, maps) = shares("Kd 0.2 0.4 0.6\nPr 0.3\nmap_Pr r.png\nmap_Pm m.png\nmap_Ks s.png");
    assert_eq!((base, roughness), (constant(0.2, 0.4, 0.6), 0.3));
    let all =
        PrincipledMaps { metallic: luminance("m.png"), roughness: luminance("r.png"), specular: luminance("s.png") };
    assert_eq!(maps, all);
    let (_, _, maps) = shares("map_Ns n.png");
    assert_eq!(maps, PrincipledMaps { roughness: luminance("n.png"), ..PrincipledMaps::NONE });
    let (materials, warnings) = library("newmtl m\nmap_Ns n.png\nmap_Pr r.png\nillum 3").unwrap();
    assert!(warnings[0].message.ends_with("`map_Ns` is ignored beside `map_Pr`"));
    let maps = PrincipledMaps { roughness: luminance("r.png"), ..PrincipledMaps::NONE };
    assert!(matches!(&materials["m"].bsdf, BsdfDescription::Principled(p) if p.maps == maps));
    let (_, _, maps) = shares("map_Pr -imfchan g a.png\nmap_Pm -imfchan b a.png");
    let channel = |k| Some(ScalarTexture::Channel(image("a.png"), k));
    assert_eq!(maps, PrincipledMaps { metallic: channel(2), roughness: channel(1), specular: None });
    let opacity = material("d 0.5\nmap_d -imfchan l a.png").opacity;
    let half = ImageTexture { tint: Rgb::splat(0.5), ..image("a.png") };
    assert_eq!(opacity, Some(ScalarTexture::Luminance(half)));
    let told = messages("newmtl a\nmap_Kd -imfchan r a.png\nmap_Pr -bm 2 b.png\nd 0.5\nillum 4");
    let expected = [
        (1, "material `a`: `map_Ks`, `map_Ns`, `map_Pr` and `map_Pm` are ignored, as it is glass"),
        (2, "option `-imfchan` of `map_Kd` is ignored"),
        (3, "option `-bm` of `map_Pr` is ignored"),
    ];
    let mut told = told;
    told.sort();
    assert_eq!(told, expected.map(|(line, message)| (line, message.to_string())));
}

#[test]
fn emission_maps_multiply_what_is_emitted() {
    let emission = |statements: &str| {
        let material = material(statements);
        (material.emission, material.emission_map)
    };
    assert_eq!(emission("Ke 3 2 1\nmap_Ke e.png"), (Rgb::new(3.0, 2.0, 1.0), Some(image("e.png"))));
    assert_eq!(emission("Ke 0 0 0\nmap_Ke e.png"), (Rgb::ONE, Some(image("e.png"))));
    assert_eq!(emission("map_Ke e.png"), (Rgb::ONE, Some(image("e.png"))));
    assert_eq!(emission("Ke 0 0 0"), (Rgb::ZERO, None));
}

#[test]
fn texture_options_precede_the_name() {
    let read = |argument: &str| {
        let mut notes = Notes::default();
        let texture = texture::read(argument.as_bytes(), Path::new("folder"), &mut notes).unwrap();
        (texture.map(|texture| texture.image), notes.messages.len())
    };
    let moved = ImageTexture { scale: [2.0, 3.0], offset: [0.5, 0.25], ..image("a b.png") };
    assert_eq!(read(" -s 2 3 1 -o 0.5 .25 a b.png # note"), (Some(moved), 0));
    let partial = ImageTexture { scale: [2.0, 1.0], ..image("7") };
    assert_eq!(read("-s 2 7"), (Some(partial), 0));
    assert_eq!(read("-blendu on -CC off -texres 64 -clamp off a.png"), (Some(image("a.png")), 0));
    let clamped = ImageTexture { clamp: true, ..image("a.png") };
    assert_eq!(read("-clamp on -imfchan r -bm 0.5 -t 1 2 a.png"), (Some(clamped), 1));
    assert_eq!(read("-imfchan z a.png"), (Some(image("a.png")), 1));
    assert_eq!(read(r"maps\wood #2.png"), (Some(image("maps/wood #2.png")), 0));
    assert_eq!(read("-x.png"), (Some(image("-x.png")), 0));
    assert_eq!(read(" # nothing"), (None, 0));
    for bad in ["-s a.png", "-o nan a.png", "-mm inf 1 a.png"] {
        assert!(texture::read(bad.as_bytes(), Path::new(""), &mut Notes::default()).is_err(), "{bad}");
    }
}

#[test]
fn oddities_are_reported_once() {
    let text = "Kd 1\nnewmtl a\nmap_Wood x\nmap_Wood y\nKa 1 1 1\nKd 2 0 0\nnewmtl b\nKs 3\nNi 0\nmap_Kd\nKd spectral x.rfl\nd 0.5\nTr 0.2\nd -halo 1\nmap_Wood z\nnewmtl a\nKd .5\n";
    let expected = [
        (1, "statements before the first `newmtl` are ignored"),
        (3, "statement `map_Wood` is ignored"),
        (6, "`Kd` is brought into [0, 1]"),
        (8, "`Ks` is brought into [0, 1]"),
        (9, "`Ni` that is not positive is ignored"),
        (10, "`map_Kd` names no file"),
        (11, "`Kd` as a spectrum or in XYZ is ignored"),
        (13, "`d` and `Tr` contradict each other; `d` counts"),
        (14, "`d -halo` counts as `d`"),
        (16, "material `a` is defined again; the first definition counts"),
    ];
    assert_eq!(messages(text), expected.map(|(line, message)| (line, message.to_string())));
    let (materials, _) = library(text).unwrap();
    assert_eq!(materials["a"].bsdf, diffuse(constant(1.0, 0.0, 0.0)));
}

#[test]
fn faults_name_the_library_line_and_column() {
    for (statement, column) in [
        ("Kd", 3),
        ("Kd red", 4),
        ("Kd 1 2", 7),
        ("Ke 1 nan 1", 6),
        ("Ns x", 4),
        ("illum two", 7),
        ("  d inf", 5),
        ("map_Kd -s x.png", 10),
    ] {
        let error = library(format!("# \\\nnewmtl \\\n m\n{statement}\n")).unwrap_err().to_string();
        assert!(error.starts_with(&format!("folder/test.mtl:4:{column}: ")), "{statement}: {error}");
    }
}

#[test]
fn files_are_found_as_people_write_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("Maps")).unwrap();
    for file in ["Maps/Wood.PNG", "a.mtl", "b c.mtl", "B C.MTL"] {
        std::fs::write(folder.path().join(file), "").unwrap();
    }
    let wood = Some(folder.path().join("Maps/Wood.PNG"));
    for name in ["Maps/Wood.PNG", r"Maps\Wood.PNG", r".\maps\wood.png", "MAPS/wood.Png"] {
        assert_eq!(paths::find(folder.path(), name.as_bytes()), wood, "{name}");
    }
    let a = Some(folder.path().join("a.mtl"));
    assert_eq!(paths::find(folder.path(), b"/elsewhere/A.mtl"), a);
    assert_eq!(paths::find(folder.path(), br"C:\elsewhere\a.mtl"), a);
    assert_eq!(paths::find(folder.path(), b"elsewhere/a.mtl"), None);
    assert_eq!(paths::resolve(folder.path(), br"x\y.png"), folder.path().join("x/y.png"));

    let names = |argument: &str| -> Vec<String> {
        library_paths(folder.path(), argument.as_bytes()).into_iter().map(|(name, _)| name).collect()
    };
    assert_eq!(names("b c.mtl"), ["b c.mtl"]);
    assert_eq!(names(r"a.mtl b\ c.mtl"), ["a.mtl", "b c.mtl"]);
    assert_eq!(names(r#""b c.mtl" "a.mtl""#), ["b c.mtl", "a.mtl"]);
    assert_eq!(names("x.mtl b c.mtl\ta.mtl y"), ["x.mtl", "b c.mtl", "a.mtl", "y"]);
}

#[test]
fn libraries_of_an_obj_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\nmap_Kd t.png\n").unwrap();
    std::fs::write(folder.path().join("b.mtl"), "newmtl red\nKd 0 1 0\nnewmtl blue\nKd 0 0 1\naniso 1\n").unwrap();
    let path = folder.path().join("scene.obj");
    std::fs::write(&path, "mtllib a.mtl none.mtl b.mtl\nv 0 0 0\nusemtl red\nf 1 1 1\nusemtl green\nf 1 1 1\n")
        .unwrap();
    let obj = crate::scene::obj::load(&path).unwrap();
    let found: Vec<&String> = obj.materials.keys().collect();
    assert_eq!(found, ["blue", "red"]);
    let texture = ImageTexture { path: folder.path().join("t.png"), tint: Rgb::X, ..image("") };
    assert_eq!(obj.materials["red"].bsdf, diffuse(ColorTexture::Image(texture)));
    let places: Vec<(&Path, usize)> = obj.warnings.iter().map(|w| (&*w.path, w.line)).collect();
    assert_eq!(places, [(&*path, 1), (&*path, 5), (&*folder.path().join("b.mtl"), 5)]);
    std::fs::write(folder.path().join("b.mtl"), "newmtl red\nKd x\n").unwrap();
    let error = crate::scene::obj::load(&path).unwrap_err().to_string();
    assert!(error.contains("b.mtl:2:4: "), "{error}");
}

proptest! {
    #[test]
    fn random_libraries_do_not_panic(
        text in r"((newmtl|Kd|Ke|Ns|Ni|d|Tr|map_Kd|map_d|illum|Pm)( (-s|-mm|-t|-halo|[-+0-9.enaif#\\]{1,5})){0,5}\r?\n){0,20}",
        bytes in prop::collection::vec(any::<u8>(), 0..100),
    ) {
        let text = [b"newmtl m\n", text.as_bytes(), &bytes].concat();
        let _ = library(text);
    }
}
