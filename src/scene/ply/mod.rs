//! The Stanford polygon format, PLY: ASCII, and binary of both byte orders.
//!
//! A header in text names the elements and the numbers of each. Vertices and faces are cut into blocks that all cores read side by
//! side. Where all things of an element are as long, which faces are as long as all are triangles, their places follow from their
//! numbers, and the file is never in memory as a whole. Where they are not, a pass over the file looks at the lengths of lists, or at
//! the ends of lines in ASCII. docs/ply.md says what is read.

mod blocks;
mod colors;
mod faces;
mod header;
#[cfg(test)]
mod tests;
mod values;
mod vertices;

use super::description::MaterialDescription;
use super::model::{Model, Warning};
use super::origin::Bounds;
use super::repair;
use crate::bsdf::DiffuseParameters;
use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices, MeshColors};
use crate::io::{memory, paths};
use crate::texture::{ColorTexture, ImageTexture};
use crate::{Error, Result};
use blocks::{Block, Search, Source, blocks};
use colors::{Channels, Wanted};
use faces::Faces;
use glam::DVec3;
use header::{Encoding, Header, LONGEST};
use std::collections::BTreeMap;
use std::path::Path;
use values::Fault;
use vertices::Vertices;

/// Loads a PLY file.
///
/// In the model positions and normals are as in the file: not transformed, normals not normalised. Positions far from 0 are counted from
/// an origin near them. All faces have the material "". Polygons become triangles, ears being cut off concave ones; faces with fewer
/// than three corners are dropped. A file without faces gives an empty mesh, and a warning.
///
/// # Errors
/// With the line, or the byte of a binary file: what is malformed, names vertices that are not there, or ends too early.
pub fn load(path: &Path) -> Result<Model> {
    parse(Source::open(path)?, path, Wanted::Any)
}

/// Loads a PLY file with the colours that Mitsuba would call `attribute`.
///
/// # Errors
/// Those of [`load`], and where there is no such attribute.
pub(super) fn load_with(path: &Path, attribute: &str) -> Result<Model> {
    let wanted = Wanted::named(attribute);
    let found = wanted.map(|wanted| parse(Source::open(path)?, path, wanted)).transpose()?;
    found
        .filter(|model| model.mesh.colors.is_some())
        .ok_or_else(|| Error::file(path, format!("there is no attribute `{attribute}` of three numbers or of one")))
}

/// `path` names the file in errors, and pictures are looked for beside it.
fn parse(mut source: Source, path: &Path, wanted: Wanted) -> Result<Model> {
    let mut buffer = Vec::new();
    let head = source.bytes(0..source.len().min(LONGEST), &mut buffer).map_err(Error::io(path))?;
    let header = header::read(head, path)?;
    if header.may_be_even()
        && let Ok(model) = (File { source: &source, path, header: &header, wanted, search: Search::Even }).read()
    {
        return Ok(model);
    }
    source.keep(path)?;
    let file = File { source: &source, path, header: &header, wanted, search: Search::Scan };
    file.read().map_err(|fault| file.error(fault))
}

/// A file whose header is known.
struct File<'a> {
    source: &'a Source<'a>,
    path: &'a Path,
    header: &'a Header,
    wanted: Wanted<'a>,
    search: Search,
}

/// The vertices and where they are, so as to read them again.
struct Vertex<'a> {
    layout: vertices::Layout<'a>,
    blocks: Vec<Block>,
}

/// The faces, likewise.
struct Face<'a> {
    layout: faces::Layout<'a>,
    blocks: Vec<Block>,
}

impl File<'_> {
    fn read(&self) -> Result<Model, Fault> {
        let (vertex, face) = self.find()?;
        let Some(vertex) = vertex else { return Err(self.in_header("there are no vertices")) };
        self.check_memory(&vertex, face.as_ref())?;
        let mut vertices = vertices::read(&vertex.layout, self.header.encoding, self.source, &vertex.blocks)?;
        let mut origin = Bounds::of(&vertices.positions).origin();
        if origin != DVec3::ZERO {
            self.move_to(origin, &vertex, &mut vertices.positions)?;
        }
        let mut faces = self.faces(face.as_ref(), &vertices.positions)?;
        let used = Bounds::of_used(&vertices.positions, &faces.triangles).map_or(DVec3::ZERO, Bounds::origin);
        if used != DVec3::ZERO {
            origin += used;
            self.move_to(origin, &vertex, &mut vertices.positions)?;
            faces = self.faces(face.as_ref(), &vertices.positions)?;
        }
        let mut model = self.model(vertices, faces, origin, (&vertex, face.as_ref()))?;
        if used != DVec3::ZERO {
            repair::drop_unused(&mut model.mesh);
        }
        Ok(model)
    }

    /// Where vertices and faces are.
    fn find(&self) -> Result<(Option<Vertex<'_>>, Option<Face<'_>>), Fault> {
        let (mut vertex, mut face, mut at) = (None, None, self.header.end);
        for element in &self.header.elements {
            if element.count > u32::MAX as usize {
                return Err(self.in_header(format!("more than {} of `{}`", u32::MAX, element.name)));
            }
            let (blocks, end) = blocks(element, self.header.encoding, self.source, at, self.search)?;
            at = end;
            match element.name.as_str() {
                "vertex" => {
                    let layout = vertices::Layout::of(element, self.wanted.of_vertices());
                    let layout = layout.map_err(|message| self.in_header(message))?;
                    vertex = Some(Vertex { layout, blocks });
                }
                "face" => {
                    let layout = faces::Layout::of(element, self.wanted.of_faces());
                    let layout = layout.map_err(|message| self.in_header(message))?;
                    face = Some(Face { layout, blocks });
                }
                "tristrips" if element.count > 0 => {
                    return Err(self.in_header("strips of triangles are not read: save the file with faces"));
                }
                _ => (),
            }
        }
        Ok((vertex, face))
    }

    fn in_header(&self, message: impl Into<String>) -> Fault {
        Fault::new(0, message)
    }

    fn check_memory(&self, vertex: &Vertex, face: Option<&Face>) -> Result<(), Fault> {
        let count = |blocks: &[Block]| blocks.iter().map(|block| block.count as u64).sum::<u64>();
        let (vertices, faces) = (count(&vertex.blocks), face.map_or(0, |face| count(&face.blocks)));
        let triangle = face.map_or(0, |face| face.layout.bytes());
        memory::check(vertex.layout.bytes() * vertices + triangle * faces)
            .map_err(|shortage| self.in_header(format!("{vertices} vertices and {faces} faces {shortage}")))
    }

    fn move_to(&self, origin: DVec3, vertex: &Vertex, positions: &mut [[f32; 3]]) -> Result<(), Fault> {
        let Vertex { layout, blocks } = vertex;
        vertices::read_positions(layout, self.header.encoding, self.source, blocks, (positions, origin))
    }

    fn faces(&self, face: Option<&Face>, positions: &[[f32; 3]]) -> Result<Faces, Fault> {
        let Some(Face { layout, blocks }) = face else { return Ok(Faces::default()) };
        let faces = faces::read(layout, (self.header.encoding, self.search), self.source, blocks, positions)?;
        if faces.triangles.len() > (u32::MAX / 3) as usize {
            return Err(self.in_header(format!("{} triangles are more than can be held", faces.triangles.len())));
        }
        Ok(faces)
    }

    fn model(
        &self,
        vertices: Vertices,
        faces: Faces,
        origin: DVec3,
        (vertex, face): (&Vertex, Option<&Face>),
    ) -> Result<Model, Fault> {
        let Vertices { positions, normals, uvs, colors, broken } = vertices;
        let of_positions = |there: bool| there.then_some(Indices::OfPositions);
        let own = vertex.layout.uvs && faces.uvs.is_empty();
        let of_vertices = self.telling(colors, vertex.layout.colors.as_ref()).map(MeshColors::OfVertices);
        let of_faces = || self.telling(faces.colors, face?.layout.colors.as_ref()).map(MeshColors::OfFaces);
        let mut mesh = Mesh {
            materials: vec![0; faces.triangles.len()],
            positions,
            triangles: faces.triangles,
            normals: of_positions(vertex.layout.normals).map(|indices| Attribute { values: normals, indices }),
            uvs: of_positions(own).map(|indices| Attribute { values: uvs, indices }),
            colors: of_vertices.or_else(of_faces),
        };
        let mut warnings = self.repair(&mut mesh, broken, vertex)?;
        if !faces.uvs.is_empty() {
            mesh.uvs = Some(Attribute { values: faces.uvs, indices: Indices::Own(faces.uv_indices) });
        }
        if mesh.triangles.is_empty() {
            warnings
                .push(self.warning(format!("{} vertices and no faces: nothing is seen of it", mesh.positions.len())));
        }
        let materials = self.header.texture.iter().map(|name| (String::new(), self.textured(name)));
        let materials: BTreeMap<_, _> = materials.collect();
        Ok(Model { mesh, origin, material_names: vec![String::new()], materials, parts: Vec::new(), warnings })
    }

    /// The colours, unless nobody asks for them and they say nothing.
    fn telling(&self, colors: Vec<[f32; 3]>, channels: Option<&Channels>) -> Option<Vec<[f32; 3]>> {
        let asked = !matches!(self.wanted, Wanted::Any);
        channels.is_some_and(|channels| asked || !channels.say_nothing(&colors)).then_some(colors)
    }

    fn textured(&self, name: &str) -> MaterialDescription {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let image = ImageTexture::new(paths::resolve(folder, name.as_bytes()));
        let diffuse = DiffuseParameters { reflectance: ColorTexture::Image(image) };
        MaterialDescription { bsdf: diffuse.into(), ..MaterialDescription::default() }
    }

    /// Takes what cannot be used away from the triangles that use it.
    fn repair(&self, mesh: &mut Mesh, broken: vertices::Broken, vertex: &Vertex) -> Result<Vec<Warning>, Fault> {
        let mut warnings = Vec::new();
        if !broken.positions.is_empty() {
            let what = "not finite or beyond 1e12";
            repair::drop_positions(mesh, &broken.positions.iter().copied().collect()).map_err(|used| {
                let at =
                    vertices::place(&vertex.layout, self.header.encoding, self.source, &vertex.blocks, used as usize);
                Fault::new(at, format!("vertex {used} is {what}, and a face uses it"))
            })?;
            let count = broken.positions.len();
            warnings.push(self.warning(format!("{count} vertices are {what}, but no face uses them")));
        }
        let Mesh { triangles, normals, uvs, .. } = mesh;
        warnings.extend(self.repair_attribute(normals, triangles, &broken.normals, "normals have no direction"));
        warnings.extend(self.repair_attribute(uvs, triangles, &broken.uvs, "texture coordinates are not finite"));
        Ok(warnings)
    }

    fn repair_attribute<const N: usize>(
        &self,
        attribute: &mut Option<Attribute<[f32; N]>>,
        triangles: &[[u32; 3]],
        broken: &[u32],
        what: &str,
    ) -> Option<Warning> {
        let found = attribute.as_mut().filter(|_| !broken.is_empty())?;
        let without = repair::drop_values(found, triangles, &broken.iter().copied().collect());
        if repair::is_unused(found, triangles) {
            *attribute = None;
        }
        Some(self.warning(format!("{} {what}; {without} triangles go without", broken.len())))
    }

    fn warning(&self, message: String) -> Warning {
        Warning { path: self.path.to_path_buf(), line: 0, message }
    }

    /// Names the line of an ASCII file, and the byte of a binary one.
    fn error(&self, Fault { at, message }: Fault) -> Error {
        let line_ends = |bytes: &[u8]| {
            let returns = memchr::memchr_iter(b'\r', bytes).filter(|&i| bytes.get(i + 1) != Some(&b'\n')).count();
            memchr::memchr_iter(b'\n', bytes).count() + returns
        };
        match self.header.encoding {
            _ if at == 0 => Error::file(self.path, message),
            Encoding::Ascii => {
                let mut buffer = Vec::new();
                let before = self.source.bytes(0..at.min(self.source.len()), &mut buffer).unwrap_or_default();
                Error::parse(self.path, 1 + line_ends(before), 0, message)
            }
            _ => Error::file(self.path, format!("byte {at}: {message}")),
        }
    }
}
