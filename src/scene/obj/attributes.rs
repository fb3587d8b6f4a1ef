//! Second pass: positions, texture coordinates and normals, straight into their places.

use super::colors::Colors;
use super::lines::{self, Fields, Lines};
use super::scan::Counts;
use super::source::Fault;
use crate::embree::LARGEST_COORDINATE;
use glam::DVec3;
use std::mem::take;

/// The parts of the mesh's arrays that a block fills.
#[derive(Default)]
pub(super) struct Slots<'a> {
    pub(crate) positions: &'a mut [[f32; 3]],
    pub(crate) uvs: &'a mut [[f32; 2]],
    pub(crate) normals: &'a mut [[f32; 3]],
}

/// A value that cannot be used: its index, and the offset of its statement.
pub(super) type Broken = (u32, u64);

/// The values that cannot be used, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct BrokenValues {
    pub(crate) positions: Vec<Broken>,
    pub(crate) uvs: Vec<Broken>,
    /// Also those too short to have a direction.
    pub(crate) normals: Vec<Broken>,
}

impl BrokenValues {
    /// All of a file's, from those of its blocks and what precedes each: vertices, and bytes.
    pub(crate) fn merge(blocks: impl Iterator<Item = ((Counts, u64), BrokenValues)>) -> BrokenValues {
        let mut all = BrokenValues::default();
        for ((before, start), block) in blocks {
            let append = |all: &mut Vec<Broken>, block: Vec<Broken>, before: usize| {
                all.extend(block.iter().map(|&(i, at)| (before as u32 + i, start + at)));
            };
            append(&mut all.positions, block.positions, before.positions);
            append(&mut all.uvs, block.uvs, before.uvs);
            append(&mut all.normals, block.normals, before.normals);
        }
        all
    }
}

/// Reads the `v`, `vt` and `vn` statements of a block, and the colours behind positions. Indices of broken values count from the
/// block's first.
pub(super) fn read(mut slots: Slots, text: &[u8]) -> Result<(BrokenValues, Colors), Fault> {
    let (mut broken, mut colors) = (BrokenValues::default(), Colors::default());
    let mut done = [0u32; 3];
    for (at, line) in Lines::new(text) {
        let (keyword, _) = lines::keyword(line);
        let mut fields = Fields::new(line, keyword.len());
        let located = |fault: Fault| fault.shifted(at as u64);
        match keyword {
            b"v" => {
                let value = fields.first_numbers("a vertex").map_err(located)?;
                if !fields.rest().is_empty() {
                    colors.read(done[0] as usize, &mut fields).map_err(located)?;
                }
                let usable = value.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
                note(&mut broken.positions, usable, &mut done[0], at);
                store(&mut slots.positions, value, at)?;
            }
            b"vt" => {
                let value = texture_coordinates(&mut fields).map_err(located)?;
                let usable = value.iter().all(|x| x.is_finite());
                note(&mut broken.uvs, usable, &mut done[1], at);
                store(&mut slots.uvs, value, at)?;
            }
            b"vn" => {
                let value = fields.numbers("a normal").map_err(located)?;
                note(&mut broken.normals, has_direction(value), &mut done[2], at);
                store(&mut slots.normals, value, at)?;
            }
            _ => {}
        }
    }
    let rest = slots.positions.len() + slots.uvs.len() + slots.normals.len();
    if rest == 0 { Ok((broken, colors)) } else { Err(changed(text.len())) }
}

/// Reads the positions of a block again, as they are written, less `origin`, and only then rounds them.
pub(super) fn read_positions(mut slots: &mut [[f32; 3]], text: &[u8], origin: DVec3) -> Result<(), Fault> {
    for (at, line) in Lines::new(text) {
        if let (b"v", _) = lines::keyword(line) {
            let mut fields = Fields::new(line, 1);
            let written = fields.doubles("a vertex").map_err(|fault| fault.shifted(at as u64))?;
            store(&mut slots, (DVec3::from(written) - origin).as_vec3().to_array(), at)?;
        }
    }
    if slots.is_empty() { Ok(()) } else { Err(changed(text.len())) }
}

#[inline]
fn note(broken: &mut Vec<Broken>, usable: bool, done: &mut u32, at: usize) {
    if !usable {
        broken.push((*done, at as u64));
    }
    *done += 1;
}

#[inline]
fn store<T>(slots: &mut &mut [T], value: T, at: usize) -> Result<(), Fault> {
    let (first, rest) = take(slots).split_first_mut().ok_or_else(|| changed(at))?;
    *first = value;
    *slots = rest;
    Ok(())
}

/// What there is to say where a later pass does not find what an earlier one counted.
#[cold]
pub(super) fn changed(at: usize) -> Fault {
    Fault::new(at, "the file changed while it was read")
}

/// One to three numbers; v is 0 where it is left out, and the third is dropped.
fn texture_coordinates(fields: &mut Fields) -> Result<[f32; 2], Fault> {
    let u = fields.number()?.ok_or_else(|| Fault::new(fields.at, "vt needs a number"))?;
    let v = fields.number()?.unwrap_or(0.0);
    while fields.number()?.is_some() {}
    Ok([u, v])
}

/// Whether the vector can be normalised in single precision.
#[inline]
fn has_direction(n: [f32; 3]) -> bool {
    let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    square >= f32::MIN_POSITIVE && square.is_finite()
}
