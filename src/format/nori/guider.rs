//! What a scene says of the guide: programs that learn where light is add a `guider` to nori, in the scene or in its integrator.

use crate::Result;
use crate::format::xml::object::{Object, Objects};
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Rate};
use std::rc::Rc;

pub(super) fn read(objects: &Objects, settings: &mut GuidingSettings) -> Result<()> {
    let mut found = objects.children(&objects.root, "guider")?;
    if let Some(integrator) = objects.child(&objects.root, "integrator")? {
        found.extend(objects.children(&integrator, "guider")?);
    }
    let Some((_, guider)) = found.first() else { return Ok(()) };
    if matches!(guider.kind.as_str(), "none" | "null" | "uniform" | "cosine" | "bsdf") {
        settings.method = GuidingMethod::None;
        return Ok(());
    }
    table(guider, settings)?;
    objects.finish(guider);
    Ok(())
}

/// A table of directions in each cell of a grid.
fn table(guider: &Rc<Object>, settings: &mut GuidingSettings) -> Result<()> {
    settings.method = GuidingMethod::Grid;
    let sphere = guider.kind.contains("sphere") && !guider.kind.contains("hemisphere");
    settings.table = if sphere { DirectionTable::Sphere } else { DirectionTable::Hemisphere };
    let spelt = |names: &[&str]| names.iter().find_map(|name| guider.maybe_number(name).transpose()).transpose();
    let whole = |number: f64, most: f64, what: &str| -> Result<u32> {
        let fits = (1.0..=most).contains(&number);
        fits.then_some(number as u32).ok_or_else(|| guider.error(format!("{what} must be between 1 and {most}")))
    };
    if let Some(cells) = spelt(&["scene_resolution", "grid_resolution", "resolution"])? {
        settings.resolution = whole(cells, 8192.0, "cells along a side of the scene")?;
    }
    if let Some(strata) = spelt(&["angle_resolution", "angular_resolution", "table_resolution", "q_resolution"])? {
        settings.strata = whole(strata, 256.0, "cells along a side of a table")?;
    }
    if let Some(alpha) = spelt(&["alpha", "learning_rate"])? {
        if !(alpha > 0.0 && alpha <= 1.0) {
            return Err(guider.error("a rate of learning must be greater than 0 and at most 1"));
        }
        settings.rate = Rate::Constant(alpha as f32);
    }
    Ok(())
}
