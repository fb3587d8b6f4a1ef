//! Meshes from files or from memory. A format of files is one line in [`READERS`].

use super::adaptation::Adaptation;
use super::description::MaterialDescription;
use super::{obj, ply};
use crate::embree::LARGEST_COORDINATE;
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices, MeshColors};
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh with what its own source says of its materials.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// In the model's own space, counted from `origin`. `materials[t]` indexes [`Model::material_names`].
    pub mesh: Mesh,
    /// 0, unless the model is far from that for its size.
    pub(crate) origin: DVec3,
    /// In the order in which triangles first have them.
    pub(crate) material_names: Vec<String>,
    /// By name. A scene file may say something else of a name; a name that neither describes is grey.
    pub(crate) materials: BTreeMap<String, MaterialDescription>,
    /// Objects in the mesh: the first triangle of each, in ascending order, and its name. Triangles before the first are the model's own.
    pub(crate) parts: Vec<(u32, String)>,
    pub(crate) warnings: Vec<Warning>,
}

/// Something in a file that could not be used, but does not keep the rest from being used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Warning {
    pub(crate) path: PathBuf,
    /// From 1; 0 where the file is no text.
    pub(crate) line: usize,
    pub(crate) message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}: {}", self.path.display(), self.message),
            line => write!(f, "{}:{line}: {}", self.path.display(), self.message),
        }
    }
}

/// Where the triangles of a mesh come from.
#[derive(Clone)]
pub(crate) enum MeshSource {
    /// A file in one of the formats of [`READERS`].
    File(PathBuf),
    /// A file whose mesh means something else in the scene that names it.
    Adapted(PathBuf, Adaptation),
    /// What a reader of another kind of scene has made.
    Memory(Arc<Model>),
}

/// Reads a file of one format.
pub(super) type Read = fn(&Path) -> Result<Model>;

/// The formats of meshes, by the end of a file's name.
const READERS: &[(&str, Read)] = &[("obj", obj::load), ("ply", ply::load), ("ply.gz", ply::load)];

impl MeshSource {
    /// The model. One in memory is checked, as what is built of it relies on its indices.
    ///
    /// # Errors
    /// Those of the file's reader; a file that no reader is for; a model in memory that contradicts itself.
    pub(super) fn load(&self) -> Result<Cow<'_, Model>> {
        match self {
            MeshSource::File(path) => reader(path)?(path).map(Cow::Owned),
            MeshSource::Adapted(path, adaptation) => adaptation.load(path).map(Cow::Owned),
            MeshSource::Memory(model) => {
                check(model).map_err(|message| self.error(message))?;
                Ok(Cow::Borrowed(&**model))
            }
        }
    }

    /// What the model is called: its file, without folder and extension.
    pub(super) fn name(&self) -> String {
        match self {
            MeshSource::File(path) | MeshSource::Adapted(path, _) => {
                path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
            }
            MeshSource::Memory(_) => "mesh".to_string(),
        }
    }

    /// That the model cannot be used.
    pub(super) fn error(&self, message: impl Into<String>) -> Error {
        match self {
            MeshSource::File(path) | MeshSource::Adapted(path, _) => Error::file(path, message),
            MeshSource::Memory(_) => Error::Scene(format!("a mesh in memory: {}", message.into())),
        }
    }

    /// The file, where it comes from one.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            MeshSource::File(path) | MeshSource::Adapted(path, _) => Some(path),
            MeshSource::Memory(_) => None,
        }
    }
}

impl fmt::Debug for MeshSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            MeshSource::File(path) => f.debug_tuple("File").field(path).finish(),
            MeshSource::Adapted(path, adaptation) => f.debug_tuple("Adapted").field(path).field(adaptation).finish(),
            MeshSource::Memory(model) => write!(f, "Memory({} triangles)", model.mesh.triangles.len()),
        }
    }
}

pub(super) fn reader(path: &Path) -> Result<Read> {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let ends = |end: &str| name.strip_suffix(end).is_some_and(|stem| stem.ends_with('.'));
    let found = READERS.iter().find(|(end, _)| ends(end)).map(|(_, read)| *read);
    found.ok_or_else(|| {
        let ends: Vec<String> = READERS.iter().map(|(end, _)| format!(".{end}")).collect();
        let (last, first) = ends.split_last().expect("there are readers");
        Error::file(path, format!("not a mesh: its name must end in {} or {last}", first.join(", ")))
    })
}

/// What is wrong with a model, if anything is.
fn check(model: &Model) -> Result<(), String> {
    let Mesh { positions, triangles, normals, uvs, colors, materials } = &model.mesh;
    if positions.len() > u32::MAX as usize || triangles.len() > u32::MAX as usize {
        return Err(format!("more than {} vertices or triangles", u32::MAX));
    }
    if !positions.iter().flatten().all(|x| x.abs() <= LARGEST_COORDINATE) {
        return Err("a coordinate is not a number between -1e12 and 1e12".into());
    }
    if triangles.iter().flatten().any(|&i| i as usize >= positions.len()) {
        return Err("a triangle names a vertex that is not there".into());
    }
    if materials.len() != triangles.len() {
        return Err(format!("{} triangles, but materials for {}", triangles.len(), materials.len()));
    }
    if materials.iter().any(|&m| m as usize >= model.material_names.len()) {
        return Err("a triangle has a material that is not there".into());
    }
    let (colored, what) = match colors {
        Some(MeshColors::OfVertices(_)) => (positions.len(), "vertices"),
        Some(MeshColors::OfFaces(_)) => (triangles.len(), "triangles"),
        None => (0, ""),
    };
    let values = colors.as_ref().map_or(&[][..], MeshColors::values);
    if values.len() != colored {
        return Err(format!("not as many colours as {what}"));
    }
    if !values.iter().flatten().all(|x| (0.0..=1.0).contains(x)) {
        return Err("a colour is not between 0 and 1".into());
    }
    check_attribute("normals", normals.as_ref(), &model.mesh)?;
    let mut directions = normals.iter().flat_map(|normals| &normals.values);
    if !directions.all(|&n| Vec3::from(n).length_squared() >= f32::MIN_POSITIVE) {
        return Err("a normal has no direction".into());
    }
    check_attribute("texture coordinates", uvs.as_ref(), &model.mesh)
}

fn check_attribute<const N: usize>(
    name: &str,
    attribute: Option<&Attribute<[f32; N]>>,
    mesh: &Mesh,
) -> Result<(), String> {
    let Some(Attribute { values, indices }) = attribute else { return Ok(()) };
    if !values.iter().flatten().all(|x| x.is_finite()) {
        return Err(format!("{name} that are not finite"));
    }
    let fits = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < values.len());
    let fit = match indices {
        Indices::OfPositions => mesh.triangles.iter().all(fits),
        Indices::Own(own) => own.len() == mesh.triangles.len() && own.iter().all(|t| *t == [ABSENT; 3] || fits(t)),
    };
    if fit { Ok(()) } else { Err(format!("{name} that do not fit the triangles")) }
}

#[cfg(test)]
mod tests;
