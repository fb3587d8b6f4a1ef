//! Large pictures, of which a guide has had enough before an iteration ends: it must have learnt from all of the picture.

use crate::common::Loaded;
use crate::common::hall::hall;
use phototaxis::guiding::settings::GuidingMethod;
use phototaxis::inspect::PixelVertex;
use phototaxis::render::{GuideIo, Rendering, Settings, render_keeping};

/// Pixels between those that are looked at.
const STEP: usize = 8;

/// Renders one sample per pixel, from which the guide learns.
fn learnt(loaded: &Loaded) -> Rendering {
    let mut settings: Settings = loaded.settings.clone();
    (settings.guiding.method, settings.render.spp) = (GuidingMethod::Adaptive, 1);
    render_keeping(&loaded.scene, &settings, GuideIo { from: None, keep: true }, &mut |_| true)
}

/// Whether the guide has left out some of what there was to learn from: a path of n segments makes n − 1 transitions.
pub fn had_enough(rendering: &Rendering) -> bool {
    let counters = &rendering.iterations[0].counters;
    counters.transitions < (counters.rays - counters.paths) * 9 / 10
}

/// Mean number of visits of the states seen in the upper, middle and lower third of a picture.
fn visits(loaded: &Loaded, rendering: &Rendering) -> [f64; 3] {
    let guide = rendering.guide.as_ref().expect("there is a guide");
    let (width, height) = (loaded.scene.camera.width, loaded.scene.camera.height);
    let mut sums = [(0.0, 0.0); 3];
    for (x, y) in (0..height).step_by(STEP).flat_map(|y| (0..width).step_by(STEP).map(move |x| (x, y))) {
        let seen = PixelVertex::through(&loaded.scene, x, y).expect("the hall is closed");
        let visits = seen.state(guide).and_then(|key| guide.visits(key)).unwrap_or(0.0);
        let third = &mut sums[(3 * y / height) as usize];
        *third = (third.0 + f64::from(visits), third.1 + 1.0);
    }
    sums.map(|(sum, pixels)| sum / pixels)
}

#[test]
fn a_guide_learns_from_all_of_a_picture() {
    let [upright, turned] = [1, -1].map(|up| {
        let loaded = hall(up, &["film.width=1280", "film.height=720"]);
        let rendering = learnt(&loaded);
        assert!(had_enough(&rendering), "the picture is too small to tell");
        visits(&loaded, &rendering)
    });
    println!("visits by thirds: {upright:.0?}; of the picture upside down: {turned:.0?}");
    for k in 0..3 {
        // the same part of the hall
        let ratio = upright[k] / turned[2 - k];
        assert!((ratio - 1.0).abs() < 0.1, "third {k}: {ratio:.2} times the visits, {upright:?} {turned:?}");
    }
}
