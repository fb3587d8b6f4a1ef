//! A scene as written, before anything is loaded: every reader ends here, [`super::Scene`] begins here.

use super::model::MeshSource;
use crate::Result;
use crate::bsdf::{BsdfDescription, DiffuseParameters};
use crate::error::{Place, SourceLocation};
use crate::film::FilmSettings;
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::texture::{ColorTexture, ScalarTexture};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

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
    /// Changes to what the models' own libraries say of materials, in their order.
    pub(crate) material_changes: Vec<MaterialChange>,
    /// Materials that a model has to have, and where they are named.
    pub(crate) named_materials: Vec<(String, Place)>,
    pub(crate) lights: Vec<LightDescription>,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraDescription {
    pub(crate) origin: DVec3,
    pub(crate) target: DVec3,
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
    pub(crate) transform: DAffine3,
    /// Replaces every material of the model.
    pub(crate) material: Option<String>,
    /// Where that is written.
    pub(crate) material_location: Option<SourceLocation>,
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
    pub(crate) transform: DAffine3,
    /// Where that is written; `None` where nothing says so.
    pub(crate) location: Option<SourceLocation>,
}

/// What a scene file says of a material that it does not describe as a whole.
#[derive(Clone)]
pub(crate) struct MaterialChange {
    pub(crate) name: String,
    /// The material with the change. An error is one at its place in the scene file.
    pub(crate) apply: Arc<Change>,
}

type Change = dyn Fn(&MaterialDescription) -> Result<MaterialDescription> + Send + Sync;

impl fmt::Debug for MaterialChange {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("MaterialChange").field(&self.name).finish()
    }
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
    /// Both sides emit.
    pub emission_two_sided: bool,
}

impl MaterialDescription {
    /// Of a name that nothing describes: diffuse, in the colours of the mesh's vertices where it has some, else grey.
    pub(crate) fn unknown(has_colors: bool) -> MaterialDescription {
        let diffuse = if has_colors {
            DiffuseParameters { reflectance: ColorTexture::Vertex(Rgb::ONE) }
        } else {
            DiffuseParameters::default()
        };
        MaterialDescription { bsdf: diffuse.into(), ..MaterialDescription::default() }
    }

    /// Multiplies what is the colour of the surface by those of the mesh's vertices, unless it is a picture's. Black, beside which they
    /// would not be seen, is left out.
    pub(crate) fn multiply_vertex_colors(&mut self) {
        let colour = match &mut self.bsdf {
            BsdfDescription::Diffuse(diffuse) => &mut diffuse.reflectance,
            BsdfDescription::Plastic(plastic) => &mut plastic.reflectance,
            BsdfDescription::Principled(principled) => &mut principled.base_color,
            BsdfDescription::Conductor(conductor) => &mut conductor.specular_reflectance,
            _ => return,
        };
        if let ColorTexture::Constant(constant) = *colour {
            *colour = ColorTexture::Vertex(if constant == Rgb::ZERO { Rgb::ONE } else { constant });
        }
    }
}

impl Default for MaterialDescription {
    fn default() -> MaterialDescription {
        MaterialDescription {
            bsdf: DiffuseParameters::default().into(),
            two_sided: true,
            opacity: None,
            emission: Rgb::ZERO,
            emission_two_sided: false,
        }
    }
}
