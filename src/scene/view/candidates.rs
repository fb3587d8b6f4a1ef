//! Views that are worth a closer look.

use super::Search;
use super::axes::{Gaze, lens};
use super::framing::{looking_at, parallel, standing_back, zoomed};
use super::pieces::count;
use super::standpoints::Standpoint;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Focal length in rooms, in mm: the usual wide angle of pictures of interiors.
const WIDE: f32 = 24.0;
/// Focal length for objects, in mm: the usual one, with which nothing looks distorted.
const NORMAL: f32 = 50.0;
/// Directions about the axis that is up.
const AZIMUTHS: usize = 24;
/// From how far above objects are looked at, in degrees.
const ELEVATIONS: [f32; 3] = [10.0, 20.0, 35.0];
/// Views inside that are looked at more closely, and how many of them from one place.
const KEPT: usize = 24;
const KEPT_OF_ONE: usize = 2;
/// Triangles whose corners stand for the model while views are compared, and those that do for the view that is chosen.
const OUTLINE: usize = 2048;
const FULL_OUTLINE: usize = 1 << 22;

/// A view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) origin: Vec3,
    pub(super) gaze: Gaze,
    /// Whether the camera stands where the whole model is in the picture.
    pub(super) whole: bool,
}

impl Search<'_> {
    /// All views.
    pub(super) fn candidates(&self, places: &[Standpoint]) -> Vec<Candidate> {
        let mut views = self.inside(places);
        match self.origin {
            Some(origin) => views.push(self.towards_model(origin)),
            None => views.extend(self.outside()),
        }
        views
    }

    /// From places in rooms, level: those in which most is seen by the rays that have looked about there.
    fn inside(&self, places: &[Standpoint]) -> Vec<Candidate> {
        let usable = |place: &&Standpoint| self.origin.is_some() || (place.indoors && place.clear && place.lit);
        let places: Vec<&Standpoint> = places.iter().filter(usable).collect();
        let rated = places.par_iter().flat_map_iter(|place| self.about(place));
        let mut rated: Vec<(usize, Candidate)> = rated.collect();
        rated.sort_by_key(|(seen, _)| std::cmp::Reverse(*seen));
        let of_one = if self.origin.is_some() { KEPT } else { KEPT_OF_ONE };
        let mut kept: Vec<Candidate> = Vec::new();
        for (_, view) in rated {
            if kept.len() < KEPT && kept.iter().filter(|other| other.origin == view.origin).count() < of_one {
                kept.push(view);
            }
        }
        kept
    }

    /// All views from one place, with how many pieces its rays see in them.
    fn about(&self, place: &Standpoint) -> Vec<(usize, Candidate)> {
        let origin = place.place;
        let directions = match self.target {
            Some(target) => (target - origin).try_normalize().into_iter().collect(),
            None => (0..AZIMUTHS).map(|k| self.axes.direction(azimuth(k), 0.0)).collect::<Vec<_>>(),
        };
        let view = |forward| {
            let gaze = Gaze::new(forward, &self.axes, self.lens(WIDE));
            let within = self.sphere.iter().zip(&place.sights).filter(|(dir, _)| gaze.sees(**dir));
            let seen = count(within.filter_map(|(_, sight)| *sight).map(|sight| sight.piece));
            (seen, Candidate { origin, gaze, whole: false })
        };
        directions.into_iter().map(view).collect()
    }

    /// From all around, the model filling the picture.
    fn outside(&self) -> Vec<Candidate> {
        let outline: Vec<Vec3> = self.subject.outline(self.scene, OUTLINE).collect();
        let view = |k: usize| {
            let elevation = ELEVATIONS[k / AZIMUTHS].to_radians();
            let forward = -self.axes.direction(azimuth(k % AZIMUTHS), elevation);
            let gaze = Gaze::new(forward, &self.axes, self.lens(NORMAL));
            Candidate { origin: self.standing(outline.iter().copied(), &gaze), gaze, whole: true }
        };
        (0..AZIMUTHS * ELEVATIONS.len()).map(view).collect()
    }

    /// Where the model fills the picture of a camera with this gaze.
    fn standing(&self, outline: impl Iterator<Item = Vec3>, gaze: &Gaze) -> Vec3 {
        match self.target {
            Some(target) => looking_at(outline, gaze, target),
            None => standing_back(outline, gaze, self.subject.centre()),
        }
    }

    /// From a place that was given.
    fn towards_model(&self, origin: Vec3) -> Candidate {
        let forward = (self.subject.centre() - origin).try_normalize().unwrap_or(-self.axes.front);
        let gaze = Gaze::new(forward, &self.axes, self.lens(WIDE));
        let narrow = zoomed(self.subject.outline(self.scene, FULL_OUTLINE), &gaze, origin, self.aspect);
        let narrow = narrow.filter(|half| self.vfov.is_none() && half[0] < gaze.half[0]);
        Candidate { origin, gaze: Gaze { half: narrow.unwrap_or(gaze.half), ..gaze }, whole: false }
    }

    /// The view with all of the model in its picture, where that is what it is for.
    pub(super) fn settled(&self, view: Candidate) -> Candidate {
        let origin = || self.standing(self.subject.outline(self.scene, FULL_OUTLINE), &view.gaze);
        Candidate { origin: if view.whole { origin() } else { view.origin }, ..view }
    }

    /// The same for parallel rays, and how high its picture has to be: where the model is not whole in it, as high as that
    /// of the lens is at the middle of what is to be seen.
    pub(super) fn flattened(&self, view: Candidate) -> (Candidate, f32) {
        let Candidate { origin, gaze, whole } = view;
        if !whole {
            let depth = (self.subject.centre() - origin).dot(gaze.forward).abs();
            return (view, 2.0 * gaze.half[1] * depth);
        }
        let points = self.subject.outline(self.scene, FULL_OUTLINE);
        let (middle, height) = parallel(points, &gaze, origin, (self.aspect, self.target.is_some()));
        let origin = origin + gaze.right * middle[0] + gaze.up * middle[1];
        (Candidate { origin, ..view }, height)
    }

    /// The field of view that was given, else that of a lens.
    fn lens(&self, focal_length: f32) -> [f32; 2] {
        match self.vfov {
            Some(vfov) => {
                let half = (0.5 * vfov.to_radians()).tan();
                [half * self.aspect, half]
            }
            None => lens(focal_length, self.aspect),
        }
    }
}

fn azimuth(k: usize) -> f32 {
    TAU * k as f32 / AZIMUTHS as f32
}
