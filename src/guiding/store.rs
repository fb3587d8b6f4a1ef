//! The Q-table: stores what is known by state and action, and does nothing else.

use crate::guiding::directional::hemitree::Cells;
use crate::guiding::spatial::StateKey;
use glam::Vec3;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// A state-action pair: the estimate of incident radiance (luminance), and the weight of the visits behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    pub q: f32,
    pub visits: f32,
}

/// Visits that an entry's own must outweigh: below it, it leans towards what its surroundings say, so that what was
/// never tried stays possible, in units that no exposure changes.
const PRIOR_VISITS: f32 = 1.0;

impl Entry {
    /// The estimate, leaning towards `prior` where visits are few.
    #[inline]
    pub fn shrunk(self, prior: f32) -> f32 {
        (self.q * self.visits + prior * PRIOR_VISITS) / (self.visits + PRIOR_VISITS)
    }
}

/// Values by action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Actions {
    Strata(Vec<Entry>),
    Tree(Cells),
}

/// What is known of one state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    pub key: StateKey,
    /// The normal of the state's site, or else of the first visit; the table of an oriented state is held in the frame about it.
    pub normal: Vec3,
    pub actions: Actions,
    /// Weight of all visits.
    pub visits: f32,
    /// Visits since the iteration began.
    pub fresh: f32,
    /// Whether it was ever met; else all that it knows is of the state that it was a part of.
    pub met: bool,
    pub returns: ReturnMoments,
    pub fraction: Fraction,
}

/// Moments of the one-sample estimate of a state's irradiance over π, that is of target·f·cosθ/p with the BSDF's albedo
/// divided out, and the rays it took. Roulette and splitting go by them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReturnMoments {
    pub weight: f32,
    pub mean: f32,
    pub square: f32,
    pub rays: f32,
}

/// Logit of the share of directions left to the BSDF, and the moments of its gradient (Kingma & Ba 2015).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fraction {
    pub logit: f32,
    pub first: f32,
    pub second: f32,
    pub steps: u32,
}

impl State {
    /// Bytes of the state and its place in the map at full load, snapshot included.
    pub fn bytes(&self) -> usize {
        bytes_besides_actions()
            + match &self.actions {
                Actions::Strata(entries) => bytes_of_strata(entries.len()),
                Actions::Tree(cells) => cells.bytes(),
            }
    }

    /// The tree of its directions, where they are held so.
    pub fn tree(&self) -> Option<&Cells> {
        match &self.actions {
            Actions::Tree(cells) => Some(cells),
            Actions::Strata(_) => None,
        }
    }

    pub fn entries(&self) -> &[Entry] {
        match &self.actions {
            Actions::Strata(entries) => entries,
            Actions::Tree(cells) => &cells.entries,
        }
    }

    pub fn entries_mut(&mut self) -> &mut [Entry] {
        match &mut self.actions {
            Actions::Strata(entries) => entries,
            Actions::Tree(cells) => &mut cells.entries,
        }
    }
}

/// Bytes of `k` strata, learnt and frozen.
pub fn bytes_of_strata(k: usize) -> usize {
    k * (size_of::<Entry>() + super::snapshot::bytes_per_stratum())
}

/// Bytes of a state of which no direction is known, snapshot included.
pub fn bytes_besides_actions() -> usize {
    size_of::<State>() + 2 * (size_of::<(StateKey, u32)>() + 1) + super::snapshot::bytes_besides_rows()
}

/// The part of the table whose states hash to one shard. States are held in the order in which they are first met.
#[derive(Clone, Debug, Default)]
pub struct Shard {
    rows: FxHashMap<StateKey, u32>,
    states: Vec<State>,
    bytes: usize,
}

impl Shard {
    #[inline]
    pub fn get(&self, key: StateKey) -> Option<&State> {
        self.rows.get(&key).map(|&row| &self.states[row as usize])
    }

    /// Where a state is held.
    #[inline]
    pub fn row(&self, key: StateKey) -> Option<u32> {
        self.rows.get(&key).copied()
    }

    #[inline]
    pub fn state(&self, row: u32) -> &State {
        &self.states[row as usize]
    }

    #[inline]
    pub fn state_mut(&mut self, row: u32) -> &mut State {
        &mut self.states[row as usize]
    }

    pub fn insert(&mut self, state: State) -> &mut State {
        self.bytes += state.bytes();
        self.rows.insert(state.key, self.states.len() as u32);
        self.states.push(state);
        self.states.last_mut().expect("just pushed")
    }

    /// Drops states: `stays` says of each in turn whether it does.
    pub fn keep(&mut self, mut stays: impl Iterator<Item = bool> + Clone) {
        if stays.clone().all(|stays| stays) {
            return;
        }
        self.states.retain(|_| stays.next().unwrap_or(true));
        self.states.shrink_to_fit();
        self.rows = self.states.iter().enumerate().map(|(row, state)| (state.key, row as u32)).collect();
        self.count_bytes();
    }

    /// Gives each state the tree that `forms` has for it, as long as all of them take `room` bytes at most.
    pub fn reshape(&mut self, forms: Vec<Option<Cells>>, room: usize) {
        let mut left = room.saturating_sub(self.bytes);
        for (state, form) in self.states.iter_mut().zip(forms) {
            let (before, Some(form)) = (state.bytes(), form) else { continue };
            let now = state.tree().map_or(0, Cells::bytes);
            if form.bytes() <= now + left {
                state.actions = Actions::Tree(form);
                left = (left + before).saturating_sub(state.bytes());
            }
        }
        self.count_bytes();
    }

    /// Counts again after states have changed in size.
    pub fn count_bytes(&mut self) {
        self.bytes = self.states.iter().map(State::bytes).sum();
    }

    pub fn states(&self) -> &[State] {
        &self.states
    }

    pub fn states_mut(&mut self) -> &mut [State] {
        &mut self.states
    }

    /// Bytes of the shard's states, snapshot included.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}
