//! A packet of vertices on its way through the steps of a wave.

use super::guided::Guided;
use crate::bsdf::BsdfLanes;
use crate::geometry::Surfaces;
use crate::guiding::{GuideLanes, GuidingDistribution, Hue, Node};
use crate::integrator::mixture::{Densities, GuidedBy, GuidedLobes, Mixture};
use crate::integrator::roulette::Moments;
use crate::integrator::sampler::PathKeys;
use crate::light::LightSamples;
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Mask, Vec3Lanes, each, mask, pick};
use glam::Vec3;

/// A packet of vertices. What one step hands on to the next lies side by side, so that each writes and reads no more
/// than it needs.
pub(super) struct Packet<'a> {
    /// Place of the first ray in its wave; the others follow, a lane each.
    first: usize,
    pub(crate) surfaces: Surfaces<'a>,
    /// How surfaces scatter, where paths may go on.
    pub(crate) bsdfs: BsdfLanes<'a>,
    pub(crate) guided: [Option<Guided<'a>>; LANES],
    /// Of surfaces of other kinds than Lambert's: for which lobes the guide may stand in.
    lobes: [GuidedLobes; LANES],
    /// Where there are any.
    rough: Mask,
    /// Where directions are drawn from a product of guide and BSDF, and for which lobes.
    products: Mask,
    product_lobes: [GuidedLobes; LANES],
    /// Where the guide can help: its directions, where these are no tree, and the share that the BSDF keeps.
    led: Mask,
    directions: [Option<GuidingDistribution<'a>>; LANES],
    bsdf_fraction: Lanes,
    /// Its trees.
    trees: GuideLanes<'a>,
    /// Where a state has told what guided roulette goes by.
    has_moments: Mask,
    square: Lanes,
    variance: Lanes,
    expected: Lanes,
    hue: [Hue; LANES],
    /// Where a state has told how often shadow rays are open.
    has_visibility: Mask,
    open: Lanes,
    pub(crate) lights: LightSamples,
    /// By which lights are chosen, where that is by more than their power.
    pub(crate) light_normals: Vec3Lanes,
    /// The paths' random numbers.
    pub(crate) keys: PathKeys<LANES>,
}

impl<'a> Packet<'a> {
    pub(crate) fn new() -> Self {
        Packet {
            first: 0,
            surfaces: Surfaces::new(),
            bsdfs: BsdfLanes::new(),
            guided: [None; LANES],
            lobes: [GuidedLobes::ALL; LANES],
            rough: Mask::NONE,
            products: Mask::NONE,
            product_lobes: [GuidedLobes::ALL; LANES],
            led: Mask::NONE,
            directions: [const { None }; LANES],
            bsdf_fraction: [1.0; LANES],
            trees: GuideLanes::new(),
            has_moments: Mask::NONE,
            square: [0.0; LANES],
            variance: [0.0; LANES],
            expected: [0.0; LANES],
            hue: [Hue::GREY; LANES],
            has_visibility: Mask::NONE,
            open: [0.0; LANES],
            lights: LightSamples::new(),
            light_normals: Vec3Lanes::ZERO,
            keys: PathKeys::NONE,
        }
    }

    /// Begins with the rays from place `first` in their wave on.
    #[inline(always)]
    pub(crate) fn begin(&mut self, first: usize, keys: PathKeys<LANES>) {
        (self.first, self.keys) = (first, keys);
        (self.led, self.has_moments, self.bsdf_fraction) = (Mask::NONE, Mask::NONE, [1.0; LANES]);
        self.has_visibility = Mask::NONE;
        self.bsdfs.clear();
        self.trees.clear();
        self.lights.clear();
    }

    /// Place of ray `k` in its wave.
    #[inline(always)]
    pub(crate) fn ray(&self, k: usize) -> usize {
        self.first + k
    }

    /// The same of all rays.
    #[inline(always)]
    pub(crate) fn rays(&self) -> [u32; LANES] {
        let mut rays = [0; LANES];
        for k in 0..LANES {
            rays[k] = (self.first + k) as u32;
        }
        rays
    }

    /// Where rays met something.
    #[inline(always)]
    pub(crate) fn met(&self) -> Mask {
        self.surfaces.met()
    }

    /// [`Bsdf::albedo`] as each surface is seen; any where the path ends.
    #[inline(always)]
    pub(crate) fn albedo(&self, albedo: &mut Vec3Lanes) {
        self.bsdfs.diffuse().albedo(self.surfaces.wo_locals(), albedo);
        let together = self.bsdfs.albedo(self.surfaces.wo_locals(), albedo);
        for k in each(self.bsdfs.are() & !self.bsdfs.diffuse().are() & !together) {
            if let Some(bsdf) = self.bsdfs.get(k) {
                albedo.set(k, bsdf.albedo(self.surfaces.wo_local(k)));
            }
        }
    }

    /// Where surfaces have smooth lobes: only there can next-event estimation or a guide help.
    #[inline(always)]
    pub(crate) fn smooth(&self) -> Mask {
        let mut smooth = self.bsdfs.diffuse().are();
        for k in each(self.bsdfs.are() & !smooth) {
            smooth.set(k, self.bsdfs.get(k).is_some_and(|bsdf| bsdf.has_smooth()));
        }
        smooth
    }

    /// Finds the normals by which lights are chosen: on the side of the path, where no light gets through from the other.
    #[inline(always)]
    pub(crate) fn find_light_normals(&mut self) {
        self.surfaces.facing_normals(&mut self.light_normals);
        for k in each(self.bsdfs.are() & !self.bsdfs.diffuse().are()) {
            if self.bsdfs.get(k).is_some_and(|bsdf| !bsdf.is_opaque()) {
                self.light_normals.set(k, Vec3::ZERO);
            }
        }
    }

    /// Finds for which lobes a guide may stand in.
    #[inline(always)]
    pub(crate) fn find_guided_lobes(&mut self) {
        (self.rough, self.products) = (self.bsdfs.diffuse().are(), Mask::NONE);
        for k in each(self.bsdfs.are() & !self.rough) {
            let (Some(bsdf), wo) = (self.bsdfs.get(k), self.surfaces.wo_local(k)) else { continue };
            self.lobes[k] = GuidedLobes::of(&bsdf, wo, GuidedBy::Radiance);
            self.rough.set(k, self.lobes[k].share() > 0.0);
        }
    }

    /// For which lobes of vertex `k` a guide may stand in by itself. What comes back by these says something of the irradiance.
    #[inline(always)]
    pub(crate) fn lobes(&self, k: usize) -> GuidedLobes {
        if self.bsdfs.diffuse().are().has(k) { GuidedLobes::ALL } else { self.lobes[k] }
    }

    /// For which lobes of vertex `k` the guide draws, if it does.
    #[inline(always)]
    pub(crate) fn drawn_lobes(&self, k: usize) -> GuidedLobes {
        if self.products.has(k) { self.product_lobes[k] } else { self.lobes(k) }
    }

    /// The same where they are drawn from a product with the BSDF, which stands in for `lobes`.
    pub(crate) fn set_product(
        &mut self,
        k: usize,
        lobes: GuidedLobes,
        directions: GuidingDistribution<'a>,
        bsdf_fraction: f32,
    ) {
        self.products.set(k, true);
        self.product_lobes[k] = lobes;
        self.set_guide(k, directions, bsdf_fraction);
    }

    /// Where there are such products.
    pub(crate) fn products(&self) -> Mask {
        self.products
    }

    /// Where there are such lobes.
    #[inline(always)]
    pub(crate) fn rough(&self) -> Mask {
        self.rough
    }

    /// Where directions of a guide were taken.
    #[inline(always)]
    pub(crate) fn led(&self) -> Mask {
        self.led
    }

    /// Takes the guide's directions at vertex `k` and the share that the BSDF keeps.
    pub(crate) fn set_guide(&mut self, k: usize, directions: GuidingDistribution<'a>, bsdf_fraction: f32) {
        self.led.set(k, true);
        (self.directions[k], self.bsdf_fraction[k]) = (Some(directions), bsdf_fraction);
    }

    /// The same where they are a tree, over the hemisphere of `normal`. [`Self::resolve_trees`] is to follow.
    #[inline(always)]
    pub(crate) fn set_tree_guide(&mut self, k: usize, (normal, nodes): (Vec3, &'a [Node]), bsdf_fraction: f32) {
        self.trees.set(k, normal, nodes);
        self.led.set(k, true);
        self.bsdf_fraction[k] = bsdf_fraction;
    }

    /// Takes what the state at vertex `k` knows of what comes back to it.
    #[inline(always)]
    pub(crate) fn set_moments(&mut self, k: usize, Moments { square, variance, expected, hue }: Moments) {
        self.has_moments.set(k, true);
        (self.square[k], self.variance[k]) = (square, variance);
        (self.expected[k], self.hue[k]) = (expected, hue);
    }

    /// Where a state has told so much.
    #[inline(always)]
    pub(crate) fn has_moments(&self) -> Mask {
        self.has_moments
    }

    /// What it has told at vertex `k`; any where it has not.
    #[inline(always)]
    pub(crate) fn moments(&self, k: usize) -> Moments {
        let (square, variance) = (self.square[k], self.variance[k]);
        Moments { square, variance, expected: self.expected[k], hue: self.hue[k] }
    }

    /// Takes the share of shadow rays that are open from where vertex `k` is.
    #[inline(always)]
    pub(crate) fn set_visibility(&mut self, k: usize, open: f32) {
        self.has_visibility.set(k, true);
        self.open[k] = open;
    }

    /// Where it is known.
    #[inline(always)]
    pub(crate) fn has_visibility(&self) -> Mask {
        self.has_visibility
    }

    /// What it is; any where it is not known.
    #[inline(always)]
    pub(crate) fn open(&self) -> &Lanes {
        &self.open
    }

    /// What the states expect to come back by the lobes that a guide may stand in for, where surfaces reflect `albedo`; black where
    /// nothing is known.
    #[inline(always)]
    pub(crate) fn expected(&self, albedo: &Vec3Lanes, expected: &mut Vec3Lanes) {
        let mut share = [0.0; LANES];
        for k in each(self.has_moments) {
            share[k] = self.lobes(k).share();
        }
        let told = self.has_moments.lanes();
        for k in 0..LANES {
            let light = albedo.get(k) * self.hue[k].light() * (self.expected[k] * share[k]);
            expected.set(k, pick(told.has(k), light, Rgb::ZERO));
        }
    }

    /// All trees were taken.
    pub(crate) fn resolve_trees(&mut self) {
        self.trees.resolve();
    }

    /// The share of the directions that the BSDF keeps, where a guide draws the others; 1 elsewhere.
    #[inline(always)]
    pub(crate) fn bsdf_fraction(&self) -> &Lanes {
        &self.bsdf_fraction
    }

    pub(crate) fn trees(&self) -> &GuideLanes<'a> {
        &self.trees
    }

    /// What `use_it` makes of the way in which directions are drawn at vertex `k`; `None` where the path ends.
    #[inline(always)]
    pub(crate) fn with_mixture<R>(&self, k: usize, use_it: impl FnOnce(&Mixture) -> R) -> Option<R> {
        let (bsdf, tree) = (self.bsdfs.get(k)?, self.trees.get(k));
        let guide = tree.as_ref().or(self.directions[k].as_ref()).filter(|_| self.led.has(k));
        Some(use_it(&Mixture::new(&bsdf, guide, self.bsdf_fraction[k], self.drawn_lobes(k))))
    }

    /// Where directions are drawn by Lambert's law, alone or with a tree: both are known side by side.
    #[inline(always)]
    pub(crate) fn vectorised(&self) -> Mask {
        self.bsdfs.diffuse().are() & (!self.led | self.trees.are())
    }

    /// [`Mixture::eval_pdf`] towards the lights that were drawn. Lanes without a light sample are unspecified.
    pub(crate) fn eval_pdf(&self, f: &mut Vec3Lanes, pdf: &mut Lanes) {
        let (surfaces, wi) = (&self.surfaces, &self.lights.wi);
        let mut local = Vec3Lanes::ZERO;
        surfaces.to_local(wi, &mut local);
        self.bsdfs.diffuse().eval_pdf(surfaces.wo_locals(), &local, f, pdf);
        let drawn = &self.lights.pdf;
        let asked = mask(|k| drawn[k] > 0.0);
        let together = self.bsdfs.eval_pdf(asked & !self.led, [surfaces.wo_locals(), &local], f, pdf);
        for k in 0..LANES {
            let lit = surfaces.consistent(k, wi.get(k));
            f.set(k, pick(lit, f.get(k), Rgb::ZERO));
            pdf[k] = pick(lit, pdf[k], 0.0);
        }
        if self.trees.any() {
            self.mix_trees(f, pdf);
        }
        for k in each(asked & !self.vectorised() & !together) {
            let (si, wo, wi) = (surfaces.get(k), surfaces.wo_local(k), wi.get(k));
            if let Some((value, density)) = self.with_mixture(k, |mixture| mixture.eval_pdf(&si, wo, wi)) {
                f.set(k, value);
                pdf[k] = density;
            }
        }
    }

    /// Makes densities of the BSDF those of its mixture with a tree, where there is one and `f` is not black.
    #[inline(always)]
    fn mix_trees(&self, f: &Vec3Lanes, pdf: &mut Lanes) {
        let mut guide = [0.0; LANES];
        let drawn = &self.lights.pdf;
        self.trees.pdf(mask(|k| (f.get(k) != Rgb::ZERO) & (drawn[k] > 0.0)), &self.lights.wi, &mut guide);
        let trees = self.trees.are().lanes();
        for k in 0..LANES {
            let mixed = Densities::mixed(self.bsdf_fraction[k], pdf[k], guide[k]).mixture;
            pdf[k] = pick(trees.has(k) & (f.get(k) != Rgb::ZERO), mixed, pdf[k]);
        }
    }
}
