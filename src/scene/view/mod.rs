//! The automatic camera: where to stand, and where to look, so that a model is seen that nobody has placed a camera in.
//!
//! Everything is decided by rays. From places inside the box about the model they say whether it is a room there (surfaces in
//! most directions, and light that arrives) or something that is seen from outside. Views from inside and from outside are
//! then compared by how many pieces of the surface they show where light arrives. Nothing depends on the model's size, on how
//! finely it is tessellated, or on the number of threads. What the user has said of the camera is kept.

mod axes;
mod candidates;
mod darkness;
mod framing;
mod header;
mod light;
mod pieces;
mod rating;
mod standpoints;
mod subject;

pub(crate) use darkness::why_dark;

use super::Scene;
use super::description::{CameraDescription, Projection, SceneDescription, Unsaid};
use crate::film::FilmSettings;
use axes::Axes;
use candidates::Candidate;
use glam::{DAffine3, Vec3};
use pieces::Pieces;
use rating::Rating;
use standpoints::Standpoint;
use subject::Subject;

/// A camera that was found.
#[derive(Clone, Debug)]
pub(crate) struct FoundCamera {
    /// All of it, in the coordinates of the scene's files.
    pub(crate) camera: CameraDescription,
    /// Whether it shows the model from outside, whole.
    pub(crate) outside: bool,
    /// Whether light arrives there.
    pub(crate) lit: bool,
}

/// What is known while a view is looked for.
struct Search<'a> {
    scene: &'a Scene,
    axes: Axes,
    subject: Subject,
    pieces: Pieces,
    sphere: Vec<Vec3>,
    /// Width of the picture over its height.
    aspect: f32,
    // What the user has said.
    origin: Option<Vec3>,
    target: Option<Vec3>,
    vfov: Option<f32>,
}

/// What is said of the camera, by a model that is a scene of its own about what is up, too.
pub(super) fn said(description: &SceneDescription) -> CameraDescription {
    let mut camera = description.camera.clone().unwrap_or_else(CameraDescription::open);
    if let [model] = &*description.meshes
        && camera.unsaid.up
        && model.transform == DAffine3::IDENTITY
        && let Some(up) = model.source.path().and_then(header::up_of_file)
    {
        camera.up = up;
    }
    camera
}

/// Completes what is said of a camera, of which at least origin or target is not.
pub(super) fn find(scene: &Scene, said: &CameraDescription, film: &FilmSettings) -> FoundCamera {
    let Unsaid { origin, target, vfov, .. } = said.unsaid;
    let given = |unsaid: bool, value: Vec3| (!unsaid).then_some(value);
    let axes = Axes::new(said.up);
    let subject = Subject::of(scene, &axes);
    let search = Search {
        scene,
        axes,
        subject,
        pieces: Pieces::of(&subject),
        sphere: standpoints::sphere(&axes),
        aspect: film.width as f32 / film.height as f32,
        origin: given(origin, said.origin.as_vec3()),
        target: given(target, said.target.as_vec3()),
        vfov: (!vfov).then_some(said.vfov),
    };
    let (view, rating) = search.run();
    FoundCamera { camera: search.describe(&view, said), outside: view.whole, lit: rating.light >= light::LEAST }
}

impl Search<'_> {
    fn run(&self) -> (Candidate, Rating) {
        let of_interest;
        let places = match self.origin {
            Some(origin) => {
                of_interest = None;
                vec![Standpoint::new(self.scene, &self.pieces, &self.sphere, origin, 0.0)]
            }
            None => {
                let places = standpoints::inside(self);
                of_interest = standpoints::rooms(&places);
                places
            }
        };
        let (view, rating) = self.best(&self.candidates(&places), of_interest.as_ref());
        (self.settled(view), rating)
    }

    /// The view as one would write it. What is in the middle of the picture is its target, at the distance of the model's
    /// size where nothing is.
    fn describe(&self, view: &Candidate, said: &CameraDescription) -> CameraDescription {
        let (view, height) = match said.projection {
            Projection::Orthographic => self.flattened(*view),
            Projection::Perspective | Projection::Panorama => (*view, said.view_height),
        };
        let Candidate { origin, gaze, .. } = view;
        let middle = self.pieces.seen(self.scene, origin, &[gaze.forward])[0];
        let (low, high) = self.scene.bounds();
        let distance = middle.map_or((high - low).length(), |sight| sight.distance);
        CameraDescription {
            origin: if said.unsaid.origin { origin.as_dvec3() } else { said.origin },
            target: if said.unsaid.target { (origin + gaze.forward * distance).as_dvec3() } else { said.target },
            up: if self.axes.up.dot(gaze.up) > 1e-4 { self.axes.up } else { gaze.up },
            vfov: self.vfov.unwrap_or(gaze.vfov()),
            view_height: if said.unsaid.view_height { height } else { said.view_height },
            unsaid: Unsaid::default(),
            ..said.clone()
        }
    }
}

/// Whether any light is found along rays through the whole picture of the scene's camera.
pub(super) fn is_lit(scene: &Scene) -> bool {
    light::reaches(scene)
}

#[cfg(test)]
mod tests;
