//! A scene as written, before anything is loaded: every reader ends here, [`super::Scene`] begins here.

use super::model::MeshSource;
use crate::bsdf::{BsdfDescription, DiffuseParameters};
use crate::error::SourceLocation;
use crate::film::FilmSettings;
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::texture::{ImageTexture, ReliefTexture, ScalarTexture};
use glam::{Affine3A, Vec3};
use std::collections::BTreeMap;

/// A whole scene as written. Paths are already resolved against the file that names them.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// `None`: the camera is placed so that the whole scene is seen.
    pub(crate) camera: Option<CameraDescription>,
    pub(crate) film: FilmSettings,
    pub meshes: Vec<MeshDescription>,
    /// Where groups of meshes stand.
    pub(crate) instances: Vec<InstanceDescription>,
    /// By name as in `usemtl`; they replace what the MTL says of that name.
    pub materials: BTreeMap<String, MaterialDescription>,
    pub(crate) lights: Vec<LightDescription>,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraDescription {
    pub(crate) origin: Vec3,
    pub(crate) target: Vec3,
    pub(crate) up: Vec3,
    /// Vertical field of view in degrees, in (0, 180).
    pub(crate) vfov: f32,
    /// The picture is flipped left to right (scene formats with a left-handed camera).
    pub(crate) mirrored: bool,
}

/// A model and where it stands.
#[derive(Clone, Debug)]
pub struct MeshDescription {
    pub(crate) source: MeshSource,
    pub(crate) transform: Affine3A,
    /// Replaces every material of the model.
    pub(crate) material: Option<String>,
    /// The mesh is part of this group and seen only where an instance of the group stands; `transform` then places it
    /// within the group.
    pub(crate) group: Option<String>,
    /// Where the transform is written; `None` where nothing says so.
    pub location: Option<SourceLocation>,
}

/// A group of meshes in one of its places. All places share the meshes and their acceleration structure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct InstanceDescription {
    /// As named by at least one mesh.
    pub(crate) group: String,
    /// From the group to the world; its determinant is not 0.
    pub(crate) transform: Affine3A,
    /// Where that is written; `None` where nothing says so.
    pub(crate) location: Option<SourceLocation>,
}

/// A surface material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDescription {
    pub bsdf: BsdfDescription,
    /// Scatters alike on both sides; else the back of an opaque material is black.
    pub two_sided: bool,
    /// Share of light that is stopped; the rest passes straight through.
    pub opacity: Option<ScalarTexture>,
    /// Radiance (W/(sr·m²)) leaving the side of the face's winding.
    pub emission: Rgb,
    /// Multiplies that from point to point.
    pub emission_map: Option<ImageTexture>,
    /// Both sides emit.
    pub emission_two_sided: bool,
    /// Turns normals.
    pub relief: Option<ReliefTexture>,
}

impl Default for MaterialDescription {
    fn default() -> MaterialDescription {
        MaterialDescription {
            bsdf: DiffuseParameters::default().into(),
            two_sided: true,
            opacity: None,
            emission: Rgb::ZERO,
            emission_map: None,
            emission_two_sided: false,
            relief: None,
        }
    }
}
