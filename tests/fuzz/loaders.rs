//! What is done with an input of each kind: all that a render or a comparison does with such a file.

use crate::mutate::Kind;
use crate::{pictures, seeds};
use glam::Vec3;
use phototaxis::format as scene_file;
use phototaxis::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings};
use phototaxis::guiding::{Guide, Hue, PackedDirection, Recorder, ShadowOutcome, Transition};
use phototaxis::image::exr::read_layers;
use phototaxis::integrator::IntegratorSettings;
use phototaxis::lab::compare::file as plan_file;
use phototaxis::lab::compare::store::Store;
use phototaxis::math::rng::Rng;
use phototaxis::math::warp;
use phototaxis::render::guide_file::{self as guide_file, GuideFingerprint};
use phototaxis::scene::{obj, ply};
use phototaxis::texture::Texture;
use std::path::{Path, PathBuf};

/// All kinds, each with the divisor of how many inputs it gets: a whole scene takes as long as a hundred files.
pub const LOADERS: [(&str, u64); 14] = [
    ("obj", 1),
    ("ply", 1),
    ("xml", 1),
    ("gltf", 1),
    ("mtl", 1),
    ("toml", 1),
    ("json", 1),
    ("scene", 20),
    ("png", 1),
    ("jpeg", 1),
    ("exr", 1),
    ("guide", 1),
    ("plan", 1),
    ("runs", 1),
];

const BOUNDS: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ONE);

/// A kind of file in a folder of its own.
pub struct Loader {
    name: &'static str,
    folder: PathBuf,
    seeds: Vec<Vec<u8>>,
    /// Of guides: what they were learnt with, in turn.
    settings: Vec<GuidingSettings>,
}

impl Loader {
    pub fn new(name: &str, folder: &Path) -> Loader {
        let (name, _) = *LOADERS.iter().find(|(known, _)| *known == name).expect("a known loader");
        seeds::write_companions(folder);
        let settings = if name == "guide" { guides() } else { Vec::new() };
        let text = |files: &[&str]| files.iter().map(|file| file.as_bytes().to_vec()).collect();
        let seeds = match name {
            "obj" => text(&seeds::OBJ),
            "ply" => seeds::ply(),
            "xml" => text(&seeds::XML),
            "gltf" => text(&[seeds::GLTF]),
            "mtl" => text(&seeds::MTL),
            "toml" => text(&seeds::TOML),
            "scene" => text(&seeds::TOML[1..]),
            "json" => text(&seeds::JSON),
            "png" => pictures::png(),
            "jpeg" => pictures::jpeg(),
            "exr" => pictures::exr(),
            "guide" => settings.iter().map(|settings| learnt(settings, folder)).collect(),
            "plan" => text(&seeds::PLAN),
            _ => text(&[seeds::RUNS]),
        };
        Loader { name, folder: folder.to_path_buf(), seeds, settings }
    }

    /// Where its input is to be written.
    pub fn path(&self) -> PathBuf {
        let extension = if self.name == "scene" { "toml" } else { self.name };
        self.folder.join("input").with_extension(extension)
    }

    pub fn seeds(&self) -> u64 {
        self.seeds.len() as u64
    }

    pub fn input(&self, index: u64) -> Vec<u8> {
        let (words, text): (&[&[u8]], bool) = match self.name {
            "obj" => (&seeds::OBJ_WORDS, true),
            "ply" => (&seeds::PLY_WORDS, false),
            "xml" => (&seeds::XML_WORDS, true),
            "gltf" => (&seeds::GLTF_WORDS, true),
            "mtl" => (&seeds::MTL_WORDS, true),
            "toml" | "scene" => (&seeds::TOML_WORDS, true),
            "json" => (&seeds::JSON_WORDS, true),
            "plan" => (&seeds::PLAN_WORDS, true),
            "runs" => (&seeds::RUNS_WORDS, true),
            "png" => (&pictures::PNG_WORDS, false),
            "jpeg" => (&pictures::JPEG_WORDS, false),
            "exr" => (&pictures::EXR_WORDS, false),
            _ => (&seeds::GUIDE_WORDS, false),
        };
        let mut bytes = Kind { seeds: &self.seeds, words, text }.input(index);
        // a checksum that is wrong would be all that is ever found
        let mend = index >= self.seeds() && !index.is_multiple_of(8);
        match self.name {
            "png" if mend => pictures::mend_png(&mut bytes),
            "guide" if mend => mend_guide(&mut bytes),
            _ => (),
        }
        bytes
    }

    /// Reads the input; the error where it is refused.
    pub fn load(&self, index: u64) -> Result<(), String> {
        let path = self.path();
        let refused = |error: phototaxis::Error| error.to_string();
        match self.name {
            "obj" => obj::load(&path).map(drop).map_err(refused),
            "mtl" => obj::load(&self.folder.join("input.obj")).map(drop).map_err(refused),
            "ply" => ply::load(&path).map(drop).map_err(refused),
            "toml" | "json" | "xml" | "gltf" => scene_file::load(&path, &[]).map(drop).map_err(refused),
            "scene" => {
                let (description, _) = scene_file::load(&path, &[]).map_err(refused)?;
                description.load_scene(1).map(drop).map_err(refused)
            }
            "png" | "jpeg" => Texture::load(&path).map(drop).map_err(refused),
            "exr" if index.is_multiple_of(2) => Texture::load(&path).map(drop).map_err(refused),
            "exr" => read_layers(&path).map(drop).map_err(refused),
            "guide" => self.guide(&path, index),
            "plan" => plan_file::read(&path).and_then(|draft| draft.finish()).map(drop).map_err(refused),
            _ => Store::open(&path, "h", "t").map(drop).map_err(refused),
        }
    }

    /// A guide that is accepted also goes on learning.
    fn guide(&self, path: &Path, index: u64) -> Result<(), String> {
        let count = self.settings.len() as u64;
        let read = |settings: &GuidingSettings| guide_file::read(path, &subject(settings), settings, BOUNDS);
        let own = (index < count).then(|| &self.settings[index as usize]);
        let results = self.settings.iter().filter(|settings| own.is_none_or(|own| own == *settings)).map(read);
        let mut refused = Err(String::new());
        for result in results {
            match result {
                Ok(mut trained) => {
                    teach(&mut trained.guide, 20, &mut Rng::new(index));
                    trained.guide.end_iteration(1);
                    return Ok(());
                }
                Err(error) => refused = Err(error.to_string()),
            }
        }
        refused
    }
}

/// Small guides of every kind.
fn guides() -> Vec<GuidingSettings> {
    let small = GuidingSettings {
        resolution: 2,
        strata: 3,
        levels: 2,
        sites: 6,
        refine_visits: 20.0,
        leaf_samples: 60.0,
        memory: 1 << 20,
        ..GuidingSettings::default()
    };
    let kind = |method, table| GuidingSettings { method, table, ..small.clone() };
    vec![
        kind(GuidingMethod::Grid, DirectionTable::Hemisphere),
        kind(GuidingMethod::Grid, DirectionTable::Tree),
        kind(GuidingMethod::Adaptive, DirectionTable::Sphere),
        kind(GuidingMethod::Adaptive, DirectionTable::Tree),
        kind(GuidingMethod::Voronoi, DirectionTable::Tree),
        kind(GuidingMethod::SdTree, DirectionTable::Tree),
    ]
}

fn subject(settings: &GuidingSettings) -> GuideFingerprint {
    GuideFingerprint::new("a scene".into(), settings, &IntegratorSettings::default())
}

fn learnt(settings: &GuidingSettings, folder: &Path) -> Vec<u8> {
    let mut guide = Guide::new(settings, BOUNDS, std::iter::empty()).expect("not the method none");
    let mut rng = Rng::new(1);
    for _ in 0..2 {
        teach(&mut guide, 200, &mut rng);
        guide.end_iteration(1);
    }
    let path = folder.join("seed.guide");
    guide_file::write(&path, &guide, &subject(settings), 1).unwrap();
    std::fs::read(path).unwrap()
}

/// Visits on a floor under light that changes from place to place.
fn teach(guide: &mut Guide, visits: usize, rng: &mut Rng) {
    let mut recorder = Recorder::new();
    for _ in 0..visits {
        let (p, w) = (Vec3::new(rng.f32(), 0.5, rng.f32()), warp::square_to_uniform_sphere(rng.f32x2()));
        let wi = if w.y < 0.0 { -w } else { w };
        let Some(at) = guide.field().locate(p, Vec3::Y, [rng.f32(), rng.f32(), 0.5]) else {
            recorder.push_point(p, Vec3::Y);
            continue;
        };
        let target = wi.dot(p).max(0.0) * rng.f32();
        recorder.push(Transition {
            key: at.recorded,
            wi: PackedDirection::new(wi),
            normal: PackedDirection::new(Vec3::Y),
            target,
            bootstrapped: target,
            pdf: 0.2,
            bsdf_pdf: 0.3,
            guide_pdf: 0.1,
            scattered: 0.3,
            hue: Hue::GREY,
            rays: 2,
            shadow: ShadowOutcome::NONE,
        });
    }
    guide.learn(&[&recorder]);
}

/// Puts length and checksum right.
fn mend_guide(bytes: &mut [u8]) {
    let Some(length) = bytes.len().checked_sub(24) else { return };
    bytes[12..20].copy_from_slice(&(length as u64).to_le_bytes());
    let end = bytes.len() - 4;
    let sum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&sum.to_le_bytes());
}
