//! What a guide knows, as pictures in PNG and EXR.

use crate::draw::short;
use crate::guiding::Guide;
use crate::image::exr::{self, Metadata, Window};
use crate::image::{Image, Layer, ViewTransform, png};
use crate::inspect::picture::Chart;
use crate::inspect::sheet::{Bar, Panel, sheet};
use crate::inspect::{Layers, PixelVertex, Radiance};
use crate::math::Rgb;
use crate::platform::Platform;
use crate::scene::Scene;
use anyhow::Result;
use std::path::Path;

/// Share of the traced directions that are darker than what is shown white.
const WHITE: f64 = 0.995;

/// Marks of directions over the sphere, from left to right and from the top.
const AROUND: &[(f64, &str)] = &[(0.0, "-z"), (0.25, "+x"), (0.5, "+z"), (0.75, "-x"), (1.0, "-z")];
const UPWARDS: &[(f64, &str)] = &[(0.0, "+y"), (0.5, "horizon"), (1.0, "-y")];
/// The same over the hemisphere.
const ACROSS: &[(f64, &str)] = &[(0.0, "-s"), (0.5, "normal"), (1.0, "+s")];
const ALONG: &[(f64, &str)] = &[(0.0, "+t"), (0.5, "normal"), (1.0, "-t")];

const RADIANCE: &str = "In the scene's own unit; what is brighter than the bar's end is white. Dark blue: no direction, or one of \
    which nothing is known.";
const STATES: &str = "A colour at random for each state; black: none was met. Marks count pixels.";

/// Where pictures go, and what their headers say.
pub(crate) struct Pictures<'a> {
    pub(crate) folder: &'a Path,
    /// Before the names of all files.
    pub(crate) prefix: &'a str,
    pub(crate) scene: &'a Scene,
    pub(crate) seed: u64,
    /// Paths for each direction of the truth.
    pub(crate) samples: u32,
}

impl Pictures<'_> {
    /// Learnt beside traced, over the sphere and over the state's hemisphere.
    pub(crate) fn radiance(&self, guide: &Guide, seen: &PixelVertex, radiance: &Radiance) -> Result<()> {
        let (view, normal) = (seen.state(guide).and_then(|key| guide.view(key)), seen.normal());
        let unit = self.scene.light_unit().value();
        let learnt = |w| Some((unit * f64::from(view.as_ref()?.q(normal, w)?)) as f32);
        let traced = |w| radiance.traced(w);
        let white = radiance.quantile(WHITE).max(f32::MIN_POSITIVE);
        let charts = [
            ("latlong", Chart::lat_long(learnt), Chart::lat_long(traced), AROUND, UPWARDS),
            ("hemisphere", Chart::disk(&radiance.frame, learnt), Chart::disk(&radiance.frame, traced), ACROSS, ALONG),
        ];
        let names = ["learnt".into(), format!("traced, {} paths a direction", self.samples)];
        let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|at| (at, short(at * f64::from(white))));
        let bar = Bar { colour: Rgb::splat, ticks: &ticks, label: "radiance, luminance" };
        for (name, learnt, traced, x, y) in &charts {
            let layers =
                [("learnt", learnt), ("traced", traced)].map(|(name, c)| Layer::scalar(name, "Y", c.or_zero()));
            let [x, y] = [x, y].map(|marks| marks.iter().map(|(at, text)| (*at, text.to_string())).collect::<Vec<_>>());
            let images = [learnt, traced].map(|chart| chart.picture(white));
            let panels: Vec<Panel> =
                names.iter().zip(&images).map(|(name, image)| Panel { name, image, x: &x, y: &y }).collect();
            let sheet = sheet("Radiance that arrives at the place, by direction", RADIANCE, &panels, Some(&bar))?;
            self.write(name, &sheet, (learnt.width, learnt.height), layers.into())?;
        }
        Ok(())
    }

    /// Which state each pixel shows.
    pub(crate) fn states(&self, layers: &Layers) -> Result<()> {
        let (states, shares) = (layers.false_colours(), layers.shares());
        let marks = |size: usize| [0.0, 0.5, 1.0].map(|at| (at, format!("{:.0}", at * size as f64)));
        let (x, y) = (marks(states.width), marks(states.height));
        let count = format!("states, {} of them", layers.states());
        let panels = [(&*count, &states), ("share of directions drawn by the guide", &shares)]
            .map(|(name, image)| Panel { name, image, x: &x, y: &y });
        let ticks = [0.0, 0.25, 0.5, 0.75, 1.0].map(|at| (at, short(at)));
        let bar = Bar { colour: Rgb::splat, ticks: &ticks, label: "share" };
        let sheet = sheet("What the guide knows, pixel by pixel", STATES, &panels, Some(&bar))?;
        self.write("states", &sheet, (states.width, states.height), layers.channels())
    }

    fn write(&self, name: &str, image: &Image, (width, height): (usize, usize), layers: Vec<Layer>) -> Result<()> {
        let path = self.folder.join(format!("{}{name}", self.prefix));
        let metadata = Metadata {
            scene_hash: self.scene.hash_text(),
            samples_per_pixel: self.samples,
            seed: self.seed,
            extra: Platform::of(self.scene.geometry().device()).attributes(),
            ..Metadata::default()
        };
        let stamp = Platform::of(self.scene.geometry().device()).stamp();
        png::write(&path.with_extension("png"), image, &ViewTransform::default(), &[("Comment", &stamp)])?;
        Ok(exr::write(&path.with_extension("exr"), &Window::full(width, height), layers, &metadata)?)
    }
}
