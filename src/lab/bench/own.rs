//! Phototaxis' own part in a comparison with another renderer.

use super::median;
use crate::Result;
use crate::film::accumulate::Estimate;
use crate::render::{Settings, render};
use crate::scene::Scene;
use crate::stats::Median;
use serde::Serialize;

/// Rates are of all threads together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct OurFigures {
    pub(crate) msamples_per_second: Median,
    pub(crate) mrays_per_second: Median,
    pub(crate) msamples_per_cpu_second: Option<Median>,
    pub(crate) rays_per_sample: f64,
}

/// One render.
pub(crate) struct Own {
    pub(crate) samples: f64,
    pub(crate) rays: f64,
    /// Wall time.
    pub(crate) seconds: f64,
    /// Processor seconds of all threads.
    pub(crate) cpu_seconds: f64,
}

impl Own {
    /// Renders with the threads of the current pool.
    pub(crate) fn render(scene: &Scene, settings: &Settings) -> Result<(Own, Estimate)> {
        let rendering = render(scene, settings, &mut |_| true);
        let (counters, total) = (rendering.iterations.iter().map(|i| &i.counters), rendering.total());
        let own = Own {
            samples: counters.map(|c| c.paths).sum::<u64>() as f64,
            rays: (total.rays + total.shadow_rays) as f64,
            seconds: rendering.wall_seconds,
            cpu_seconds: rendering.cpu.seconds(),
        };
        Ok((own, rendering.estimate))
    }

    pub(crate) fn msamples_per_second(&self) -> f64 {
        self.samples * 1e-6 / self.seconds
    }

    pub(crate) fn msamples_per_cpu_second(&self) -> f64 {
        self.samples * 1e-6 / self.cpu_seconds
    }
}

impl OurFigures {
    pub(crate) fn of<'a>(renders: impl Iterator<Item = &'a Own> + Clone) -> Result<OurFigures> {
        let of = |figure: fn(&Own) -> f64| renders.clone().map(figure).collect::<Vec<f64>>();
        Ok(OurFigures {
            msamples_per_second: median(&of(Own::msamples_per_second))?,
            mrays_per_second: median(&of(|o| o.rays * 1e-6 / o.seconds))?,
            msamples_per_cpu_second: Median::of(&of(Own::msamples_per_cpu_second)),
            rays_per_sample: median(&of(|o| o.rays / o.samples))?.median,
        })
    }
}
