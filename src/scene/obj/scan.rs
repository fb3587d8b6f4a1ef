//! First pass: how much of everything a block holds, and the statements that are not numbers.

use super::lines::{self, Lines};
use crate::io::paths;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::ops::Range;

/// Kinds of unknown statements told apart; a file that is no OBJ at all has any number of them.
const UNKNOWN_KINDS: usize = 16;

/// Numbers of vertices of each sort.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
    pub(crate) positions: usize,
    pub(crate) uvs: usize,
    pub(crate) normals: usize,
}

impl Counts {
    pub(crate) fn plus(self, other: Counts) -> Counts {
        Counts {
            positions: self.positions + other.positions,
            uvs: self.uvs + other.uvs,
            normals: self.normals + other.normals,
        }
    }
}

/// How often something was met, and the offset of the first time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tally {
    pub(crate) first: u64,
    pub(crate) count: usize,
}

/// What one block, or the file, holds.
#[derive(Debug, Default)]
pub(super) struct Census {
    pub(crate) counts: Counts,
    pub(crate) triangles: usize,
    /// Where the material changes: the first triangle after it, the name, the offset.
    pub(crate) switches: Vec<Switch>,
    pub(crate) names: Vec<String>,
    /// `s` and `o` statements, each with the first triangle after it.
    pub(crate) smoothing: Vec<(usize, Smoothing)>,
    /// `o` statements, each with the first triangle after it and its name.
    pub(crate) objects: Vec<(usize, String)>,
    /// `g` statements likewise.
    pub(crate) groups: Vec<(usize, String)>,
    /// `mtllib` statements: offset and argument.
    pub(crate) libraries: Vec<(u64, Vec<u8>)>,
    /// Faces with fewer than three corners.
    pub(crate) slivers: Option<Tally>,
    /// Points and lines.
    pub(crate) strokes: Option<Tally>,
    pub(crate) unknown: BTreeMap<String, Tally>,
    /// Unknown statements of further kinds.
    pub(crate) others: Option<Tally>,
}

/// What decides over which faces normals are averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Smoothing {
    /// `s`: the faces after it are in this smoothing group, or in none where it is 0.
    Group(u64),
    /// `o`: the faces after it are another object's.
    Object,
}

/// A `usemtl`: `name` is an index into [`Census::names`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Switch {
    pub(crate) triangle: usize,
    pub(crate) name: usize,
    pub(crate) at: u64,
}

/// Counts a block of whole lines. Offsets are relative to `text`.
pub(super) fn scan(text: &[u8]) -> Census {
    let mut census = Census::default();
    let mut names = FxHashMap::default();
    for (at, line) in Lines::new(text) {
        let (keyword, rest) = lines::keyword(line);
        match keyword {
            b"v" => census.counts.positions += 1,
            b"vt" => census.counts.uvs += 1,
            b"vn" => census.counts.normals += 1,
            b"f" => census.face(at, rest),
            b"usemtl" => census.switch(at, paths::unquoted(lines::name(rest)), &mut names),
            b"mtllib" => census.libraries.push((at as u64, lines::name(rest).to_vec())),
            b"s" => census.smooth(Smoothing::Group(smoothing_group(rest))),
            b"o" => {
                census.smooth(Smoothing::Object);
                begin_part(&mut census.objects, census.triangles, rest);
            }
            b"g" => begin_part(&mut census.groups, census.triangles, rest),
            b"l" | b"p" => add(&mut census.strokes, once(at)),
            _ => census.unknown(lines::excerpt(keyword), once(at)),
        }
    }
    census
}

/// Takes down the name of an object or a group, in the place of one that no face followed.
fn begin_part(parts: &mut Vec<(usize, String)>, triangle: usize, rest: &[u8]) {
    if parts.last().is_some_and(|(first, _)| *first == triangle) {
        parts.pop();
    }
    parts.push((triangle, lines::text(lines::name(rest))));
}

fn once(at: usize) -> Tally {
    Tally { first: at as u64, count: 1 }
}

fn add(total: &mut Option<Tally>, more: Tally) {
    match total {
        Some(total) => total.count += more.count,
        None => *total = Some(more),
    }
}

/// The number of arguments; the third pass reads exactly as many corners.
#[inline]
fn corners(rest: &[u8]) -> usize {
    let mut count = 0;
    let mut blank = true;
    for &byte in rest {
        if byte == b'#' {
            break;
        }
        let now = lines::is_blank(byte);
        count += usize::from(blank && !now);
        blank = now;
    }
    count
}

/// The number of a smoothing group. `on` is a group like any other.
fn smoothing_group(rest: &[u8]) -> u64 {
    let name = lines::name(rest);
    if name.is_empty() || name.eq_ignore_ascii_case(b"off") {
        return 0;
    }
    std::str::from_utf8(name).ok().and_then(|name| name.parse().ok()).unwrap_or(1)
}

impl Census {
    fn smooth(&mut self, smoothing: Smoothing) {
        let kind = std::mem::discriminant(&smoothing);
        // A statement that no face followed has no effect.
        let unused = |last: &(usize, Smoothing)| last.0 == self.triangles && std::mem::discriminant(&last.1) == kind;
        if self.smoothing.last().is_some_and(unused) {
            self.smoothing.pop();
        }
        self.smoothing.push((self.triangles, smoothing));
    }

    #[inline]
    fn face(&mut self, at: usize, rest: &[u8]) {
        match corners(rest) {
            n @ 3.. => self.triangles += n - 2,
            _ => add(&mut self.slivers, once(at)),
        }
    }

    fn switch<'a>(&mut self, at: usize, name: &'a [u8], names: &mut FxHashMap<&'a [u8], usize>) {
        let name = *names.entry(name).or_insert_with(|| {
            self.names.push(lines::text(name));
            self.names.len() - 1
        });
        // A switch that no face followed has no effect.
        if self.switches.last().is_some_and(|s| s.triangle == self.triangles) {
            self.switches.pop();
        }
        self.switches.push(Switch { triangle: self.triangles, name, at: at as u64 });
    }

    /// Triangles in a row with the same material: its name, "" before any `usemtl`, and where it was named.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (&str, Range<usize>, u64)> {
        let first = self.switches.first().map_or(self.triangles, |s| s.triangle);
        let ends = self.switches.iter().skip(1).map(|s| s.triangle).chain([self.triangles]);
        let named = self.switches.iter().zip(ends);
        let named = named.map(|(s, end)| (&*self.names[s.name], s.triangle..end, s.at));
        std::iter::once(("", 0..first, 0)).chain(named).filter(|(_, range, _)| !range.is_empty())
    }

    /// Objects, or groups where no object is named: each with its first triangle and its name, which may be empty. Triangles before
    /// the first are of none of them.
    pub(crate) fn parts(&self) -> Vec<(u32, String)> {
        let named = if self.objects.is_empty() { &self.groups } else { &self.objects };
        let mut parts: Vec<(u32, String)> = Vec::new();
        for (triangle, name) in named.iter().filter(|(triangle, _)| *triangle < self.triangles) {
            match parts.last_mut() {
                Some(last) if last.1 == *name => {}
                // a block may begin with a statement that follows one at the end of the block before
                Some(last) if last.0 == *triangle as u32 => last.1.clone_from(name),
                _ => parts.push((*triangle as u32, name.clone())),
            }
        }
        parts
    }

    /// Takes in what a block that begins at `start` leaves out.
    fn leave_out(&mut self, start: u64, block: &Census) {
        let moved = |tally: &Tally| Tally { first: start + tally.first, ..*tally };
        block.slivers.iter().for_each(|tally| add(&mut self.slivers, moved(tally)));
        block.strokes.iter().for_each(|tally| add(&mut self.strokes, moved(tally)));
        let mut kinds: Vec<_> = block.unknown.iter().collect();
        kinds.sort_by_key(|(_, tally)| tally.first);
        kinds.into_iter().for_each(|(kind, tally)| self.unknown(kind.clone(), moved(tally)));
        block.others.iter().for_each(|tally| add(&mut self.others, moved(tally)));
    }

    fn unknown(&mut self, kind: String, tally: Tally) {
        let full = self.unknown.len() >= UNKNOWN_KINDS;
        match self.unknown.get_mut(&kind) {
            Some(known) => known.count += tally.count,
            None if full => add(&mut self.others, tally),
            None => drop(self.unknown.insert(kind, tally)),
        }
    }
}

/// The census of the whole file from those of its blocks, which begin at `starts`.
pub(super) fn merge<'a>(blocks: impl Iterator<Item = (u64, &'a Census)>) -> Census {
    let mut total = Census::default();
    let mut names: FxHashMap<&str, usize> = FxHashMap::default();
    for (start, block) in blocks {
        for switch in &block.switches {
            let name = *names.entry(&block.names[switch.name]).or_insert_with(|| {
                total.names.push(block.names[switch.name].clone());
                total.names.len() - 1
            });
            let triangle = total.triangles + switch.triangle;
            total.switches.push(Switch { triangle, name, at: start + switch.at });
        }
        total.smoothing.extend(block.smoothing.iter().map(|&(triangle, s)| (total.triangles + triangle, s)));
        let moved = |parts: &[(usize, String)]| -> Vec<(usize, String)> {
            parts.iter().map(|(triangle, name)| (total.triangles + triangle, name.clone())).collect()
        };
        total.objects.extend(moved(&block.objects));
        total.groups.extend(moved(&block.groups));
        total.counts = total.counts.plus(block.counts);
        total.triangles += block.triangles;
        total.libraries.extend(block.libraries.iter().map(|(at, name)| (start + at, name.clone())));
        total.leave_out(start, block);
    }
    total
}
