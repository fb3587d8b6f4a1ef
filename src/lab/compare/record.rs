//! What is known of a run, and of a reference: the lines of runs.jsonl.

use serde::{Deserialize, Deserializer, Serialize};
use std::path::{Path, PathBuf};

/// One run: one scene, method, budget and seed. Errors are against the scene's reference, whose own noise is taken off
/// where it is known. A measure that is not finite is NaN, written as null.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    pub(crate) scene: String,
    pub(crate) method: String,
    pub(crate) budget: String,
    pub(crate) seed: u64,
    /// Samples per pixel that were traced, those of discarded iterations too.
    pub(crate) samples: u32,
    /// Wall time from the guide's making to the last sample: learning counts, loading and files do not.
    pub(crate) wall_seconds: f64,
    /// Processor time over the same, of all threads.
    pub(crate) cpu_seconds: f64,
    /// Wall time that learning took, on average over all threads.
    pub(crate) learn_wall_seconds: f64,
    /// Wall time in which one picture was made of the iterations, after `wall_seconds`.
    pub(crate) film_wall_seconds: f64,
    #[serde(flatten)]
    pub(crate) errors: RunErrors,
    /// Mean of the picture.
    pub(crate) mean: [f64; 3],
    /// Samples that were not finite and count as black.
    pub(crate) non_finite: u64,
    /// Pixels of the picture that are not finite.
    #[serde(default)]
    pub(crate) broken_pixels: u64,
    /// Pixels of the picture that are negative: where roulette ends a path, the light that is expected of it is added and taken away
    /// elsewhere, so that noise may go below 0.
    #[serde(default)]
    pub(crate) negative_pixels: u64,
    pub(crate) rays: u64,
    pub(crate) shadow_rays: u64,
    pub(crate) paths: u64,
    /// Segments of a camera path, splits included.
    pub(crate) mean_path_length: f64,
    /// Share of camera paths that brought nothing.
    pub(crate) zero_share: f64,
    pub(crate) guide_bytes: u64,
    pub(crate) guide_states: u64,
    /// The most memory that the process held during the run, all of its scenes included; where the system says so.
    pub(crate) peak_bytes: Option<u64>,
    pub(crate) iterations: Vec<Iteration>,
    /// Mean luminance of blocks of the picture, for the test of bias.
    pub(crate) blocks: Vec<f64>,
}

impl Run {
    /// relMSE, infinite where there is none.
    pub(crate) fn badness(&self) -> f64 {
        if self.errors.relmse.is_nan() { f64::INFINITY } else { self.errors.relmse }
    }
}

/// How far a run's picture is from the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunErrors {
    #[serde(deserialize_with = "nullable")]
    pub(crate) mse: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) relmse: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) relmse_trimmed: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) mape: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) smape: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) flip: f64,
    #[serde(deserialize_with = "nullable")]
    pub(crate) worst_permille: f64,
}

/// One iteration of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Iteration {
    pub(crate) samples: u32,
    pub(crate) wall_seconds: f64,
    pub(crate) learn_wall_seconds: f64,
    pub(crate) mean_path_length: f64,
    pub(crate) zero_share: f64,
    /// Share of the vertices that asked the guide where it knew an answer.
    pub(crate) guide_hit_share: f64,
}

/// Where a scene's reference comes from and how good it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ReferenceRecord {
    pub(crate) source: Source,
    /// Of one that was made, within the comparison's folder.
    pub(crate) path: String,
    /// Samples per pixel, where it was made.
    pub(crate) samples: Option<u32>,
    pub(crate) wall_seconds: Option<f64>,
    /// relMSE of its own, where its variance is known.
    pub(crate) relmse_noise: Option<f64>,
}

impl ReferenceRecord {
    /// Where the picture is, of a comparison whose folder is `folder`.
    pub(crate) fn file(&self, folder: &Path) -> PathBuf {
        match self.source {
            Source::File => PathBuf::from(&self.path),
            Source::Made => folder.join(&self.path),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Source {
    File,
    Made,
}

fn nullable<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}
