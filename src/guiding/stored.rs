//! What of a guide outlives a render: all that it has learnt, and nothing that can be made of that again.

use super::learner::{Learner, Table};
use super::qtable::{Actions, State};
use super::states::States;
use super::tables::Tables;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What a guide has learnt, by the kind of guide. Variants are told apart by their order: new ones come last.
#[derive(Serialize, Deserialize)]
pub(super) enum Stored<'g> {
    Table(StoredTable<'g>),
}

#[derive(Serialize, Deserialize)]
pub(super) struct StoredTable<'g> {
    /// How often each coarse cell of an adaptive grid was halved; of others nothing.
    levels: Cow<'g, [u8]>,
    /// By shard, in the order in which they were met.
    shards: Vec<Cow<'g, [State]>>,
    ended: bool,
}

impl Tables {
    /// `None` for states that are not kept in files: Voronoi sites.
    pub(super) fn stored(&self) -> Option<Stored<'_>> {
        let levels = match &self.states {
            States::Grid(_) => &[],
            States::Adaptive(adaptive) => adaptive.levels(),
            States::Voronoi(_) => return None,
        };
        let shards = self.learner.shards().iter().map(|shard| Cow::Borrowed(shard.states())).collect();
        Some(Stored::Table(StoredTable { levels: Cow::Borrowed(levels), shards, ended: self.ended }))
    }

    /// Puts back what an empty guide of the same settings has learnt; its snapshot is then that of the guide that was
    /// stored.
    ///
    /// # Errors
    /// Where that is not what such a guide can have learnt, or is more than its memory holds.
    pub(super) fn restore(&mut self, stored: Stored) -> Result<(), String> {
        let Stored::Table(StoredTable { levels, shards, ended }) = stored;
        let levels_fit = match &mut self.states {
            States::Grid(_) => levels.is_empty(),
            States::Adaptive(adaptive) => adaptive.set_levels(levels.into_owned()),
            States::Voronoi(_) => false,
        };
        if !levels_fit {
            return Err("its cells are not those of this grid".into());
        }
        for state in shards.into_iter().flat_map(Cow::into_owned) {
            self.restore_state(state)?;
        }
        if self.learner.bytes() > self.learner.memory() {
            let (takes, has) = (self.bytes() >> 20, self.learner.memory() >> 20);
            return Err(format!("the guide takes {takes} MiB, and guiding.memory leaves {has} MiB"));
        }
        self.ended = ended;
        self.refresh();
        Ok(())
    }

    fn restore_state(&mut self, state: State) -> Result<(), String> {
        let known = self.learner.get(state.key).is_some();
        if known || !self.states.holds(state.key) || !is_plausible(&state) || !fits(&state, &self.learner) {
            return Err(format!("state {:016x} is not one that a guide can have learnt", state.key.0));
        }
        self.learner.restore(state);
        Ok(())
    }
}

/// Whether the state's directions are those of the table.
fn fits(state: &State, learner: &Learner) -> bool {
    match (&state.actions, &learner.table) {
        (Actions::Strata(entries), Table::Strata(strata)) => entries.len() == strata.count(),
        (Actions::Tree(cells), Table::Tree(_)) => cells.is_sound(),
        _ => false,
    }
}

/// Whether the numbers that sampling relies on are of the range that learning keeps them in. The moments of returns
/// decide only how many paths go on, which is bounded whatever they are.
fn is_plausible(state: &State) -> bool {
    let amount = |x: f32| x >= 0.0 && x.is_finite();
    (state.normal.length() - 1.0).abs() < 1e-3
        && amount(state.visits)
        && amount(state.fresh)
        && state.fraction.logit.is_finite()
        && state.entries().iter().all(|entry| amount(entry.q) && amount(entry.visits))
}
