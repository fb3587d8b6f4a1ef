//! A lamp that shines into a cone.

use super::point::unit_and_length;
use super::source::{Extent, Findings, LightParameters, LightSource};
use super::tree::LightBounds;
use super::{LightPoint, LightSample, Rounding, check_light, scaled, wide_luminance};
use crate::Result;
use crate::document::{Bounds, NOT_NEGATIVE, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

const CUTOFF: Bounds = Bounds::new(|x| (0.01..=180.0).contains(&x), "between 0.01 and 180");
const BEAM: Bounds = Bounds::new(|x| (0.0..=180.0).contains(&x), "between 0 and 180");

/// Light from a point: `intensity` in W/sr within `beam_angle` of `direction`; from there to `cutoff_angle` it falls to nothing, evenly
/// with the angle.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotLightParameters {
    /// As written: it may be far from 0.
    pub position: DVec3,
    /// Where the light travels to, of any length but zero.
    pub direction: Vec3,
    pub intensity: Rgb,
    /// Degrees from the axis.
    pub cutoff_angle: f32,
    /// Degrees from the axis, at most `cutoff_angle`.
    pub beam_angle: f32,
}

impl Default for SpotLightParameters {
    fn default() -> SpotLightParameters {
        let (position, direction) = (DVec3::ZERO, Vec3::NEG_Y);
        SpotLightParameters { position, direction, intensity: Rgb::ZERO, cutoff_angle: 20.0, beam_angle: 15.0 }
    }
}

impl Fields for SpotLightParameters {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        visitor.position(key("position", "where it is").unit("length").required(), &mut self.position)?;
        visitor.direction(key("direction", "where the light travels to").required(), &mut self.direction)?;
        let intensity = key("intensity", "within the beam").unit("W/sr").required();
        visitor.color(intensity, NOT_NEGATIVE, &mut self.intensity)?;
        let cutoff =
            "from the axis, beyond which there is no light; it falls evenly with the angle from `beam_angle` to there";
        visitor.number(key("cutoff_angle", cutoff).unit("degrees"), CUTOFF, &mut self.cutoff_angle)?;
        let beam = key("beam_angle", "from the axis, within which all directions have the same light").unit("degrees");
        visitor.number(beam, BEAM, &mut self.beam_angle)?;
        let message = "`beam_angle` must not be above `cutoff_angle`";
        visitor.check(self.beam_angle <= self.cutoff_angle, &["beam_angle", "cutoff_angle"], message)
    }
}

impl LightParameters for SpotLightParameters {
    const NUMBER: u32 = 7;
    type Loaded = SpotLight;

    fn load(&self, _: &mut Findings) -> Result<SpotLight> {
        let unit = self.direction.as_dvec3().try_normalize();
        check_light(self.intensity, unit.is_some(), "a spot light")?;
        let [cutoff, beam] = [self.cutoff_angle, self.beam_angle].map(f32::to_radians);
        let direction = unit.unwrap_or(DVec3::NEG_Y).as_vec3();
        Ok(SpotLight { position: self.position.as_vec3(), direction, intensity: self.intensity, cutoff, beam })
    }

    fn translate(&mut self, by: DVec3) {
        self.position += by;
    }
}

/// Radians from the axis, up to which a spot is taken for a light that shines to its front: there the cosine is half of what it is
/// along the axis, and a light that is chosen by it is chosen often enough.
const MAX_NARROW: f32 = std::f32::consts::FRAC_PI_3;

/// The same in the scene's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SpotLight {
    position: Vec3,
    /// Unit.
    direction: Vec3,
    intensity: Rgb,
    /// Radians; the beam's angle is at most the other.
    cutoff: f32,
    beam: f32,
}

impl SpotLight {
    /// The share of the intensity that leaves along the unit vector `w`.
    fn falloff(&self, w: Vec3) -> f32 {
        let angle = self.direction.cross(w).length().atan2(self.direction.dot(w));
        if angle <= self.beam { 1.0 } else { ((self.cutoff - angle) / (self.cutoff - self.beam)).max(0.0) }
    }
}

impl LightSource for SpotLight {
    fn checked(self) -> Result<SpotLight> {
        let angles = 0.0 <= self.beam && self.beam <= self.cutoff && self.cutoff > 0.0;
        check_light(self.intensity, self.position.is_finite() && self.direction.is_finite() && angles, "a spot light")?;
        Ok(self)
    }

    /// The integral of the falloff over directions.
    fn power(&self, _section: f64) -> f64 {
        let (cutoff, beam) = (f64::from(self.cutoff), f64::from(self.beam));
        let mean_cosine = if cutoff > beam { (cutoff.sin() - beam.sin()) / (cutoff - beam) } else { beam.cos() };
        TAU * (1.0 - mean_cosine) * wide_luminance(self.intensity)
    }

    /// Its light falls with the angle, which for a narrow one is bounded well enough by the cosine.
    fn extent(&self) -> Extent {
        let at = self.position;
        let narrow = self.cutoff <= MAX_NARROW;
        Extent::Near(LightBounds {
            lo: at,
            hi: at,
            centre: at,
            radius: 0.0,
            thickness: 0.0,
            axis: if narrow { self.direction } else { Vec3::ZERO },
            two_sided: false,
            intensity: wide_luminance(self.intensity),
        })
    }

    fn brightness(&self, scene_radius: f64) -> f64 {
        self.intensity.max_element() as f64 / scene_radius.powi(2)
    }

    fn scaled(self, factor: f64) -> SpotLight {
        SpotLight { intensity: scaled(self.intensity, factor), ..self }
    }

    fn sample(&self, p: Vec3, _u_cell: f64, _u: [f32; 2]) -> Option<LightSample> {
        let (wi, distance) = unit_and_length(self.position - p)?;
        let share = self.falloff(-wi);
        let radiance = self.intensity * share / distance / distance;
        let target = LightPoint { point: self.position, normal: Vec3::ZERO, error: Rounding::default() };
        (share > 0.0).then_some(LightSample { wi, radiance, pdf: 1.0, delta: true, target: Some(target) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(cutoff_angle: f32, beam_angle: f32) -> SpotLight {
        let parameters =
            SpotLightParameters { intensity: Rgb::splat(3.0), cutoff_angle, beam_angle, ..Default::default() };
        parameters.load(&mut Findings::default()).unwrap()
    }

    #[test]
    fn light_falls_evenly_with_the_angle() {
        let spot = spot(40.0, 20.0);
        let at = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            spot.sample(2.0 * Vec3::new(sin, -cos, 0.0), 0.0, [0.0; 2]).map_or(0.0, |sample| sample.radiance.x)
        };
        for (degrees, share) in [(0.0, 1.0), (19.0, 1.0), (25.0, 0.75), (35.0, 0.25), (41.0, 0.0), (180.0, 0.0)] {
            assert!((at(degrees) - 3.0 / 4.0 * share).abs() < 1e-5, "{degrees}: {}", at(degrees));
        }
    }

    #[test]
    fn its_power_is_what_leaves_in_all_directions() {
        for spot in [spot(40.0, 20.0), spot(90.0, 0.0), spot(30.0, 30.0), spot(180.0, 170.0)] {
            const STEPS: usize = 100_000;
            let step = std::f64::consts::PI / STEPS as f64;
            let ring = |k: usize| {
                let angle = (k as f64 + 0.5) * step;
                let w = Vec3::new(angle.sin() as f32, -angle.cos() as f32, 0.0);
                f64::from(spot.falloff(w)) * TAU * angle.sin() * step
            };
            let wanted = 3.0 * (0..STEPS).map(ring).sum::<f64>();
            assert!((spot.power(1.0) / wanted - 1.0).abs() < 1e-4, "{} {wanted}", spot.power(1.0));
        }
    }
}
