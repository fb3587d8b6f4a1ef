//! Triangle meshes, indexed like OBJ: normals and texture coordinates may have indices of their own.

use crate::math::Rgb;
use glam::Vec3;

/// The index of "this triangle has none".
pub(crate) const ABSENT: u32 = u32::MAX;

/// A triangle mesh, in world space or in that of its group.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    /// Indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub normals: Option<Attribute<[f32; 3]>>,
    pub uvs: Option<Attribute<[f32; 2]>>,
    pub colors: Option<MeshColors>,
    /// Per triangle, an index into the scene's materials.
    pub materials: Vec<u32>,
}

/// Colours, linear, each channel in [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub enum MeshColors {
    /// One per position, and between them in between.
    OfVertices(Vec<[f32; 3]>),
    /// One per triangle, which is all of that colour.
    OfFaces(Vec<[f32; 3]>),
}

/// A vertex attribute.
#[derive(Clone, Debug, Default)]
pub struct Attribute<T> {
    pub values: Vec<T>,
    pub indices: Indices,
}

/// Which values the corners of triangles have.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Indices {
    /// Those with the indices of the corners' positions: most files say so, and then the indices are held once.
    #[default]
    OfPositions,
    /// One triple per triangle; `[ABSENT; 3]` where a triangle has none.
    Own(Vec<[u32; 3]>),
}

impl Mesh {
    /// A triangle's corners, counter-clockwise seen from outside.
    #[inline]
    pub(crate) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        // spelt out, as below: `map` is not always inlined, and here every nanosecond counts
        let [a, b, c] = self.triangles[triangle];
        let corner = |i: u32| Vec3::from(self.positions[i as usize]);
        [corner(a), corner(b), corner(c)]
    }

    /// Bytes of its arrays, spare capacity included.
    pub(crate) fn bytes(&self) -> usize {
        let normals = self.normals.as_ref().map_or(0, Attribute::bytes);
        let uvs = self.uvs.as_ref().map_or(0, Attribute::bytes);
        let colors = self.colors.as_ref().map_or(0, MeshColors::bytes);
        of(&self.positions) + of(&self.triangles) + of(&self.materials) + normals + uvs + colors
    }

    /// Texture coordinates of a triangle's corners, as of [`Self::uv`].
    pub(crate) fn uvs_of(&self, triangle: usize) -> [[f32; 2]; 3] {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[u, v]| self.uv(triangle, u, v))
    }

    /// Texture coordinates of a triangle at the barycentric weights `u`, `v` of its second and third corner; the
    /// weights themselves where it has none.
    #[inline(always)]
    pub(crate) fn uv(&self, triangle: usize, u: f32, v: f32) -> [f32; 2] {
        match &self.uvs {
            Some(uvs) => interpolated(uvs.corners(&self.triangles, triangle), u, v),
            None => [u, v],
        }
    }
}

impl Mesh {
    /// The colour of a triangle at the barycentric weights `u`, `v` of its second and third corner; white where the mesh has none.
    #[inline(never)]
    pub(crate) fn color(&self, triangle: usize, u: f32, v: f32) -> Rgb {
        let colors = match &self.colors {
            None => return Rgb::ONE,
            Some(MeshColors::OfFaces(colors)) => return Rgb::from(colors[triangle]),
            Some(MeshColors::OfVertices(colors)) => colors,
        };
        let [a, b, c] = self.triangles[triangle].map(|i| Rgb::from(colors[i as usize]));
        a * (1.0 - u - v) + b * u + c * v
    }
}

impl MeshColors {
    /// As they are held.
    pub(crate) fn values(&self) -> &[[f32; 3]] {
        match self {
            MeshColors::OfVertices(values) | MeshColors::OfFaces(values) => values,
        }
    }

    fn bytes(&self) -> usize {
        match self {
            MeshColors::OfVertices(values) | MeshColors::OfFaces(values) => of(values),
        }
    }
}

#[inline(never)]
fn interpolated(corners: Option<[[f32; 2]; 3]>, u: f32, v: f32) -> [f32; 2] {
    let Some([a, b, c]) = corners else { return [u, v] };
    let w = 1.0 - u - v;
    [w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1]]
}

/// Bytes that a vector holds.
fn of<T>(values: &Vec<T>) -> usize {
    values.capacity() * size_of::<T>()
}

impl<T: Copy> Attribute<T> {
    fn bytes(&self) -> usize {
        let own = match &self.indices {
            Indices::Own(indices) => of(indices),
            Indices::OfPositions => 0,
        };
        of(&self.values) + own
    }

    /// The three values at the corners of a triangle of the mesh whose `triangles` these are.
    #[inline]
    pub(crate) fn corners(&self, triangles: &[[u32; 3]], triangle: usize) -> Option<[T; 3]> {
        let i = match &self.indices {
            Indices::OfPositions => triangles[triangle],
            Indices::Own(indices) => indices[triangle],
        };
        let value = |k: u32| self.values[k as usize];
        (i[0] != ABSENT).then(|| [value(i[0]), value(i[1]), value(i[2])])
    }
}
