//! A room that is lit through a hole of two millimetres.

use super::{View, lamp, with_mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::blocks::{Blocks, cuboid};
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shape::Shape;
use glam::DVec3;

/// Half the hole's side, the room's half width and height, in metres.
const HOLE: f64 = 0.001;
const HALF: f64 = 1.0;
const TOP: f64 = 2.0;
const HOLE_HEIGHT: f64 = 1.1;

/// Between the wall and the lamp's rim. Shadow rays end a little before the light they ask for: were the rim to touch the
/// wall, those to its edge would end behind the wall and bring hundreds of times the light of the hole. What passes the
/// hole at so flat an angle that it misses the lamp is a thousandth of all.
const GAP: f64 = 0.02;

/// About 10⁻⁷ of the radiance is left on the walls.
const EMISSION: [f64; 3] = [4.0e6, 3.8e6, 3.2e6];

const VIEW: View =
    View { eye: DVec3::new(0.3, 1.1, -0.7), target: DVec3::new(0.0, 0.9, 1.0), vfov: 60.0, exposure: -2.5 };

pub(crate) fn keyhole() -> SceneFiles {
    let about = "Behind a hole of two millimetres all is lamp. About one path in a hundred thousand finds it, by chance or by\n\
                 next-event estimation, which looks at the lamp and hits the wall about the hole.";
    let behind = Blocks::in_rock()
        .carve(cuboid([-0.6, 0.5, -1.6], [0.6, 1.7, -HALF - GAP]))
        .surface(|_, normal| if normal.z < -0.5 { "none" } else { "lamp" });
    let model = Model {
        about: "a room with a hole in its wall, and a lamp all about the hole's other side",
        objects: vec![("room", room()), ("behind", without_none(behind))],
        materials: materials(),
    };
    with_mesh("keyhole", about, &VIEW, model)
}

/// The same light: from within the room, a hole behind which all glows is a lamp of the hole's size.
pub(crate) fn plugged() -> SceneFiles {
    let about = "What the scene `keyhole` looks like, by other means: the hole is closed by a lamp of the same radiance.\n\
                 Seen from the room nothing else differs, and next-event estimation finds this lamp at once.";
    let [a, b, c, d] = hole();
    let model = Model {
        about: "the room of keyhole, its hole closed by a lamp",
        objects: vec![("room", room()), ("plug", Shape::quads(&[[a, b, c, d]], "lamp"))],
        materials: materials(),
    };
    with_mesh("keyhole-plugged", about, &VIEW, model)
}

fn without_none(mut shape: Shape) -> Shape {
    shape.triangles.retain(|triangle| triangle.material != "none");
    shape
}

/// Counter-clockwise seen from the room.
fn hole() -> [DVec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y): (f64, f64)| DVec3::new(x * HOLE, HOLE_HEIGHT + y * HOLE, -HALF))
}

/// All of the room, and the wall with the hole as four trapezia.
fn room() -> Shape {
    let walls = Blocks::in_rock().carve(cuboid([-HALF, 0.0, -HALF], [HALF, TOP, HALF])).surface(|_, normal| {
        match (normal.y, normal.z) {
            (_, z) if z > 0.5 => "none",
            (y, _) if y > 0.5 => "floor",
            _ => "plaster",
        }
    });
    let p = |x: f64, y: f64| DVec3::new(x, y, -HALF);
    let outer = [p(-HALF, 0.0), p(HALF, 0.0), p(HALF, TOP), p(-HALF, TOP)];
    let inner = hole();
    let trapezia = [0, 1, 2, 3].map(|i| {
        let j = (i + 1) % 4;
        [outer[i], outer[j], inner[j], inner[i]]
    });
    without_none(walls).with(Shape::quads(&trapezia, "plaster"))
}

fn materials() -> Vec<Material> {
    vec![
        Material::diffuse("plaster", [0.75, 0.74, 0.7]),
        Material::diffuse("floor", [0.6, 0.48, 0.36]),
        lamp("lamp", EMISSION),
    ]
}
