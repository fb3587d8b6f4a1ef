//! Ten thousand small lights, as a hundred copies of a hundred.

use super::shiny::BOX_TOP;
use super::{View, head, lamp, mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::obj_writer::{Model, number};
use crate::lab::generate::shape::Shape;
use glam::DVec3;

/// No light is in the picture: a dot of 1 mm would make noise that no method can do anything about.
const VIEW: View =
    View { eye: DVec3::new(0.0, 1.1, 0.96), target: DVec3::new(0.0, 0.35, -1.0), vfov: 60.0, exposure: 2.0 };

/// Copies along each side of the ceiling, and their distance in metres.
const COPIES: i32 = 10;
const STEP: f64 = 0.18;

/// One light in ten is ten times as bright as most, one in a hundred a hundred times.
const MATERIALS: [(&str, f64); 3] = [("spark", 30.0), ("bright", 300.0), ("brightest", 3000.0)];

pub(crate) fn many_lights() -> SceneFiles {
    let about =
        "The box of `shiny` without its lamp, under ten thousand lights of 1 mm and three levels of brightness.";
    let mut toml = head(about, &VIEW) + &mesh("shiny");
    toml += "\n[material.lamp]\ntype = \"diffuse\"\nreflectance = 0.7\n";
    for copy in 0..COPIES * COPIES {
        let at = |k: i32| number((f64::from(k) - 0.5 * f64::from(COPIES - 1)) * STEP);
        let place = format!("translate = [{}, {}, {}]\n", at(copy % COPIES), number(BOX_TOP - 0.05), at(copy / COPIES));
        toml += &(mesh("many-lights") + &place);
    }
    let materials = MATERIALS.map(|(name, emission)| lamp(name, [emission, 0.9 * emission, 0.75 * emission]));
    let model = Model {
        about: "a hundred small lights that face down, more or less",
        objects: vec![("lights", lights())],
        materials: materials.to_vec(),
    };
    SceneFiles { toml, model }
}

/// Triangles with legs of 1 mm on a grid, each tilted in a direction of its own.
fn lights() -> Shape {
    let light = |k: u32| {
        let place = DVec3::new(f64::from(k % 10) - 4.5, 0.0, f64::from(k / 10) - 4.5) * (STEP / 10.0);
        let turn = 2.4 * f64::from(k);
        let tilt = DVec3::new(turn.cos(), 0.0, turn.sin()) * 0.6;
        let (u, v) = ((DVec3::X - DVec3::Y * tilt.x) * 1e-3, (DVec3::Z - DVec3::Y * tilt.z) * 1e-3);
        let material = MATERIALS[if k == 37 { 2 } else { usize::from(k % 10 == 3) }].0;
        // x × z points down
        Shape::new(vec![place, place + u, place + v], vec![[0, 1, 2]], material)
    };
    (1..100).map(light).fold(light(0), Shape::with)
}
