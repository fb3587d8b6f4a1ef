//! What a scene file says, before anything is loaded: every importer ends here, [`super::Scene`] begins here.

mod guiding;
mod material;

pub use guiding::*;
pub use material::*;

use crate::Error;
use crate::math::Rgb;
use glam::{Affine3A, Vec3};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A whole scene as written. Paths are already resolved against the file that names them.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// `None`: the camera is placed so that the whole scene is seen.
    pub camera: Option<CameraDescription>,
    pub film: FilmDescription,
    pub meshes: Vec<MeshDescription>,
    /// Where groups of meshes stand.
    pub instances: Vec<InstanceDescription>,
    /// By name as in `usemtl`; they replace what the MTL says of that name.
    pub materials: BTreeMap<String, MaterialDescription>,
    pub lights: Vec<LightDescription>,
    pub integrator: IntegratorSettings,
    pub guiding: GuidingSettings,
    pub render: RenderSettings,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    pub origin: Vec3,
    pub target: Vec3,
    pub up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub vfov: f32,
    /// The picture is flipped left to right (scene formats with a left-handed camera).
    pub mirrored: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FilmDescription {
    pub width: u32,
    pub height: u32,
    pub filter: Filter,
    /// Of the PNG only: stops by which the picture is brightened.
    pub exposure: f32,
}

impl Default for FilmDescription {
    fn default() -> FilmDescription {
        FilmDescription { width: 1280, height: 720, filter: Filter::Box, exposure: 0.0 }
    }
}

/// Pixel reconstruction filters. They are importance sampled, so that a sample belongs to one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// One pixel wide.
    Box,
    /// Radius one pixel.
    Tent,
    /// Truncated at the radius 1.5 pixels, standard deviation 0.5 pixels.
    Gaussian,
}

/// Where a scene file says something. Line and column count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceLocation {
    pub path: PathBuf,
    pub line: usize,
    pub column: usize,
}

impl SourceLocation {
    /// That what is said there cannot be used.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::parse(&self.path, self.line, self.column, message)
    }
}

/// A file of triangles and where it stands.
#[derive(Clone, Debug)]
pub struct MeshDescription {
    pub path: PathBuf,
    pub transform: Affine3A,
    /// Replaces every material of the file.
    pub material: Option<String>,
    /// The mesh is part of this group and seen only where an instance of the group stands; `transform` then places it
    /// within the group.
    pub group: Option<String>,
    /// Where the transform is written; `None` where nothing says so.
    pub location: Option<SourceLocation>,
}

/// A group of meshes in one of its places. All places share the meshes and their acceleration structure.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceDescription {
    /// As named by at least one mesh.
    pub group: String,
    /// From the group to the world; its determinant is not 0.
    pub transform: Affine3A,
    /// Where that is written; `None` where nothing says so.
    pub location: Option<SourceLocation>,
}

/// Lights that are not surfaces.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// Lat-long picture (EXR, linear): u = atan2(x, −z)/2π, v = acos(y)/π, row 0 is +y, in the light's own frame.
    Environment { path: PathBuf, scale: Rgb, to_world: Affine3A },
    /// The same radiance from everywhere.
    Constant { radiance: Rgb },
    /// `intensity` in W/sr.
    Point { position: Vec3, intensity: Rgb },
    /// Light travels along `direction`; `irradiance` in W/m² on a surface that faces it.
    Directional { direction: Vec3, irradiance: Rgb },
}

/// How paths are built.
#[derive(Clone, Debug, PartialEq)]
pub struct IntegratorSettings {
    /// Path segments from the camera, at most: 1 sees emitters only, 2 direct light.
    pub max_depth: u32,
    /// Next-event estimation: every vertex looks at a light ("path reuse" in the paper).
    pub next_event: bool,
    /// Emitters that are hit count by the power heuristic; without it only what next-event estimation cannot reach counts.
    pub mis: bool,
    pub roulette: Roulette,
    /// Segments before roulette may end a path.
    pub rr_depth: u32,
    /// Guided roulette splits a path into at most this many.
    pub max_split: f32,
}

impl Default for IntegratorSettings {
    fn default() -> IntegratorSettings {
        IntegratorSettings {
            max_depth: 16,
            next_event: true,
            mis: true,
            roulette: Roulette::Guided,
            rr_depth: 5,
            max_split: 8.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Roulette {
    None,
    /// By what scattering alone would leave of the path's throughput, so that a guide's choices do not end its paths.
    Throughput,
    /// By what the guide expects of going on, against what it costs and what the pixel holds (Rath et al. 2022); where
    /// that is much, the path is split.
    Guided,
}

/// How long, from which numbers, and what becomes of the iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples per pixel over all iterations.
    pub spp: u32,
    /// Seconds after loading; rendering stops at whichever of `spp` and `time` comes first.
    pub time: Option<f64>,
    pub seed: u64,
    pub combine: Combine,
    pub order: Order,
    /// Watertight ray queries: no ray slips between two triangles that share an edge, for about a quarter of the speed.
    pub robust: bool,
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            spp: 64,
            time: None,
            seed: 0,
            combine: Combine::InverseVariance,
            order: Order::Progressive,
            robust: false,
        }
    }
}

/// Which samples come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Passes over the whole picture, in iterations of doubling length.
    Progressive,
    /// One block after the other, each with all of its samples, from the middle outwards: a single iteration.
    Blocks,
}

/// What becomes of the iterations' pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// Only the last counts (the paper).
    Last,
    /// All samples count alike.
    All,
    /// Each picture is weighted by the inverse of its estimated variance (Müller et al. 2017).
    InverseVariance,
}
