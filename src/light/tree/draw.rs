//! Draws by importance, one by one and for packets.

use super::far::Far;
use super::node::Link;
use super::patch::part;
use super::{LightTree, is_amount};
use crate::math::ONE_MINUS_EPSILON_F64;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each, mask, pick};
use glam::Vec3;

/// A light that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    pub light: u32,
    /// Probability of this choice.
    pub pmf: f32,
    /// What is left of the random number, as a fresh one.
    pub rest: f64,
}

/// The same for a packet; `pmf` is 0 where nothing was chosen.
pub(crate) struct ChoiceLanes {
    pub light: [u32; LANES],
    pub pmf: Lanes,
    pub rest: [f64; LANES],
}

impl ChoiceLanes {
    #[inline(always)]
    pub fn get(&self, k: usize) -> Choice {
        Choice { light: self.light[k], pmf: self.pmf[k], rest: self.rest[k] }
    }
}

/// One of several.
#[derive(Clone, Copy)]
pub(super) struct Draw {
    pub index: usize,
    pub pmf: f64,
    /// What is left of the random number.
    pub rest: f64,
}

/// Sums of importances, of which there are [`ROWS`] rows: they go down one column after the other, so that columns are summed
/// side by side. Sums need more digits than importances, or what is rare would be drawn at another rate than its own.
pub(super) struct Sums {
    /// Of all that come before a column.
    before: [f64; ROWS],
    /// Of a column down to and with a row.
    down: [[f64; ROWS]; ROWS],
    pub total: f64,
}

const ROWS: usize = 4;
const _: () = assert!(ROWS * ROWS == LANES);

impl Sums {
    #[inline(always)]
    pub fn new(importances: &Lanes) -> Sums {
        let mut down = [[0.0; ROWS]; ROWS];
        for c in 0..ROWS {
            down[0][c] = f64::from(importances[c]);
        }
        for r in 1..ROWS {
            for c in 0..ROWS {
                down[r][c] = down[r - 1][c] + f64::from(importances[r * ROWS + c]);
            }
        }
        let (mut before, mut total) = ([0.0; ROWS], 0.0);
        for c in 0..ROWS {
            before[c] = total;
            total += down[ROWS - 1][c];
        }
        Sums { before, down, total }
    }
}

/// Draws one in proportion to its importance; `None` where all are 0.
#[inline(always)]
pub(super) fn draw(importances: &Lanes, u: f64) -> Option<Draw> {
    let Sums { before, down, total } = Sums::new(importances);
    if !is_amount(total) {
        return None;
    }
    let target = target(u, total);
    // how many sums, in their order, are not beyond the target
    let mut passed = [0; ROWS];
    for row in &down {
        for c in 0..ROWS {
            passed[c] += u64::from(before[c] + row[c] <= target);
        }
    }
    let passed = passed.iter().sum::<u64>().min(LANES as u64 - 1) as usize;
    let (c, r) = (passed / ROWS, passed % ROWS);
    let index = r * ROWS + c;
    let importance = f64::from(importances[index]);
    let before = before[c] + if r == 0 { 0.0 } else { down[r - 1][c] };
    Some(Draw { index, pmf: importance / total, rest: rest(target - before, importance) })
}

/// The place in a sum to which a number points: always below the sum.
#[inline(always)]
fn target(u: f64, total: f64) -> f64 {
    let (target, most) = (u * total, total * ONE_MINUS_EPSILON_F64);
    pick(target < most, target, most)
}

/// What is left of a number that points so far into a share.
#[inline(always)]
pub(super) fn rest(into: f64, share: f64) -> f64 {
    let rest = into / share;
    let rest = pick(rest > 0.0, rest, 0.0);
    pick(rest < ONE_MINUS_EPSILON_F64, rest, ONE_MINUS_EPSILON_F64)
}

/// Points of a packet, in the tree's unit of length.
struct Points<'a> {
    p: Vec3Lanes,
    n: &'a Vec3Lanes,
    /// Where there is a normal.
    oriented: [u32; LANES],
}

/// What was drawn at the root so far: indices of children, or [`LANES`] and the place of a light at infinity.
struct RootDraws {
    target: [f64; LANES],
    sum: [f64; LANES],
    index: [u32; LANES],
    importance: Lanes,
    before: [f64; LANES],
}

impl RootDraws {
    /// Goes on by a row of importances.
    #[inline(always)]
    fn step(&mut self, index: usize, importances: &Lanes) {
        for k in 0..LANES {
            let next = self.sum[k] + f64::from(importances[k]);
            let here = (self.sum[k] <= self.target[k]) & (self.target[k] < next);
            self.index[k] = pick(here, index as u32, self.index[k]);
            self.importance[k] = pick(here, importances[k], self.importance[k]);
            self.before[k] = pick(here, self.sum[k], self.before[k]);
            self.sum[k] = next;
        }
    }
}

impl LightTree {
    /// Draws among the root's children and the lights at infinity.
    pub(super) fn draw_at_root(&self, p: Vec3, n: Vec3, u: f64) -> Option<Draw> {
        let near = self.nodes[0].importances(p, n);
        let all = || near.iter().copied().chain(self.far.iter().map(|(far, _)| far.importance(n)));
        let total = all().fold(0.0, |total, importance| total + f64::from(importance));
        if !is_amount(total) {
            return None;
        }
        let (target, mut before) = (target(u, total), 0.0);
        for (index, importance) in all().enumerate() {
            let importance = f64::from(importance);
            if target < before + importance {
                return Some(Draw { index, pmf: importance / total, rest: rest(target - before, importance) });
            }
            before += importance;
        }
        None
    }

    /// [`Self::choose`] for the lanes of `lit`, at the points `p` with the normals `n`.
    pub fn choose_lanes(&self, lit: Mask, p: &Vec3Lanes, n: &Vec3Lanes, u: &[f64; LANES]) -> ChoiceLanes {
        let mut chosen = self.choose_patches(lit, p, n, u);
        if !self.shares.is_empty() {
            // `map` would be a call
            let mut shares = [1.0; LANES];
            for k in 0..LANES {
                shares[k] = self.shares[chosen.light[k] as usize];
            }
            for k in 0..LANES {
                let (next, pmf, rest) = part(shares[k], chosen.rest[k]);
                chosen.light[k] += next;
                chosen.pmf[k] *= pmf;
                chosen.rest[k] = rest;
            }
        }
        chosen
    }

    fn choose_patches(&self, lit: Mask, p: &Vec3Lanes, n: &Vec3Lanes, u: &[f64; LANES]) -> ChoiceLanes {
        if let Some(light) = self.only {
            return ChoiceLanes { light: [light; LANES], pmf: [1.0; LANES], rest: *u };
        }
        let mut points = Points { p: Vec3Lanes::ZERO, n, oriented: [0; LANES] };
        for k in 0..LANES {
            points.p.set(k, p.get(k) * self.scale);
            points.oriented[k] = u32::from(n.get(k) != Vec3::ZERO);
        }
        let lit = lit & self.reached(&points);
        if !lit.any() {
            return ChoiceLanes { light: [0; LANES], pmf: [0.0; LANES], rest: *u };
        }
        let (index, mut pmf, rest) = self.draw_lanes_at_root(&points, u);
        let lit_lanes = lit.lanes();
        for k in 0..LANES {
            pmf[k] = pick(lit_lanes.has(k), pmf[k], 0.0);
        }
        self.descend(lit, &points, index, pmf, rest)
    }

    /// [`Self::may_reach`] for all.
    #[inline(always)]
    fn reached(&self, points: &Points) -> Mask {
        let Some(whole) = &self.whole else { return !Mask::NONE };
        let mut importance = [0.0; LANES];
        for k in 0..LANES {
            importance[k] = whole.importance(points.p.get(k), points.n.get(k), points.oriented[k] != 0);
        }
        mask(|k| importance[k] > 0.0)
    }

    #[inline(always)]
    fn draw_lanes_at_root(&self, points: &Points, u: &[f64; LANES]) -> ([u32; LANES], [f64; LANES], [f64; LANES]) {
        let (root, mut rows, mut total) = (&self.nodes[0], [[0.0; LANES]; LANES], [0.0; LANES]);
        for (c, row) in rows[..self.children].iter_mut().enumerate() {
            let child = root.child(c);
            for k in 0..LANES {
                row[k] = child.importance(points.p.get(k), points.n.get(k), points.oriented[k] != 0);
            }
        }
        let far = self.far.iter().map(|(far, _)| far_row(far, points.n));
        for row in rows[..self.children].iter().copied().chain(far) {
            for k in 0..LANES {
                total[k] += f64::from(row[k]);
            }
        }
        let mut draws = RootDraws {
            target: [0.0; LANES],
            sum: [0.0; LANES],
            index: [0; LANES],
            importance: [0.0; LANES],
            before: [0.0; LANES],
        };
        for k in 0..LANES {
            draws.target[k] = target(u[k], total[k]);
        }
        for (c, row) in rows[..self.children].iter().enumerate() {
            draws.step(c, row);
        }
        for (c, (far, _)) in self.far.iter().enumerate() {
            draws.step(LANES + c, &far_row(far, points.n));
        }
        let (mut pmf, mut left) = ([0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            let importance = f64::from(draws.importance[k]);
            pmf[k] = pick(is_amount(total[k]), importance / total[k], 0.0);
            left[k] = rest(draws.target[k] - draws.before[k], importance);
        }
        (draws.index, pmf, left)
    }

    /// From what was drawn at the root down to lights, all lanes to one level before the next.
    #[inline(always)]
    fn descend(
        &self,
        lit: Mask,
        points: &Points,
        index: [u32; LANES],
        mut pmf: [f64; LANES],
        rest: [f64; LANES],
    ) -> ChoiceLanes {
        let mut chosen = ChoiceLanes { light: [0; LANES], pmf: [0.0; LANES], rest };
        let (mut below, mut nodes) = (Mask::NONE, [0; LANES]);
        for k in each(lit) {
            let index = index[k] as usize;
            if index >= LANES {
                chosen.light[k] = self.far[index - LANES].1;
            } else {
                follow(self.nodes[0].link(index), k, &mut chosen, &mut below, &mut nodes);
            }
        }
        while below.any() {
            let level = below;
            for k in each(level) {
                let node = &self.nodes[nodes[k] as usize];
                below.set(k, false);
                match draw(&node.importances(points.p.get(k), points.n.get(k)), chosen.rest[k]) {
                    Some(next) => {
                        pmf[k] *= next.pmf;
                        chosen.rest[k] = next.rest;
                        follow(node.link(next.index), k, &mut chosen, &mut below, &mut nodes);
                    }
                    None => pmf[k] = 0.0,
                }
            }
        }
        for k in 0..LANES {
            chosen.pmf[k] = pmf[k] as f32;
        }
        chosen
    }
}

#[inline(always)]
fn follow(link: Link, k: usize, chosen: &mut ChoiceLanes, below: &mut Mask, nodes: &mut [u32; LANES]) {
    match link {
        Link::Light(light) => chosen.light[k] = light,
        Link::Node(node) => {
            below.set(k, true);
            nodes[k] = node;
        }
    }
}

#[inline(always)]
fn far_row(far: &Far, n: &Vec3Lanes) -> Lanes {
    let mut row = [0.0; LANES];
    for k in 0..LANES {
        row[k] = far.importance(n.get(k));
    }
    row
}
