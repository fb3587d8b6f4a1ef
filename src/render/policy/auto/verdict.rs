//! What was found of the guide: whether it pays, and why.

/// Whether the guide pays, and what that rests on.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Whether the guide is in use.
    pub guided: bool,
    /// Variance of one unguided sample, relative to the picture.
    pub variance: f64,
    /// The same of the light that bounced alone.
    pub bounced: f64,
    /// Unguided samples per pixel that the budget holds.
    pub budget: f64,
    /// Of these, what the guide has lost before the last iteration; negative where it has gained.
    pub lost: f64,
    pub reason: Reason,
    /// How the guide did in the iteration before the last, where it was tried.
    pub trial: Option<Trial>,
}

/// Why the guide is in use, or is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Bounced light is too small a part of the noise for any guide to pay.
    Calm,
    /// The budget is too short to learn in.
    Short,
    /// It is still learning, or pays.
    Promising,
    /// It was tried, and did not pay.
    Losing,
}

/// Guided samples against unguided ones.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Trial {
    /// Variance of one guided sample over that of an unguided one.
    pub variance_ratio: f64,
    /// The same of the cost of tracing it. Learning is left out: the last and longest iteration does not learn.
    pub cost_ratio: f64,
    /// The variance of the mean of n samples falls with n^−(1 + evenness).
    pub evenness: f64,
}

impl Trial {
    /// How many times the samples the guide is worth: how many unguided ones have a mean that varies as that of the guided ones does
    /// which cost as much as one.
    pub fn gain(&self) -> f64 {
        self.variance_ratio.powf(-1.0 / (1.0 + self.evenness)) / self.cost_ratio
    }

    /// What a group of so many guided samples brings to a picture that could have as many unguided ones as `budget`: the number of these,
    /// if each brings the same, that have so precise a mean. A small group is less even than they are all together.
    pub fn worth(&self, samples: f64, budget: f64) -> f64 {
        samples / self.variance_ratio * (samples / budget).powf(self.evenness)
    }
}
