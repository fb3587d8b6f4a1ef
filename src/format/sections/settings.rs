//! The sections of settings. A key is one line here (and one row of docs/scene-file.md, which a test asks for).

use crate::document::{At, Bounds, COORDINATE, Fault, NOT_NEGATIVE, Node, Reader, UNIT, Value};
use crate::film::{Combine, FilmSettings, Filter, MAX_SIDE};
use crate::guiding::settings::{
    DirectionTable, GuideSampling, GuidingMethod, GuidingSettings, LearningRule, Placement, Rate, Updates,
};
use crate::image::{Exposure, MOST_STOPS, Tone};
use crate::integrator::{IntegratorSettings, Roulette};
use crate::render::{Order, RenderSettings};
use crate::scene::description::CameraDescription;
use glam::Vec3;
use std::ops::RangeInclusive;

/// Pixels along a side of the film.
pub(in crate::format) const SIDE: RangeInclusive<u64> = 1..=MAX_SIDE as u64;
/// Degrees of a field of view.
pub(in crate::format) const VFOV: Bounds = Bounds::new(|x| x > 0.0 && x < 180.0, "greater than 0 and less than 180");
const STOPS: Bounds = Bounds::new(|x| x.abs() <= MOST_STOPS as f64, "between -64 and 64");
/// Without any share for the BSDF, light that the guide does not know of would be missing.
const FRACTION: Bounds = Bounds::new(|x| x > 0.0 && x <= 1.0, "greater than 0 and at most 1");
const AT_LEAST_ONE: Bounds = Bounds::new(|x| x >= 1.0, "at least 1");
const ANY: u64 = u32::MAX as u64;
/// An adaptive guide holds a number for each of its coarse cells, empty ones too.
const MAX_COARSE: u32 = 128;

pub(in crate::format) fn film(t: &mut Reader, film: &mut FilmSettings) -> Result<(), Fault> {
    let filters = [("box", Filter::Box), ("tent", Filter::Tent), ("gaussian", Filter::Gaussian)];
    t.integer("width", SIDE, &mut film.width)?;
    t.integer("height", SIDE, &mut film.height)?;
    t.choice("filter", &filters, &mut film.filter)?;
    exposure(t, &mut film.exposure)?;
    t.choice("tone", &Tone::NAMES, &mut film.tone)
}

/// Stops, or "auto".
fn exposure(t: &mut Reader, slot: &mut Exposure) -> Result<(), Fault> {
    let Some(node) = t.ask("exposure".into(), "number or `\"auto\"`", slot.to_string(), STOPS.range())? else {
        return Ok(());
    };
    *slot = match &node.value {
        Value::String(text) if text == "auto" => Exposure::Auto,
        Value::String(_) => return Err(node.mismatch("exposure", "a number or \"auto\"")),
        _ => Exposure::Stops(node.number("exposure", STOPS)?),
    };
    Ok(())
}

pub(in crate::format) fn integrator(t: &mut Reader, s: &mut IntegratorSettings) -> Result<(), Fault> {
    let roulettes = [("guided", Roulette::Guided), ("throughput", Roulette::Throughput), ("none", Roulette::None)];
    t.integer("max_depth", 1..=ANY, &mut s.max_depth)?;
    t.flag("next_event", &mut s.next_event)?;
    t.flag("mis", &mut s.mis)?;
    t.choice("roulette", &roulettes, &mut s.roulette)?;
    t.integer("rr_depth", 0..=ANY, &mut s.rr_depth)?;
    t.number("max_split", AT_LEAST_ONE, &mut s.max_split)
}

pub(in crate::format) fn guiding(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    let tables = [
        ("tree", DirectionTable::Tree),
        ("hemisphere", DirectionTable::Hemisphere),
        ("sphere", DirectionTable::Sphere),
    ];
    t.choice("method", &GuidingMethod::NAMES, &mut s.method)?;
    t.choice("table", &tables, &mut s.table)?;
    t.integer("resolution", 1..=8192, &mut s.resolution)?;
    t.flag("normals", &mut s.normals)?;
    t.integer("strata", 1..=256, &mut s.strata)?;
    t.integer("levels", 0..=4, &mut s.levels)?;
    t.number("refine_visits", NOT_NEGATIVE, &mut s.refine_visits)?;
    t.number("refine_difference", UNIT, &mut s.refine_difference)?;
    t.number("split_share", UNIT, &mut s.split_share)?;
    t.number("split_visits", NOT_NEGATIVE, &mut s.split_visits)?;
    learning(t, s)?;
    let samplings = [("q-cos", GuideSampling::QCos), ("product", GuideSampling::Product), ("q", GuideSampling::Q)];
    t.choice("sampling", &samplings, &mut s.sampling)?;
    t.number("bsdf_fraction", FRACTION, &mut s.bsdf_fraction)?;
    let mut learned = s.learns_fraction();
    t.flag("learned_fraction", &mut learned)?;
    s.learned_fraction = if t.has("learned_fraction") { Some(learned) } else { s.learned_fraction };
    t.flag("mis_compensation", &mut s.mis_compensation)?;
    t.number("smoothing", UNIT, &mut s.smoothing)?;
    t.flag("jitter", &mut s.jitter)?;
    let placements = [("paths", Placement::Paths), ("area", Placement::Area)];
    t.integer("sites", 0..=1 << 24, &mut s.sites)?;
    t.choice("placement", &placements, &mut s.placement)?;
    t.number("leaf_samples", NOT_NEGATIVE, &mut s.leaf_samples)?;
    t.number("rho", UNIT, &mut s.rho)?;
    t.flag("directional_filter", &mut s.directional_filter)?;
    check_updates(t, s)?;
    memory(t, "memory", &mut s.memory)?;
    if s.method.model() == GuidingMethod::Adaptive && s.resolution > MAX_COARSE {
        let message =
            format!("`resolution` must be at most {MAX_COARSE} with method `adaptive`, found {}", s.resolution);
        return Err(Fault::new(t.place(&["resolution", "method"]), message));
    }
    Ok(())
}

/// An SD-tree's snapshots are of whole iterations, and of whole iterations is judged whether a guide pays.
fn check_updates(t: &Reader, s: &GuidingSettings) -> Result<(), Fault> {
    if matches!(s.method, GuidingMethod::SdTree | GuidingMethod::Auto) && s.updates == Updates::Online {
        let at = t.place(&["updates", "method"]);
        let message = format!("`updates` must be \"frozen\" where `method` is \"{}\"", s.method.name());
        return Err(Fault::new(at, message));
    }
    Ok(())
}

fn learning(t: &mut Reader, s: &mut GuidingSettings) -> Result<(), Fault> {
    use LearningRule as Rule;
    let rules = [
        ("expected-sarsa", Rule::ExpectedSarsa),
        ("q-learning", Rule::QLearning),
        ("monte-carlo", Rule::MonteCarlo),
        ("blend", Rule::Blend),
    ];
    t.choice("rule", &rules, &mut s.rule)?;
    t.number("blend_visits", NOT_NEGATIVE, &mut s.blend_visits)?;
    let (mut alpha, mut retain) = (0.1, 0.5);
    match s.rate {
        Rate::Constant(a) => alpha = a,
        Rate::Forgetting(r) => retain = r,
        Rate::Vanishing => {}
    }
    t.number("alpha", UNIT, &mut alpha)?;
    t.number("retain", UNIT, &mut retain)?;
    let rates =
        [("forgetting", Rate::Forgetting(retain)), ("vanishing", Rate::Vanishing), ("constant", Rate::Constant(alpha))];
    if let Rate::Forgetting(r) = &mut s.rate {
        *r = retain;
    }
    t.choice("rate", &rates, &mut s.rate)?;
    let updates = [("frozen", Updates::Frozen), ("online", Updates::Online)];
    t.choice("updates", &updates, &mut s.updates)
}

pub(in crate::format) fn render(t: &mut Reader, s: &mut RenderSettings) -> Result<(), Fault> {
    let combines = [("inverse-variance", Combine::InverseVariance), ("all", Combine::All), ("last", Combine::Last)];
    t.integer("spp", 1..=ANY, &mut s.spp)?;
    seconds(t, "time", &mut s.time)?;
    t.integer("seed", 0..=u64::MAX, &mut s.seed)?;
    t.flag("robust", &mut s.robust)?;
    t.choice("order", &[("progressive", Order::Progressive), ("blocks", Order::Blocks)], &mut s.order)?;
    t.choice("combine", &combines, &mut s.combine)
}

/// `None` before means that the section places a camera, else it changes the one there is.
pub(in crate::format) fn camera(t: &mut Reader, camera: &mut Option<CameraDescription>) -> Result<(), Fault> {
    let mut c = camera.clone().unwrap_or_else(camera_facing_up);
    t.vector("origin", COORDINATE, &mut c.origin)?;
    t.vector("target", COORDINATE, &mut c.target)?;
    t.vector("up", COORDINATE, &mut c.up)?;
    t.number("vfov", VFOV, &mut c.vfov)?;
    t.flag("mirrored", &mut c.mirrored)?;
    if camera.is_none() {
        needs(t, &["origin", "target"])?;
    }
    check_camera(t, &c)?;
    *camera = Some(c);
    Ok(())
}

/// What a camera has before its keys are read; that `origin` and `target` are given is checked after.
pub(in crate::format) fn camera_facing_up() -> CameraDescription {
    let (origin, target, up) = (Vec3::ZERO, Vec3::ZERO, Vec3::Y);
    CameraDescription { origin, target, up, vfov: 45.0, mirrored: false }
}

/// That all of `keys`, which were asked for, were there.
pub(in crate::format) fn needs(t: &Reader, keys: &[&str]) -> Result<(), Fault> {
    keys.iter().find(|k| !t.has(k)).map_or(Ok(()), |k| Err(t.missing(k)))
}

/// That the three vectors span a frame.
pub(in crate::format) fn check_camera(t: &Reader, c: &CameraDescription) -> Result<(), Fault> {
    let view = c.target.as_dvec3() - c.origin.as_dvec3();
    if view.length() == 0.0 {
        let at = t.place(&["target", "origin"]);
        return Err(Fault::new(at, "`target` must differ from `origin`"));
    }
    let up = c.up.as_dvec3();
    // The sine of the angle between them; below about 1e-6, `f32` can no longer tell the camera's right.
    if view.cross(up).length() <= 1e-6 * view.length() * up.length() {
        let at = t.place(&["up", "target", "origin"]);
        return Err(Fault::new(at, "`up` must not be zero or parallel to the view"));
    }
    Ok(())
}

/// Positive seconds, in double precision.
fn seconds(t: &mut Reader, key: &'static str, slot: &mut Option<f64>) -> Result<(), Fault> {
    let Some(node) = t.take(key) else { return Ok(()) };
    let seconds = match node.value {
        Value::Integer(i) => i as f64,
        Value::Float(x) => x,
        _ => return Err(node.mismatch(key, "a number")),
    };
    if !(seconds > 0.0 && seconds.is_finite()) {
        let message = format!("`{key}` must be finite and greater than 0, found {seconds}");
        return Err(Fault::new(node.at, message));
    }
    *slot = Some(seconds);
    Ok(())
}

/// Bytes as an integer, or text with a unit.
fn memory(t: &mut Reader, key: &'static str, slot: &mut u64) -> Result<(), Fault> {
    let Some(node) = t.take(key) else { return Ok(()) };
    *slot = match &node.value {
        Value::Integer(i) => u64::try_from(*i).ok().filter(|b| *b > 0),
        Value::String(s) => bytes(s),
        _ => return Err(node.mismatch(key, "an integer or a string like \"256 MiB\"")),
    }
    .ok_or_else(|| memory_fault(node.at, key))?;
    Ok(())
}

fn memory_fault(at: At, key: &str) -> Fault {
    let units = "B, KiB, MiB, GiB, TiB, kB, MB, GB or TB";
    Fault::new(at, format!("`{key}` must be 1 or more bytes, or text with a unit ({units})"))
}

/// "1.5 GiB" in bytes, rounded down; `None` where it is no size or less than a byte.
fn bytes(text: &str) -> Option<u64> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim() {
        "" | "B" => 1.0,
        "KiB" => 1024.0,
        "MiB" => f64::from(1 << 20),
        "GiB" => f64::from(1 << 30),
        "TiB" => (1u64 << 40) as f64,
        "kB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "TB" => 1e12,
        _ => return None,
    };
    let size = number.parse::<f64>().ok()? * factor;
    (1.0..u64::MAX as f64).contains(&size).then_some(size as u64)
}

/// Reads the section `key` of `root`, if it is there, and refuses what `read` has not asked for.
pub(in crate::format) fn section(
    root: &mut Reader,
    key: &'static str,
    read: impl FnOnce(&mut Reader) -> Result<(), Fault>,
) -> Result<(), Fault> {
    root.take(key).map_or(Ok(()), |node: Node| {
        let mut t = Reader::new(format!("[{key}]"), node)?;
        read(&mut t)?;
        t.finish()
    })
}
