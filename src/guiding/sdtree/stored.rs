//! A tree in a file: all that it has learnt, and whether what is read can be such.

use super::{Frozen, Learner, SdTree};
use crate::guiding::bsdf_fraction::Fraction;
use crate::guiding::directional::quadtree::building::Building;
use crate::guiding::directional::quadtree::frozen::Node;
use crate::math::is_amount;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What a tree has learnt; cube and settings are the reader's own.
#[derive(Serialize, Deserialize)]
pub struct StoredTree<'t> {
    spatial: Cow<'t, [u32]>,
    frozen: Cow<'t, [Frozen]>,
    nodes: Cow<'t, [Node]>,
    learners: Cow<'t, [Learner]>,
}

impl SdTree {
    pub fn stored(&self) -> StoredTree<'_> {
        StoredTree {
            spatial: Cow::Borrowed(self.spatial.nodes()),
            frozen: Cow::Borrowed(&self.frozen),
            nodes: Cow::Borrowed(&self.nodes),
            learners: Cow::Borrowed(&self.learners),
        }
    }

    /// Takes over what a tree in the same cube has learnt.
    ///
    /// # Errors
    /// Where that is not what a tree can have learnt, or is more than the memory holds.
    pub fn restore(&mut self, stored: StoredTree) -> Result<(), String> {
        let StoredTree { spatial, frozen, nodes, learners } = stored;
        let wrong = |what: &str| Err(format!("the {what} of the SD-tree are not ones that it can have"));
        let Some(leaves) = self.spatial.replaced(spatial.into_owned(), learners.len()) else {
            return wrong("cells");
        };
        let placed = |(at, learner): (&(u32, u32), &Learner)| *at == (learner.node, learner.depth);
        if frozen.len() != learners.len() || !leaves.iter().zip(&*learners).all(placed) {
            return wrong("cells");
        }
        if !frozen.iter().all(|leaf| leaf.is_sound(&nodes)) || !learners.iter().all(Learner::is_sound) {
            return wrong("leaves");
        }
        (self.frozen, self.nodes) = (frozen.into_owned(), nodes.into_owned());
        self.learners = learners.into_owned();
        let (takes, has) = (self.bytes() >> 20, self.memory >> 20);
        match self.bytes() <= self.memory {
            true => Ok(()),
            false => Err(format!("the guide takes {takes} MiB, and guiding.memory leaves {has} MiB")),
        }
    }
}

impl Frozen {
    /// Whether it has a quadtree among `all` nodes, or none, and numbers that sampling can rely on.
    fn is_sound(&self, all: &[Node]) -> bool {
        let own = all.get(self.first as usize..).and_then(|rest| rest.get(..self.nodes as usize));
        let sampled = (0.0..=1.0).contains(&self.fraction) && is_amount(self.mean as f64);
        sampled && own.is_some_and(|own| own.is_empty() || Node::are_sound(own))
    }
}

impl Learner {
    fn is_sound(&self) -> bool {
        is_amount(self.last_visits) && Building::is_sound(&self.quadtree) && Fraction::is_sound(&self.fraction)
    }
}
