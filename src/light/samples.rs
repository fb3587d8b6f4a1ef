//! Lights drawn for a packet's vertices, side by side.

use super::lights::Lights;
use super::triangle::AreaLight;
use super::{LightPoint, LightSample, LightSampler, Rounding};
use crate::geometry::Surfaces;
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each, mask, pick};
use glam::Vec3;

/// Up to [`LANES`] draws from [`Lights`]: what [`Lights::sample`] gives one by one, to the last bit.
pub(crate) struct LightSamples {
    /// Directions to the lights, unit.
    pub wi: Vec3Lanes,
    /// As of [`LightSample`].
    pub radiance: Vec3Lanes,
    /// Per steradian, the choice of the light included; 0 where nothing was drawn, or nothing arrives.
    pub pdf: Lanes,
    pub delta: Mask,
    /// Lanes where something else was drawn.
    others: Mask,
    /// Numbers of the lights that were chosen.
    light: [u32; LANES],
    /// On an emissive triangle, or that of a point light.
    point: Vec3Lanes,
    surface: Mask,
    /// Lanes whose shadow ray ends at `point`.
    aimed: Mask,
    // what is drawn from
    chosen: Chosen,
}

/// Emissive triangles that were chosen.
struct Chosen {
    origin: Vec3Lanes,
    edges: [Vec3Lanes; 2],
    normal: Vec3Lanes,
    density: Lanes,
    two_sided: [u32; LANES],
    /// As of [`Rounding`].
    near: Lanes,
    far: Lanes,
    /// What was drawn where the light is no triangle, or there is none.
    other: [Option<LightSample>; LANES],
}

impl LightSamples {
    pub fn new() -> LightSamples {
        let chosen = Chosen {
            origin: Vec3Lanes::ZERO,
            edges: [Vec3Lanes::ZERO; 2],
            normal: Vec3Lanes::ZERO,
            density: [0.0; LANES],
            two_sided: [0; LANES],
            near: [0.0; LANES],
            far: [0.0; LANES],
            other: [None; LANES],
        };
        LightSamples {
            wi: Vec3Lanes::ZERO,
            radiance: Vec3Lanes::ZERO,
            pdf: [0.0; LANES],
            delta: Mask::NONE,
            point: Vec3Lanes::ZERO,
            others: Mask::NONE,
            light: [0; LANES],
            surface: Mask::NONE,
            aimed: Mask::NONE,
            chosen,
        }
    }

    /// Begins anew, with nothing drawn.
    #[inline(always)]
    pub fn clear(&mut self) {
        (self.surface, self.others) = (Mask::NONE, Mask::NONE);
    }

    /// Chooses lights for the lanes of `lit` at the places `p` with the normals `n`, as [`Lights::sample`] with the same
    /// numbers. `u` becomes what the points are to be drawn with.
    #[inline(always)]
    pub fn choose(
        &mut self,
        lit: Mask,
        (lights, by): (&Lights, LightSampler),
        [p, n]: [&Vec3Lanes; 2],
        u_choice: &[f64; LANES],
        u: &mut [Lanes; 2],
    ) {
        let Some(choice) = lights.choose(by, lit, p, n, u_choice) else { return };
        let (mut surface, mut others) = (Mask::NONE, Mask::NONE);
        for k in each(lit & mask(|k| choice.pmf[k] > 0.0)) {
            match lights.triangle(choice.light[k] as usize) {
                Some(light) => {
                    surface.set(k, true);
                    self.choose_triangle(k, light, choice.pmf[k]);
                }
                None => others.set(k, true),
            }
        }
        if others.any() {
            lights.sample_others(by, others, &choice, [p, n], u, &mut self.chosen.other);
        }
        (self.surface, self.others, self.delta, self.light) = (surface, others, Mask::NONE, choice.light);
        if lights.has_patterns() {
            self.follow_patterns(lights, &choice.light, u);
        }
    }

    #[inline(never)]
    fn follow_patterns(&mut self, lights: &Lights, index: &[u32; LANES], u: &mut [Lanes; 2]) {
        for k in each(self.surface) {
            let Some((moved, density, factor)) = lights.warp(index[k] as usize, [u[0][k], u[1][k]]) else { continue };
            [u[0][k], u[1][k]] = moved;
            self.chosen.density[k] *= density;
            self.radiance.set(k, self.radiance.get(k) * factor);
        }
    }

    #[inline(always)]
    fn choose_triangle(&mut self, k: usize, light: &AreaLight, pmf: f32) {
        self.radiance.set(k, light.radiance);
        let chosen = &mut self.chosen;
        chosen.origin.set(k, light.origin);
        chosen.edges[0].set(k, light.edges[0]);
        chosen.edges[1].set(k, light.edges[1]);
        chosen.normal.set(k, light.normal);
        chosen.density[k] = light.density * pmf;
        chosen.two_sided[k] = light.two_sided as u32;
        (chosen.near[k], chosen.far[k]) = (light.error.near, light.error.far);
    }

    /// Draws the points on all triangles that were chosen, from places and numbers as in [`Self::choose`].
    pub fn resolve(&mut self, p: &Vec3Lanes, u: &[Lanes; 2]) {
        let (chosen, surface) = (&self.chosen, self.surface.lanes());
        for k in 0..LANES {
            let view = chosen.light(k).sample_from(p.get(k), [u[0][k], u[1][k]]);
            self.point.set(k, view.surface.point);
            self.wi.set(k, view.wi);
            self.pdf[k] = pick(surface.has(k), view.pdf, 0.0);
        }
        self.aimed = self.surface;
        for k in each(self.others) {
            self.take_other(k);
        }
    }

    #[inline]
    fn take_other(&mut self, k: usize) {
        if let Some(sample) = self.chosen.other[k] {
            self.wi.set(k, sample.wi);
            self.radiance.set(k, sample.radiance);
            self.pdf[k] = sample.pdf;
            self.delta.set(k, sample.delta);
            if let Some(LightPoint { point, normal, error }) = sample.target {
                self.aimed.set(k, true);
                self.point.set(k, point);
                self.chosen.normal.set(k, normal);
                (self.chosen.near[k], self.chosen.far[k]) = (error.near, error.far);
            }
        }
    }

    /// Numbers of the groups that the lights are in; any where nothing was drawn.
    #[inline(never)]
    pub fn groups(&self, lights: &Lights) -> [u32; LANES] {
        self.light.map(|light| lights.group(light))
    }

    /// What arrives from the lights if nothing stands between: `f`·radiance·`weight`/pdf. Any where nothing was drawn.
    #[inline(always)]
    pub fn contribution(&self, f: &Vec3Lanes, weight: &Lanes, contribution: &mut Vec3Lanes) {
        for k in 0..LANES {
            let light: Rgb = f.get(k) * self.radiance.get(k) * (weight[k] / self.pdf[k]);
            contribution.set(k, light);
        }
    }

    /// [`LightSample::shadow_ray`] for all, from just off the surfaces: origins, directions and lengths.
    #[inline(always)]
    pub fn shadow_rays(&self, surfaces: &Surfaces, origin: &mut Vec3Lanes, dir: &mut Vec3Lanes, tfar: &mut Lanes) {
        surfaces.spawn(&self.wi, origin);
        let aimed = self.aimed.lanes();
        for k in 0..LANES {
            let target = self.chosen.target(k, self.point.get(k));
            let way = target.point - origin.get(k);
            let distance = way.length();
            let wi = way / distance;
            dir.set(k, pick(aimed.has(k), wi, self.wi.get(k)));
            tfar[k] = pick(aimed.has(k), target.open_way(wi, distance), f32::INFINITY);
        }
    }
}

impl Chosen {
    /// The triangle of lane `k`, but for what does not matter to where its points are seen from.
    #[inline(always)]
    fn light(&self, k: usize) -> AreaLight {
        AreaLight {
            origin: self.origin.get(k),
            edges: [self.edges[0].get(k), self.edges[1].get(k)],
            normal: self.normal.get(k),
            density: self.density[k],
            radiance: Rgb::ZERO,
            two_sided: self.two_sided[k] != 0,
            error: Rounding::default(),
        }
    }

    /// Where the shadow ray of lane `k` ends.
    #[inline(always)]
    fn target(&self, k: usize, point: Vec3) -> LightPoint {
        LightPoint { point, normal: self.normal.get(k), error: Rounding { near: self.near[k], far: self.far[k] } }
    }
}

impl Default for LightSamples {
    fn default() -> LightSamples {
        LightSamples::new()
    }
}
