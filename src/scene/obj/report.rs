//! From byte offsets to messages with lines.

use super::Warning;
use super::scan::{Census, Tally};
use super::source::{Failure, Source};
use crate::error::{Error, Result};
use crate::scene::description::MaterialDescription;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::Path;

/// Names that a message lists before it only counts them.
const LISTED: usize = 5;

/// Collects what there is to say about an OBJ file.
pub(super) struct Reporter<'a> {
    source: &'a Source,
    blocks: &'a [Range<u64>],
    notes: Vec<(u64, String)>,
}

impl<'a> Reporter<'a> {
    pub(crate) fn new(source: &'a Source, blocks: &'a [Range<u64>]) -> Reporter<'a> {
        Reporter { source, blocks, notes: Vec::new() }
    }

    pub(crate) fn path(&self) -> &'a Path {
        self.source.path()
    }

    /// A warning about the statement at byte `at`.
    pub(crate) fn warn(&mut self, at: u64, message: impl Into<String>) {
        self.notes.push((at, message.into()));
    }

    /// What was left out.
    pub(crate) fn census(&mut self, census: &Census) {
        let mut tally = |tally: Option<Tally>, message: &str| {
            if let Some(Tally { first, count }) = tally {
                self.warn(first, format!("{message} ({count} times, here first)"));
            }
        };
        tally(census.slivers, "a face with fewer than three corners is left out");
        tally(census.strokes, "points and lines are left out");
        tally(census.others, "statements of more kinds are ignored");
        for (kind, &found) in &census.unknown {
            tally(Some(found), &format!("statement `{kind}` is ignored"));
        }
    }

    /// One warning for all names that faces use and no library defines.
    pub(crate) fn unknown_materials(&mut self, census: &Census, materials: &BTreeMap<String, MaterialDescription>) {
        let used = census.runs().filter(|(name, _, _)| !name.is_empty());
        let mut unknown = used.filter(|(name, _, _)| !materials.contains_key(*name)).peekable();
        let Some(first) = unknown.peek().map(|&(_, _, at)| at) else { return };
        let names: BTreeSet<&str> = unknown.map(|(name, _, _)| name).collect();
        let list: Vec<String> = names.iter().take(LISTED).map(|name| format!("`{name}`")).collect();
        let more = if names.len() > LISTED { ", …" } else { "" };
        let (count, list) = (names.len(), list.join(", "));
        self.warn(first, format!("{count} material names are in no MTL file: {list}{more}"));
    }

    /// The material of faces in a file that names libraries and never a material: the libraries' only one. Says so, and where there
    /// are several.
    pub(crate) fn unnamed_material(
        &mut self,
        census: &Census,
        materials: &BTreeMap<String, MaterialDescription>,
    ) -> Option<String> {
        let &(at, _) = census.libraries.first().filter(|_| census.names.is_empty() && census.triangles > 0)?;
        let mut names = materials.keys();
        let (first, others) = (names.next()?, names.count());
        if others > 0 {
            self.warn(at, format!("no `usemtl` says which of the {} materials the faces have", others + 1));
            return None;
        }
        self.warn(at, format!("no `usemtl` says what the faces are made of: they have the only material, `{first}`"));
        Some(first.clone())
    }

    /// The first failure of a pass, with its place.
    pub(crate) fn error(&self, failure: Failure) -> Error {
        let located = match failure {
            Failure::Io(error) => Err(error),
            Failure::Fault(fault) => self
                .locate(&[fault.at])
                .map(|places| Error::parse(self.path(), places[0].0, places[0].1, fault.message)),
        };
        located.unwrap_or_else(Error::io(self.path()))
    }

    /// All warnings, in the order of the file.
    pub(crate) fn finish(mut self) -> Result<Vec<Warning>> {
        self.notes.sort_by_key(|(at, _)| *at);
        let offsets: Vec<u64> = self.notes.iter().map(|(at, _)| *at).collect();
        let places = self.locate(&offsets).map_err(Error::io(self.path()))?;
        let path = self.path();
        let warning = |((_, message), (line, _))| Warning { path: path.to_path_buf(), line, message };
        Ok(self.notes.into_iter().zip(places).map(warning).collect())
    }

    /// Lines and columns of offsets.
    fn locate(&self, offsets: &[u64]) -> std::io::Result<Vec<(usize, usize)>> {
        let block = |at: u64| self.blocks.partition_point(|range| range.end <= at);
        let needed = offsets.iter().map(|&at| block(at)).max().unwrap_or(0);
        let counts = self.source.count_lines(&self.blocks[..needed.min(self.blocks.len())])?;
        let place = |&at: &u64| {
            let index = block(at).min(self.blocks.len().saturating_sub(1));
            let first = 1 + counts[..index].iter().sum::<usize>();
            match self.blocks.get(index) {
                Some(range) => self.source.position(at, range.clone(), first),
                None => Ok((1, 1)),
            }
        };
        offsets.iter().map(place).collect()
    }
}
