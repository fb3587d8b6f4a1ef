//! All lights of a scene, and the one sampler over them.

use super::choice::PowerLightSampler;
use super::leaves;
use super::pattern::{Fineness, TrianglePattern};
use super::source::LightSource;
use super::tree::{Choice, ChoiceLanes, LightTree};
use super::triangle::{AreaLight, EmissiveTriangle, View};
use super::{EmitterPattern, Light, LightSample, LightSampleContext, LightSampler};
use crate::math::Rgb;
use crate::simd::{LANES, Mask, Vec3Lanes, each, mask};
use crate::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// All lights of a scene.
///
/// [`LightSampler::Tree`] chooses a light by an estimate of what it sends to the point in question. [`LightSampler::Power`]
/// does so with probability proportional to the luminance of its power in watts: L·π·A for each emitting side of a triangle,
/// times the mean of its pattern; 4π·I for a point; and what reaches a scene whose bounding sphere has the radius R,
/// πR²·∫L dω for the surroundings (4π²R²·L where constant) and πR²·E for a directional light. Only ratios matter, so a
/// common factor on all emission changes nothing.
#[derive(Clone, Debug)]
pub(crate) struct Lights {
    /// Indices of the choice: first the triangles, then `others`.
    triangles: Vec<AreaLight>,
    others: Vec<Light>,
    /// By triangle, where the emission varies over it; empty where that of no light does.
    patterns: Vec<Option<TrianglePattern>>,
    /// Numbers of the groups of triangles and others; empty where all are in group 0.
    groups: Vec<u32>,
    /// Light by (mesh, triangle).
    ids: FxHashMap<(u32, u32), u32>,
    power: PowerLightSampler,
    pub(super) tree: LightTree,
}

impl Lights {
    /// What a triangle takes at most while [`Self::build`] runs: as it comes, as a light, its power and share, its
    /// place in a hash table that has just grown, and the tree.
    pub const BYTES_PER_TRIANGLE: u64 =
        (size_of::<EmissiveTriangle>() + 2 * size_of::<AreaLight>() + 96) as u64 + LightTree::BYTES_PER_LIGHT;

    /// `scene_radius`: of a sphere around all surfaces, which sets how far lights at infinity compare with near ones.
    /// Triangles without area or radiance are left out. An error where a number is negative, infinite or undefined, or
    /// where a triangle is named twice.
    pub(crate) fn build(triangles: &[EmissiveTriangle], others: Vec<Light>, scene_radius: f32) -> Result<Lights> {
        if !(scene_radius.is_finite() && scene_radius >= 0.0) {
            return Err(Error::Scene(format!("the scene has the radius {scene_radius}")));
        }
        let others = others.into_iter().map(Light::checked).collect::<Result<Vec<_>>>()?;
        let mut ids = FxHashMap::default();
        let (mut lights, mut areas, mut patterns, mut groups) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for t in triangles {
            let Some((light, area)) = AreaLight::new(t)? else { continue };
            if ids.insert((t.mesh, t.triangle), lights.len() as u32).is_some() {
                let (mesh, triangle) = (t.mesh, t.triangle);
                let message = format!("triangle {triangle} of mesh {mesh} is a light twice");
                return Err(Error::Scene(message));
            }
            lights.push(light);
            areas.push(area);
            patterns.push(t.pattern.as_ref().map(|pattern| (pattern, t.triangle)));
            groups.push(t.group);
        }
        let patterns = prepared(&patterns);
        let section = PI * (scene_radius as f64).powi(2);
        let far = others.iter().map(|light| light.power(section));
        let mean = |k: usize| patterns.get(k).and_then(Option::as_ref).map_or(Rgb::ONE, TrianglePattern::mean);
        let near = lights.iter().zip(&areas).enumerate().map(|(k, (light, &area))| light.power(area, mean(k)));
        let power = PowerLightSampler::new(&near.chain(far).collect::<Vec<_>>());
        let tree = leaves::tree((&lights, &areas, &patterns), &others, scene_radius);
        Ok(Lights { triangles: lights, others, patterns, groups, ids, power, tree }.with_groups(&[]))
    }

    /// With the groups of the lights that are no triangles, where any is in one.
    pub fn with_groups(mut self, others: &[u32]) -> Lights {
        self.groups.resize(self.triangles.len(), 0);
        self.groups.extend_from_slice(others);
        if self.groups.iter().all(|group| *group == 0) {
            self.groups = Vec::new();
        }
        self
    }

    /// The group of the light `index` of the choice.
    #[inline]
    pub(super) fn group(&self, index: u32) -> u32 {
        self.groups.get(index as usize).copied().unwrap_or(0)
    }

    /// The group that all surroundings are in.
    pub fn group_of_surroundings(&self) -> u32 {
        let first = self.surroundings().next();
        first.map_or(0, |(k, _)| self.group((self.triangles.len() + k) as u32))
    }

    /// Luminance of the power of each light that is no surface, in W times the lights' unit, where the scene has this radius.
    pub fn far_powers(&self, scene_radius: f32) -> Vec<f64> {
        let section = PI * f64::from(scene_radius).powi(2);
        self.others.iter().map(|light| light.power(section)).collect()
    }

    /// Whether the choice of a light depends on the point.
    pub fn look_at_points(&self, by: LightSampler) -> bool {
        by == LightSampler::Tree && !self.tree.is_single()
    }

    /// Whether no light has any power, so that there is nothing to sample.
    pub fn are_black(&self) -> bool {
        self.power.is_empty()
    }

    /// The light that triangle `triangle` of mesh `mesh` is, if it is one.
    pub fn triangle_light(&self, mesh: u32, triangle: u32) -> Option<u32> {
        self.ids.get(&(mesh, triangle)).copied()
    }

    /// A direction from a point to a light. `u_choice` chooses the light (and a cell of the surroundings) and needs more
    /// bits than an `f32` has where powers differ by more than 10⁵; `u` chooses the point on it. All in [0, 1).
    /// `None` where the chosen light sends nothing to the point: that sample counts as zero.
    pub fn sample(
        &self,
        by: LightSampler,
        ctx: &LightSampleContext,
        u_choice: f64,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let choice = match by {
            LightSampler::Tree => self.tree.choose(ctx, u_choice),
            LightSampler::Power => self.power.choose(u_choice),
        }?;
        if (choice.light as usize) < self.triangles.len() {
            usable(self.sample_triangle(&choice, ctx.p, u))
        } else {
            self.sample_other(by, &choice, ctx, u)
        }
    }

    /// Lights for the lanes of `lit`, as of [`Self::sample`]; `None` where there is no light.
    #[inline(always)]
    pub(super) fn choose(
        &self,
        by: LightSampler,
        lit: Mask,
        p: &Vec3Lanes,
        n: &Vec3Lanes,
        u_choice: &[f64; LANES],
    ) -> Option<ChoiceLanes> {
        match by {
            LightSampler::Tree => Some(self.tree.choose_lanes(lit, p, n, u_choice)),
            LightSampler::Power => self.power.choose_lanes(u_choice),
        }
    }

    /// The light `index` of the choice, where it is a triangle.
    #[inline]
    pub(super) fn triangle(&self, index: usize) -> Option<&AreaLight> {
        self.triangles.get(index)
    }

    /// Whether the emission of any triangle varies.
    #[inline]
    pub(super) fn has_patterns(&self) -> bool {
        !self.patterns.is_empty()
    }

    /// Where the triangle `index` draws its point with the numbers `u`: the numbers of that point, by how much its density is
    /// that of uniform points, and by what the emission is multiplied there. `None` where it emits the same everywhere.
    pub(super) fn warp(&self, index: usize, u: [f32; 2]) -> Option<([f32; 2], f32, Rgb)> {
        let pattern = self.pattern(index)?;
        let (u, density) = pattern.warp(u);
        Some((u, density, pattern.at(u)))
    }

    fn pattern(&self, index: usize) -> Option<&TrianglePattern> {
        self.patterns.get(index)?.as_ref()
    }

    /// [`Self::sample`] where the choice has fallen on a light that is no triangle.
    fn sample_other(
        &self,
        by: LightSampler,
        choice: &Choice,
        ctx: &LightSampleContext,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let k = choice.light as usize - self.triangles.len();
        self.weighed(by, choice, ctx, self.others[k].sample(ctx.p, choice.rest, u)?)
    }

    /// The same for the `lanes` of a packet; others are left as they are.
    pub(super) fn sample_others(
        &self,
        by: LightSampler,
        lanes: Mask,
        choice: &ChoiceLanes,
        [p, n]: [&Vec3Lanes; 2],
        u: &[[f32; LANES]; 2],
        samples: &mut [Option<LightSample>; LANES],
    ) {
        let mut left = lanes;
        while let Some(first) = each(left).next() {
            let light = choice.light[first];
            let same = left & mask(|k| choice.light[k] == light);
            self.others[light as usize - self.triangles.len()].sample_lanes(same, p, &choice.rest, u, samples);
            left = left & !same;
        }
        for k in each(lanes) {
            let ctx = LightSampleContext { p: p.get(k), n: n.get(k) };
            samples[k] = samples[k].and_then(|sample| self.weighed(by, &choice.get(k), &ctx, sample));
        }
    }

    /// A draw from the light that was chosen as one from all lights.
    fn weighed(
        &self,
        by: LightSampler,
        choice: &Choice,
        ctx: &LightSampleContext,
        mut sample: LightSample,
    ) -> Option<LightSample> {
        let k = choice.light as usize - self.triangles.len();
        if sample.delta {
            sample.pdf *= choice.pmf;
        } else {
            // surroundings shine from the same directions: their radiances and their densities add
            let others = || self.surroundings().filter(|&(other, _)| other != k);
            sample.radiance += others().map(|(_, light)| light.radiance(sample.wi)).sum::<Rgb>();
            sample.pdf = sample.pdf * choice.pmf + self.pdf_of(by, ctx, others(), sample.wi);
        }
        usable(sample)
    }

    /// Density per steradian with which [`Self::sample`] draws the point `y` of the triangle `light` (from
    /// [`Self::triangle_light`]), the choice of the light included: pmf·d²/(A·cosθ), times the density of its pattern at the
    /// barycentric `weights` of the second and third corner. 0 where it never would.
    pub fn pdf_triangle(
        &self,
        by: LightSampler,
        ctx: &LightSampleContext,
        light: u32,
        y: Vec3,
        weights: [f32; 2],
    ) -> f32 {
        let pmf = match by {
            LightSampler::Tree => self.tree.root(ctx).pmf(light),
            LightSampler::Power => self.power.pmf(light as usize),
        };
        let triangle = self.triangles[light as usize].denser(pmf);
        match self.pattern(light as usize) {
            None => triangle.pdf(ctx.p, y),
            Some(pattern) => triangle.denser(pattern.density(weights)).pdf(ctx.p, y),
        }
    }

    /// Radiance of all surroundings together from `wi` (unit), for a ray that leaves the scene.
    #[inline(always)]
    pub fn environment_radiance(&self, wi: Vec3) -> Rgb {
        if self.others.is_empty() { Rgb::ZERO } else { self.sum_of_surroundings(wi) }
    }

    fn sum_of_surroundings(&self, wi: Vec3) -> Rgb {
        self.others.iter().map(|light| light.radiance(wi)).sum()
    }

    /// Whether a ray that leaves the scene sees a background.
    pub fn has_surroundings(&self) -> bool {
        self.others.iter().any(Light::surrounds)
    }

    /// Density per steradian with which [`Self::sample`] draws `wi` (unit) as a direction to the surroundings, the
    /// choice of the light included.
    pub fn pdf_environment(&self, by: LightSampler, ctx: &LightSampleContext, wi: Vec3) -> f32 {
        self.pdf_of(by, ctx, self.surroundings(), wi)
    }

    fn surroundings(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.others.iter().enumerate().filter(|(_, light)| light.surrounds())
    }

    fn pdf_of<'a>(
        &self,
        by: LightSampler,
        ctx: &LightSampleContext,
        mut lights: impl Iterator<Item = (usize, &'a Light)>,
        wi: Vec3,
    ) -> f32 {
        let Some(first) = lights.next() else { return 0.0 };
        let root = matches!(by, LightSampler::Tree).then(|| self.tree.root(ctx));
        let pdf = |(k, light): (usize, &Light)| {
            let index = self.triangles.len() + k;
            root.as_ref().map_or_else(|| self.power.pmf(index), |root| root.pmf(index as u32)) * light.pdf(wi)
        };
        std::iter::once(first).chain(lights).map(pdf).sum()
    }

    fn sample_triangle(&self, choice: &Choice, p: Vec3, u: [f32; 2]) -> LightSample {
        let index = choice.light as usize;
        let light = self.triangles[index].denser(choice.pmf);
        let (u, density, factor) = self.warp(index, u).unwrap_or((u, 1.0, Rgb::ONE));
        let View { surface, wi, pdf } = light.denser(density).sample_from(p, u);
        let radiance = light.radiance * factor;
        LightSample { wi, radiance, pdf, delta: false, target: Some(surface) }
    }
}

/// The patterns of triangles, in their order; empty where there are none.
fn prepared(patterns: &[Option<(&Arc<dyn EmitterPattern>, u32)>]) -> Vec<Option<TrianglePattern>> {
    if patterns.iter().all(Option::is_none) {
        return Vec::new();
    }
    let fineness = Fineness::of(patterns.iter().flatten().map(|(pattern, triangle)| pattern.texels(*triangle)));
    let new = |&(pattern, triangle)| TrianglePattern::new(pattern, triangle, fineness);
    patterns.par_iter().map(|pattern| pattern.as_ref().map(new)).collect()
}

/// A sample that can be weighed.
#[inline(always)]
fn usable(sample: LightSample) -> Option<LightSample> {
    (sample.pdf > 0.0 && sample.pdf.is_finite() && sample.radiance.is_finite()).then_some(sample)
}
