//! What a film says of the picture before its render has ended, and films of several renders of one scene as one picture.

use super::RadianceLayer;
use super::accumulate::{Estimate, Film, MIN_GROUP};
use super::features::FeatureSums;
use super::picture::Picture;
use crate::film::Combine;

impl Film {
    /// As [`Self::resolve`], with all samples: what rendering would leave if it ended now.
    pub(crate) fn so_far(&self) -> Estimate {
        self.estimate(self.picture_so_far())
    }

    pub(super) fn picture_so_far(&self) -> Picture {
        let is_rest = self.group.samples < MIN_GROUP && !self.group.is_empty();
        match &self.pending {
            Some(before) if is_rest && self.allotted.is_none() => {
                self.picture_of(Some(&before.clone().joined(&self.group)), None)
            }
            _ => self.whole_picture(),
        }
    }

    /// All that it says of the picture, which that of other renders can join.
    pub(crate) fn into_joint(self) -> JointFilm {
        let picture = self.picture_so_far().that_tells_its_error(false);
        let by_samples = self.combine != Combine::InverseVariance || self.allotted.is_some();
        let alike = self.allotted.is_some();
        JointFilm {
            picture,
            by_samples,
            alike,
            features: self.features,
            layers: self.layers,
            size: [self.width, self.height],
        }
    }
}

/// What one film says of the picture, or several together.
pub(crate) struct JointFilm {
    pub(super) picture: Picture,
    /// Samples count alike, and nothing is known of their noise.
    pub(super) by_samples: bool,
    /// Its pixels count alike, however many samples each has: by their noise they were given them.
    pub(super) alike: bool,
    pub(super) features: FeatureSums,
    pub(super) layers: Vec<RadianceLayer>,
    pub(super) size: [u32; 2],
}

impl JointFilm {
    /// Joins the film of a render that drew other random numbers, of the same size and with the same layers.
    pub(crate) fn join(&mut self, other: JointFilm) {
        self.alike |= other.alike;
        self.picture.join(&other.picture, self.size[0], [self.by_samples || other.by_samples, self.alike]);
        self.features.join(other.features);
    }

    /// The picture with all that is known of it.
    pub(crate) fn finish(self) -> Estimate {
        let (features, ids) = self.features.finish();
        Estimate { features, ids, ..self.picture.estimate(self.size, &self.layers) }
    }
}
