//! A scene as written, before anything is loaded: every reader ends here, [`super::Scene`] begins here.

use super::model::MeshSource;
use crate::Result;
use crate::bsdf::{BsdfDescription, DiffuseParameters};
use crate::error::{Place, SourceLocation};
use crate::film::FilmSettings;
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::texture::{ColorTexture, EmbeddedPictures, ImageTexture, ReliefTexture, ScalarTexture};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

/// A whole scene as written. Paths are already resolved against the file that names them.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// `None`: nothing is said of it, and all of it is found.
    pub(crate) camera: Option<CameraDescription>,
    /// Other cameras, by name, of which one may be chosen.
    pub(crate) cameras: Vec<NamedCamera>,
    /// A sky is added also where there are lights but none of theirs reaches the camera: for models that nobody has made a
    /// scene of.
    pub(crate) sky_where_dark: bool,
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
    /// Of the first of these lights, in their order, the groups that they are in.
    pub(crate) light_groups: Vec<Option<String>>,
    /// Pictures that textures name and that are in no file of their own.
    pub(crate) pictures: EmbeddedPictures,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Projection {
    Perspective,
    /// All rays are parallel.
    Orthographic,
    /// All directions by longitude and latitude, 360° × 180°, the target in the middle.
    Panorama,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraDescription {
    pub(crate) projection: Projection,
    pub(crate) origin: DVec3,
    pub(crate) target: DVec3,
    pub(crate) up: Vec3,
    /// Vertical field of view in degrees, in (0, 180), of a perspective camera.
    pub(crate) vfov: f32,
    /// Height of what an orthographic camera sees, in the scene's unit.
    pub(crate) view_height: f32,
    /// Radius of the lens of a perspective camera, in the scene's unit; 0 for a pinhole.
    pub(crate) aperture_radius: f32,
    /// Along the view; `None`: the target is in focus.
    pub(crate) focus_distance: Option<f32>,
    /// The picture is flipped left to right (scene formats with a left-handed camera).
    pub(crate) mirrored: bool,
    /// Where it is at frames, in their order; they count where frames are rendered.
    pub(crate) keys: Vec<CameraKey>,
    pub(crate) interpolation: Interpolation,
    pub(crate) unsaid: Unsaid,
}

/// What is said of a camera at one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CameraKey {
    pub(crate) frame: f64,
    pub(crate) origin: Option<DVec3>,
    pub(crate) target: Option<DVec3>,
    pub(crate) up: Option<Vec3>,
    pub(crate) vfov: Option<f32>,
    pub(crate) view_height: Option<f32>,
    pub(crate) aperture_radius: Option<f32>,
    pub(crate) focus_distance: Option<f32>,
}

/// How a camera goes from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Interpolation {
    #[default]
    Smooth,
    Linear,
}

/// A camera that can be chosen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NamedCamera {
    pub(crate) name: String,
    pub(crate) camera: CameraDescription,
    /// Width and height of its picture, where the file says so.
    pub(crate) size: [Option<u32>; 2],
}

/// Which keys of a camera nobody has said. What they hold counts for nothing where the camera is found by what is seen
/// ([`super::view`]); where origin and target are both said, it is their default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Unsaid {
    pub(crate) origin: bool,
    pub(crate) target: bool,
    pub(crate) up: bool,
    pub(crate) vfov: bool,
    pub(crate) view_height: bool,
}

impl Unsaid {
    /// Nothing is said.
    pub(crate) const ALL: Unsaid = Unsaid { origin: true, target: true, up: true, vfov: true, view_height: true };

    /// Whether the camera has to be found.
    pub(crate) fn is_open(&self) -> bool {
        self.origin || self.target
    }
}

impl CameraDescription {
    /// One of which nothing is said.
    pub(crate) fn open() -> CameraDescription {
        CameraDescription { unsaid: Unsaid::ALL, ..CameraDescription::default() }
    }
}

impl Default for CameraDescription {
    /// What the keys of a camera are where nothing else is said.
    fn default() -> CameraDescription {
        CameraDescription {
            projection: Projection::Perspective,
            origin: DVec3::ZERO,
            target: DVec3::ZERO,
            up: Vec3::Y,
            vfov: 45.0,
            view_height: 1.0,
            aperture_radius: 0.0,
            focus_distance: None,
            mirrored: false,
            keys: Vec::new(),
            interpolation: Interpolation::Smooth,
            unsaid: Unsaid::default(),
        }
    }
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
    /// Multiplies that from point to point.
    pub emission_map: Option<ImageTexture>,
    /// Both sides emit.
    pub emission_two_sided: bool,
    /// Which light group surfaces that emit are in.
    pub light_group: Option<String>,
    /// Turns normals.
    pub relief: Option<ReliefTexture>,
    /// The surface is two others, mixed. How it scatters, its sides and its relief are theirs then; opacity counts beside theirs.
    pub blend: Option<BlendDescription>,
}

/// Two materials mixed: f = (1 − w) f₁ + w f₂.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendDescription {
    /// The share w of the second.
    pub weight: ScalarTexture,
    /// What they emit has no part in it.
    pub parts: Arc<[BlendPart; 2]>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendPart {
    /// The material of the scene file that it is.
    pub name: Option<String>,
    pub material: MaterialDescription,
}

impl From<MaterialDescription> for BlendPart {
    fn from(material: MaterialDescription) -> BlendPart {
        BlendPart { name: None, material }
    }
}

impl MaterialDescription {
    /// Two materials, the second with the share `weight`.
    pub(crate) fn blend(weight: ScalarTexture, [first, second]: [MaterialDescription; 2]) -> MaterialDescription {
        let blend = BlendDescription { weight, parts: Arc::new([first.into(), second.into()]) };
        MaterialDescription { blend: Some(blend), ..MaterialDescription::default() }
    }

    /// What a scene file calls its type.
    pub(crate) fn type_name(&self) -> &'static str {
        if self.blend.is_some() { "blend" } else { self.bsdf.bsdf_type().name() }
    }

    /// Adds the names of the materials that it is mixed of.
    pub(crate) fn add_names_of_parts(&self, names: &mut BTreeSet<String>) {
        for part in self.blend.iter().flat_map(|blend| blend.parts.iter()) {
            names.extend(part.name.clone());
            part.material.add_names_of_parts(names);
        }
    }

    /// Calls `each` with all that is no blend: the material itself, or what it is mixed of.
    pub(crate) fn each_single<'a>(&'a self, each: &mut impl FnMut(&'a MaterialDescription)) {
        match &self.blend {
            None => each(self),
            Some(blend) => blend.parts.iter().for_each(|part| part.material.each_single(each)),
        }
    }

    /// The same, to change them.
    pub(crate) fn change_singles(&mut self, change: &mut impl FnMut(&mut MaterialDescription)) {
        match &mut self.blend {
            None => change(self),
            Some(blend) => {
                let parts = Arc::make_mut(&mut blend.parts);
                parts.iter_mut().for_each(|part| part.material.change_singles(change));
            }
        }
    }

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
            emission_map: None,
            emission_two_sided: false,
            light_group: None,
            relief: None,
            blend: None,
        }
    }
}
