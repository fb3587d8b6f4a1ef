//! Smoothing groups: normals of faces that have none in the file.
//!
//! The normal of a corner is the mean over all triangles of its smoothing group that have a corner at the same place, weighted by
//! their angles there, as Blender and 3ds Max do it: how a polygon was cut into triangles then makes no difference (Thürmer and
//! Wüthrich, Computing vertex normals from polygonal facets, 1998). Places are the same where the coordinates are, whatever the
//! indices: many files repeat vertices at seams and poles. Smoothing ends where an object does.

use super::scan::Smoothing;
use super::source::{Failure, Fault};
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices};
use crate::io::memory;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::{FxBuildHasher, FxHashMap};
use std::hash::BuildHasher;
use std::ops::Range;

/// Places whose normals a thread computes at a time.
const PLACES: usize = 4096;

/// Where the weighted sum of normals is a smaller share than this of the weights, faces back to back have cancelled each other, and
/// its direction is that of rounding.
const CANCELLED: f64 = 1e-6;

/// Gives normals to the triangles of smoothing groups that have none. Costs nothing where there are none of those.
pub(super) fn smooth(mesh: &mut Mesh, statements: &[(usize, Smoothing)]) -> Result<(), Failure> {
    let groups = Groups::new(statements, mesh.triangles.len());
    if !groups.any_without_normals(mesh) {
        return Ok(());
    }
    check_memory(mesh)?;
    let places = places(&mesh.positions);
    let normals = PlaceNormals::new(mesh, &places, &groups);
    match normals.of_positions(mesh, &places, &groups) {
        Some(values) => mesh.normals = Some(Attribute { values, indices: Indices::OfPositions }),
        None => normals.add_to(mesh, &places, &groups),
    }
    Ok(())
}

/// What smoothing takes at most for a while, beside the mesh: a place, a fan and a hash for each vertex, three entries of fans and
/// indices for each triangle, and a normal for each place.
fn check_memory(mesh: &Mesh) -> Result<(), Failure> {
    let (vertices, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    memory::check(48 * vertices + 24 * triangles).map_err(|shortage| {
        let message = format!("smoothing groups of {vertices} vertices and {triangles} triangles {shortage}");
        Failure::Fault(Fault::new(0, message))
    })
}

/// Smoothing groups by triangle. Groups of the same number in two objects are two groups.
struct Groups {
    /// The first triangle of a run and the group of all in it, 0 for none.
    runs: Vec<(usize, u32)>,
    triangles: usize,
}

impl Groups {
    fn new(statements: &[(usize, Smoothing)], triangles: usize) -> Groups {
        let (mut object, mut group) = (0usize, 0);
        let mut known: FxHashMap<(usize, u64), u32> = FxHashMap::default();
        let mut runs = vec![(0, 0)];
        for &(triangle, statement) in statements {
            match statement {
                Smoothing::Group(number) => group = number,
                Smoothing::Object => object += 1,
            }
            let next = known.len() as u32 + 1;
            let id = if group == 0 { 0 } else { *known.entry((object, group)).or_insert(next) };
            runs.push((triangle, id));
        }
        Groups { runs, triangles }
    }

    #[inline]
    fn of(&self, triangle: usize) -> u32 {
        self.runs[self.runs.partition_point(|&(first, _)| first <= triangle) - 1].1
    }

    /// Triangles in a row that are in a group.
    fn smooth(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let ends = self.runs.iter().skip(1).map(|&(first, _)| first).chain([self.triangles]);
        self.runs
            .iter()
            .zip(ends)
            .filter(|((first, id), end)| *id != 0 && first < end)
            .map(|(&(first, _), end)| first..end)
    }

    fn any_without_normals(&self, mesh: &Mesh) -> bool {
        match mesh.normals.as_ref().map(|normals| &normals.indices) {
            None => self.smooth().next().is_some(),
            Some(Indices::OfPositions) => false,
            Some(Indices::Own(own)) => self.smooth().any(|run| own[run].par_iter().any(|t| t[0] == ABSENT)),
        }
    }
}

/// For each vertex the first one in the order of hashes that has the same coordinates.
fn places(positions: &[[f32; 3]]) -> Vec<u32> {
    // adding 0 makes -0 the same as 0
    let bits = |i: u32| positions[i as usize].map(|x| (x + 0.0).to_bits());
    let hash = |i: u32| FxBuildHasher.hash_one(bits(i)) & !u64::from(u32::MAX) | u64::from(i);
    let mut order: Vec<u64> = (0..positions.len() as u32).into_par_iter().map(hash).collect();
    order.par_sort_unstable();
    let mut places = vec![0; positions.len()];
    let mut distinct: Vec<u32> = Vec::new();
    for alike in order.chunk_by(|a, b| a >> 32 == b >> 32) {
        distinct.clear();
        for vertex in alike.iter().map(|&both| both as u32) {
            let known = distinct.iter().find(|&&place| bits(place) == bits(vertex)).copied();
            places[vertex as usize] = known.unwrap_or_else(|| {
                distinct.push(vertex);
                vertex
            });
        }
    }
    places
}

/// The triangles of smoothing groups around each place, in the order of the file.
struct Fans {
    starts: Vec<usize>,
    triangles: Vec<u32>,
}

impl Fans {
    fn new(mesh: &Mesh, places: &[u32], groups: &Groups) -> Fans {
        let corners = || {
            let triangles = groups.smooth().flatten();
            triangles.flat_map(|t| mesh.triangles[t].map(|i| (places[i as usize] as usize, t as u32)))
        };
        let mut starts = vec![0; places.len() + 1];
        corners().for_each(|(place, _)| starts[place + 1] += 1);
        (0..places.len()).for_each(|place| starts[place + 1] += starts[place]);
        let mut triangles = vec![0; starts[places.len()]];
        corners().for_each(|(place, triangle)| {
            triangles[starts[place]] = triangle;
            starts[place] += 1;
        });
        // each start has become the next one's
        starts.rotate_right(1);
        starts[0] = 0;
        Fans { starts, triangles }
    }

    fn at(&self, place: usize) -> &[u32] {
        &self.triangles[self.starts[place]..self.starts[place + 1]]
    }
}

/// A normal for each place and each smoothing group there; zero where the faces' normals cancel.
struct PlaceNormals {
    /// By place, where its normals begin.
    starts: Vec<usize>,
    values: Vec<[f32; 3]>,
    /// Of each normal.
    groups: Vec<u32>,
}

impl PlaceNormals {
    fn new(mesh: &Mesh, places: &[u32], groups: &Groups) -> PlaceNormals {
        let fans = Fans::new(mesh, places, groups);
        let chunks = places.len().div_ceil(PLACES);
        let chunk = |k: usize| {
            let mut part = PlaceNormals { starts: Vec::new(), values: Vec::new(), groups: Vec::new() };
            let mut sums = Vec::new();
            for place in k * PLACES..places.len().min((k + 1) * PLACES) {
                part.starts.push(part.values.len());
                part.add(place, fans.at(place), mesh, places, groups, &mut sums);
            }
            part
        };
        let parts: Vec<PlaceNormals> = (0..chunks).into_par_iter().map(chunk).collect();
        let mut all =
            PlaceNormals { starts: Vec::with_capacity(places.len() + 1), values: Vec::new(), groups: Vec::new() };
        for part in parts {
            let before = all.values.len();
            all.starts.extend(part.starts.iter().map(|start| before + start));
            all.values.extend(part.values);
            all.groups.extend(part.groups);
        }
        all.starts.push(all.values.len());
        all
    }

    /// The normals of one place. `sums` is scratch memory.
    fn add(
        &mut self,
        place: usize,
        fan: &[u32],
        mesh: &Mesh,
        places: &[u32],
        groups: &Groups,
        sums: &mut Vec<(DVec3, f64)>,
    ) {
        let first = self.groups.len();
        sums.clear();
        for &triangle in fan {
            let group = groups.of(triangle as usize);
            let known = self.groups[first..].iter().position(|&g| g == group).unwrap_or_else(|| {
                self.groups.push(group);
                sums.push((DVec3::ZERO, 0.0));
                sums.len() - 1
            });
            let Some((normal, angle)) = corner(mesh, triangle as usize, |i| places[i as usize] as usize == place)
            else {
                continue;
            };
            sums[known].0 += normal * angle;
            sums[known].1 += angle;
        }
        self.values.extend(sums.iter().map(|&(sum, weight)| {
            let cancelled = sum.length() <= CANCELLED * weight;
            let normal = if cancelled { DVec3::ZERO } else { sum.normalize() };
            normal.as_vec3().to_array()
        }));
    }

    /// The normal of a place in a group.
    fn index(&self, place: u32, group: u32) -> u32 {
        let range = self.starts[place as usize]..self.starts[place as usize + 1];
        let at = self.groups[range.clone()].iter().position(|&g| g == group);
        at.map_or(ABSENT, |at| (range.start + at) as u32)
    }

    /// One normal for each vertex, where that is all there is to say.
    fn of_positions(&self, mesh: &Mesh, places: &[u32], groups: &Groups) -> Option<Vec<[f32; 3]>> {
        let all_smooth = groups.smooth().map(|run| run.len()).sum::<usize>() == groups.triangles;
        let single = self.groups.par_iter().all(|&g| g == self.groups[0]);
        let whole = self.values.par_iter().all(|&n| n != [0.0; 3]);
        let enough = mesh.normals.is_none() && all_smooth && single && whole;
        let of = |&place: &u32| {
            let range = self.starts[place as usize]..self.starts[place as usize + 1];
            // no face uses a vertex without normals
            self.values[range].first().copied().unwrap_or([0.0, 0.0, 1.0])
        };
        enough.then(|| places.par_iter().map(of).collect())
    }

    /// Gives their normals to the triangles that have none.
    fn add_to(mut self, mesh: &mut Mesh, places: &[u32], groups: &Groups) {
        let (mut values, mut own) = match mesh.normals.take() {
            None => (Vec::new(), vec![[ABSENT; 3]; mesh.triangles.len()]),
            Some(Attribute { values, indices: Indices::Own(own) }) => (values, own),
            Some(complete) => return mesh.normals = Some(complete),
        };
        let before = values.len() as u32;
        for run in groups.smooth() {
            let group = groups.of(run.start);
            own[run.clone()].par_iter_mut().zip(&mesh.triangles[run]).filter(|(t, _)| t[0] == ABSENT).for_each(
                |(t, corners)| {
                    *t = corners.map(|i| before + self.index(places[i as usize], group));
                },
            );
        }
        values.append(&mut self.values);
        let cancelled =
            |t: &[u32; 3]| t[0] != ABSENT && t.iter().any(|&i| i >= before && values[i as usize] == [0.0; 3]);
        let flat: Vec<usize> = (0..own.len()).into_par_iter().filter(|&t| cancelled(&own[t])).collect();
        for t in flat {
            flatten(&mut own[t], &mut values, face_normal(mesh, t));
        }
        mesh.normals = Some(Attribute { values, indices: Indices::Own(own) });
    }
}

/// Gives corners without a normal that of their face; a face that has none goes without.
fn flatten(corners: &mut [u32; 3], values: &mut Vec<[f32; 3]>, face: Option<DVec3>) {
    let Some(normal) = face else {
        *corners = [ABSENT; 3];
        return;
    };
    let own = values.len() as u32;
    values.push(normal.as_vec3().to_array());
    corners.iter_mut().filter(|i| values[**i as usize] == [0.0; 3]).for_each(|i| *i = own);
}

/// Unit, on the side from which the corners run counter-clockwise; `None` for a triangle without area.
fn face_normal(mesh: &Mesh, triangle: usize) -> Option<DVec3> {
    let [a, b, c] = mesh.triangles[triangle].map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3());
    (b - a).cross(c - a).try_normalize()
}

/// The normal of a triangle and its angle at the corner that `is_here`; `None` for a triangle without area.
fn corner(mesh: &Mesh, triangle: usize, is_here: impl Fn(u32) -> bool) -> Option<(DVec3, f64)> {
    let indices = mesh.triangles[triangle];
    let here = indices.iter().position(|&i| is_here(i))?;
    let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.positions[indices[(here + k) % 3] as usize]).as_dvec3());
    let area = (b - a).cross(c - a);
    Some((area.try_normalize()?, area.length().atan2((b - a).dot(c - a))))
}
