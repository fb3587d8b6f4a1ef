//! The BSDFs of a packet.

use super::microfacet::sin_cos_turn;
use super::{Bsdf, BsdfModel, DiffuseLanes, Scatter, mirrored};
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Mask, MaskLanes, Vec3Lanes, each, pick};
use glam::Vec3;

/// From so many surfaces of a material on, all lanes together take less time than these one by one. Without AVX-512 compilers leave
/// loops with table look-ups as they are, and there is no such number.
const FEWEST: u64 = if cfg!(target_feature = "avx512vl") { 3 } else { u64::MAX };

/// As many groups of three as a packet can have.
const GROUPS: usize = LANES / 3;

/// The BSDFs of a packet, as a structure of arrays. (Structures that are stored field by field and loaded at once would stall on
/// store forwarding.)
pub(crate) struct BsdfLanes<'s> {
    are: Mask,
    model: [Option<&'s BsdfModel>; LANES],
    colors: [Vec3Lanes; 2],
    /// Where surfaces scatter about another normal than that of the shading frame, and that normal.
    turned: Mask,
    normal: Vec3Lanes,
    diffuse: DiffuseLanes,
    /// Surfaces of other materials that are evaluated side by side, material by material: the first `group_count` are in use.
    groups: [Mask; GROUPS],
    group_count: usize,
}

impl<'s> BsdfLanes<'s> {
    pub fn new() -> BsdfLanes<'s> {
        BsdfLanes {
            are: Mask::NONE,
            model: [None; LANES],
            colors: [Vec3Lanes::ZERO; 2],
            turned: Mask::NONE,
            normal: Vec3Lanes::ZERO,
            diffuse: DiffuseLanes::new(),
            groups: [Mask::NONE; GROUPS],
            group_count: 0,
        }
    }

    /// Forgets all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.are = Mask::NONE;
        self.diffuse.clear();
        self.group_count = 0;
    }

    #[inline(always)]
    pub fn set(&mut self, k: usize, bsdf: &Bsdf<'s>) {
        self.are.set(k, true);
        self.model[k] = Some(bsdf.model);
        self.colors[0].set(k, bsdf.colors[0]);
        self.colors[1].set(k, bsdf.colors[1]);
        self.turned.set(k, bsdf.normal.is_some());
        if let Some(normal) = bsdf.normal {
            self.normal.set(k, normal);
        }
        self.diffuse.set(k, bsdf);
    }

    /// What was set since all was forgotten.
    #[inline(always)]
    pub fn get(&self, k: usize) -> Option<Bsdf<'s>> {
        let model = self.model[k].filter(|_| self.are.has(k))?;
        let normal = self.turned.has(k).then(|| self.normal.get(k));
        Some(Bsdf { model, colors: [self.colors[0].get(k), self.colors[1].get(k)], normal })
    }

    /// Where something was set.
    #[inline(always)]
    pub fn are(&self) -> Mask {
        self.are
    }

    /// Those that are Lambertian.
    #[inline(always)]
    pub fn diffuse(&self) -> &DiffuseLanes {
        &self.diffuse
    }

    /// Finds which of the others can be evaluated side by side, now that all are set.
    #[inline(always)]
    pub fn find_groups(&mut self) {
        self.find_groups_of(FEWEST);
    }

    /// The same where groups have at least `fewest` surfaces, which are three or more.
    #[inline(always)]
    pub(super) fn find_groups_of(&mut self, fewest: u64) {
        let mut left = self.are & !self.diffuse.are() & !self.turned;
        while left.count() >= fewest {
            let Some(model) = each(left).next().and_then(|k| self.model[k]) else { return };
            let mut same = Mask::NONE;
            for k in each(left) {
                same.set(k, self.model[k].is_some_and(|other| std::ptr::eq(model, other)));
            }
            left = left & !same;
            if model.in_lanes() && same.count() >= fewest {
                self.groups[self.group_count] = same;
                self.group_count += 1;
            }
        }
    }

    /// The groups, each with its material.
    #[inline(always)]
    fn groups(&self) -> impl Iterator<Item = (Mask, &'s BsdfModel)> {
        let groups = self.groups[..self.group_count].iter();
        groups.filter_map(|&group| Some((group, self.model[each(group).next()?]?)))
    }

    /// [`Bsdf::eval_pdf`] of those of `lanes` that are in a group; which these are. Other lanes are left as they are.
    #[inline(always)]
    pub fn eval_pdf(&self, lanes: Mask, [wo, wi]: [&Vec3Lanes; 2], f: &mut Vec3Lanes, pdf: &mut Lanes) -> Mask {
        let mut done = Mask::NONE;
        for (group, model) in self.groups().filter(|(group, _)| (*group & lanes).any()) {
            model.eval_pdf_lanes(&self.same_material(group & lanes, model, wo), wi, f, pdf);
            done = done | group & lanes;
        }
        done
    }

    /// [`Bsdf::albedo`] of those that are in a group; which these are. Other lanes are left as they are.
    #[inline(always)]
    pub fn albedo(&self, wo: &Vec3Lanes, albedo: &mut Vec3Lanes) -> Mask {
        let mut done = Mask::NONE;
        for (group, model) in self.groups() {
            model.albedo_lanes(&self.same_material(group, model, wo), albedo);
            done = done | group;
        }
        done
    }

    /// [`Bsdf::sample`] of those of `lanes` that are in a group which draws side by side: directions `wi`, weights and densities,
    /// which are 0 where nothing is drawn; which lanes these are. Other lanes are left as they are. No lobe is a delta distribution.
    #[inline(always)]
    pub fn sample(
        &self,
        lanes: Mask,
        wo: &Vec3Lanes,
        (lobe, u): (&Lanes, &[Lanes; 2]),
        [wi, weight]: [&mut Vec3Lanes; 2],
        pdf: &mut Lanes,
    ) -> Mask {
        let mut done = Mask::NONE;
        for (group, model) in self.groups().filter(|(group, model)| (*group & lanes).any() && model.draws_in_lanes()) {
            let surfaces = self.same_material(group & lanes, model, wo);
            model.draw_lanes(&surfaces, &LobeNumbers::new(group & lanes, lobe, u), wi);
            model.eval_pdf_lanes(&surfaces, wi, weight, pdf);
            done = done | group & lanes;
        }
        let drawn = done.lanes();
        for k in 0..LANES {
            weight.set(k, pick(drawn.has(k), weight.get(k) / pdf[k], weight.get(k)));
        }
        done
    }

    #[inline(always)]
    fn same_material<'a>(&'a self, lanes: Mask, model: &BsdfModel, wo: &'a Vec3Lanes) -> SameMaterial<'a> {
        SameMaterial { are: lanes.lanes(), turns: model.turns(), colors: &self.colors, wo }
    }
}

/// Random numbers with which surfaces of a packet draw.
pub(crate) struct LobeNumbers<'a> {
    lobe: &'a Lanes,
    u: &'a [Lanes; 2],
    /// [`sin_cos_turn`] of the first of these. It is a call, and so no part of a loop that is to run in vectors.
    turn: [Lanes; 2],
}

impl<'a> LobeNumbers<'a> {
    #[inline(always)]
    fn new(lanes: Mask, lobe: &'a Lanes, u: &'a [Lanes; 2]) -> LobeNumbers<'a> {
        let mut turn = [[0.0; LANES]; 2];
        for k in each(lanes) {
            (turn[0][k], turn[1][k]) = sin_cos_turn(u[0][k]);
        }
        LobeNumbers { lobe, u, turn }
    }
}

/// Surfaces of one material in a packet, by the directions in which they are seen. What a material makes of one surface becomes
/// here a loop over all lanes.
pub(crate) struct SameMaterial<'a> {
    are: MaskLanes,
    /// Whether they scatter to both sides alike.
    turns: bool,
    colors: &'a [Vec3Lanes; 2],
    wo: &'a Vec3Lanes,
}

impl SameMaterial<'_> {
    /// As [`Bsdf::eval_pdf`]; `at` makes a surface of its colours.
    #[inline(always)]
    pub fn eval_pdf<S: Scatter>(&self, wi: &Vec3Lanes, at: impl Fn([Rgb; 2]) -> S, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        for k in 0..LANES {
            let (wo, wi) = (self.wo.get(k), wi.get(k));
            let turned = self.turns & (wo.z < 0.0);
            let (wo, wi) = (pick(turned, mirrored(wo), wo), pick(turned, mirrored(wi), wi));
            let (value, density) = at(self.colors(k)).eval_pdf(wo, wi);
            f.set(k, pick(self.are.has(k), value, f.get(k)));
            pdf[k] = pick(self.are.has(k), density, pdf[k]);
        }
    }

    /// Directions that `draw` makes of colours, of the direction to the viewer, of the number that chooses the lobe, of those that
    /// choose the direction and of [`sin_cos_turn`] of the first of them. Where there is none it is zero, for which nothing scatters.
    #[inline(always)]
    pub fn draw(
        &self,
        numbers: &LobeNumbers,
        draw: impl Fn([Rgb; 2], Vec3, f32, [f32; 2], (f32, f32)) -> Option<Vec3>,
        wi: &mut Vec3Lanes,
    ) {
        let LobeNumbers { lobe, u, turn } = numbers;
        for k in 0..LANES {
            let wo = self.wo.get(k);
            let turned = self.turns & (wo.z < 0.0);
            let wo = pick(turned, mirrored(wo), wo);
            let drawn = draw(self.colors(k), wo, lobe[k], [u[0][k], u[1][k]], (turn[0][k], turn[1][k]));
            let drawn = drawn.unwrap_or(Vec3::ZERO);
            let drawn = pick(turned, mirrored(drawn), drawn);
            wi.set(k, pick(self.are.has(k), drawn, wi.get(k)));
        }
    }

    /// As [`Bsdf::albedo`].
    #[inline(always)]
    pub fn albedo<S: Scatter>(&self, at: impl Fn([Rgb; 2]) -> S, albedo: &mut Vec3Lanes) {
        for k in 0..LANES {
            let wo = self.wo.get(k);
            let wo = pick(self.turns & (wo.z < 0.0), mirrored(wo), wo);
            let value = at(self.colors(k)).albedo(wo).clamp(Rgb::ZERO, Rgb::ONE);
            albedo.set(k, pick(self.are.has(k), value, albedo.get(k)));
        }
    }

    #[inline(always)]
    fn colors(&self, k: usize) -> [Rgb; 2] {
        [self.colors[0].get(k), self.colors[1].get(k)]
    }
}

impl Default for BsdfLanes<'_> {
    fn default() -> Self {
        BsdfLanes::new()
    }
}
