use crate::format;
use crate::image::{Layer, exr};
use crate::io::canon::texels;
use crate::math::Rgb;
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::path::Path;

/// What the files of a small scene with one of everything hold.
#[derive(Clone)]
struct Files {
    obj: String,
    mtl: String,
    toml: String,
    texels: Vec<[u8; 3]>,
    sky: Vec<Rgb>,
    texture_name: &'static str,
}

impl Files {
    fn new() -> Files {
        let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nvn 0.5 0 1\n\
                   usemtl wood\nf 1/1/1 2/2/1 3/3/2\nusemtl glow\nf 1 2 4\n";
        let mtl = "newmtl wood\nmap_Kd wood.png\nnewmtl glow\nKe 1 2 3\n";
        let toml = "[camera]\norigin = [0, 0, 5]\ntarget = [0, 0, 0]\n[[mesh]]\npath = 'm.obj'\n\
                    [[mesh]]\npath = 'm.obj'\ngroup = 'a'\nscale = 0.5\n[[instance]]\ngroup = 'a'\ntranslate = [2, 0, 0]\n\
                    [[light]]\ntype = 'point'\nposition = [0, 0, 3]\nintensity = 4\n\
                    [[light]]\ntype = 'environment'\npath = 'sky.exr'\nscale = 0.25\n";
        Files {
            obj: obj.into(),
            mtl: mtl.into(),
            toml: toml.into(),
            texels: vec![[10, 20, 30], [40, 50, 60], [70, 80, 90], [100, 110, 120]],
            sky: vec![Rgb::new(1.0, 2.0, 3.0), Rgb::ONE, Rgb::X, Rgb::Y],
            texture_name: "wood.png",
        }
    }

    fn with(change: impl FnOnce(&mut Files)) -> Files {
        let mut files = Files::new();
        change(&mut files);
        files
    }

    /// Writes the files into a folder of their own, and loads what they say.
    fn load(&self) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("m.obj"), &self.obj).unwrap();
        std::fs::write(at("m.mtl"), &self.mtl).unwrap();
        let texel = |x: u32, y: u32| image::Rgb(self.texels[(2 * y + x) as usize]);
        image::RgbImage::from_fn(2, 2, texel).save(at(self.texture_name)).unwrap();
        let metadata = exr::Metadata::default();
        exr::write(&at("sky.exr"), &exr::Window::full(2, 2), vec![Layer::color("", &self.sky)], &metadata).unwrap();
        let (description, _) = format::parse(&self.toml, &at("scene.toml"), &[]).unwrap();
        description.load_scene(1).unwrap().0
    }

    fn hash(&self) -> String {
        self.load().content_hash_text()
    }
}

fn replaced(text: &mut String, from: &str, to: &str) {
    assert!(text.contains(from), "{from:?} is not there");
    *text = text.replacen(from, to, 1);
}

/// Who changes what is hashed raises the version in its domain, and that of guides' files; then this number may change.
#[test]
fn the_hash_of_a_scene_is_what_it_was_in_earlier_releases() {
    let scene = Files::new().load();
    assert_eq!(scene.content_hash_text(), "cbbeb658a0396d7d");
    assert_eq!(scene.hash_text(), "8a2842a25e9ce4c4");
}

#[test]
fn each_kind_of_change_gives_another_hash() {
    type Change = fn(&mut Files);
    let changes: [(&str, Change); 22] = [
        ("nothing", |_| ()),
        ("a vertex", |f| replaced(&mut f.obj, "v 0 0 1\n", "v 0 0 1.0000001\n")),
        ("a vertex that no face has", |f| f.obj += "v 9 9 9\n"),
        ("a triangle", |f| replaced(&mut f.obj, "f 1 2 4", "f 1 3 4")),
        ("a winding", |f| replaced(&mut f.obj, "f 1 2 4", "f 1 4 2")),
        ("a normal", |f| replaced(&mut f.obj, "vn 0.5 0 1", "vn 0.5 0.001 1")),
        ("which corner has a normal", |f| replaced(&mut f.obj, "3/3/2", "3/3/1")),
        ("no normals", |f| f.obj = f.obj.replace("/1 ", " ").replace("/2\n", "\n")),
        ("a texture coordinate", |f| replaced(&mut f.obj, "vt 1 0", "vt 1 0.001")),
        ("which corner has a coordinate", |f| replaced(&mut f.obj, "2/2/1", "2/3/1")),
        ("the material of a triangle", |f| replaced(&mut f.obj, "usemtl glow", "usemtl wood")),
        ("what a material emits", |f| replaced(&mut f.mtl, "Ke 1 2 3", "Ke 1 2 3.5")),
        ("how a material scatters", |f| f.mtl += "Kd 0.1 0.2 0.3\n"),
        ("what is seen through", |f| f.mtl += "d 0.5\n"),
        ("a texel", |f| f.texels[2][1] += 1),
        ("how a picture lies", |f| replaced(&mut f.mtl, "map_Kd wood", "map_Kd -s 2 1 wood")),
        ("a light", |f| replaced(&mut f.toml, "intensity = 4", "intensity = 5")),
        ("where a light is", |f| replaced(&mut f.toml, "position = [0, 0, 3]", "position = [0, 0, 4]")),
        ("a pixel of the sky", |f| f.sky[3] = Rgb::Z),
        ("the sky's scale", |f| replaced(&mut f.toml, "scale = 0.25", "scale = 0.5")),
        ("an instance", |f| replaced(&mut f.toml, "translate = [2", "translate = [3")),
        ("another instance", |f| f.toml += "[[instance]]\ngroup = 'a'\n"),
    ];
    let mut seen = BTreeMap::new();
    for (what, change) in changes {
        if let Some(other) = seen.insert(Files::with(change).hash(), what) {
            panic!("{what} has the hash of {other}");
        }
    }
}

/// Options that came later than the hash leave it as it was where they are not used.
#[test]
fn an_option_that_is_not_used_does_not_change_the_hash() {
    let metal =
        |more: &str| Files::with(|f| f.toml += &format!("[material.wood]\ntype = 'conductor'\nalpha = 0.3\n{more}"));
    let plain = metal("").hash();
    assert_eq!(metal("energy_conserving = false\n").hash(), plain);
    assert_ne!(metal("energy_conserving = true\n").hash(), plain);
}

#[test]
fn names_numbers_text_and_views_do_not_change_the_hash() {
    type Change = fn(&mut Files);
    let changes: [(&str, Change); 6] = [
        ("names of materials", |f| {
            (f.obj, f.mtl) = (f.obj.replace("wood", "oak"), f.mtl.replace("newmtl wood", "newmtl oak"));
        }),
        ("names of pictures", |f| {
            f.texture_name = "other.png";
            f.mtl = f.mtl.replace("wood.png", "other.png");
        }),
        ("names of groups", |f| f.toml = f.toml.replace("group = 'a'", "group = 'other'")),
        ("how numbers are written", |f| {
            replaced(&mut f.obj, "vn 0.5 0 1", "vn 5e-1 0.0 +1.000");
            replaced(&mut f.toml, "intensity = 4", "intensity = 4.0");
        }),
        ("comments", |f| f.obj += "# a comment\n"),
        ("cameras, films and settings", |f| {
            replaced(&mut f.toml, "origin = [0, 0, 5]", "origin = [0, 1, 5]");
            f.toml += "[film]\nwidth = 7\n[guiding]\nresolution = 9\n[render]\nseed = 5\n";
        }),
    ];
    let wanted = Files::new().hash();
    for (what, change) in changes {
        assert_eq!(Files::with(change).hash(), wanted, "{what}");
    }
}

#[test]
fn views_have_hashes_of_their_own() {
    let hash = |from: &str, to: &str| Files::with(|f| replaced(&mut f.toml, from, to)).load().hash_text();
    let hashes = [
        Files::new().load().hash_text(),
        hash("origin = [0, 0, 5]", "origin = [0, 0, 6]"),
        hash("[camera]", "[film]\nheight = 721\n[camera]"),
        hash("[camera]", "[film]\nfilter = 'tent'\n[camera]"),
        hash("intensity = 4", "intensity = 5"),
    ];
    let distinct: std::collections::BTreeSet<&String> = hashes.iter().collect();
    assert_eq!(distinct.len(), hashes.len(), "{hashes:?}");
}

/// Arrays of several blocks, which threads share.
#[test]
fn threads_do_not_change_the_hash_of_an_array() {
    let values: Vec<u32> = (0..1_000_003).collect();
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| texels([1_000_003, 1], |canon| canon.array(&values)))
    };
    assert_eq!(hash(1), hash(7));
    // each of its blocks counts
    for at in [0, 300_000, 600_000, 1_000_002] {
        let mut other = values.clone();
        other[at] ^= 1;
        assert_ne!(texels([1_000_003, 1], |canon| canon.array(&other)), hash(3), "{at}");
    }
}

#[test]
fn pictures_of_another_shape_or_another_kind_differ() {
    let folder = tempfile::tempdir().unwrap();
    let hash = |picture: image::DynamicImage| {
        let path: &Path = &folder.path().join("a.png");
        picture.save(path).unwrap();
        crate::texture::Texture::load(path).unwrap().content_hash()
    };
    let grey = |w, h| image::GrayImage::from_pixel(w, h, image::Luma([0]));
    let hashes = [
        hash(grey(2, 3).into()),
        hash(grey(3, 2).into()),
        hash(grey(6, 1).into()),
        hash(image::RgbImage::new(2, 1).into()),
        hash(image::ImageBuffer::<image::Luma<u16>, _>::new(3, 1).into()),
    ];
    let distinct: std::collections::BTreeSet<u64> = hashes.into_iter().collect();
    assert_eq!(distinct.len(), hashes.len());
}
