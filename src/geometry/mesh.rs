//! Triangle meshes, indexed like OBJ: positions, normals and texture coordinates each with their own indices.

/// The index of "this triangle has none".
pub const ABSENT: u32 = u32::MAX;

/// A triangle mesh in world space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    /// Indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub normals: Option<Attribute<[f32; 3]>>,
    pub uvs: Option<Attribute<[f32; 2]>>,
    /// Per triangle, an index into the scene's materials.
    pub materials: Vec<u32>,
}

/// A vertex attribute with its own indices, one triple per triangle; `[ABSENT; 3]` where a triangle has none.
#[derive(Clone, Debug, Default)]
pub struct Attribute<T> {
    pub values: Vec<T>,
    pub indices: Vec<[u32; 3]>,
}

impl Mesh {
    /// Bytes of its arrays, spare capacity included.
    pub fn bytes(&self) -> usize {
        fn of<T>(values: &Vec<T>) -> usize {
            values.capacity() * size_of::<T>()
        }
        let normals = self.normals.as_ref().map_or(0, |n| of(&n.values) + of(&n.indices));
        let uvs = self.uvs.as_ref().map_or(0, |uvs| of(&uvs.values) + of(&uvs.indices));
        of(&self.positions) + of(&self.triangles) + of(&self.materials) + normals + uvs
    }

    /// Texture coordinates of a triangle at the barycentric weights `u`, `v` of its second and third corner; the
    /// weights themselves where it has none.
    #[inline]
    pub fn uv(&self, triangle: usize, u: f32, v: f32) -> [f32; 2] {
        let w = 1.0 - u - v;
        self.uvs
            .as_ref()
            .and_then(|uvs| uvs.corners(triangle))
            .map_or([u, v], |corner| [0, 1].map(|k| w * corner[0][k] + u * corner[1][k] + v * corner[2][k]))
    }
}

impl<T: Copy> Attribute<T> {
    /// The three values at a triangle's corners.
    #[inline]
    pub fn corners(&self, triangle: usize) -> Option<[T; 3]> {
        let i = self.indices[triangle];
        (i[0] != ABSENT).then(|| i.map(|k| self.values[k as usize]))
    }
}
