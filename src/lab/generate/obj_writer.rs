//! OBJ and MTL text of a model.

use super::shape::Shape;
use glam::DVec3;

/// What MTL can say of a material.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    pub(crate) name: &'static str,
    /// `Kd`: diffuse reflectance.
    pub(crate) diffuse: [f64; 3],
    /// `Ke`: emitted radiance, W/(sr·m²).
    pub(crate) emission: [f64; 3],
    /// Further lines, as near as MTL comes to what the scene file says exactly.
    pub(crate) more: &'static [&'static str],
}

impl Material {
    /// A diffuse material.
    pub(crate) fn diffuse(name: &'static str, diffuse: [f64; 3]) -> Material {
        Material { name, diffuse, emission: [0.0; 3], more: &[] }
    }
}

/// Named objects and their materials.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub(crate) about: &'static str,
    pub(crate) objects: Vec<(&'static str, Shape)>,
    pub(crate) materials: Vec<Material>,
}

/// Decimals written: 10 micrometres, and 10⁻⁵ of a normal's length.
const DECIMALS: usize = 5;

impl Model {
    /// The OBJ text, which names `NAME.mtl`.
    pub(crate) fn obj(&self, name: &str) -> String {
        let mut text = self.header(name);
        text.push_str(&format!("mtllib {name}.mtl\n"));
        let (mut positions, mut normals) = (1, 1);
        for (object, shape) in &self.objects {
            text.push_str(&format!("o {object}\n"));
            write_vectors(&mut text, "v", &shape.positions);
            write_vectors(&mut text, "vn", &shape.normals);
            write_faces(&mut text, shape, positions, normals);
            positions += shape.positions.len() as u32;
            normals += shape.normals.len() as u32;
        }
        text
    }

    /// The MTL text.
    pub(crate) fn mtl(&self, name: &str) -> String {
        let mut text = self.header(name);
        for material in &self.materials {
            text.push_str(&format!("newmtl {}\n", material.name));
            text.push_str(&format!("Kd {}\n", numbers(material.diffuse)));
            if material.emission != [0.0; 3] {
                text.push_str(&format!("Ke {}\n", numbers(material.emission)));
            }
            material.more.iter().for_each(|line| text.extend([line, "\n"]));
        }
        text
    }

    fn header(&self, name: &str) -> String {
        format!("# {name}: {}\n# Made by phototaxis generate {name}. CC0 1.0.\n", self.about)
    }
}

fn write_vectors(text: &mut String, keyword: &str, vectors: &[DVec3]) {
    for vector in vectors {
        text.push_str(&format!("{keyword} {}\n", numbers(vector.to_array())));
    }
}

/// Faces sorted by material, in their order within each.
fn write_faces(text: &mut String, shape: &Shape, positions: u32, normals: u32) {
    let mut faces = shape.triangles.clone();
    faces.sort_by_key(|face| face.material);
    for group in faces.chunk_by(|a, b| a.material == b.material) {
        text.push_str(&format!("usemtl {}\n", group[0].material));
        for face in group {
            text.push('f');
            for i in face.corners {
                text.push_str(&format!(" {}", i + positions));
                if !shape.normals.is_empty() {
                    text.push_str(&format!("//{}", i + normals));
                }
            }
            text.push('\n');
        }
    }
}

/// Three numbers with at most [`DECIMALS`] decimals, separated by spaces.
fn numbers(vector: [f64; 3]) -> String {
    vector.map(number).join(" ")
}

/// A number as a scene's files hold it: at most [`DECIMALS`] decimals, no trailing zeros, no negative zero.
pub(crate) fn number(x: f64) -> String {
    let text = format!("{x:.DECIMALS$}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// A TOML array of three numbers.
pub(crate) fn toml_vector(vector: DVec3) -> String {
    format!("[{}]", vector.to_array().map(number).join(", "))
}
