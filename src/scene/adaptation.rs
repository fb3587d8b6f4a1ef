//! Meshes of files, with what a scene of another format means by them.

use super::model::{Model, reader};
use super::{ply, serialized};
use crate::Result;
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices};
use glam::Vec3;
use rustc_hash::FxHashMap;
use std::path::Path;

/// What becomes of the normals at corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum NormalsChange {
    #[default]
    Keep,
    /// There are none: all faces are flat.
    Drop,
    /// Where the file has none, they are means over all faces at a vertex, weighed by their angles there.
    Smooth,
}

/// How a mesh differs from what is in its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Adaptation {
    /// Of a file of Mitsuba's `serialized` form, which mesh it is; of other files it means nothing.
    pub(crate) part: Option<usize>,
    pub(crate) normals: NormalsChange,
    /// Inside and outside change places.
    pub(crate) flip: bool,
    /// The same where the file has no normals.
    pub(crate) flip_bare: bool,
    /// Where the file has normals they say what is outside, and triangles that are wound the other way are turned over.
    pub(crate) by_normals: bool,
    /// Texture coordinates are counted from above: v is 1 − v.
    pub(crate) flip_v: bool,
    /// Of a PLY file, the attribute that its colours are, as Mitsuba calls it; where nothing is said they are any that there are.
    pub(crate) colors: Option<String>,
}

impl Adaptation {
    /// Reads the file.
    ///
    /// # Errors
    /// Those of its reader.
    pub(super) fn load(&self, path: &Path) -> Result<Model> {
        let mut model = match (self.part, &self.colors) {
            (Some(part), _) => serialized::load(path, part)?,
            (None, Some(attribute)) => ply::load_with(path, attribute)?,
            (None, None) => reader(path)?(path)?,
        };
        self.apply(&mut model.mesh);
        Ok(model)
    }

    /// Changes a mesh.
    pub(crate) fn apply(&self, mesh: &mut Mesh) {
        // before there are any that are made of the winding
        match &mesh.normals {
            Some(normals) if self.by_normals => {
                let wrong = against_normals(mesh, normals);
                wrong.into_iter().for_each(|t| turn_over(mesh, t));
            }
            None if self.flip_bare => flip(mesh),
            _ => (),
        }
        if self.flip {
            flip(mesh);
        }
        match self.normals {
            NormalsChange::Drop => mesh.normals = None,
            NormalsChange::Smooth if mesh.normals.is_none() => mesh.normals = Some(smooth(mesh)),
            NormalsChange::Keep | NormalsChange::Smooth => (),
        }
        if self.flip_v
            && let Some(uvs) = &mut mesh.uvs
        {
            uvs.values.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
        }
    }
}

/// The model inside out.
pub(crate) fn flipped(model: &Model) -> Model {
    let mut model = model.clone();
    flip(&mut model.mesh);
    model
}

/// Triangles whose winding says that outside is where their normals say that inside is.
fn against_normals(mesh: &Mesh, normals: &Attribute<[f32; 3]>) -> Vec<usize> {
    let against = |&t: &usize| {
        let [a, b, c] = mesh.corners(t);
        let Some(normals) = normals.corners(&mesh.triangles, t) else { return false };
        normals.iter().map(|n| Vec3::from(*n)).sum::<Vec3>().dot((b - a).cross(c - a)) < 0.0
    };
    (0..mesh.triangles.len()).filter(against).collect()
}

/// Winds one triangle the other way round. Attributes with indices of their own go with it.
fn turn_over(mesh: &mut Mesh, t: usize) {
    mesh.triangles[t].swap(1, 2);
    let own = [mesh.normals.as_mut().map(|n| &mut n.indices), mesh.uvs.as_mut().map(|uvs| &mut uvs.indices)];
    for indices in own.into_iter().flatten() {
        if let Indices::Own(indices) = indices {
            indices[t].swap(1, 2);
        }
    }
}

/// Turns a mesh inside out.
fn flip(mesh: &mut Mesh) {
    (0..mesh.triangles.len()).for_each(|t| turn_over(mesh, t));
    if let Some(normals) = &mut mesh.normals {
        normals.values.iter_mut().for_each(|n| *n = n.map(|x| -x));
    }
}

/// Normals of vertices. A vertex with two texture coordinates is two, as for programs that keep one set of indices.
fn smooth(mesh: &Mesh) -> Attribute<[f32; 3]> {
    let mut numbers: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut sums: Vec<Vec3> = Vec::new();
    let mut indices = Vec::with_capacity(mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let uvs = match mesh.uvs.as_ref().map(|uvs| &uvs.indices) {
            None => [ABSENT; 3],
            Some(Indices::OfPositions) => *triangle,
            Some(Indices::Own(own)) => own[t],
        };
        let corners = mesh.corners(t);
        let own = [0, 1, 2].map(|k| {
            *numbers.entry([triangle[k], uvs[k]]).or_insert_with(|| {
                sums.push(Vec3::ZERO);
                sums.len() as u32 - 1
            })
        });
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for k in 0..3 {
            let [a, b] = [1, 2].map(|step| (corners[(k + step) % 3] - corners[k]).normalize_or_zero());
            let angle = a.angle_between(b);
            // edges without length have none
            sums[own[k] as usize] += if angle.is_finite() { normal * angle } else { Vec3::ZERO };
        }
        indices.push(own);
    }
    let usable = |n: &Vec3| n.length_squared() >= f32::MIN_POSITIVE && n.is_finite();
    for own in indices.iter_mut().filter(|own| !own.iter().all(|&k| usable(&sums[k as usize]))) {
        *own = [ABSENT; 3];
    }
    let values = sums.iter().map(|n| if usable(n) { n.normalize().into() } else { [0.0, 0.0, 1.0] }).collect();
    Attribute { values, indices: Indices::Own(indices) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles with a common edge, at a right angle.
    fn roof() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 3, 1]],
            materials: vec![0; 2],
            ..Mesh::default()
        }
    }

    #[test]
    fn normals_are_means_by_angle_and_end_at_seams() {
        let mut mesh = roof();
        let normals = smooth(&mesh);
        let at = |t: usize, k: usize| normals.corners(&mesh.triangles, t).unwrap()[k];
        // faces look up +y and +x; both have a right angle at vertex 0
        let half = 0.5f32.sqrt();
        assert!((Vec3::from(at(0, 0)) - Vec3::new(half, half, 0.0)).length() < 1e-6, "{:?}", at(0, 0));
        assert_eq!(at(0, 2), [0.0, 1.0, 0.0]);
        assert_eq!(at(0, 0), at(1, 0));
        let own = Indices::Own(vec![[0, 1, 2], [3, 4, 5]]);
        mesh.uvs = Some(Attribute { values: vec![[0.0; 2]; 6], indices: own });
        let cut = smooth(&mesh);
        assert_eq!(cut.corners(&mesh.triangles, 0).unwrap(), [[0.0, 1.0, 0.0]; 3]);
    }

    #[test]
    fn triangles_go_by_their_normals_where_these_say_what_is_outside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nvn 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n";
        let up = |adaptation: Adaptation, faces: &str| -> Vec<bool> {
            std::fs::write(&path, format!("{text}{faces}")).unwrap();
            let mesh = adaptation.load(&path).unwrap().mesh;
            let up = |t| {
                let [a, b, c] = mesh.corners(t);
                (b - a).cross(c - a).z > 0.0
            };
            (0..mesh.triangles.len()).map(up).collect()
        };
        let (lit, dull) = ("f 1/1/1 2/2/1 3/3/1\nf 1/1/2 2/2/2 3/3/2\n", "f 1 2 3\n");
        let led = || Adaptation { by_normals: true, flip_bare: true, ..Adaptation::default() };
        assert_eq!(up(led(), lit), [false, true]);
        assert_eq!(up(led(), dull), [false], "without normals it is turned inside out");
        assert_eq!(up(Adaptation { flip_bare: false, ..led() }, dull), [true]);
        assert_eq!(up(Adaptation { flip: true, ..led() }, lit), [true, false], "what normals say, inside out");
        assert_eq!(up(Adaptation::default(), lit), [true, true]);
    }

    #[test]
    fn a_mesh_inside_out_has_all_corners_the_other_way_round() {
        let mut mesh = roof();
        mesh.normals = Some(smooth(&mesh));
        let (before, normals) = (mesh.corners(1), mesh.normals.as_ref().unwrap().corners(&mesh.triangles, 1).unwrap());
        flip(&mut mesh);
        assert_eq!(mesh.corners(1), [before[0], before[2], before[1]]);
        let turned = mesh.normals.as_ref().unwrap().corners(&mesh.triangles, 1).unwrap();
        assert_eq!(turned, [normals[0], normals[2], normals[1]].map(|n| n.map(|x| -x)));
    }
}
