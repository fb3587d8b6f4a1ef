//! How trees grow, and what becomes of them in a snapshot.

use super::square::SquareCell;
use super::{DEPTH, FAN, LearntTree, MAX_NODES, Node, SIDE, WHOLE};
use crate::guiding::directional::bins::mean_cosine;
use crate::guiding::directional::{Entry, Totals};

/// What is the same for all trees.
#[derive(Clone, Debug)]
pub struct TreeShape {
    /// Mean cosines of the cells of each size, over the whole square.
    cosines: [Vec<f32>; DEPTH],
    /// A cell with more than this share of a state's irradiance is cut.
    share: f32,
    /// And with at least this many visits.
    visits: f32,
}

impl TreeShape {
    pub fn new(share: f32, visits: f32) -> TreeShape {
        let cosines = [1, 2, 3].map(|depth| {
            let side = SIDE.pow(depth);
            (0..side * side).map(|k| mean_cosine(side, k)).collect()
        });
        TreeShape { cosines, share, visits }
    }

    /// The same for a share that is `factor` times as large.
    pub fn coarser(&self, factor: f32) -> TreeShape {
        TreeShape { share: self.share * factor, ..self.clone() }
    }

    /// Whether no cell can hold more light than it takes to be cut.
    pub fn is_coarsest(&self) -> bool {
        // beyond 1, a share cuts nothing
        self.share >= 1.0
    }

    fn cosine(&self, place: SquareCell) -> f32 {
        self.cosines[place.depth - 1][(place.y * place.side() + place.x) as usize]
    }

    /// Cuts cells that hold more than their share of the light and are visited enough, joins those that do not, and
    /// hands what they know to the new ones.
    pub fn refine(&self, cells: &LearntTree) -> LearntTree {
        let irradiance = self.irradiance(cells, 0, SquareCell::ROOT, 0.0);
        let room = cells.entries.len();
        let mut refined = LearntTree { entries: Vec::with_capacity(room), children: Vec::with_capacity(room) };
        let root: [Entry; FAN] = std::array::from_fn(|k| cells.entries[k]);
        self.rebuild(cells, Some(0), &root, SquareCell::ROOT, self.share * irradiance, &mut refined);
        refined.entries.shrink_to_fit();
        refined.children.shrink_to_fit();
        refined
    }

    /// Appends the node at `place`, whose cells are those of node `old`, or new ones that know what `inherited` says.
    fn rebuild(
        &self,
        cells: &LearntTree,
        old: Option<usize>,
        inherited: &[Entry; FAN],
        place: SquareCell,
        limit: f32,
        out: &mut LearntTree,
    ) -> usize {
        let node = out.children.len() / FAN;
        out.entries.extend(inherited);
        out.children.extend([0; FAN]);
        for (k, own) in inherited.iter().enumerate() {
            let at = place.cell(k);
            let child = old.and_then(|old| cells.child(old, k));
            let entry = child.map_or(*own, |child| cells.summary(child));
            out.entries[node * FAN + k] = entry;
            let light = match child {
                Some(child) => self.irradiance(cells, child, at, entry.q),
                None => entry.q * self.cosine(at) * at.solid_angle(),
            };
            let enough = light > limit && entry.visits >= self.visits;
            if at.depth == DEPTH || !enough || out.children.len() / FAN >= MAX_NODES {
                continue;
            }
            let part = Entry { q: entry.q, visits: entry.visits / FAN as f32 };
            let next = child.map_or([part; FAN], |child| std::array::from_fn(|i| cells.entries[child * FAN + i]));
            let child = self.rebuild(cells, child, &next, at, limit, out);
            out.children[node * FAN + k] = child as u16;
        }
        node
    }

    /// ∫ Q cosθ dω over each cell of the root.
    pub fn profile(&self, cells: &LearntTree) -> [f32; FAN] {
        let prior = cells.mean(0).unwrap_or(0.0);
        std::array::from_fn(|k| match (cells.child(0, k), SquareCell::ROOT.cell(k)) {
            (Some(child), at) => self.irradiance(cells, child, at, prior),
            (None, at) => cells.entries[k].shrunk(prior) * self.cosine(at) * at.solid_angle(),
        })
    }

    /// ∫ Q cosθ dω over a node; `prior` is what its parent would expect.
    fn irradiance(&self, cells: &LearntTree, node: usize, place: SquareCell, prior: f32) -> f32 {
        let prior = cells.mean(node).unwrap_or(prior);
        (0..FAN)
            .map(|k| match (cells.child(node, k), place.cell(k)) {
                (Some(child), at) => self.irradiance(cells, child, at, prior),
                (None, at) => cells.entries[node * FAN + k].shrunk(prior) * self.cosine(at) * at.solid_angle(),
            })
            .sum()
    }

    /// ∫ Q cosθ dω and max Q cosθ.
    pub fn totals(&self, cells: &LearntTree) -> Totals {
        self.freeze(cells, &|_, _| 0.0, &mut Vec::new())
    }

    /// Appends what sampling needs: cells are drawn in proportion to `weight(Q, cosθ)` times their solid angle.
    pub fn freeze(&self, cells: &LearntTree, weight: &impl Fn(f32, f32) -> f32, out: &mut Vec<Node>) -> Totals {
        let base = out.len();
        out.resize(base + cells.nodes(), Node { starts: [0; FAN], children: [0; FAN] });
        let mut totals = Totals::default();
        self.freeze_node(cells, 0, SquareCell::ROOT, 0.0, weight, &mut out[base..], &mut totals);
        totals
    }

    /// Returns the node's weight.
    #[allow(clippy::too_many_arguments, reason = "one step of a recursion")]
    fn freeze_node(
        &self,
        cells: &LearntTree,
        node: usize,
        place: SquareCell,
        prior: f32,
        weight: &impl Fn(f32, f32) -> f32,
        out: &mut [Node],
        totals: &mut Totals,
    ) -> f64 {
        let prior = cells.mean(node).unwrap_or(prior);
        let mut begun = [0.0f64; FAN + 1];
        for k in 0..FAN {
            let at = place.cell(k);
            let mass = match cells.child(node, k) {
                Some(child) => {
                    out[node].children[k] = child as u16;
                    self.freeze_node(cells, child, at, prior, weight, out, totals)
                }
                None => {
                    let (q, cos) = (cells.entries[node * FAN + k].shrunk(prior), self.cosine(at));
                    totals.irradiance += q * cos * at.solid_angle();
                    totals.peak = totals.peak.max(q * cos);
                    (weight(q, cos) * at.solid_angle()) as f64
                }
            };
            begun[k + 1] = begun[k] + mass;
        }
        out[node].starts = starts(&begun);
        begun[FAN]
    }
}

/// Rounded shares of the unit interval; a node without weight is drawn from evenly.
fn starts(begun: &[f64; FAN + 1]) -> [u16; FAN] {
    let whole = begun[FAN];
    std::array::from_fn(|k| {
        let share = if whole > 0.0 { begun[k] / whole } else { k as f64 / FAN as f64 };
        (share * WHOLE as f64).round().min((WHOLE - 1) as f64) as u16
    })
}
