//! What the page shows, and who looks at it.

use super::super::progress::Status;
use crate::image::Tone;
use crate::render::{Figures, Mode, Reason};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A page that has not asked for so long is closed.
const GONE: Duration = Duration::from_secs(10);
/// Pages that are waited for at the end.
const MOST_VISITORS: usize = 64;

/// Shared by the render and the server.
pub(super) struct Board {
    name: String,
    tone: Tone,
    shown: Mutex<Shown>,
}

#[derive(Default)]
pub(super) struct Shown {
    pub(super) status: Option<Status>,
    /// How the render ended.
    pub(super) ended: Option<String>,
    figures: Option<Figures>,
    picture: Option<Arc<[u8]>>,
    /// Pictures so far.
    number: u64,
    visitors: BTreeMap<u32, Visitor>,
}

/// A page that somebody has open.
struct Visitor {
    asked: Instant,
    /// Number of the picture that it has.
    has: u64,
    knows_the_end: bool,
}

impl Shown {
    /// Another picture, and what is known of it.
    pub(super) fn show(&mut self, picture: Vec<u8>, figures: Figures) {
        self.figures = Some(figures);
        self.show_bytes(picture);
    }

    pub(super) fn show_bytes(&mut self, picture: Vec<u8>) {
        self.picture = Some(picture.into());
        self.number += 1;
    }
}

impl Board {
    pub(super) fn new(name: &str, tone: Tone) -> Board {
        Board { name: name.to_owned(), tone, shown: Mutex::default() }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn change(&self, change: impl FnOnce(&mut Shown)) {
        change(&mut self.lock());
    }

    /// Whether anybody may want another picture; the first comes in any case.
    pub(super) fn is_watched(&self) -> bool {
        let shown = self.lock();
        shown.picture.is_none() || shown.visitors.values().any(|visitor| visitor.asked.elapsed() < GONE)
    }

    /// Whether a page that is open does not know the end yet, or has not the last picture.
    pub(super) fn is_waited_for(&self) -> bool {
        let shown = self.lock();
        let mut open = shown.visitors.values().filter(|visitor| visitor.asked.elapsed() < GONE);
        open.any(|visitor| !visitor.knows_the_end || visitor.has < shown.number)
    }

    /// The newest picture and its number.
    pub(super) fn picture(&self) -> Option<(Arc<[u8]>, u64)> {
        let shown = self.lock();
        Some((shown.picture.clone()?, shown.number))
    }

    /// That `visitor` has taken the picture of this number.
    pub(super) fn has_taken(&self, visitor: u32, number: u64) {
        self.lock().visitors.get_mut(&visitor).into_iter().for_each(|visitor| visitor.has = number);
    }

    /// All that is known, for a page that is told apart by a number of its own.
    pub(super) fn status(&self, visitor: Option<u32>) -> Value {
        let mut shown = self.lock();
        let knows_the_end = shown.ended.is_some();
        shown.visitors.retain(|_, visitor| visitor.asked.elapsed() < GONE);
        if let Some(id) = visitor
            && (shown.visitors.len() < MOST_VISITORS || shown.visitors.contains_key(&id))
        {
            let has = shown.visitors.get(&id).map_or(0, |visitor| visitor.has);
            shown.visitors.insert(id, Visitor { asked: Instant::now(), has, knows_the_end });
        }
        json!({
            "name": self.name,
            "tone": self.tone.name(),
            "progress": shown.status.as_ref().map(Status::json),
            "figures": shown.figures,
            "guide": shown.figures.as_ref().map(guide),
            "picture": shown.number,
            "ended": shown.ended,
        })
    }
}

/// What the guide does, in words.
fn guide(figures: &Figures) -> String {
    let reason = figures.verdict.map(|verdict| match verdict.reason {
        Reason::Calm => "bounced light makes too little of the noise",
        Reason::Short => "there is too little time to learn in",
        Reason::Promising => "it pays, or may",
        Reason::Losing => "it was tried, and did not pay",
    });
    match (figures.mode, &figures.guide, reason) {
        (_, None, _) | (Mode::Unguided, _, None) => "none".into(),
        (Mode::Pilot, ..) => "auto: not decided yet, the noise is being measured".into(),
        (Mode::Unguided, _, Some(reason)) => format!("auto: not used, since {reason}"),
        (Mode::Guided, Some(guide), None) => guide.method.into(),
        (Mode::Guided, Some(_), Some(reason)) => format!("auto: in use, since {reason}"),
    }
}
