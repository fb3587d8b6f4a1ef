//! A scene as Embree's tutorial program can have it: one grey material and a point light.

use super::EmbreePlan;
use crate::film::Filter;
use crate::format::SceneFile;
use crate::guiding::settings::{GuidingMethod, GuidingSettings};
use crate::integrator::{IntegratorSettings, Roulette};
use crate::io::atomic::write_atomically;
use crate::light::{self, LightDescription};
use crate::render::RenderSettings;
use crate::scene::description::{CameraDescription, Projection, SceneDescription};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};
use glam::Vec3;
use rustc_hash::FxHashMap;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;
use tempfile::TempDir;

/// The one light.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PointLight {
    pub(crate) position: Vec3,
    /// W/sr; so much that a surface half the scene's size away gets an irradiance of π.
    pub(crate) intensity: Vec3,
    /// What its place comes from.
    pub(crate) origin: &'static str,
}

/// How far off an emitter the light hangs, as a share of the scene's radius.
const HANGING: f32 = 0.01;

/// The files, for as long as this lives, and what Phototaxis is told of them.
pub(crate) struct StandIn {
    folder: TempDir,
    pub(crate) description: SceneFile,
    pub(crate) light: PointLight,
}

impl StandIn {
    pub(crate) fn write(scene: &Scene, description: &SceneFile, plan: &EmbreePlan) -> Result<StandIn> {
        let folder = TempDir::with_prefix("phototaxis-bench-").map_err(Error::io(std::env::temp_dir()))?;
        let model = folder.path().join(MODEL);
        write_atomically(&model, |file| write_model(file, scene.facets()))?;
        let albedo = plan.albedo;
        let library = format!("newmtl {GREY}\nillum 1\nKd {albedo} {albedo} {albedo}\n");
        write_atomically(&folder.path().join(LIBRARY), |file| file.write_all(library.as_bytes()))?;
        let light = light(scene, description);
        let description = stand_in(scene, description, plan, model, &light);
        Ok(StandIn { folder, description, light })
    }

    pub(crate) fn model(&self) -> PathBuf {
        self.folder.path().join(MODEL)
    }

    pub(crate) fn camera(&self) -> &CameraDescription {
        self.description.scene.camera.as_ref().expect("a stand-in is made with its camera")
    }
}

const MODEL: &str = "model.obj";
const LIBRARY: &str = "model.mtl";
const GREY: &str = "grey";

fn stand_in(
    scene: &Scene,
    description: &SceneFile,
    plan: &EmbreePlan,
    model: PathBuf,
    light: &PointLight,
) -> SceneFile {
    let camera = Camera::in_place(description.scene.camera.as_ref(), scene.bounds());
    let mut film = description.scene.film.clone();
    film.filter = Filter::Box;
    film.crop = None;
    let scene = SceneDescription {
        // the program has pinholes alone, and no mirrored view; turning it changes no ray's cost
        camera: Some(CameraDescription {
            projection: Projection::Perspective,
            aperture_radius: 0.0,
            mirrored: false,
            ..camera
        }),
        film,
        meshes: vec![crate::format::whole_file(&model)],
        lights: vec![light::PointLight { position: light.position, intensity: light.intensity }.into()],
        ..Default::default()
    };
    SceneFile {
        scene,
        integrator: IntegratorSettings { max_depth: plan.depth, roulette: Roulette::None, ..Default::default() },
        guiding: GuidingSettings { method: GuidingMethod::None, ..Default::default() },
        render: RenderSettings { spp: plan.spp * plan.frames, seed: description.render.seed, ..Default::default() },
    }
}

/// Triangles in world space, corners that coincide held once; both renderers are to take the normals of triangles.
fn write_model(file: &mut dyn Write, facets: impl Iterator<Item = [Vec3; 3]>) -> io::Result<()> {
    writeln!(file, "mtllib {LIBRARY}\nusemtl {GREY}")?;
    let mut numbers = FxHashMap::default();
    for facet in facets {
        let mut corners = [0; 3];
        for (corner, p) in corners.iter_mut().zip(facet) {
            let next = numbers.len() + 1;
            *corner = *numbers.entry(p.to_array().map(f32::to_bits)).or_insert(next);
            if *corner == next {
                writeln!(file, "v {} {} {}", p.x, p.y, p.z)?;
            }
        }
        let [a, b, c] = corners;
        writeln!(file, "f {a} {b} {c}")?;
    }
    Ok(())
}

/// The scene's own point light; else one just off the middle of what emits; else one at the camera.
fn light(scene: &Scene, description: &SceneFile) -> PointLight {
    let (low, high) = scene.bounds();
    let radius = 0.5 * (high - low).length();
    let intensity = Vec3::splat(std::f32::consts::PI * 0.25 * radius * radius);
    let own = description.scene.lights.iter().find_map(|light| match light {
        LightDescription::Point(point) => Some(point.position),
        _ => None,
    });
    let emitter = || middle_of_emitters(scene).map(|(p, n)| p + n * (HANGING * radius));
    let camera = || Camera::in_place(description.scene.camera.as_ref(), (low, high)).origin;
    let (position, origin) = match own {
        Some(position) => (position, "the scene's own"),
        None => emitter().map_or_else(|| (camera(), "at the camera"), |p| (p, "off the middle of the emitters")),
    };
    PointLight { position, intensity, origin }
}

/// Mean point and unit mean normal of emissive triangles, by area; `None` where there are none, or they face all ways.
fn middle_of_emitters(scene: &Scene) -> Option<(Vec3, Vec3)> {
    let (mut sum, mut area, mut normal) = (Vec3::ZERO, 0.0, Vec3::ZERO);
    for (k, mesh) in (0..).zip(scene.meshes()) {
        for (t, triangle) in (0..).zip(&mesh.triangles) {
            if scene.lights().triangle_light(k, t).is_some() {
                let [a, b, c] = triangle.map(|i| Vec3::from(mesh.positions[i as usize]));
                let cross = 0.5 * (b - a).cross(c - a);
                sum += (a + b + c) / 3.0 * cross.length();
                area += cross.length();
                normal += cross;
            }
        }
    }
    normal.try_normalize().filter(|_| area > 0.0).map(|n| (sum / area, n))
}
