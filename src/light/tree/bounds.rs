//! How bright a set of lights is, where it is, and where it shines to.

use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Rounding of points on lights, relative to their coordinates: a few units in the last place.
const OF_COORDINATES: f32 = 4.0 * f32::EPSILON;

/// One light that is somewhere, as its tree sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightBounds {
    /// Corners of its box.
    pub lo: Vec3,
    pub hi: Vec3,
    /// Of a sphere about it.
    pub centre: Vec3,
    pub radius: f32,
    /// How far its points lie at most from the plane through the centre that is across the axis.
    pub thickness: f32,
    /// Unit, where it shines brightest: its intensity falls with the cosine from there. Zero for a light that shines the
    /// same in all directions.
    pub axis: Vec3,
    /// Whether it shines from its back too.
    pub two_sided: bool,
    /// Luminance of the intensity along the axis; positive.
    pub intensity: f64,
}

impl LightBounds {
    pub fn largest_coordinate(&self) -> f32 {
        self.lo.abs().max(self.hi.abs()).max_element()
    }

    /// The same in another unit of length, which is `scale` of the present one. Radius and thickness are widened by as much as
    /// rounding may move points of the light.
    pub fn scaled(&self, scale: f32) -> LightBounds {
        let slack = OF_COORDINATES * self.largest_coordinate();
        LightBounds {
            lo: self.lo * scale,
            hi: self.hi * scale,
            centre: self.centre * scale,
            radius: (self.radius + slack) * scale,
            thickness: (self.thickness + slack) * scale,
            intensity: self.intensity * f64::from(scale).powi(2),
            ..*self
        }
    }
}

/// Sums over a set of lights: what a split is judged by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Summary {
    pub lo: Vec3,
    pub hi: Vec3,
    /// Of the lights' axes, each times its intensity.
    pub axes: DVec3,
    pub intensity: f64,
    pub count: usize,
}

impl Summary {
    pub const EMPTY: Summary =
        Summary { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY, axes: DVec3::ZERO, intensity: 0.0, count: 0 };

    /// Axes of lights that shine from both sides count as the one of the two that is on the side of `reference`.
    pub fn of<'a>(lights: impl Iterator<Item = &'a LightBounds>, reference: Vec3) -> Summary {
        lights.fold(Summary::EMPTY, |sum, light| sum.with(light, reference))
    }

    #[inline]
    pub fn with(mut self, light: &LightBounds, reference: Vec3) -> Summary {
        let axis = if light.two_sided && light.axis.dot(reference) < 0.0 { -light.axis } else { light.axis };
        self.lo = self.lo.min(light.lo);
        self.hi = self.hi.max(light.hi);
        self.axes += axis.as_dvec3() * light.intensity;
        self.intensity += light.intensity;
        self.count += 1;
        self
    }

    pub fn join(self, other: &Summary) -> Summary {
        Summary {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            axes: self.axes + other.axes,
            intensity: self.intensity + other.intensity,
            count: self.count + other.count,
        }
    }

    /// Surface area orientation heuristic (Conty Estevez & Kulla 2018, eq. 1): intensity × area × solid angle of the set.
    /// To the area of the box its squared diagonal is added, which tells rows of lights apart too.
    pub fn cost(&self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let d = (self.hi - self.lo).as_dvec3();
        let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x) + d.length_squared();
        self.intensity * area * self.solid_angle()
    }

    /// That the set shines to, weighed by the cosine beyond its cone. Of axes that fill a cone evenly, the mean has the
    /// length (1 + cosθ)/2.
    fn solid_angle(&self) -> f64 {
        let cos = (2.0 * self.axes.length() / self.intensity - 1.0).clamp(-1.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        // the paper's θₑ is a right angle, so that its cosines and most of its angles cancel
        let beyond = if cos > 0.0 { PI * sin + 2.0 * cos } else { 2.0 * (PI - cos.acos()) * sin };
        2.0 * PI * (1.0 - cos) + FRAC_PI_2 * beyond
    }
}

/// What a node keeps of a light or a set of lights: a sphere that holds them, a cone that holds their axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    pub centre: Vec3,
    pub radius: f32,
    /// How far behind the centre, along their own axes, lights of the set begin to shine. Flat lamps, however large, shine from
    /// the plane on which they lie.
    pub thickness: f32,
    pub axis: Vec3,
    /// Of the angle between the axis and the edge of the cone; −1 where lights shine in all directions.
    pub cos_spread: f32,
    pub two_sided: bool,
    pub intensity: f64,
}

/// By how much rounding may make bounds too small.
const ROUNDING: f64 = 1e-6;

impl Cluster {
    pub fn of_light(light: &LightBounds) -> Cluster {
        Cluster {
            centre: light.centre,
            radius: light.radius,
            thickness: light.thickness,
            axis: light.axis,
            cos_spread: if light.axis == Vec3::ZERO { -1.0 } else { 1.0 },
            two_sided: light.two_sided,
            intensity: light.intensity,
        }
    }

    pub fn of_set(lights: &[LightBounds], set: &[u32], sums: &Summary) -> Cluster {
        let all = || set.iter().map(|&k| &lights[k as usize]);
        let two_sided = all().any(|light| light.two_sided);
        let axis = sums.axes.try_normalize();
        let cosine = |light: &LightBounds| {
            let cos = light.axis.as_dvec3().dot(axis.unwrap_or_default());
            if two_sided { cos.abs() } else { cos }
        };
        let somewhere = axis.is_some() && all().all(|light| light.axis != Vec3::ZERO);
        let cos = if somewhere { all().map(cosine).fold(1.0, f64::min) - ROUNDING } else { -1.0 };
        let (lo, hi) = (sums.lo.as_dvec3(), sums.hi.as_dvec3());
        let centre = (0.5 * (lo + hi)).as_vec3();
        let radius = (hi - centre.as_dvec3()).max(centre.as_dvec3() - lo).length();
        let behind = |light: &LightBounds| {
            let along = light.axis.as_dvec3().dot(light.centre.as_dvec3() - centre.as_dvec3());
            f64::from(light.thickness) + if two_sided { along.abs() } else { -along }
        };
        let thickness = all().map(behind).fold(0.0, f64::max);
        Cluster {
            centre,
            radius: (radius * (1.0 + ROUNDING)) as f32,
            thickness: (thickness.min(radius) * (1.0 + ROUNDING)) as f32,
            axis: axis.unwrap_or_default().as_vec3(),
            cos_spread: cos.max(-1.0) as f32,
            two_sided,
            intensity: sums.intensity,
        }
    }
}
