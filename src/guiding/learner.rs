//! The learner: owns the Q-table, has its shards learn, and cuts and drops what is in it between iterations.

use super::recorder::{Recorder, SHARDS, Transition, shard_of};
use super::update_job::{Rules, UpdateJob};
use crate::guiding::directional::bins::strata::{Domain, Strata};
use crate::guiding::directional::hemitree::{Cells, FAN, TreeShape, bytes_per_node};
use crate::guiding::settings::{DirectionTable, GuidingSettings, Rate};
use crate::guiding::spatial::{StateKey, States};
use crate::guiding::store::{
    Actions, Entry, Fraction, ReturnMoments, Shard, State, bytes_besides_actions, bytes_of_strata,
};
use crate::math::Frame;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// The directions of a state.
#[derive(Clone, Debug)]
pub enum Table {
    Strata(Strata),
    Tree(TreeShape),
}

impl Table {
    /// The table that the settings ask for.
    pub fn new(settings: &GuidingSettings) -> Table {
        match settings.table {
            DirectionTable::Hemisphere => Table::Strata(Strata::new(Domain::Hemisphere, settings.strata)),
            DirectionTable::Sphere => Table::Strata(Strata::new(Domain::Sphere, settings.strata)),
            DirectionTable::Tree => Table::Tree(TreeShape::new(settings.split_share, settings.split_visits)),
        }
    }

    /// Bytes that a state takes, learnt and frozen; with a tree of a few nodes, as most are.
    pub fn usual_bytes(&self) -> usize {
        const NODES: usize = 4;
        bytes_besides_actions()
            + match self {
                Table::Strata(strata) => bytes_of_strata(strata.count()),
                Table::Tree(_) => NODES * bytes_per_node(),
            }
    }

    pub(super) fn nothing_known(&self) -> Actions {
        match self {
            Table::Strata(strata) => Actions::Strata(vec![Entry::default(); strata.count()]),
            Table::Tree(_) => Actions::Tree(Cells::new()),
        }
    }

    /// Irradiance from each sixteenth of the directions, for telling states apart.
    pub fn profile(&self, actions: &Actions) -> [f32; FAN] {
        match (actions, self) {
            (Actions::Tree(cells), Table::Tree(shape)) => shape.profile(cells),
            (Actions::Strata(entries), Table::Strata(strata)) => {
                let mut profile = [0.0; FAN];
                let (columns, lines) = (strata.columns(), strata.lines());
                for (k, entry) in entries.iter().enumerate() {
                    let cos = strata.cosines().get(k).copied().unwrap_or(1.0);
                    let (x, y) = (4 * (k % columns) / columns, 4 * (k / columns) / lines);
                    profile[4 * y + x] += entry.q * cos * strata.solid_angle();
                }
                profile
            }
            _ => unreachable!("a state's actions are those of its table"),
        }
    }
}

/// Step of the learnt BSDF fraction, and how fast its moments fade (Müller 2019, Kingma & Ba 2015).
const STEP: f32 = 0.01;
const FADE_FIRST: f32 = 0.9;
const FADE_SECOND: f32 = 0.999;
/// What running means hold of all that came, by the number of steps, until that is all to the last bit: powers take
/// longer than the step itself.
static FIRST_TAKEN: LazyLock<Vec<f32>> = LazyLock::new(|| taken(FADE_FIRST, 200));
static SECOND_TAKEN: LazyLock<Vec<f32>> = LazyLock::new(|| taken(FADE_SECOND, 10_000));

fn taken(fade: f32, steps: i32) -> Vec<f32> {
    (0..=steps).map(|steps| 1.0 - fade.powi(steps)).collect()
}

#[inline]
fn shares_taken(taken: &[f32], steps: u32) -> f32 {
    taken[(steps as usize).min(taken.len() - 1)]
}
/// Pulls the fraction towards one half.
const REGULARISATION: f32 = 0.01;
/// Keeps the share between 0.05 and 0.95: the mixture stays defensive, and the guide in use.
const MAX_LOGIT: f32 = 2.944_439;

/// Owns the Q-table; the only code that changes it.
#[derive(Clone, Debug)]
pub struct Learner {
    shards: Vec<Shard>,
    pub table: Table,
    /// Whether a state's table is held in the frame about its own normal.
    oriented: bool,
    rate: Rate,
    /// Bytes that all shards together may hold.
    memory: usize,
    /// How much larger than the settings' the share of light is for which trees are cut, so that there is room for all.
    coarseness: f32,
}

/// Share of the memory up to which trees grow: the rest is for states yet to be met.
const TREES_SHARE: f64 = 0.75;

impl Learner {
    pub fn new(table: Table, oriented: bool, rate: Rate, memory: usize) -> Learner {
        let shards = (0..SHARDS).map(|_| Shard::default()).collect();
        Learner { shards, table, oriented, rate, memory, coarseness: 1.0 }
    }

    /// What the tiles recorded, by shard, in the order of `recorders`: the result is the same for any number of threads.
    pub fn lessons<'a>(&'a mut self, recorders: &'a [&'a Recorder], states: &'a States) -> Vec<UpdateJob<'a>> {
        let Learner { shards, table, oriented, rate, memory, .. } = self;
        let rules = Rules { states, table, oriented: *oriented, rate: *rate, room: *memory / SHARDS };
        let lesson = |(number, shard)| UpdateJob { rules, shard, number, recorders };
        shards.iter_mut().enumerate().map(lesson).collect()
    }

    /// Cuts tables anew where the light is. Comes between two iterations, before the snapshot is taken. Where all trees
    /// together would be too large, they are cut for twice the share of light, and so on.
    pub fn refine_actions(&mut self) {
        let Table::Tree(shape) = &self.table else { return };
        let most = (self.memory as f64 * TREES_SHARE) as usize;
        let forms = loop {
            let shape = shape.coarser(self.coarseness);
            let refined = |state: &State| state.tree().map(|cells| shape.refine(cells));
            let forms = |shard: &Shard| shard.states().iter().map(refined).collect::<Vec<_>>();
            let forms: Vec<Vec<_>> = self.shards.par_iter().map(forms).collect();
            let fixed = bytes_besides_actions() * self.states().count();
            let bytes = fixed + forms.iter().flatten().flatten().map(Cells::bytes).sum::<usize>();
            // beyond 1, a share cuts nothing
            if bytes <= most || shape.is_coarsest() {
                break forms;
            }
            self.coarseness *= 2.0;
        };
        let room = self.memory / SHARDS;
        self.shards.par_iter_mut().zip(forms).for_each(|(shard, forms)| shard.reshape(forms, room));
    }

    /// Begins an iteration, once the snapshot is taken: earlier visits keep only a share of their weight. Early targets
    /// were bootstrapped from a table that knew little; a rate of 1/n alone forgets their error only as n^−(1−albedo).
    pub fn fade(&mut self) {
        let retain = match self.rate {
            Rate::Forgetting(retain) => retain,
            Rate::Vanishing | Rate::Constant(_) => 1.0,
        };
        self.shards.par_iter_mut().flat_map(|shard| shard.states_mut()).for_each(|state| {
            state.entries_mut().iter_mut().for_each(|entry| entry.visits *= retain);
            state.visits *= retain;
            state.returns.weight *= retain;
            state.fresh = 0.0;
        });
    }

    /// Replaces each state by others: `heirs` says by which; where it says nothing, the state stays.
    pub fn replace(&mut self, heirs: impl Fn(&State) -> Option<Vec<State>> + Sync) {
        let new: Vec<Vec<State>> = self
            .shards
            .par_iter_mut()
            .map(|shard| {
                let heirs: Vec<Option<Vec<State>>> = shard.states().iter().map(&heirs).collect();
                shard.keep(heirs.iter().map(Option::is_none));
                heirs.into_iter().flatten().flatten().collect()
            })
            .collect();
        let room = self.memory / SHARDS;
        for state in new.into_iter().flatten() {
            let shard = &mut self.shards[shard_of(state.key)];
            if shard.get(state.key).is_none() && shard.bytes() + state.bytes() <= room {
                shard.insert(state);
            }
        }
    }

    /// What is known, by shard.
    pub fn shards(&self) -> &[Shard] {
        &self.shards
    }

    /// Puts back a state that is not there yet.
    pub fn restore(&mut self, state: State) {
        self.shards[shard_of(state.key)].insert(state);
    }

    /// Bytes that the table may take.
    pub fn memory(&self) -> usize {
        self.memory
    }

    /// Changes the bytes that all states together may take, where none is yet.
    pub fn keep_within(&mut self, memory: usize) {
        self.memory = memory;
    }

    pub fn get(&self, key: StateKey) -> Option<&State> {
        self.shards[shard_of(key)].get(key)
    }

    /// All states, in an order that depends on nothing but what was learnt.
    pub fn states(&self) -> impl Iterator<Item = &State> {
        self.shards.iter().flat_map(|shard| shard.states())
    }

    pub fn bytes(&self) -> usize {
        self.shards.iter().map(Shard::bytes).sum()
    }
}

/// A direction as a table holds it: hemispheres about the state's normal, spheres in world space.
pub fn in_table(domain: Domain, normal: Vec3, w: Vec3) -> Vec3 {
    match domain {
        Domain::Hemisphere => Frame::from_normal(normal).to_local(w),
        Domain::Sphere => w,
    }
}

impl ReturnMoments {
    /// Counts a transition in.
    #[inline]
    pub(super) fn add(&mut self, transition: &Transition) {
        let estimate = transition.target * transition.scattered / transition.pdf;
        // one whose square is beyond an `f32` would be all that is ever known
        if transition.scattered == 0.0 || !(estimate * estimate).is_finite() {
            return;
        }
        self.weight += 1.0;
        let step = 1.0 / self.weight;
        self.mean += (estimate - self.mean) * step;
        self.square += (estimate * estimate - self.square) * step;
        self.rays += (transition.rays - self.rays) * step;
    }
}

impl Fraction {
    /// The share of directions left to the BSDF.
    pub fn share(&self) -> f32 {
        1.0 / (1.0 + (-self.logit).exp())
    }

    /// One step down the gradient of the Kullback-Leibler divergence of the mixture from the product f·cosθ·L
    /// (Müller 2019, §10.5). The step is the gradient in units of its own running size, so exposure is nothing to it.
    #[inline]
    pub(super) fn step(&mut self, transition: &Transition) {
        let Transition { target, scattered, pdf, bsdf_pdf, guide_pdf, .. } = *transition;
        let share = self.share();
        let mixture = share * bsdf_pdf + (1.0 - share) * guide_pdf;
        let product = target * scattered;
        if !(product > 0.0 && mixture > 0.0 && guide_pdf >= 0.0) {
            return;
        }
        let gradient = -product / (pdf * mixture) * (bsdf_pdf - guide_pdf) * share * (1.0 - share);
        if !(gradient * gradient).is_finite() {
            return;
        }
        self.steps += 1;
        self.first = FADE_FIRST * self.first + (1.0 - FADE_FIRST) * gradient;
        self.second = FADE_SECOND * self.second + (1.0 - FADE_SECOND) * gradient * gradient;
        let second = (self.second / shares_taken(&SECOND_TAKEN, self.steps)).sqrt();
        let first = self.first / shares_taken(&FIRST_TAKEN, self.steps);
        if second > 0.0 {
            let move_by = STEP * (first / second + REGULARISATION * self.logit);
            self.logit = (self.logit - move_by).clamp(-MAX_LOGIT, MAX_LOGIT);
        }
    }
}
