//! What a film says of the picture before its render has ended, and films of several renders of one scene as one picture.

use super::RadianceLayer;
use super::accumulate::{Estimate, Film, MIN_GROUP};
use super::features::FeatureSums;
use super::group::IterationGroup;
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

    /// Standard error of the picture so far, relative to it: the root of the mean square over its pixels but for the noisiest, as
    /// iterations are weighed by ([`IterationGroup::weights`]). `None` for a picture that does not tell, or of a film that was not
    /// asked to.
    pub(crate) fn relative_error(&self) -> Option<f64> {
        let newest = Some(&self.group).filter(|group| group.samples >= MIN_GROUP);
        let own =
            |group: &IterationGroup| group.weights(self.width as usize, group).map(|weight| weight.unwrap_or(0.0));
        let [mut first, mut second] = match self.combine {
            _ if !self.tells_error || self.allotted.is_some() => return None,
            Combine::InverseVariance => self.picture_so_far().information()?,
            Combine::All => self.information,
            Combine::Last if newest.is_some() => [0.0; 2],
            Combine::Last => self.information,
        };
        if let Some(newest) = newest.filter(|_| self.combine != Combine::InverseVariance) {
            let [a, b] = own(newest);
            (first, second) = (first + a, second + b);
        }
        let known = first > 0.0 && second > 0.0;
        known.then(|| (0.5 * (first.recip() + second.recip())).sqrt())
    }

    /// All that it says of the picture, which that of other renders can join.
    pub(crate) fn into_joint(self) -> JointFilm {
        let picture = self.picture_so_far();
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
