//! A clear sky, with its sun or without.

mod solar;

use super::LightSample;
use super::environment::Environment;
use super::source::{Extent, Findings, LightParameters, LightSource};
use super::sun::{SUN_DIAMETER, SunDisc, SunLight};
use super::tree::FarLight;
use crate::document::{Bounds, NOT_NEGATIVE, UNIT, key};
use crate::fields::{FieldVisitor, Fields};
use crate::math::Rgb;
use crate::{Error, Result};
use glam::{Affine3A, DVec3, Mat3, Vec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const TURBIDITY: Bounds = Bounds::new(|x| (1.0..=10.0).contains(&x), "between 1 and 10");

/// Columns and rows of the picture that the sky is baked into: pixels of 0.35°, finer than the glow about the sun.
const SIZE: [usize; 2] = [1024, 513];

/// A clear sky as written: the model of L. Hošek and A. Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance",
/// SIGGRAPH 2012, by its table for linear sRGB. Nothing comes from below the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyLight {
    /// Where the sun stands, of any length but zero; not below the horizon.
    pub sun_direction: Vec3,
    /// What is up, of any length but zero.
    pub up: Vec3,
    pub turbidity: f32,
    /// Of the ground, which the sky reflects.
    pub ground_albedo: Rgb,
    /// Whether the sun itself shines too.
    pub sun: bool,
    /// Multiplies all of it.
    pub scale: f32,
}

impl Default for SkyLight {
    fn default() -> SkyLight {
        SkyLight {
            sun_direction: Vec3::Y,
            up: Vec3::Y,
            turbidity: 3.0,
            ground_albedo: Rgb::splat(0.3),
            sun: true,
            scale: 1.0,
        }
    }
}

impl Fields for SkyLight {
    fn fields<V: FieldVisitor>(&mut self, visitor: &mut V) -> Result<(), V::Error> {
        let sun = key("sun_direction", "where the sun stands, not below the horizon").required();
        visitor.direction(sun, &mut self.sun_direction)?;
        visitor.direction(key("up", "from the horizon to the zenith"), &mut self.up)?;
        let turbidity = "2 on a very clear day, 3 on a clear one, 6 in haze";
        visitor.number(key("turbidity", turbidity), TURBIDITY, &mut self.turbidity)?;
        let albedo = key("ground_albedo", "of the ground that the sky reflects; it is not seen");
        visitor.color(albedo, UNIT, &mut self.ground_albedo)?;
        visitor.flag(key("sun", "the sun shines too, as a disc of 0.533°"), &mut self.sun)?;
        let scale =
            "multiplies the light, which is in watts weighed by the eye's sensitivity: a sky of some 10 W/(sr·m²)";
        visitor.number(key("scale", scale), NOT_NEGATIVE, &mut self.scale)
    }
}

impl LightParameters for SkyLight {
    const NUMBER: u32 = 6;
    type Loaded = Sky;

    fn load(&self, _: &mut Findings) -> Result<Sky> {
        let (to_sun, up, elevation) = self.directions()?;
        let dome = self.dome(to_sun, up, elevation)?;
        let sun = self.sun.then(|| {
            let irradiance = solar::irradiance(elevation, f64::from(self.turbidity)) * self.scale;
            SunDisc::new(to_sun, irradiance, SUN_DIAMETER)
        });
        Ok(Sky { dome: Box::new(dome), sun })
    }
}

impl SkyLight {
    /// Its sun alone, whether it shines in this sky or not.
    ///
    /// # Errors
    /// As of the sky: directions that are zero, and a sun below the horizon.
    pub(crate) fn sun_alone(&self) -> Result<SunLight> {
        let (to_sun, _, elevation) = self.directions()?;
        let irradiance = solar::irradiance(elevation, f64::from(self.turbidity)) * self.scale;
        Ok(SunLight { direction: -to_sun.as_vec3(), irradiance, angular_diameter: SUN_DIAMETER })
    }

    /// Unit vectors to the sun and to the zenith, and the sun's elevation in radians.
    fn directions(&self) -> Result<(DVec3, DVec3, f64)> {
        let unit = |v: Vec3, what: &str| {
            v.as_dvec3().try_normalize().ok_or_else(|| Error::Scene(format!("a sky's `{what}` has no direction")))
        };
        let (to_sun, up) = (unit(self.sun_direction, "sun_direction")?, unit(self.up, "up")?);
        let elevation = to_sun.dot(up).asin();
        if elevation < 0.0 {
            return Err(Error::Scene("a sky's sun stands below the horizon, where its model ends".into()));
        }
        Ok((to_sun, up, elevation))
    }

    /// The sky as a picture, whose frame has the zenith at +y.
    fn dome(&self, to_sun: DVec3, up: DVec3, elevation: f64) -> Result<Environment> {
        let albedo = self.ground_albedo.to_array();
        let parameters =
            SkyParams { elevation: elevation.min(FRAC_PI_2 - 1e-6) as f32, turbidity: self.turbidity, albedo };
        let state = SkyState::new(&parameters).map_err(|error| Error::Scene(format!("a sky: {error}")))?;
        let to_world = Mat3::from_quat(glam::Quat::from_rotation_arc(Vec3::Y, up.as_vec3()));
        let local_sun = to_world.transpose().as_dmat3() * to_sun;
        let [width, height] = SIZE;
        let pixel = |k: usize| {
            let (u, v) = ((k % width) as f64 + 0.5, (k / width) as f64 / (height - 1) as f64);
            radiance(&state, direction(u / width as f64, v), local_sun)
        };
        let pixels = (0..width * height).map(pixel).collect();
        let scale = Rgb::splat(self.scale);
        Environment::new(width as u32, height as u32, pixels, scale, Affine3A::from_mat3(to_world))
    }
}

/// The unit direction at (u, v) of an [`Environment`]'s picture.
fn direction(u: f64, v: f64) -> DVec3 {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = ((TAU * u).sin_cos(), (PI * v).sin_cos());
    DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}

/// Of the sky in the unit direction `w`; black below the horizon.
fn radiance(state: &SkyState, w: DVec3, to_sun: DVec3) -> Rgb {
    // the model is singular at the horizon, which a pixel's centre may meet
    if w.y < 1e-4 {
        return Rgb::ZERO;
    }
    let (theta, gamma) = (w.y.min(1.0).acos() as f32, w.dot(to_sun).clamp(-1.0, 1.0).acos() as f32);
    let channels = [Channel::R, Channel::G, Channel::B].map(|channel| state.radiance(theta, gamma, channel));
    Rgb::from(channels).max(Rgb::ZERO)
}

/// A sky, ready to be sampled.
#[derive(Clone, Debug)]
pub(crate) struct Sky {
    dome: Box<Environment>,
    sun: Option<SunDisc>,
}

impl Sky {
    /// Radiance without the sun's disc, from the unit direction `wi`.
    #[cfg(test)]
    pub(super) fn dome_radiance(&self, wi: Vec3) -> Rgb {
        LightSource::radiance(&self.dome, wi)
    }

    /// Irradiance by the disc on a surface that faces it.
    #[cfg(test)]
    pub(super) fn sun_irradiance(&self) -> Option<Rgb> {
        self.sun.as_ref().map(SunDisc::irradiance)
    }

    /// Share of samples that go to the sun: its share of the power.
    fn sun_share(&self) -> f64 {
        let (sun, dome) = (self.sun.as_ref().map_or(0.0, |sun| sun.power(1.0)), self.dome.power(1.0));
        if sun > 0.0 { sun / (sun + dome) } else { 0.0 }
    }
}

impl LightSource for Sky {
    fn checked(self) -> Result<Sky> {
        Ok(Sky { dome: self.dome.checked()?, sun: self.sun.map(SunDisc::checked).transpose()? })
    }

    fn power(&self, section: f64) -> f64 {
        self.dome.power(section) + self.sun.as_ref().map_or(0.0, |sun| sun.power(section))
    }

    fn extent(&self) -> Extent {
        Extent::Far(FarLight::around(
            self.power(1.0),
            self.dome.excess() + self.sun.as_ref().map_or(0.0, |sun| sun.power(1.0)),
        ))
    }

    fn brightness(&self, scene_radius: f64) -> f64 {
        let sun = self.sun.as_ref().map_or(0.0, |sun| sun.brightness(scene_radius));
        self.dome.brightness(scene_radius).max(sun)
    }

    fn scaled(self, factor: f64) -> Sky {
        Sky { dome: self.dome.scaled(factor), sun: self.sun.map(|sun| sun.scaled(factor)) }
    }

    fn sample(&self, p: Vec3, u_cell: f64, u: [f32; 2]) -> Option<LightSample> {
        let share = self.sun_share();
        let sample = match &self.sun {
            Some(sun) if u_cell < share => sun.sample(p, u_cell / share, u),
            _ => LightSource::sample(&self.dome, p, (u_cell - share) / (1.0 - share), u),
        }?;
        Some(LightSample { radiance: self.radiance(sample.wi), pdf: self.pdf(sample.wi), ..sample })
    }

    fn surrounds(&self) -> bool {
        true
    }

    fn radiance(&self, wi: Vec3) -> Rgb {
        let sun = self.sun.as_ref().map_or(Rgb::ZERO, |sun| sun.radiance(wi));
        LightSource::radiance(&self.dome, wi) + sun
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        let (share, sun) = (self.sun_share() as f32, self.sun.as_ref().map_or(0.0, |sun| sun.pdf(wi)));
        (1.0 - share) * LightSource::pdf(&self.dome, wi) + share * sun
    }
}
