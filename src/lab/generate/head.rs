//! A stylised monkey's head: blobs melted into each other, seen as a displaced sphere.

use super::shape::Shape;
use super::shapes::displaced_sphere;
use glam::DVec3;

/// An ellipsoidal blob: how much it adds to the field at its centre, where it is, and its half axes.
struct Blob {
    weight: f64,
    centre: DVec3,
    axes: DVec3,
}

const fn blob(weight: f64, centre: [f64; 3], axes: [f64; 3]) -> Blob {
    Blob { weight, centre: DVec3::from_array(centre), axes: DVec3::from_array(axes) }
}

/// Of the middle and of the right half; [`field`] mirrors x. The face looks along +z.
const BLOBS: [Blob; 11] = [
    // Cranium, muzzle, chin, nose.
    blob(1.0, [0.0, 0.15, -0.1], [0.78, 0.78, 0.78]),
    blob(0.9, [0.0, -0.42, 0.48], [0.44, 0.3, 0.42]),
    blob(0.5, [0.0, -0.68, 0.38], [0.24, 0.2, 0.3]),
    blob(0.6, [0.0, -0.2, 0.82], [0.13, 0.11, 0.16]),
    // Brow, cheek, eye socket, eyeball.
    blob(0.8, [0.27, 0.42, 0.6], [0.27, 0.09, 0.16]),
    blob(0.3, [0.52, -0.2, 0.45], [0.2, 0.2, 0.2]),
    blob(-1.6, [0.29, 0.13, 0.8], [0.2, 0.15, 0.24]),
    blob(1.5, [0.29, 0.12, 0.55], [0.11, 0.1, 0.11]),
    // Ear and its hollow.
    blob(1.3, [0.98, 0.12, -0.12], [0.3, 0.38, 0.11]),
    blob(-1.1, [1.04, 0.12, 0.08], [0.2, 0.26, 0.12]),
    // Mouth.
    blob(-0.9, [0.1, -0.5, 0.98], [0.34, 0.04, 0.2]),
];

/// Where the field has this value is the surface.
const LEVEL: f64 = 0.4;

/// The head, about 2.4 wide with its ears; scale it to taste. 20·frequency² triangles, smooth.
pub(crate) fn head(frequency: u32, material: &'static str) -> Shape {
    displaced_sphere(frequency, material, surface)
}

/// Sum of the blobs' bells e^(−|(p − centre)/axes|²).
fn field(p: DVec3) -> f64 {
    let right = DVec3::new(p.x.abs(), p.y, p.z);
    let bell = |b: &Blob| b.weight * (-((right - b.centre) / b.axes).length_squared()).exp();
    BLOBS.iter().map(bell).sum()
}

/// Distance of the outermost surface along a unit direction: steps inward to the first inside point, then bisection.
fn surface(direction: DVec3) -> f64 {
    const STEP: f64 = 0.01;
    let inside = |r: f64| field(direction * r) > LEVEL;
    let outermost = (1..250).rev().map(|i| i as f64 * STEP).find(|r| inside(*r));
    let (mut low, mut high) = outermost.map_or((0.0, STEP), |r| (r, r + STEP));
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if inside(middle) { low = middle } else { high = middle }
    }
    low
}
