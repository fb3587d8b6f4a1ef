//! Colours behind the coordinates of vertices, as MeshLab, scanners and programs of photogrammetry write them.
//!
//! `v x y z r g b`, where a single further number is the weight of a rational curve's point and no colour. Seven numbers are
//! `x y z r g b a`, as MeshLab reads them, or `x y z w r g b` where the fourth is 1 throughout and the seventh is not. Numbers are
//! shares, or from 0 to 255 where all are whole and one is above 1. They are sRGB, as in Blender's importer.

use super::lines::Fields;
use super::source::{Failure, Fault};
use crate::image::srgb;
use crate::io::memory;
use rayon::prelude::*;

/// Colours as written, of a block.
#[derive(Debug, Default)]
pub(super) struct Colors {
    /// Of the block's vertices up to the last that has one; white where there is none before it. Empty where none has.
    first: Vec<[f32; 3]>,
    /// The number after those, where any vertex has one.
    last: Vec<f32>,
}

const NONE: [f32; 3] = [f32::NAN; 3];

impl Colors {
    /// The numbers behind the position of vertex `index`.
    #[cold]
    #[inline(never)]
    pub(crate) fn read(&mut self, index: usize, fields: &mut Fields) -> Result<(), Fault> {
        let (mut numbers, mut count) = ([0.0; 4], 0);
        while let Some(number) = fields.number()? {
            if let Some(slot) = numbers.get_mut(count) {
                *slot = number;
            }
            count += 1;
        }
        let [r, g, b, last] = numbers;
        if count >= 3 && numbers.iter().all(|x| x.is_finite()) {
            self.first.resize(index, NONE);
            self.first.push([r, g, b]);
        }
        if count >= 4 && self.first.len() == index + 1 {
            self.last.resize(index, f32::NAN);
            self.last.push(last);
        }
        Ok(())
    }

    fn numbers(&self) -> impl Iterator<Item = f32> + '_ {
        self.first.iter().flatten().chain(&self.last).copied().filter(|x| !x.is_nan())
    }
}

/// How the numbers of a file are meant.
#[derive(Clone, Copy)]
struct Meaning {
    /// The first number is a weight.
    weighted: bool,
    /// Of a channel.
    largest: f32,
}

impl Meaning {
    fn of(blocks: &[(usize, Colors)]) -> Meaning {
        let all = |holds: &(dyn Fn(&Colors) -> bool + Sync)| blocks.par_iter().all(|(_, block)| holds(block));
        let is = |x: &f32, value: f32| x.is_nan() || *x == value;
        let sevens = all(&|block| block.first.len() == block.last.len());
        let weights = all(&|block| block.first.iter().all(|c| is(&c[0], 1.0)));
        let alphas = all(&|block| block.last.iter().all(|x| is(x, 1.0)));
        let whole = all(&|block| block.numbers().all(|x| x.fract() == 0.0));
        let shares = all(&|block| block.numbers().all(|x| x <= 1.0));
        let largest = if whole && !shares { 255.0 } else { 1.0 };
        Meaning { weighted: sevens && weights && !alphas, largest }
    }

    /// Linear, in [0, 1]; white for none.
    fn color(self, first: [f32; 3], last: f32) -> [f32; 3] {
        let [a, b, c] = first;
        let stored = if self.weighted { [b, c, last] } else { [a, b, c] };
        let channel = |x: f32| srgb::decode((x / self.largest).clamp(0.0, 1.0));
        if a.is_nan() { [1.0; 3] } else { stored.map(channel) }
    }
}

/// The colours of all `vertices`, from those of blocks that begin at vertices. White throughout says nothing: `None`.
pub(super) fn merge(blocks: Vec<(usize, Colors)>, vertices: usize) -> Result<Option<Vec<[f32; 3]>>, Failure> {
    if blocks.iter().all(|(_, block)| block.first.is_empty()) {
        return Ok(None);
    }
    memory::check(12 * vertices as u64)
        .map_err(|shortage| Failure::Fault(Fault::new(0, format!("the colours of {vertices} vertices {shortage}"))))?;
    let meaning = Meaning::of(&blocks);
    let mut all = vec![[1.0; 3]; vertices];
    let mut rest = &mut all[..];
    let mut parts = Vec::new();
    let ends = blocks.iter().skip(1).map(|(start, _)| *start).chain([vertices]);
    for ((start, block), end) in blocks.iter().zip(ends) {
        parts.push((super::cut(&mut rest, end - start), block));
    }
    parts.into_par_iter().for_each(|(slots, block)| {
        for (k, (slot, &first)) in slots.iter_mut().zip(&block.first).enumerate() {
            *slot = meaning.color(first, block.last.get(k).copied().unwrap_or(f32::NAN));
        }
    });
    let white = all.par_iter().all(|color| *color == [1.0; 3]);
    Ok((!white).then_some(all))
}
