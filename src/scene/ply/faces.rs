//! The element `face`: polygons into triangles.

use super::blocks::{Block, Search, Source, unread};
use super::colors::Channels;
use super::header::{Element, Encoding, Kind};
use super::values::{Binary, Fault, Text, Values, with_values, within};
use super::vertices::cut;
use crate::geometry::mesh::ABSENT;
use crate::scene::triangulate::{LARGEST_CONCAVE, triangulate};
use rayon::prelude::*;
use std::mem::take;

/// Which of an element's properties mean what.
pub(super) struct Layout<'a> {
    element: &'a Element,
    indices: usize,
    /// A list of two numbers for each corner (MeshLab, OpenMVS).
    uvs: Option<usize>,
    pub(crate) colors: Option<Channels>,
}

impl<'a> Layout<'a> {
    /// `colors` is the attribute that becomes the mesh's colours.
    ///
    /// # Errors
    /// Where there is no list of vertices.
    pub(crate) fn of(element: &'a Element, colors: Option<&str>) -> Result<Layout<'a>, String> {
        let list = |names: &[&str]| {
            element.properties.iter().position(|p| p.length.is_some() && names.contains(&p.name.as_str()))
        };
        let indices = list(&["vertex_indices", "vertex_index"]).ok_or("faces have no list `vertex_indices`")?;
        if !element.properties[indices].kind.is_whole() {
            return Err(format!("`{}` must be whole numbers", element.properties[indices].name));
        }
        let colors = colors.and_then(|name| Channels::of(element, name));
        Ok(Layout { element, indices, uvs: list(&["texcoord"]), colors })
    }

    /// Bytes that a triangle takes in a mesh, what is held twice while blocks are joined included.
    pub(crate) fn bytes(&self) -> u64 {
        // three corners of four bytes, twice, and a material
        28 + if self.uvs.is_some() { 60 } else { 0 } + if self.colors.is_some() { 24 } else { 0 }
    }

    fn has_corners_alone(&self) -> bool {
        self.uvs.is_none() && self.colors.is_none()
    }
}

/// What is read of all faces.
#[derive(Default)]
pub(super) struct Faces {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the corners of all triangles, where faces have their own; else empty.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Of triangles, which of those they have.
    pub(crate) uv_indices: Vec<[u32; 3]>,
    /// Of triangles, where faces have some; else empty.
    pub(crate) colors: Vec<[f32; 3]>,
}

/// The triangles of a block, the texture coordinates of their corners, and their colours.
type Part = (Vec<[u32; 3]>, Vec<[f32; 2]>, Vec<[f32; 3]>);

/// Reads all faces, which may name the vertices at `positions`.
///
/// # Errors
/// Faces that cannot be read. With [`Search::Even`] also those that are no triangles.
pub(super) fn read(
    layout: &Layout,
    (encoding, search): (Encoding, Search),
    source: &Source,
    blocks: &[Block],
    positions: &[[f32; 3]],
) -> Result<Faces, Fault> {
    let read = |reader: &mut Reader, block: &Block| {
        let (at, mut buffer) = (block.range.start, take(&mut reader.buffer));
        let bytes = source.bytes(block.range.clone(), &mut buffer).map_err(|error| unread(at, &error))?;
        let read = with_values!(encoding, bytes, values => {
            reader.block(&mut values, block).and_then(|()| match search {
                Search::Even if values.at() != block.range.len() => {
                    Err(Fault::new(values.at(), "not all lists are as long"))
                }
                _ => Ok(()),
            })
        });
        reader.buffer = buffer;
        read.map_err(|fault| fault.after(at))
    };
    let init = || Reader::new(layout, positions);
    if search == Search::Even && layout.has_corners_alone() {
        let mut triangles = vec![[0; 3]; blocks.iter().map(|block| block.count).sum()];
        let mut rest = &mut triangles[..];
        let tasks: Vec<_> = blocks.iter().map(|block| (block, cut(&mut rest, block.count))).collect();
        tasks.into_par_iter().try_for_each_init(init, |reader, (block, slots)| {
            read(reader, block)?;
            if reader.triangles.len() != slots.len() {
                return Err(Fault::new(block.range.start, "not all faces are triangles"));
            }
            slots.copy_from_slice(&reader.triangles);
            reader.triangles.clear();
            Ok(())
        })?;
        return Ok(Faces { triangles, ..Faces::default() });
    }
    let part = |reader: &mut Reader, block: &Block| {
        read(reader, block)?;
        Ok((take(&mut reader.triangles), take(&mut reader.uvs), take(&mut reader.colors)))
    };
    let parts: Result<Vec<Part>, Fault> = blocks.par_iter().map_init(init, part).collect();
    let (triangles, uvs, colors): (Vec<_>, Vec<_>, Vec<_>) = parts?.into_iter().collect();
    let (triangles, uvs, colors) = (joined(triangles), joined(uvs), joined(colors));
    let faces = if layout.uvs.is_none() { Faces { triangles, ..Faces::default() } } else { with_uvs(triangles, uvs) };
    Ok(Faces { colors, ..faces })
}

/// Faces with three texture coordinates for each triangle; those that are not finite are none.
fn with_uvs(triangles: Vec<[u32; 3]>, uvs: Vec<[f32; 2]>) -> Faces {
    let own = |k: usize| {
        let corners = [3 * k, 3 * k + 1, 3 * k + 2];
        let there = corners.iter().all(|&c| uvs[c].iter().all(|x: &f32| x.is_finite()));
        if there { corners.map(|c| c as u32) } else { [ABSENT; 3] }
    };
    let uv_indices = (0..triangles.len()).into_par_iter().map(own).collect();
    // what is not finite is not looked at, but a mesh holds finite numbers only
    let uvs = uvs.into_par_iter().map(|uv| uv.map(|x| if x.is_finite() { x } else { 0.0 })).collect();
    Faces { triangles, uvs, uv_indices, ..Faces::default() }
}

/// One after the other.
fn joined<T: Copy + Default + Send + Sync>(parts: Vec<Vec<T>>) -> Vec<T> {
    let mut all = vec![T::default(); parts.iter().map(Vec::len).sum()];
    let mut rest = &mut all[..];
    let tasks: Vec<_> = parts.into_iter().map(|part| (cut(&mut rest, part.len()), part)).collect();
    tasks.into_par_iter().for_each(|(slots, part)| slots.copy_from_slice(&part));
    all
}

/// What faces may refer to, what has been read, and scratch memory for one of them.
struct Reader<'a> {
    layout: &'a Layout<'a>,
    positions: &'a [[f32; 3]],
    triangles: Vec<[u32; 3]>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[f32; 3]>,
    corners: Vec<u32>,
    corner_uvs: Vec<f32>,
    /// Channels of the face's colour, as they are stored.
    color: [f64; 3],
    points: Vec<[f32; 3]>,
    pieces: Vec<[usize; 3]>,
    /// Bytes of a block.
    buffer: Vec<u8>,
}

impl<'a> Reader<'a> {
    fn new(layout: &'a Layout, positions: &'a [[f32; 3]]) -> Reader<'a> {
        let (triangles, uvs, colors, corners, corner_uvs, color, points, pieces, buffer) = Default::default();
        Reader { layout, positions, triangles, uvs, colors, corners, corner_uvs, color, points, pieces, buffer }
    }

    fn block<V: Values>(&mut self, values: &mut V, block: &Block) -> Result<(), Fault> {
        self.triangles.reserve(block.count);
        let element = self.layout.element;
        // most files have nothing but triangles
        let alone = element.properties.len() == 1;
        for k in block.first..block.first + block.count {
            if alone && let Some(triangle) = values.triangle(&element.properties[0]) {
                self.triangle(triangle, values.at()).map_err(|fault| within(fault, element, k))?;
                continue;
            }
            self.face(values).map_err(|fault| within(fault, element, k))?;
        }
        Ok(())
    }

    /// A triangle that was read before the byte `end`.
    #[inline(always)]
    fn triangle(&mut self, corners: [u32; 3], end: usize) -> Result<(), Fault> {
        let count = self.positions.len();
        if corners[0].max(corners[1]).max(corners[2]) as usize >= count {
            let k = corners.iter().position(|&corner| corner as usize >= count).unwrap_or(0);
            let kind = self.layout.element.properties[self.layout.indices].kind;
            let index = if kind == Kind::I32 { f64::from(corners[k] as i32) } else { f64::from(corners[k]) };
            return Err(no_vertex(end - 12 + 4 * k, index, count));
        }
        self.triangles.push(corners);
        Ok(())
    }

    fn face<V: Values>(&mut self, values: &mut V) -> Result<(), Fault> {
        values.begin()?;
        let layout = self.layout;
        for (k, property) in layout.element.properties.iter().enumerate() {
            let count = property.length.map_or(Ok(1), |length| values.length(length))?;
            if k == layout.indices {
                self.indices(values, property.kind, count)?;
            } else if Some(k) == layout.uvs {
                self.corner_uvs.clear();
                for _ in 0..count {
                    self.corner_uvs.push(values.number(property.kind)? as f32);
                }
            } else if let Some(channel) = layout.colors.as_ref().and_then(|colors| colors.channel(k)) {
                self.color[channel] = values.number(property.kind)?;
            } else {
                values.skip(property.kind, count)?;
            }
        }
        let at = values.at();
        values.end()?;
        self.cut(at)
    }

    #[inline(always)]
    fn indices<V: Values>(&mut self, values: &mut V, kind: Kind, count: usize) -> Result<(), Fault> {
        self.corners.clear();
        for _ in 0..count {
            let (at, index) = (values.at(), values.number(kind)?);
            if !(index >= 0.0 && index < self.positions.len() as f64 && index.fract() == 0.0) {
                return Err(no_vertex(at, index, self.positions.len()));
            }
            self.corners.push(index as u32);
        }
        Ok(())
    }

    /// Appends the triangles of the face that was read.
    #[inline(always)]
    fn cut(&mut self, at: usize) -> Result<(), Fault> {
        let with_uvs = self.layout.uvs.is_some();
        if with_uvs && !self.corner_uvs.is_empty() && self.corner_uvs.len() != 2 * self.corners.len() {
            let (has, needs) = (self.corner_uvs.len(), 2 * self.corners.len());
            return Err(Fault::new(at, format!("`texcoord` has {has} numbers, and the corners need {needs}")));
        }
        if let [a, b, c] = self.corners[..] {
            self.push([0, 1, 2], [a, b, c]);
            return Ok(());
        }
        self.points.clear();
        self.points.extend(self.corners.iter().map(|&corner| self.positions[corner as usize]));
        self.pieces.clear();
        if !triangulate(&self.points, &mut self.pieces) {
            let message = format!("a concave face of {} corners (at most {LARGEST_CONCAVE})", self.corners.len());
            return Err(Fault::new(at, message));
        }
        for k in 0..self.pieces.len() {
            let piece = self.pieces[k];
            self.push(piece, piece.map(|corner| self.corners[corner]));
        }
        Ok(())
    }

    #[inline(always)]
    fn push(&mut self, piece: [usize; 3], triangle: [u32; 3]) {
        self.triangles.push(triangle);
        if let Some(channels) = &self.layout.colors {
            self.colors.push(channels.color(self.color));
        }
        if self.layout.uvs.is_some() {
            let uv =
                |corner: usize| self.corner_uvs.get(2 * corner..2 * corner + 2).map_or([f32::NAN; 2], |x| [x[0], x[1]]);
            self.uvs.extend(piece.map(uv));
        }
    }
}

#[cold]
fn no_vertex(at: usize, index: f64, count: usize) -> Fault {
    Fault::new(at, format!("there is no vertex {index}: the file has {count}, counted from 0"))
}
