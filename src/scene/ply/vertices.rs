//! The element `vertex`: positions, and what else is known there.

use super::blocks::{Block, Source, unread};
use super::colors::Channels;
use super::header::{Element, Encoding};
use super::values::{Binary, Fault, Text, Values, with_values, within};
use crate::embree::LARGEST_COORDINATE;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::mem::take;

/// Names of a vertex' numbers, in the order of [`Record`].
const NAMES: [&[&str]; 8] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
];

/// Where in a [`Record`] its colour is.
const COLOR: usize = NAMES.len();

/// The numbers of a vertex.
type Record = [f64; COLOR + 3];

/// Which of an element's properties mean what.
pub(super) struct Layout<'a> {
    element: &'a Element,
    /// Of each property, its place in a [`Record`].
    places: Vec<Option<usize>>,
    pub(crate) normals: bool,
    pub(crate) uvs: bool,
    pub(crate) colors: Option<Channels>,
}

impl<'a> Layout<'a> {
    /// `colors` is the attribute that becomes the mesh's colours.
    ///
    /// # Errors
    /// Where a coordinate is missing.
    pub(crate) fn of(element: &'a Element, colors: Option<&str>) -> Result<Layout<'a>, String> {
        let scalar = |name: &&str| element.properties.iter().position(|p| p.name == **name && p.length.is_none());
        let found = NAMES.map(|names| names.iter().find_map(scalar));
        if let Some(missing) = (0..3).find(|&k| found[k].is_none()) {
            return Err(format!("vertices have no `{}`", NAMES[missing][0]));
        }
        let has = |range: std::ops::Range<usize>| range.into_iter().all(|k| found[k].is_some());
        let (normals, uvs) = (has(3..6), has(6..8));
        let wanted = |k: usize| k < 3 || (k < 6 && normals) || (k >= 6 && uvs);
        let mut places = vec![None; element.properties.len()];
        for (place, property) in found.iter().enumerate().filter(|(place, _)| wanted(*place)) {
            if let Some(property) = property {
                places[*property] = Some(place);
            }
        }
        let colors = colors.and_then(|name| Channels::of(element, name));
        for (property, place) in places.iter_mut().enumerate().filter(|(_, place)| place.is_none()) {
            *place = colors.as_ref().and_then(|colors| colors.channel(property)).map(|channel| COLOR + channel);
        }
        Ok(Layout { element, places, normals, uvs, colors })
    }

    /// Bytes that a vertex takes in a mesh.
    pub(crate) fn bytes(&self) -> u64 {
        12 + 12 * u64::from(self.normals) + 8 * u64::from(self.uvs) + 12 * u64::from(self.colors.is_some())
    }

    #[inline(always)]
    fn read<V: Values>(&self, values: &mut V, record: &mut Record) -> Result<(), Fault> {
        values.begin()?;
        for (property, place) in self.element.properties.iter().zip(&self.places) {
            match (property.length, place) {
                (None, Some(place)) => record[*place] = values.number(property.kind)?,
                (None, None) => values.skip(property.kind, 1)?,
                (Some(length), _) => {
                    let count = values.length(length)?;
                    values.skip(property.kind, count)?;
                }
            }
        }
        values.end()
    }
}

/// What is read of all vertices.
#[derive(Default)]
pub(super) struct Vertices {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) colors: Vec<[f32; 3]>,
    pub(crate) broken: Broken,
}

/// Vertices of which something cannot be used, by number, in their order.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Broken {
    pub(crate) positions: Vec<u32>,
    pub(crate) normals: Vec<u32>,
    pub(crate) uvs: Vec<u32>,
}

/// The parts of the arrays that a block fills; those of what there is none of are empty.
struct Slots<'a> {
    block: &'a Block,
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    uvs: &'a mut [[f32; 2]],
    colors: &'a mut [[f32; 3]],
}

/// Reads all vertices.
pub(super) fn read(layout: &Layout, encoding: Encoding, source: &Source, blocks: &[Block]) -> Result<Vertices, Fault> {
    let count = layout.element.count;
    let length = |there: bool| if there { count } else { 0 };
    let mut all = Vertices {
        positions: vec![[0.0; 3]; count],
        normals: vec![[0.0; 3]; length(layout.normals)],
        uvs: vec![[0.0; 2]; length(layout.uvs)],
        colors: vec![[0.0; 3]; length(layout.colors.is_some())],
        broken: Broken::default(),
    };
    let tasks = slots(&mut all, blocks);
    let read = |buffer: &mut Vec<u8>, slots: Slots| {
        let range = slots.block.range.clone();
        let at = range.start;
        let bytes = source.bytes(range, buffer).map_err(|error| unread(at, &error))?;
        with_values!(encoding, bytes, values => block(layout, &mut values, slots)).map_err(|fault| fault.after(at))
    };
    let parts: Vec<Result<Broken, Fault>> = tasks.into_par_iter().map_init(Vec::new, read).collect();
    for part in parts {
        let part = part?;
        all.broken.positions.extend(part.positions);
        all.broken.normals.extend(part.normals);
        all.broken.uvs.extend(part.uvs);
    }
    Ok(all)
}

fn slots<'a>(all: &'a mut Vertices, blocks: &'a [Block]) -> Vec<Slots<'a>> {
    let Vertices { positions, normals, uvs, colors, .. } = all;
    let (mut positions, mut normals) = (&mut positions[..], &mut normals[..]);
    let (mut uvs, mut colors) = (&mut uvs[..], &mut colors[..]);
    let slots = blocks.iter().map(|block| Slots {
        block,
        positions: cut(&mut positions, block.count),
        normals: cut(&mut normals, block.count),
        uvs: cut(&mut uvs, block.count),
        colors: cut(&mut colors, block.count),
    });
    slots.collect()
}

/// Cuts the front off a slice; an empty one stays so.
pub(super) fn cut<'a, T>(rest: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (front, back) = take(rest).split_at_mut_checked(count).unwrap_or_default();
    *rest = back;
    front
}

fn block<V: Values>(layout: &Layout, values: &mut V, slots: Slots) -> Result<Broken, Fault> {
    let (mut broken, mut record) = (Broken::default(), Record::default());
    for k in 0..slots.block.count {
        let index = slots.block.first + k;
        layout.read(values, &mut record).map_err(|fault| within(fault, layout.element, index))?;
        let [x, y, z, nx, ny, nz, u, v, red, green, blue] = record;
        let position = [x as f32, y as f32, z as f32];
        if !position.iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
            broken.positions.push(index as u32);
        }
        slots.positions[k] = position;
        if let Some(slot) = slots.normals.get_mut(k) {
            *slot = [nx as f32, ny as f32, nz as f32];
            let square = Vec3::from(*slot).length_squared();
            if !(square >= f32::MIN_POSITIVE && square.is_finite()) {
                broken.normals.push(index as u32);
            }
        }
        if let Some(slot) = slots.uvs.get_mut(k) {
            *slot = [u as f32, v as f32];
            if !slot.iter().all(|x| x.is_finite()) {
                broken.uvs.push(index as u32);
            }
        }
        if let Some((slot, channels)) = slots.colors.get_mut(k).zip(layout.colors.as_ref()) {
            *slot = channels.color([red, green, blue]);
        }
    }
    Ok(broken)
}

/// Reads the positions anew, counted from `origin` before they are rounded.
pub(super) fn read_positions(
    layout: &Layout,
    encoding: Encoding,
    source: &Source,
    blocks: &[Block],
    (mut positions, origin): (&mut [[f32; 3]], DVec3),
) -> Result<(), Fault> {
    let tasks: Vec<_> = blocks.iter().map(|block| (block, cut(&mut positions, block.count))).collect();
    tasks.into_par_iter().try_for_each_init(Vec::new, |buffer, (block, slots)| {
        let at = block.range.start;
        let bytes = source.bytes(block.range.clone(), buffer).map_err(|error| unread(at, &error))?;
        let mut record = Record::default();
        with_values!(encoding, bytes, values => slots.iter_mut().try_for_each(|slot| {
            layout.read(&mut values, &mut record)?;
            let [x, y, z, ..] = record;
            *slot = (DVec3::new(x, y, z) - origin).as_vec3().into();
            Ok(())
        }))
        .map_err(|fault: Fault| fault.after(at))
    })
}

/// Where vertex `index` begins.
pub(super) fn place(layout: &Layout, encoding: Encoding, source: &Source, blocks: &[Block], index: usize) -> usize {
    let mut buffer = Vec::new();
    let Some(block) = blocks.iter().rfind(|block| block.first <= index) else { return 0 };
    let Ok(bytes) = source.bytes(block.range.clone(), &mut buffer) else { return block.range.start };
    with_values!(encoding, bytes, values => {
        for _ in block.first..index {
            if values.pass(layout.element).is_err() {
                break;
            }
        }
        // an ASCII file's line begins behind the end of the one before
        _ = values.begin();
        block.range.start + values.at()
    })
}
