//! All that a guide takes from one moment of a render to the next, also in the middle of an iteration.
//!
//! A stored guide says what was learnt; the snapshot is made of that. In the middle of an iteration the snapshot is older
//! than what has been learnt since, so that what it was made of is remembered beside.

use super::directional::{DirectionalModel, Model};
use super::guide::Guide;
use super::persist::Stored;
use super::spatial::{Gathered, Partition, SpatialPartition};
use super::store::StoreLimits;
use serde::{Deserialize, Serialize};

/// What was learnt by some moment, and what it takes to go on from there to the same bits.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct GuideState<'g, S: SpatialPartition = Partition, D: DirectionalModel = Model> {
    learnt: Stored<'g, S, D>,
    /// What the snapshot was made of, where that is something else.
    frozen: Option<Stored<'g, S, D>>,
    gathered: Option<Gathered>,
    limits: StoreLimits,
    growth: f64,
}

impl<S: SpatialPartition, D: DirectionalModel> Guide<S, D> {
    /// Remembers what the snapshot was made of, before more is learnt, so that [`Self::state`] can be asked for until the
    /// next snapshot. Of a guide whose snapshot follows what is learnt that is not needed.
    pub fn remember(&mut self, follows: bool) {
        let needed = !(follows && self.refreshes());
        self.remembered = needed.then(|| self.stored().into_owned());
    }

    /// All that [`Self::resume`] needs.
    pub fn state(&self) -> GuideState<'_, S, D> {
        GuideState {
            learnt: self.stored(),
            frozen: self.remembered.as_ref().map(Stored::borrowed),
            gathered: self.partition.gathered(),
            limits: self.store.limits(),
            growth: self.growth,
        }
    }

    /// Makes a new guide of the same settings what the one was whose state is given.
    ///
    /// # Errors
    /// Where no guide of these settings can have that state.
    pub fn resume(&mut self, state: GuideState<S, D>) -> Result<(), String> {
        let GuideState { learnt, frozen, gathered, limits, growth } = state;
        if let Some(frozen) = frozen {
            self.take_over(frozen)?;
            self.freeze();
            self.remember(false);
            self.store.clear();
        }
        let changed = self.remembered.is_some();
        self.take_over(learnt)?;
        if !changed {
            self.freeze();
        }
        gathered.into_iter().for_each(|gathered| self.partition.restore_gathered(gathered));
        self.store.set_limits(limits)?;
        self.growth = growth;
        Ok(())
    }
}
