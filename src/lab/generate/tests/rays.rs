//! What the scene tests look with: a written model read back, and rays by brute force.

use crate::math::rng::Rng;
use glam::DVec3;

/// A triangle as written, with the normals at its corners if it has any.
pub(crate) struct Face {
    pub(crate) object: String,
    pub(crate) material: String,
    pub(crate) corners: [DVec3; 3],
    pub(crate) normals: Option<[DVec3; 3]>,
}

impl Face {
    /// Twice the area, along the side that the winding faces.
    pub(crate) fn cross(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }
}

/// All faces of a model, those of an object together, with the objects' bounds to pass them by.
pub(crate) struct World {
    pub(crate) faces: Vec<Face>,
    objects: Vec<(std::ops::Range<usize>, [DVec3; 2])>,
}

/// The nearest face that a ray meets.
pub(crate) struct Hit<'a> {
    pub(crate) distance: f64,
    pub(crate) face: &'a Face,
}

impl World {
    /// Reads what the writer wrote: positions and normals are those of the file.
    pub(crate) fn read(model: &crate::lab::generate::obj_writer::Model) -> World {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let (mut object, mut material) = (String::new(), String::new());
        let mut faces = Vec::new();
        for line in model.obj("x").lines() {
            let words: Vec<&str> = line.split(' ').collect();
            match words[0] {
                "v" => positions.push(vector(&words[1..])),
                "vn" => normals.push(vector(&words[1..])),
                "o" => object = words[1].to_owned(),
                "usemtl" => material = words[1].to_owned(),
                "f" => faces.push(Face {
                    object: object.clone(),
                    material: material.clone(),
                    corners: [1, 2, 3].map(|i| pick(words[i].split("//").next(), &positions)),
                    normals: line
                        .contains("//")
                        .then(|| [1, 2, 3].map(|i| pick(words[i].split("//").nth(1), &normals))),
                }),
                other => assert!(["#", "mtllib"].contains(&other), "{line}"),
            }
        }
        World::new(faces)
    }

    fn new(faces: Vec<Face>) -> World {
        let mut first = 0;
        let objects = faces
            .chunk_by(|a, b| a.object == b.object)
            .map(|chunk| {
                let range = first..first + chunk.len();
                first = range.end;
                (range, bounds(chunk.iter()))
            })
            .collect();
        World { faces, objects }
    }

    /// The faces for which `keep` holds.
    pub(crate) fn filtered(self, keep: impl Fn(&Face) -> bool) -> World {
        World::new(self.faces.into_iter().filter(keep).collect())
    }

    pub(crate) fn of_object<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Face> {
        self.faces.iter().filter(move |face| face.object == name)
    }

    pub(crate) fn trace(&self, origin: DVec3, direction: DVec3) -> Option<Hit<'_>> {
        let near_objects = self.objects.iter().filter(|object| meets_box(object.1, origin, direction));
        near_objects
            .flat_map(|object| &self.faces[object.0.clone()])
            .filter_map(|face| meets_face(face, origin, direction).map(|distance| Hit { distance, face }))
            .min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Whether nothing stands between two points; a hundredth of a millimetre at either end does not count.
    pub(crate) fn sees(&self, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        let direction = way.normalize();
        let hit = self.trace(from + direction * 1e-5, direction);
        hit.is_none_or(|hit| hit.distance > way.length() - 2e-5)
    }
}

fn vector(words: &[&str]) -> DVec3 {
    let numbers: Vec<f64> = words.iter().map(|word| word.parse().expect("a number")).collect();
    assert_eq!(numbers.len(), 3);
    DVec3::from_slice(&numbers)
}

fn pick(index: Option<&str>, values: &[DVec3]) -> DVec3 {
    let index: usize = index.expect("an index").parse().expect("an index");
    values[index - 1]
}

/// Lower and upper corner of what holds the faces.
pub(crate) fn bounds<'a>(faces: impl Iterator<Item = &'a Face>) -> [DVec3; 2] {
    faces
        .flat_map(|face| face.corners)
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

fn meets_box([low, high]: [DVec3; 2], origin: DVec3, direction: DVec3) -> bool {
    let (a, b) = ((low - 1e-4 - origin) / direction, (high + 1e-4 - origin) / direction);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    leave >= enter.max(0.0)
}

/// Distance to a face (Möller and Trumbore 1997).
fn meets_face(face: &Face, origin: DVec3, direction: DVec3) -> Option<f64> {
    let [a, b, c] = face.corners;
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let scale = 1.0 / ab.dot(p);
    let s = origin - a;
    let u = s.dot(p) * scale;
    let q = s.cross(ab);
    let v = direction.dot(q) * scale;
    let distance = ac.dot(q) * scale;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
}

/// Uniform on the unit sphere.
pub(crate) fn random_direction(rng: &mut Rng) -> DVec3 {
    let [u, v] = rng.f32x2().map(f64::from);
    let (y, angle) = (1.0 - 2.0 * u, std::f64::consts::TAU * v);
    let r = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(r * angle.cos(), y, r * angle.sin())
}

/// Uniform in a box.
pub(crate) fn random_point(rng: &mut Rng, low: DVec3, high: DVec3) -> DVec3 {
    let t = DVec3::from_array([rng.f32(), rng.f32(), rng.f32()].map(f64::from));
    low + (high - low) * t
}
