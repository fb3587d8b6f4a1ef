//! What was found of the guide: whether it pays, and why.

/// What was found.
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
    /// Of these, what the guide has cost before the last iteration; less than none where it has gained.
    pub lost: f64,
    pub reason: Reason,
    /// How the guide did in the iteration before the last, where it was tried.
    pub trial: Option<Trial>,
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// So little of what varies is bounced light that no guide could pay.
    Calm,
    /// The budget is too short to learn in.
    Short,
    /// It is still learning, or pays.
    Promising,
    /// It was tried, and did not pay.
    Losing,
}

/// The guide against none.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Trial {
    /// Of one sample; below 1 the guide's vary less.
    pub variance_ratio: f64,
    /// Of one sample that nothing is learnt from, as in the last iteration; above 1 the guide's cost more.
    pub cost_ratio: f64,
}

impl Trial {
    /// Efficiency of rendering with the guide over that without.
    pub fn gain(&self) -> f64 {
        1.0 / (self.variance_ratio * self.cost_ratio)
    }
}
