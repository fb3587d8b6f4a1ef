//! One house of the city: four walls of bays and floors, and a roof.

use super::super::stream::ObjStream;
use crate::math::rng::{Rng, mix};
use glam::DVec3;
use std::io;

/// Width of a bay and height of a floor, in metres.
const BAY: f64 = 3.0;
const FLOOR: f64 = 3.4;
/// A window's edges within its bay and floor, and how deep it lies in the wall.
const WINDOW: [[f64; 2]; 2] = [[0.75, 2.25], [0.95, 2.75]];
const REVEAL: f64 = 0.2;
/// Triangles of a bay of a floor: four pieces of wall, four of the reveal, the pane, the sill.
const CELL: u64 = 8 + 8 + 2 + 10;
/// Of the roof and the house on it.
const ROOF: u64 = 2 + 10;
/// One window in so many is lit.
const LIT: u64 = 14;

const WALLS: [&str; 3] = ["plaster", "brick", "concrete"];

/// Right-handed axes about a corner, in which boxes and walls are given as (along, up, outward).
#[derive(Clone, Copy)]
pub(crate) struct Block {
    origin: DVec3,
    along: DVec3,
    outward: DVec3,
}

impl Block {
    /// The axes of the world.
    pub(crate) fn world() -> Block {
        Block { origin: DVec3::ZERO, along: DVec3::X, outward: DVec3::Z }
    }

    fn at(&self, p: [f64; 3]) -> DVec3 {
        self.origin + self.along * p[0] + DVec3::Y * p[1] + self.outward * p[2]
    }

    fn quad(&self, obj: &mut ObjStream, corners: [[f64; 3]; 4]) -> io::Result<()> {
        obj.quad(corners.map(|p| self.at(p)))
    }

    /// A box between two corners: without its bottom if it stands on the ground, else with all six sides.
    pub(crate) fn write(&self, obj: &mut ObjStream, (low, high): (DVec3, DVec3), bottom: bool) -> io::Result<()> {
        let (a, b) = (low.to_array(), high.to_array());
        self.sides(obj, a, b)?;
        self.quad(obj, [[b[0], a[1], a[2]], [a[0], a[1], a[2]], [a[0], b[1], a[2]], [b[0], b[1], a[2]]])?;
        if bottom {
            self.quad(obj, [[a[0], a[1], a[2]], [b[0], a[1], a[2]], [b[0], a[1], b[2]], [a[0], a[1], b[2]]])?;
        }
        Ok(())
    }

    /// What a box that leans on a wall shows besides its bottom: front, top, both ends.
    fn sides(&self, obj: &mut ObjStream, a: [f64; 3], b: [f64; 3]) -> io::Result<()> {
        self.quad(obj, [[a[0], a[1], b[2]], [b[0], a[1], b[2]], [b[0], b[1], b[2]], [a[0], b[1], b[2]]])?;
        self.quad(obj, [[a[0], b[1], b[2]], [b[0], b[1], b[2]], [b[0], b[1], a[2]], [a[0], b[1], a[2]]])?;
        self.quad(obj, [[a[0], a[1], a[2]], [a[0], a[1], b[2]], [a[0], b[1], b[2]], [a[0], b[1], a[2]]])?;
        self.quad(obj, [[b[0], a[1], b[2]], [b[0], a[1], a[2]], [b[0], b[1], a[2]], [b[0], b[1], b[2]]])
    }
}

/// A house, by its numbers.
pub(crate) struct Building {
    number: u64,
    /// The middle of its ground plan.
    middle: DVec3,
    /// Bays along x and along z.
    bays: [u64; 2],
    floors: u64,
    wall: &'static str,
}

/// What is written together, so that materials change three times to a house.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Wall,
    Dark,
    Lit,
}

impl Building {
    /// House `number` about `middle`; `growth` scales how many floors houses have.
    pub(crate) fn new(number: u64, middle: DVec3, growth: f64) -> Building {
        let mut rng = Rng::new(number ^ 0xc17);
        let mut draw = |n: u32| rng.next_u32() % n;
        let bays = [5 + draw(3) as u64, 5 + draw(3) as u64];
        // many low houses, few high ones
        let height = 4.0 + 14.0 * (draw(1000) as f64 / 1000.0).powi(2);
        let floors = (height * growth).round().max(1.0) as u64;
        Building { number, middle, bays, floors, wall: WALLS[draw(3) as usize] }
    }

    pub(crate) fn triangles(&self) -> u64 {
        CELL * self.floors * 2 * (self.bays[0] + self.bays[1]) + ROOF
    }

    pub(crate) fn write(&self, obj: &mut ObjStream) -> io::Result<()> {
        for (part, material) in [(Part::Wall, self.wall), (Part::Dark, "window"), (Part::Lit, "window_lit")] {
            for (k, (wall, bays)) in self.walls().into_iter().enumerate() {
                for cell in 0..bays * self.floors {
                    if part != Part::Wall && part != self.pane(k as u64, cell) {
                        continue;
                    }
                    obj.material(material)?;
                    let (u, v) = ((cell % bays) as f64 * BAY, (cell / bays) as f64 * FLOOR);
                    if part == Part::Wall { bay(obj, &wall, u, v)? } else { pane(obj, &wall, u, v)? }
                }
            }
        }
        self.roof(obj)
    }

    /// Whether somebody is in.
    fn pane(&self, wall: u64, cell: u64) -> Part {
        if mix(mix(self.number << 2 | wall) ^ cell).is_multiple_of(LIT) { Part::Lit } else { Part::Dark }
    }

    fn half(&self) -> [f64; 2] {
        self.bays.map(|bays| bays as f64 * BAY / 2.0)
    }

    /// The four walls and how many bays each has; each begins at its lower left corner, seen from outside.
    fn walls(&self) -> [(Block, u64); 4] {
        let [x, z] = self.half();
        let wall = |cx: f64, cz: f64, along: DVec3, bays: u64| {
            let origin = self.middle + DVec3::new(cx, 0.0, cz);
            (Block { origin, along, outward: along.cross(DVec3::Y) }, bays)
        };
        [
            wall(-x, z, DVec3::X, self.bays[0]),
            wall(x, z, DVec3::NEG_Z, self.bays[1]),
            wall(x, -z, DVec3::NEG_X, self.bays[0]),
            wall(-x, -z, DVec3::Z, self.bays[1]),
        ]
    }

    fn roof(&self, obj: &mut ObjStream) -> io::Result<()> {
        let [x, z] = self.half();
        let top = self.middle.y + self.floors as f64 * FLOOR;
        let corner = |sx: f64, sz: f64| DVec3::new(self.middle.x + sx * x, top, self.middle.z + sz * z);
        obj.material("roof")?;
        obj.quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)])?;
        let low = DVec3::new(self.middle.x - x / 3.0, top, self.middle.z - z / 4.0);
        let high = DVec3::new(self.middle.x + x / 4.0, top + 2.2, self.middle.z + z / 3.0);
        Block::world().write(obj, (low, high), false)
    }
}

/// One bay of one floor but for its pane, its lower left corner at (`u`, `v`) of the wall.
fn bay(obj: &mut ObjStream, wall: &Block, u: f64, v: f64) -> io::Result<()> {
    let [[left, right], [sill, head]] = [WINDOW[0].map(|x| u + x), WINDOW[1].map(|y| v + y)];
    let flat = |a: [f64; 2], b: [f64; 2]| [[a[0], a[1], 0.0], [b[0], a[1], 0.0], [b[0], b[1], 0.0], [a[0], b[1], 0.0]];
    wall.quad(obj, flat([u, v], [left, v + FLOOR]))?;
    wall.quad(obj, flat([right, v], [u + BAY, v + FLOOR]))?;
    wall.quad(obj, flat([left, v], [right, sill]))?;
    wall.quad(obj, flat([left, head], [right, v + FLOOR]))?;
    let r = -REVEAL;
    wall.quad(obj, [[left, sill, 0.0], [right, sill, 0.0], [right, sill, r], [left, sill, r]])?;
    wall.quad(obj, [[left, head, r], [right, head, r], [right, head, 0.0], [left, head, 0.0]])?;
    wall.quad(obj, [[left, sill, r], [left, head, r], [left, head, 0.0], [left, sill, 0.0]])?;
    wall.quad(obj, [[right, sill, r], [right, sill, 0.0], [right, head, 0.0], [right, head, r]])?;
    let (low, high) = ([left - 0.1, sill - 0.14, 0.0], [right + 0.1, sill - 0.02, 0.16]);
    wall.sides(obj, low, high)?;
    let [x, y] = [[low[0], high[0]], [low[1], high[2]]];
    wall.quad(obj, [[x[0], y[0], 0.0], [x[1], y[0], 0.0], [x[1], y[0], y[1]], [x[0], y[0], y[1]]])
}

fn pane(obj: &mut ObjStream, wall: &Block, u: f64, v: f64) -> io::Result<()> {
    let [[left, right], [sill, head]] = [WINDOW[0].map(|x| u + x), WINDOW[1].map(|y| v + y)];
    let r = -REVEAL;
    wall.quad(obj, [[left, sill, r], [right, sill, r], [right, head, r], [left, head, r]])
}
