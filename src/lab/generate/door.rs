//! `door`: two rooms and a door ajar.
//!
//! Laid out in the building's own frame: the wall with the doorway ends at z = 0, the near room is on the side of +z,
//! the far room on that of −z. Then everything, camera included, is turned by [`TURN`].

use super::SceneFiles;
use super::blocks::{Blocks, Cuboid, cuboid};
use super::obj_writer::{Material, Model, toml_vector};
use super::shape::Shape;
use super::still_life::{knob, pumpkin, teapot, vase};
use glam::{DAffine3, DVec3};

/// Degrees about the y axis, so that no wall is aligned to a guide's grid.
const TURN: f64 = 17.0;
/// Degrees by which the door stands open.
const AJAR: f64 = 18.0;

/// Half the rooms' width, their height, how far they reach on either side, in metres.
const HALF: f64 = 2.2;
const TOP: f64 = 2.7;
const NEAR: f64 = 4.95;
const FAR: f64 = -3.45;
/// Of the wall between the rooms.
const THICKNESS: f64 = 0.15;
/// The doorway's left and right side, and its height.
const JAMBS: [f64; 2] = [0.55, 1.45];
const LINTEL: f64 = 2.05;
const TILE: f64 = 0.55;
const TABLE_TOP: f64 = 0.75;

/// The camera, in the building's frame.
pub(super) const EYE: DVec3 = DVec3::new(0.3, 1.45, 4.3);
pub(super) const TARGET: DVec3 = DVec3::new(0.05, 1.0, 0.6);

pub(crate) fn scene() -> SceneFiles {
    let model =
        Model { about: "two rooms, a lamp in the far one, a door ajar", objects: objects(), materials: materials() };
    SceneFiles { toml: toml(), model }
}

/// From the building's frame to the world's.
pub(super) fn to_world() -> DAffine3 {
    DAffine3::from_rotation_y(TURN.to_radians())
}

/// The rooms with door, table and picture, in the world's frame: what is made of flat faces.
pub(super) fn rooms() -> Vec<(&'static str, Shape)> {
    let rooms = [("building", building()), ("door", door()), ("table", table()), ("picture", picture())];
    rooms.map(|(name, shape)| (name, shape.transformed(&to_world()))).into()
}

fn objects() -> Vec<(&'static str, Shape)> {
    let on_table = |x: f64, z: f64, degrees: f64| {
        DAffine3::from_translation(DVec3::new(x, TABLE_TOP, z))
            * DAffine3::from_rotation_y(degrees.to_radians())
            * DAffine3::from_scale(DVec3::splat(1.4))
    };
    let objects = [
        ("building", building()),
        ("door", door()),
        ("knobs", knobs()),
        ("table", table()),
        ("picture", picture()),
        ("vase", vase("glass").transformed(&on_table(-0.98, 2.3, 0.0))),
        ("teapot", teapot("copper").transformed(&on_table(-0.5, 2.55, -25.0))),
        ("pumpkin", pumpkin("pumpkin", "stem").transformed(&on_table(0.0, 2.35, 10.0))),
    ];
    objects.map(|(name, shape)| (name, shape.transformed(&to_world()))).into()
}

/// Where the door wall is lit from behind: a panel on its far side, which no point of the near room faces.
fn lamp() -> Cuboid {
    cuboid([-1.1, 0.9, -THICKNESS - 1e-3], [0.4, 2.3, -THICKNESS + 1e-3])
}

/// Both rooms and the doorway between, carved from rock; skirting boards and the door's casing are left standing.
fn building() -> Shape {
    let (skirting, casing) = (0.014, 0.02);
    let [left, right] = JAMBS;
    let tiles = |from: f64, to: f64| {
        let first = (from / TILE).ceil() as i32;
        (first..).map(|i| i as f64 * TILE).take_while(move |x| *x < to)
    };
    let lamp = lamp();
    Blocks::in_rock()
        .carve(cuboid([-HALF, 0.0, 0.0], [HALF, 0.1, NEAR]))
        .fill(cuboid([-HALF, 0.0, 0.0], [HALF, 0.1, skirting]))
        .fill(cuboid([-HALF, 0.0, 0.0], [-HALF + skirting, 0.1, NEAR]))
        .fill(cuboid([HALF - skirting, 0.0, 0.0], [HALF, 0.1, NEAR]))
        .carve(cuboid([-HALF, 0.1, 0.0], [HALF, TOP, NEAR]))
        .carve(cuboid([-HALF, 0.0, FAR], [HALF, TOP, -THICKNESS]))
        .fill(cuboid([left - 0.08, 0.0, 0.0], [right + 0.08, LINTEL + 0.08, casing]))
        .carve(cuboid([left, 0.0, -THICKNESS], [right, LINTEL, casing]))
        .cut(0, tiles(-HALF, HALF).chain([lamp.min.x, lamp.max.x]))
        .cut(1, [lamp.min.y, lamp.max.y])
        .cut(2, tiles(FAR, NEAR))
        .surface(building_material)
}

fn building_material(centre: DVec3, normal: DVec3) -> &'static str {
    let [left, right] = JAMBS;
    let doorway = cuboid([left - 0.08, 0.0, 1e-3 - THICKNESS], [right + 0.08, LINTEL + 0.08, 0.02]);
    let dark = (centre / TILE).floor();
    if normal.y > 0.5 && centre.y < 1e-3 {
        if (dark.x + dark.z) % 2.0 == 0.0 { "tile_light" } else { "tile_dark" }
    } else if lamp().contains(centre) {
        "lamp"
    } else if doorway.contains(centre) || (centre.y <= 0.1 && centre.z > 0.0) {
        "paint"
    } else if centre.z > 0.0 && centre.x == -HALF {
        "wall_warm"
    } else if centre.z > 0.0 && centre.x == HALF {
        "wall_green"
    } else {
        "plaster"
    }
}

/// From the door's frame (hinge on the y axis, the leaf towards −x, 4 cm thick about z = 0) to the building's. The
/// hinge is at the right jamb; the free edge stands in the near room.
fn door_to_building() -> DAffine3 {
    DAffine3::from_translation(DVec3::new(JAMBS[1] - 0.004, 0.0, -0.02)) * DAffine3::from_rotation_y(AJAR.to_radians())
}

/// A thin closed slab with six panels sunk into it, alike on both sides.
fn door() -> Shape {
    let slab = |min: [f64; 2], max: [f64; 2], half: f64| cuboid([min[0], min[1], -half], [max[0], max[1], half]);
    let mut leaf = Blocks::in_air().fill(slab([-0.885, 0.006], [0.0, 2.044], 0.02));
    for (low, high) in [(0.16, 0.66), (0.78, 1.42), (1.54, 1.92)] {
        for (left, right) in [(-0.785, -0.495), (-0.39, -0.1)] {
            let inner = ([left + 0.035, low + 0.035], [right - 0.035, high - 0.035]);
            leaf = leaf
                .carve(slab([left, low], [right, high], 0.02))
                .fill(slab([left, low], [right, high], 0.012))
                .fill(slab(inner.0, inner.1, 0.017));
        }
    }
    leaf.surface(|_, _| "door").transformed(&door_to_building())
}

fn knobs() -> Shape {
    let side = |sign: f64| {
        let out = DAffine3::from_rotation_x(sign * std::f64::consts::FRAC_PI_2);
        let at = DAffine3::from_translation(DVec3::new(-0.835, 1.0, sign * 0.02));
        knob("brass").transformed(&(door_to_building() * at * out))
    };
    side(1.0).with(side(-1.0))
}

/// A table whose legs reach a centimetre into the floor.
fn table() -> Shape {
    let (min, max) = ([-1.35, 2.0], [0.3, 2.9]);
    let mut table = Blocks::in_air()
        .fill(cuboid([min[0], TABLE_TOP - 0.035, min[1]], [max[0], TABLE_TOP, max[1]]))
        .fill(cuboid(
            [min[0] + 0.06, TABLE_TOP - 0.12, min[1] + 0.06],
            [max[0] - 0.06, TABLE_TOP - 0.035, max[1] - 0.06],
        ))
        .carve(cuboid(
            [min[0] + 0.08, TABLE_TOP - 0.12, min[1] + 0.08],
            [max[0] - 0.08, TABLE_TOP - 0.035, max[1] - 0.08],
        ));
    for x in [min[0] + 0.05, max[0] - 0.11] {
        for z in [min[1] + 0.05, max[1] - 0.11] {
            table = table.fill(cuboid([x, -0.01, z], [x + 0.06, TABLE_TOP - 0.035, z + 0.06]));
        }
    }
    table.surface(|_, _| "wood")
}

/// A framed picture on the door wall, its back 5 mm in the plaster.
fn picture() -> Shape {
    let (min, max) = ([-1.35, 1.3], [-0.25, 2.05]);
    let (frame, canvas) = (0.05, 0.012);
    Blocks::in_air()
        .fill(cuboid([min[0], min[1], -0.005], [max[0], max[1], 0.035]))
        .carve(cuboid([min[0] + frame, min[1] + frame, canvas], [max[0] - frame, max[1] - frame, 0.035]))
        .cut(0, [-1.0, -0.82, -0.5])
        .cut(1, [1.5, 1.62, 1.85])
        .surface(move |centre, normal| match centre {
            c if normal.z < 0.5 || c.z != canvas => "wood",
            c if c.y < 1.5 => "paint_blue",
            c if c.x < -1.0 && c.y > 1.62 => "wall_warm",
            c if c.x > -0.5 && c.y < 1.85 => "paint_yellow",
            c if c.x > -0.82 && c.x < -0.5 && c.y > 1.62 => "wall_green",
            _ => "paint",
        })
}

pub(super) fn materials() -> Vec<Material> {
    const GLASS: &[&str] = &["Ks 1 1 1", "Ni 1.5", "illum 7"];
    const METAL: &[&str] = &["Ks 0.95 0.64 0.54", "Ns 200", "Pm 1", "Pr 0.4", "illum 3"];
    const BRASS: &[&str] = &["Ks 0.89 0.75 0.42", "Ns 300", "Pm 1", "Pr 0.3", "illum 3"];
    let shiny = |name, more| Material { more, ..Material::diffuse(name, [0.0; 3]) };
    vec![
        Material::diffuse("plaster", [0.82, 0.8, 0.76]),
        Material::diffuse("wall_warm", [0.74, 0.42, 0.28]),
        Material::diffuse("wall_green", [0.4, 0.6, 0.42]),
        Material::diffuse("paint", [0.8, 0.79, 0.76]),
        Material::diffuse("paint_blue", [0.1, 0.2, 0.42]),
        Material::diffuse("paint_yellow", [0.75, 0.55, 0.12]),
        Material::diffuse("tile_light", [0.66, 0.6, 0.52]),
        Material::diffuse("tile_dark", [0.22, 0.2, 0.19]),
        Material::diffuse("door", [0.62, 0.7, 0.74]),
        Material::diffuse("wood", [0.5, 0.33, 0.19]),
        Material::diffuse("pumpkin", [0.78, 0.34, 0.07]),
        Material::diffuse("stem", [0.25, 0.3, 0.1]),
        shiny("glass", GLASS),
        shiny("copper", METAL),
        shiny("brass", BRASS),
        Material { emission: LAMP, ..Material::diffuse("lamp", [0.0; 3]) },
    ]
}

/// Radiance of the lamp: about a part in a thousand arrives at the near room's walls, whose radiance is to be near 1,
/// so that neither the PNG needs exposure nor a relative error its floor.
const LAMP: [f64; 3] = [900.0, 810.0, 670.0];

fn toml() -> String {
    let [eye, target] = [EYE, TARGET].map(|p| toml_vector(to_world().transform_point3(p)));
    format!(
        r#"# After the DOOR scene of Tan, "Path Tracing with Reinforcement Learning", and the ajar door of Veach 1997.
# The only lamp is a panel in the far room, on the far side of the wall that holds the door: no point of the near
# room faces it, so that all that is seen there has come through the gap after at least one reflection. The building
# is turned by {TURN} degrees, so that its walls and the thin, two-sided door lie along no axis of a guide's grid.
[camera]
origin = {eye}
target = {target}
up = [0, 1, 0]
vfov = 40.0

[film]
width = 512
height = 288
filter = "box"
exposure = 0.0

[[mesh]]
path = "door.obj"

[material.glass]
type = "dielectric"
int_ior = 1.5
ext_ior = 1.0
alpha = 0

[material.copper]
type = "conductor"
alpha = 0.15
eta = [0.2, 0.924, 1.102]
k = [3.912, 2.452, 2.142]

[material.brass]
type = "conductor"
alpha = 0.1
eta = [0.444, 0.527, 1.094]
k = [3.695, 2.765, 1.829]

[integrator]
max_depth = 16
next_event = true
mis = true
rr_depth = 5

[render]
spp = 64
seed = 0
"#
    )
}
