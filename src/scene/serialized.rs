//! Mitsuba's `serialized` form: meshes in zlib streams, one after the other, and at the end of the file where each begins.

use super::model::Model;
use super::repair;
use crate::embree::LARGEST_COORDINATE;
use crate::geometry::Mesh;
use crate::geometry::mesh::{Attribute, Indices, MeshColors};
use crate::io::memory;
use crate::{Error, Result};
use flate2::bufread::ZlibDecoder;
use glam::Vec3;
use rustc_hash::FxHashSet;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// The first two bytes of a file, and of each mesh in it.
const MAGIC: u16 = 0x041c;

const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const DOUBLE: u32 = 0x2000;

/// Loads mesh number `part`, counted from 0. v of texture coordinates is as in the file. It has the material "".
///
/// # Errors
/// A file of another form or version, or that ends too early; a mesh that is not there; indices out of range.
pub(super) fn load(path: &Path, part: usize) -> Result<Model> {
    parse(&memory::read_file(path, u64::MAX)?, part).map_err(|message| Error::file(path, message))
}

fn parse(bytes: &[u8], part: usize) -> Result<Model, String> {
    let short = || "the file ends too early".to_string();
    let version = version(bytes)?;
    let starts = starts(bytes, version)?;
    let &start = starts.get(part).ok_or_else(|| format!("there is no mesh {part}: the file has {}", starts.len()))?;
    let mesh = usize::try_from(start).ok().and_then(|start| bytes.get(start..)).ok_or_else(short)?;
    let version = self::version(mesh).map_err(|message| format!("mesh {part}: {message}"))?;
    let stream = BufReader::new(ZlibDecoder::new(&mesh[4..]));
    Stream { stream, double: false }.model(version).map_err(|message| format!("mesh {part}: {message}"))
}

/// Of what begins with these bytes.
fn version(bytes: &[u8]) -> Result<u16, String> {
    let Some(&[a, b, c, d]) = bytes.first_chunk::<4>() else { return Err("the file ends too early".into()) };
    if u16::from_le_bytes([a, b]) != MAGIC {
        return Err("not a file of serialized meshes".into());
    }
    match u16::from_le_bytes([c, d]) {
        version @ (3 | 4) => Ok(version),
        version => Err(format!("version {version} is not known: there are 3 and 4")),
    }
}

/// Where each mesh begins: their number is the last word, and the places stand before it.
fn starts(bytes: &[u8], version: u16) -> Result<Vec<u64>, String> {
    let damaged = || "the list of meshes at its end is damaged".to_string();
    let (places, count) = bytes.split_last_chunk::<4>().ok_or_else(damaged)?;
    let count = u32::from_le_bytes(*count) as usize;
    let width = if version == 3 { 4 } else { 8 };
    let length = count.checked_mul(width).filter(|&length| length <= places.len()).ok_or_else(damaged)?;
    let place = |bytes: &[u8]| bytes.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte));
    Ok(places[places.len() - length..].chunks_exact(width).map(place).collect())
}

/// What is in a mesh's stream.
struct Stream<R> {
    stream: R,
    double: bool,
}

impl<R: BufRead> Stream<R> {
    fn model(&mut self, version: u16) -> Result<Model, String> {
        let flags = u32::from_le_bytes(self.word()?);
        self.double = flags & DOUBLE != 0;
        if version == 4 {
            self.name()?;
        }
        let (vertices, faces) = (u64::from_le_bytes(self.word()?), u64::from_le_bytes(self.word()?));
        if vertices > u64::from(u32::MAX) || faces > u64::from(u32::MAX) {
            return Err(format!("{vertices} vertices and {faces} triangles are more than can be held"));
        }
        memory::check(44 * vertices + 16 * faces)
            .map_err(|shortage| format!("{vertices} vertices and {faces} triangles {shortage}"))?;
        let (vertices, faces) = (vertices as usize, faces as usize);
        let positions = self.vectors(vertices)?;
        let normals = if flags & HAS_NORMALS != 0 { Some(self.vectors(vertices)?) } else { None };
        let uvs = if flags & HAS_UVS != 0 { Some(self.vectors(vertices)?) } else { None };
        let colors = if flags & HAS_COLORS != 0 { Some(self.vectors(vertices)?) } else { None };
        let triangles = self.triangles(faces, vertices)?;
        let clamped = |color: [f32; 3]| color.map(|x: f32| if x >= 0.0 { x.min(1.0) } else { 0.0 });
        let attribute = |values| Attribute { values, indices: Indices::OfPositions };
        let mesh = Mesh {
            materials: vec![0; faces],
            normals: normals.filter(|_| flags & FACE_NORMALS == 0).map(attribute),
            uvs: uvs.map(|values| Attribute { values, indices: Indices::OfPositions }),
            colors: colors.map(|colors| MeshColors::OfVertices(colors.into_iter().map(clamped).collect())),
            positions,
            triangles,
        };
        Ok(Model { mesh: repaired(mesh)?, material_names: vec![String::new()], ..Model::default() })
    }

    fn word<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.stream.read_exact(&mut bytes).map_err(|error| damaged(&error))?;
        Ok(bytes)
    }

    /// Passes over a name, which ends with a zero.
    fn name(&mut self) -> Result<(), String> {
        loop {
            let buffer = self.stream.fill_buf().map_err(|error| damaged(&error))?;
            let (zero, length) = (memchr::memchr(0, buffer), buffer.len());
            self.stream.consume(zero.map_or(length, |zero| zero + 1));
            match zero {
                Some(_) => return Ok(()),
                None if length == 0 => return Err("it ends within its name".into()),
                None => (),
            }
        }
    }

    fn bytes(&mut self, count: usize) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        (&mut self.stream).take(count as u64).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
        if bytes.len() == count { Ok(bytes) } else { Err("the file ends too early".into()) }
    }

    fn vectors<const N: usize>(&mut self, count: usize) -> Result<Vec<[f32; N]>, String> {
        let mut numbers: Vec<f32> = if self.double {
            let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap_or_default()) as f32;
            self.bytes(8 * N * count)?.chunks_exact(8).map(number).collect()
        } else {
            let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap_or_default());
            self.bytes(4 * N * count)?.chunks_exact(4).map(number).collect()
        };
        numbers.truncate(N * count);
        Ok(numbers.chunks_exact(N).map(|chunk| std::array::from_fn(|k| chunk[k])).collect())
    }

    fn triangles(&mut self, count: usize, vertices: usize) -> Result<Vec<[u32; 3]>, String> {
        let number = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap_or_default());
        let corners: Vec<u32> = self.bytes(12 * count)?.chunks_exact(4).map(number).collect();
        match corners.iter().find(|&&corner| corner as usize >= vertices) {
            Some(corner) => Err(format!("a triangle has the vertex {corner}, of {vertices}")),
            None => Ok(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()),
        }
    }
}

fn damaged(error: &std::io::Error) -> String {
    format!("damaged: {error}")
}

/// Takes what cannot be used away from the triangles that use it.
fn repaired(mut mesh: Mesh) -> Result<Mesh, String> {
    let broken = |usable: &dyn Fn(usize) -> bool, count: usize| -> FxHashSet<u32> {
        (0..count).filter(|&k| !usable(k)).map(|k| k as u32).collect()
    };
    let traced = |k: usize| mesh.positions[k].iter().all(|x| x.abs() <= LARGEST_COORDINATE);
    let positions = broken(&traced, mesh.positions.len());
    repair::drop_positions(&mut mesh, &positions)
        .map_err(|used| format!("vertex {used} is not finite or beyond 1e12, and a triangle uses it"))?;
    if let Some(normals) = &mut mesh.normals {
        let square = |k: usize| Vec3::from(normals.values[k]).length_squared();
        let none = broken(&|k| square(k) >= f32::MIN_POSITIVE && square(k).is_finite(), normals.values.len());
        if !none.is_empty() {
            repair::drop_values(normals, &mesh.triangles, &none);
        }
    }
    if let Some(uvs) = &mut mesh.uvs {
        let none = broken(&|k| uvs.values[k].iter().all(|x| x.is_finite()), uvs.values.len());
        if !none.is_empty() {
            repair::drop_values(uvs, &mesh.triangles, &none);
        }
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mesh::ABSENT;
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write;

    /// A file of meshes that are a triangle each, of which the first has its right angle at x = number of the mesh.
    fn file(version: u16, flags: u32, meshes: usize) -> Vec<u8> {
        let (mut bytes, mut starts) = (Vec::new(), Vec::new());
        for k in 0..meshes {
            starts.push(bytes.len() as u64);
            bytes.extend(MAGIC.to_le_bytes());
            bytes.extend(version.to_le_bytes());
            let mut stream = ZlibEncoder::new(&mut bytes, Compression::default());
            let mut put = |bytes: &[u8]| stream.write_all(bytes).unwrap();
            put(&flags.to_le_bytes());
            if version == 4 {
                put(b"a name\0");
            }
            put(&3u64.to_le_bytes());
            put(&1u64.to_le_bytes());
            let x = k as f64;
            let mut numbers = vec![x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0];
            if flags & HAS_NORMALS != 0 {
                numbers.extend([0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
            }
            if flags & HAS_UVS != 0 {
                numbers.extend([0.0, 0.25, 1.0, 0.0, 0.0, 1.0]);
            }
            if flags & HAS_COLORS != 0 {
                numbers.extend([0.5; 9]);
            }
            for x in numbers {
                if flags & DOUBLE != 0 { put(&x.to_le_bytes()) } else { put(&(x as f32).to_le_bytes()) }
            }
            [0u32, 1, 2].iter().for_each(|i| put(&i.to_le_bytes()));
            stream.finish().unwrap();
        }
        for start in starts {
            bytes.extend(&start.to_le_bytes()[..if version == 3 { 4 } else { 8 }]);
        }
        bytes.extend((meshes as u32).to_le_bytes());
        bytes
    }

    #[test]
    fn all_versions_and_parts_are_read() {
        for version in [3, 4] {
            for precision in [0x1000, DOUBLE] {
                let bytes = file(version, precision | HAS_NORMALS | HAS_UVS | HAS_COLORS, 3);
                let mesh = parse(&bytes, 2).unwrap().mesh;
                assert_eq!(mesh.positions, [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
                assert_eq!(mesh.uvs.unwrap().values[0], [0.0, 0.25]);
                assert_eq!(mesh.colors.unwrap(), MeshColors::OfVertices(vec![[0.5; 3]; 3]));
                assert_eq!(
                    mesh.normals.unwrap().indices,
                    Indices::Own(vec![[ABSENT; 3]]),
                    "one normal has no direction"
                );
                let flat = parse(&file(version, precision | HAS_NORMALS | FACE_NORMALS, 1), 0).unwrap().mesh;
                assert!(flat.normals.is_none() && flat.uvs.is_none() && flat.colors.is_none());
            }
        }
    }

    #[test]
    fn damage_is_an_error() {
        let whole = file(4, HAS_UVS, 2);
        assert_eq!(parse(&whole, 2).unwrap_err(), "there is no mesh 2: the file has 2");
        assert_eq!(parse(b"obj\0", 0).unwrap_err(), "not a file of serialized meshes");
        assert!(parse(&file(2, 0, 1), 0).unwrap_err().contains("version 2 is not known"));
        for length in 0..whole.len() {
            _ = parse(&whole[..length], 0).map(drop);
            let mut bytes = whole.clone();
            bytes[length] ^= 0x55;
            _ = parse(&bytes, 1).map(drop);
        }
        assert!(parse(&whole[..20], 0).is_err());
    }
}
