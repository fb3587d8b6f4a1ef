//! What a guide knows, as pictures in PNG and EXR.

use crate::guiding::Guide;
use crate::image::exr::{self, Metadata, Window};
use crate::image::{Image, Layer, ViewTransform, png};
use crate::inspect::picture::{Chart, side_by_side};
use crate::inspect::{Layers, PixelVertex, Radiance};
use crate::platform::Platform;
use crate::scene::Scene;
use anyhow::Result;
use std::path::Path;

/// Share of the traced directions that are darker than what is shown white.
const WHITE: f64 = 0.995;

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
            ("latlong", Chart::lat_long(learnt), Chart::lat_long(traced)),
            ("hemisphere", Chart::disk(&radiance.frame, learnt), Chart::disk(&radiance.frame, traced)),
        ];
        for (name, learnt, traced) in &charts {
            let layers =
                [("learnt", learnt), ("traced", traced)].map(|(name, c)| Layer::scalar(name, "Y", c.or_zero()));
            self.write(name, &side_by_side(learnt, traced, white), (learnt.width, learnt.height), layers.into())?;
        }
        Ok(())
    }

    /// Which state each pixel shows.
    pub(crate) fn states(&self, layers: &Layers) -> Result<()> {
        let image = layers.false_colours();
        self.write("states", &image, (image.width, image.height), layers.channels())
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
        png::write(&path.with_extension("png"), image, &ViewTransform::default(), &[])?;
        Ok(exr::write(&path.with_extension("exr"), &Window::full(width, height), layers, &metadata)?)
    }
}
