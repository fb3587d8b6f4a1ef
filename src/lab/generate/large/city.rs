//! `city`: streets at dusk. Every wall has windows with reveals and sills; a few are lit, and so are the street lamps.

mod building;

use super::stream::ObjStream;
use super::{LargeScene, Model};
use crate::lab::generate::obj_writer::Material;
use building::{Block, Building};
use glam::DVec3;
use std::io;

/// From one lot to the next: a lot and a street.
const PITCH: f64 = 34.0;
/// Half the side of a lot's pavement, its height, and how far houses stay off its edge.
const PAVEMENT: f64 = 12.0;
const KERB: f64 = 0.15;
/// Triangles of an average house, by which the number of lots is chosen.
const AVERAGE: f64 = 6000.0;
/// Of a lot besides its house: street, pavement, lamp.
const LOT: u64 = 2 + 10 + 10 + 12;

/// A city of about `triangles` triangles: the more, the larger.
pub(crate) fn scene(triangles: u64) -> LargeScene {
    let plan = Plan::new(triangles);
    LargeScene {
        toml: TOML.to_owned(),
        about: "streets at dusk",
        materials: materials(),
        models: vec![Model::new("city.obj", move |obj| plan.write(obj))],
    }
}

/// How many lots there are, and how high their houses.
struct Plan {
    /// Lots along each side: an even number, so that two streets cross at the origin.
    lots: u64,
    growth: f64,
}

impl Plan {
    /// Chooses the growth of all houses by bisection, so that their triangles add up.
    fn new(triangles: u64) -> Plan {
        let lots = 2 * ((triangles as f64 / AVERAGE).sqrt() / 2.0).round().max(1.0) as u64;
        let (mut low, mut high) = (0.0, 64.0);
        for _ in 0..60 {
            let growth = 0.5 * (low + high);
            let too_many = Plan { lots, growth }.triangles() > triangles;
            *(if too_many { &mut high } else { &mut low }) = growth;
        }
        Plan { lots, growth: low }
    }

    fn triangles(&self) -> u64 {
        self.houses().map(|(_, house)| LOT + house.triangles()).sum()
    }

    /// The middle of each lot and the house on it.
    fn houses(&self) -> impl Iterator<Item = (DVec3, Building)> + '_ {
        let place = |i: u64| (i as f64 + 0.5 - self.lots as f64 / 2.0) * PITCH;
        (0..self.lots * self.lots).map(move |k| {
            let middle = DVec3::new(place(k % self.lots), 0.0, place(k / self.lots));
            (middle, Building::new(k, middle + DVec3::Y * KERB, self.growth))
        })
    }

    fn write(&self, obj: &mut ObjStream) -> io::Result<()> {
        for (middle, house) in self.houses() {
            lot(obj, middle)?;
            house.write(obj)?;
        }
        Ok(())
    }
}

/// Asphalt, pavement, and a lamp at the corner nearest to the street crossing.
fn lot(obj: &mut ObjStream, middle: DVec3) -> io::Result<()> {
    let h = PITCH / 2.0;
    let corner = |x: f64, z: f64| middle + DVec3::new(x, 0.0, z);
    obj.material("asphalt")?;
    obj.quad([corner(-h, h), corner(h, h), corner(h, -h), corner(-h, -h)])?;
    let world = Block::world();
    let about = |centre: DVec3, size: [f64; 3]| {
        let half = DVec3::new(size[0] / 2.0, 0.0, size[2] / 2.0);
        (centre - half, centre + half + DVec3::Y * size[1])
    };
    obj.material("pavement")?;
    world.write(obj, about(middle, [2.0 * PAVEMENT, KERB, 2.0 * PAVEMENT]), false)?;
    let foot = corner(PAVEMENT - 0.6, PAVEMENT - 0.6) + DVec3::Y * KERB;
    obj.material("iron")?;
    world.write(obj, about(foot, [0.12, 4.4, 0.12]), false)?;
    obj.material("lamp")?;
    world.write(obj, about(foot + DVec3::Y * 4.45, [0.34, 0.24, 0.34]), true)
}

fn materials() -> Vec<Material> {
    let glow = |name, emission| Material { emission, ..Material::diffuse(name, [0.0; 3]) };
    vec![
        Material::diffuse("asphalt", [0.09, 0.09, 0.1]),
        Material::diffuse("pavement", [0.3, 0.29, 0.28]),
        Material::diffuse("iron", [0.06, 0.06, 0.06]),
        Material::diffuse("plaster", [0.55, 0.5, 0.42]),
        Material::diffuse("brick", [0.4, 0.2, 0.14]),
        Material::diffuse("concrete", [0.42, 0.42, 0.41]),
        Material::diffuse("roof", [0.17, 0.16, 0.16]),
        Material::diffuse("window", [0.04, 0.05, 0.06]),
        glow("window_lit", [5.0, 3.3, 1.5]),
        glow("lamp", [60.0, 42.0, 22.0]),
    ]
}

const TOML: &str = r#"# Streets at dusk: a city of houses whose windows have reveals and sills. A few windows are lit, and so is the lamp
# at every corner; the sky is dim. The more triangles, the larger the city.
[camera]
origin = [2.2, 4.2, 15]
target = [-1.5, 6.4, -30]
vfov = 56.0

[film]
width = 960
height = 540
exposure = 2.0

[[mesh]]
path = "city.obj"

[material.window]
type = "plastic"
reflectance = [0.03, 0.035, 0.04]
alpha = 0.02

[[light]]
type = "constant"
radiance = [0.1, 0.14, 0.25]

[render]
spp = 64
"#;
