//! How cells come to know their sites.

use super::*;
use crate::math::rng::Rng;

/// Sites per region, about: regions are counted along a side of the scene as if its surface were a cube's.
const SITES_PER_REGION: usize = 32;
const MAX_REGIONS: f32 = 40.0;

/// Neighbours that tell the spacing: in a plane with one site per unit area the fourth is at 1, evenly spread or not.
const NEIGHBOURS: usize = 4;

/// A list longer than this is left to the tree, and no more than this many times `GATHERED` sites are looked at for it.
const LONGEST: usize = 24;
const GATHERED: usize = 512;

/// Points in a row of the lattice about a site, whose cells are prepared; they lie `STEP` spacings of its region apart.
const LATTICE: i32 = 5;
const STEP: f32 = 0.5;

/// Rounding in a point's coordinate, in cells: some operations at half an ulp of the largest.
const ROUNDING: f32 = (1 << CELL_BITS) as f32 * 2.0 * f32::EPSILON;

/// A cell's candidates, ascending.
struct CandidateList {
    sites: Vec<u32>,
    mixed: bool,
}

/// A cell and what it is met with.
struct CandidateCell {
    centre: Vec3,
    half: Vec3,
    bin: usize,
}

impl CandidateCells {
    /// Prepares the cells about the sites and those that `samples` (points with unit normals) lie in.
    pub fn new(tree: &SiteTree, samples: &[(Vec3, Vec3)]) -> CandidateCells {
        let spacings: Vec<f32> = (0..tree.points().len() as u32).into_par_iter().map(|s| spacing(tree, s)).collect();
        let mut cells = CandidateCells::without_lists(tree, &spacings);
        let keys = cells.keys_to_prepare(tree, samples);
        let agreeable: Vec<bool> = Bin::all().iter().map(|b| tree.normals().iter().any(|n| b.maybe(*n))).collect();
        let lists: Vec<(u64, CandidateList)> =
            keys.par_iter().filter_map(|key| Some((*key, cells.cell(*key).list(tree, &agreeable)?))).collect();
        cells.store(&lists, tree.points().len());
        cells
    }

    /// The regions, each as spaced as the harmonic mean of its sites, or as the site nearest to its centre.
    fn without_lists(tree: &SiteTree, spacings: &[f32]) -> CandidateCells {
        let points = tree.points();
        let margin = 2.0 * median(spacings);
        let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min) - margin;
        let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max) + margin;
        let along = (points.len() as f32 / SITES_PER_REGION as f32).sqrt().clamp(1.0, MAX_REGIONS - 1.0).floor();
        let side = (high - low).max_element() / along;
        let regions_per_unit = if side > 0.0 && side.is_finite() { 1.0 / side } else { 1.0 };
        let dims = ((high - low) * regions_per_unit).as_uvec3().min(UVec3::splat(along as u32)) + 1;
        let mut cells = CandidateCells {
            origin: low,
            regions_per_unit,
            dims,
            regions: Vec::new(),
            slots: vec![EMPTY],
            long: Vec::new(),
        };
        let mut sums = vec![(0.0, 0.0); dims.element_product() as usize];
        for (p, spacing) in points.iter().zip(spacings).filter(|(_, spacing)| **spacing > 0.0) {
            let sum = &mut sums[cells.region(*p) as usize];
            *sum = (sum.0 + 1.0 / spacing, sum.1 + 1.0);
        }
        // coordinates have too few bits for smaller cells than these
        let finest = ((1 << CELL_BITS) - 2) as f32 / (high - low).max_element().max(f32::MIN_POSITIVE);
        let region = |i: u32| {
            let centre = UVec3::new(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y).as_vec3() + 0.5;
            let nearest = || tree.nearest_where(low + centre / regions_per_unit, Bins::MAX, |_| true);
            let spacing = match sums[i as usize] {
                (_, 0.0) => nearest().map_or(0.0, |(site, _)| spacings[site as usize]),
                (sum, count) => count / sum,
            };
            let scale = (1.0 / (CELL * spacing)).min(finest).max(f32::MIN_POSITIVE);
            Region { spacing, scale: f32::from_bits(scale.to_bits() >> SCALE_BITS << SCALE_BITS) }
        };
        cells.regions = (0..sums.len() as u32).into_par_iter().map(region).collect();
        cells
    }

    /// The cells to prepare, ascending: those about each site, and those of the samples, each jittered once.
    fn keys_to_prepare(&self, tree: &SiteTree, samples: &[(Vec3, Vec3)]) -> Vec<u64> {
        let key = |p: Vec3, n: Vec3, jitter: [f32; 2]| {
            let (p, scale) = self.moved(p, n, jitter);
            Some(self.key(p, scale, bin(n))).filter(|key| *key != NOWHERE)
        };
        let about = |(p, n): (&Vec3, &Vec3)| {
            let (p, n) = (*p, *n);
            let offset = |i: i32| (i - LATTICE / 2) as f32 * STEP + 0.5;
            (0..LATTICE * LATTICE).filter_map(move |i| key(p, n, [offset(i % LATTICE), offset(i / LATTICE)]))
        };
        let mut keys: Vec<u64> = tree.points().par_iter().zip(tree.normals()).flat_map_iter(about).collect();
        let sample = |(i, (p, n)): (usize, &(Vec3, Vec3))| key(*p, *n, Rng::new(i as u64).f32x2());
        keys.par_extend(samples.par_iter().enumerate().filter_map(sample));
        keys.par_sort_unstable();
        let mut met: Vec<(u32, u64)> = keys.chunk_by(|a, b| a == b).map(|run| (run.len() as u32, run[0])).collect();
        let most = CELLS_PER_SITE * tree.points().len();
        if met.len() > most {
            met.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
            met.truncate(most);
            met.sort_unstable_by_key(|(_, key)| *key);
        }
        met.into_iter().map(|(_, key)| key).collect()
    }

    /// The box of all points that have this key, rounding included.
    fn cell(&self, key: u64) -> CandidateCell {
        let field = |i: u32| (key >> (BIN_BITS + i * CELL_BITS)) as u32 & ((1 << CELL_BITS) - 1);
        let scale = f32::from_bits(((key >> (3 * CELL_BITS + BIN_BITS)) as u32) << SCALE_BITS);
        let centre = self.origin + (UVec3::new(field(0), field(1), field(2)).as_vec3() + 0.5) / scale;
        // the centre itself is rounded in world space
        let half = Vec3::splat((0.5 + ROUNDING) / scale) + centre.abs() * (2.0 * f32::EPSILON);
        CandidateCell { centre, half, bin: key as usize & ((1 << BIN_BITS) - 1) }
    }

    /// Fills the table, in the order of lists, which are those of so many sites.
    fn store(&mut self, lists: &[(u64, CandidateList)], sites: usize) {
        self.slots = vec![EMPTY; SLOTS_PER_PAIR * lists.len() / 2 + 1];
        let room = LONG_PER_SITE * sites;
        for (key, list) in lists {
            let mut slot = CellSlot { head: key << FLAGS | if list.mixed { MIXED } else { 0 }, ..EMPTY };
            let count = list.sites.len();
            if count <= SHORT {
                slot.head |= count as u64;
                // the last fills what is left, so that all places can be looked at
                slot.candidates = std::array::from_fn(|i| list.sites[i.min(count - 1)]);
            } else if self.long.len() + count <= room {
                slot.head |= LONG;
                slot.candidates[..2].copy_from_slice(&[self.long.len() as u32, count as u32]);
                self.long.extend(&list.sites);
            } else {
                continue;
            }
            let mut at = self.home(*key) as usize;
            while self.slots[at].head != EMPTY.head {
                at = (at + 1) % self.slots.len();
            }
            self.slots[at] = slot;
        }
    }
}

impl CandidateCell {
    /// Every site that is the answer somewhere in this cell; `None` where these are too many, or not bounded.
    fn list(&self, tree: &SiteTree, agreeable: &[bool]) -> Option<CandidateList> {
        let normal = |site: u32| tree.normals()[site as usize];
        // where no site agrees with any normal of the bin, all compete
        let (alone, bin) = (!agreeable[self.bin], &Bin::all()[self.bin]);
        let (surely, maybe) = (|s: u32| alone || bin.surely(normal(s)), |s: u32| alone || bin.maybe(normal(s)));
        let bins = if alone { Bins::MAX } else { bin.partners };
        let (_, d2) = tree.nearest_where(self.centre, bins, surely)?;
        let reach = (d2.sqrt() + 2.0 * self.half.length()) * (1.0 + 1e-5);
        let mut near: Vec<(f32, u32)> = Vec::new();
        tree.visit(self.centre, bins, reach * reach, |site, d2| {
            if d2 <= reach * reach && maybe(site) {
                near.push((d2, site));
            }
            if near.len() > GATHERED { -1.0 } else { reach * reach }
        });
        if near.len() > GATHERED {
            return None;
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut sites: Vec<u32> = Vec::new();
        for (_, site) in near {
            let beaten = |by: &u32| surely(*by) && self.beats(tree.point(*by), tree.point(site));
            if !sites.iter().any(beaten) {
                sites.push(site);
            }
            if sites.len() > LONGEST {
                return None;
            }
        }
        sites.sort_unstable();
        let mixed = !sites.iter().all(|site| surely(*site));
        Some(CandidateList { sites, mixed })
    }

    /// Whether `t` is nearer than `s` to all points of the box, by more than rounding can hide.
    fn beats(&self, t: Vec3, s: Vec3) -> bool {
        let (centre, half, t, s) = (self.centre.as_dvec3(), self.half.as_dvec3(), t.as_dvec3(), s.as_dvec3());
        let at_centre = (centre - s).length_squared() - (centre - t).length_squared();
        let least = at_centre - 2.0 * (t - s).abs().dot(half);
        let farthest = (centre - s).length() + half.length();
        least > 1e-6 * farthest * farthest
    }
}

fn median(values: &[f32]) -> f32 {
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Distance from a site to its fourth neighbour whose normal agrees, or to the farthest where there are fewer; copies
/// do not count, and a site without neighbours has none.
fn spacing(tree: &SiteTree, site: u32) -> f32 {
    let n = tree.normals()[site as usize];
    let mut nearest = [f32::INFINITY; NEIGHBOURS];
    tree.visit(tree.point(site), Bin::all()[bin(n)].partners, f32::INFINITY, |other, d2| {
        if d2 > 0.0 && d2 < nearest[NEIGHBOURS - 1] && agree(n, tree.normals()[other as usize]) {
            nearest[NEIGHBOURS - 1] = d2;
            nearest.sort_unstable_by(f32::total_cmp);
        }
        nearest[NEIGHBOURS - 1]
    });
    nearest.into_iter().filter(|d2| d2.is_finite()).fold(0.0, f32::max).sqrt()
}
