//! The serialised form of a guide: what it has learnt. Snapshots are made again when a guide is loaded.

use super::learner::{Learner, Table};
use super::ppg::PpgGuide;
use super::sdtree::StoredTree;
use super::tables::Tables;
use super::{Guide, Kind};
use crate::guiding::spatial::States;
use crate::guiding::spatial::voronoi::{Site, Voronoi};
use crate::guiding::store::{Actions, ReturnMoments, State};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

/// What a guide has learnt, by the kind of guide. Variants are told apart by their order: new ones come last.
#[derive(Serialize, Deserialize)]
pub enum Stored<'g> {
    Tables(StoredTables<'g>),
    PpgGuide(StoredLeaves<'g>),
}

#[derive(Serialize, Deserialize)]
pub struct StoredTables<'g> {
    /// How often each coarse cell of an adaptive grid was halved; of others nothing.
    levels: Cow<'g, [u8]>,
    /// Of Voronoi states, by state; of others nothing.
    sites: Vec<Site>,
    /// By shard, in the order in which they were met.
    shards: Vec<Cow<'g, [State]>>,
    ended: bool,
}

#[derive(Serialize, Deserialize)]
pub struct StoredLeaves<'g> {
    tree: StoredTree<'g>,
    returns: Cow<'g, [ReturnMoments]>,
}

impl Guide {
    pub fn stored(&self) -> Stored<'_> {
        match &self.kind {
            Kind::Tables(tables) => Stored::Tables(tables.stored()),
            Kind::PpgGuide(leaves) => Stored::PpgGuide(leaves.stored()),
        }
    }

    /// Puts back what a guide of the same settings has learnt, where this one is empty; its snapshot is then that of the
    /// guide that was stored.
    ///
    /// # Errors
    /// Where that is not what such a guide can have learnt, or is more than its memory holds.
    pub fn restore(&mut self, stored: Stored) -> Result<(), String> {
        match (&mut self.kind, stored) {
            (Kind::Tables(tables), Stored::Tables(stored)) => tables.restore(stored),
            (Kind::PpgGuide(leaves), Stored::PpgGuide(stored)) => leaves.restore(stored),
            _ => Err("what was learnt is of another kind than guiding.method asks for".into()),
        }
    }
}

impl PpgGuide {
    fn stored(&self) -> StoredLeaves<'_> {
        StoredLeaves { tree: self.tree.stored(), returns: Cow::Borrowed(&self.returns) }
    }

    fn restore(&mut self, stored: StoredLeaves) -> Result<(), String> {
        self.tree.restore(stored.tree)?;
        if stored.returns.len() != self.tree.leaves() {
            return Err("the leaves of the SD-tree are not ones that it can have".into());
        }
        self.returns = stored.returns.into_owned();
        self.summarise();
        Ok(())
    }
}

impl Tables {
    fn stored(&self) -> StoredTables<'_> {
        let (levels, sites): (&[u8], _) = match &self.states {
            States::Grid(_) => (&[], Vec::new()),
            States::Adaptive(adaptive) => (adaptive.levels(), Vec::new()),
            States::Voronoi(voronoi) => (&[], voronoi.iter().flat_map(|voronoi| voronoi.sites()).collect()),
        };
        let shards = self.learner.shards().iter().map(|shard| Cow::Borrowed(shard.states())).collect();
        StoredTables { levels: Cow::Borrowed(levels), sites, shards, ended: self.ended }
    }

    fn restore(&mut self, stored: StoredTables) -> Result<(), String> {
        let StoredTables { levels, sites, shards, ended } = stored;
        self.restore_states(levels.into_owned(), sites)?;
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

    fn restore_states(&mut self, levels: Vec<u8>, sites: Vec<Site>) -> Result<(), String> {
        let fits = match &mut self.states {
            States::Grid(_) => levels.is_empty() && sites.is_empty(),
            States::Adaptive(adaptive) => sites.is_empty() && adaptive.set_levels(levels),
            States::Voronoi(_) => levels.is_empty(),
        };
        if !fits {
            return Err("its cells are not those of this grid".into());
        }
        if sites.is_empty() {
            return Ok(());
        }
        let count = sites.len();
        if count.saturating_mul(Voronoi::bytes_per_site()) > self.memory {
            return Err(format!("its {count} sites take more than guiding.memory"));
        }
        // the sites themselves stand for the points where look-ups are to be expected
        let about: Vec<_> = sites.iter().map(|site| (site.p, site.n)).collect();
        let voronoi = Voronoi::new(sites, &about).filter(|voronoi| voronoi.len() == count);
        self.place(Arc::new(voronoi.ok_or("its sites are not ones that states can have")?));
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
