//! The list of directional models. A new one is a file of its own, a line here, and a name in the settings.

use super::bins::{BinDirections, HemisphereBins, SphereBins};
use super::hemitree::{HemisphereTree, Node, TreeDirections};
use super::quadtree::{Quadtree, SphereQuadtree};
use super::{
    DirectionalModel, Directions, Entry, Evaluator, GlossyLobe, InFrame, Normals, PROFILE, SamplingOptions, Totals,
};
use crate::guiding::recorder::Transition;
use crate::guiding::settings::{DirectionTable, GuidingMethod, GuidingSettings, Rate};
use crate::simd::Vec3Lanes;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

macro_rules! models {
    ($($name:ident: $type:ty => $directions:ty),* $(,)?) => {
        /// Any of the models.
        #[derive(Clone, Debug)]
        pub enum Model {
            $($name($type)),*
        }

        /// What is learnt by any of them. Variants are told apart by their order in files: new ones come last.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Learnt {
            $($name(<$type as DirectionalModel>::Learnt)),*
        }

        /// Where any of them locates directions.
        pub enum Located {
            $($name(<$type as DirectionalModel>::Located)),*
        }

        /// What any of them freezes.
        pub enum Frozen {
            $($name(<$type as DirectionalModel>::Frozen)),*
        }

        /// The pools of all models; only one of them is ever filled.
        #[derive(Clone, Debug, Default)]
        #[allow(non_snake_case, reason = "one field for each variant")]
        pub struct Pool {
            $($name: <$type as DirectionalModel>::Pool),*
        }

        /// Directions of any of them.
        #[derive(Clone, Debug)]
        pub enum AnyDirections<'f> {
            $($name($directions)),*
        }

        impl Directions for AnyDirections<'_> {
            #[inline(always)]
            fn sample(&self, u: f64, inside: [f32; 2]) -> (Vec3, f32) {
                match self {
                    $(AnyDirections::$name(it) => it.sample(u, inside)),*
                }
            }

            #[inline(always)]
            fn pdf(&self, local: Vec3) -> f32 {
                match self {
                    $(AnyDirections::$name(it) => it.pdf(local)),*
                }
            }

            fn times(&self, value: impl Fn(Vec3) -> f32) -> Self {
                match self {
                    $(AnyDirections::$name(it) => AnyDirections::$name(it.times(value))),*
                }
            }
        }

        /// Calls what all models have, `$learnt` being what the model itself has learnt.
        macro_rules! each {
            ($self:expr, $model:ident => $call:expr) => {
                match $self {
                    $(Model::$name($model) => $call),*
                }
            };
            ($self:expr, $of:expr, $model:ident, $learnt:ident => $call:expr) => {
                match ($self, $of) {
                    $((Model::$name($model), Learnt::$name($learnt)) => $call,)*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            };
        }

        impl DirectionalModel for Model {
            type Learnt = Learnt;
            type Located = Located;
            type Frozen = Frozen;
            type Pool = Pool;
            type Directions<'f> = AnyDirections<'f>;

            fn untrained(&self) -> Learnt {
                match self {
                    $(Model::$name(model) => Learnt::$name(model.untrained())),*
                }
            }

            #[inline(always)]
            fn locate(&self, about: &Vec3Lanes, wi: &Vec3Lanes) -> Located {
                match self {
                    $(Model::$name(model) => Located::$name(model.locate(about, wi))),*
                }
            }

            #[inline(always)]
            fn record(&self, learnt: &mut Learnt, at: &Located, k: usize, transition: &Transition, rate: Rate) {
                match (self, learnt, at) {
                    $((Model::$name(model), Learnt::$name(learnt), Located::$name(at)) => {
                        model.record(learnt, at, k, transition, rate)
                    })*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            }

            fn entries_mut<'l>(&self, learnt: &'l mut Learnt) -> &'l mut [Entry] {
                each!(self, learnt, model, learnt => model.entries_mut(learnt))
            }

            fn entry_index(&self, learnt: &Learnt, at: &Located, k: usize) -> Option<usize> {
                match (self, learnt, at) {
                    $((Model::$name(model), Learnt::$name(learnt), Located::$name(at)) => {
                        model.entry_index(learnt, at, k)
                    })*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            }

            fn decay(&self, learnt: &mut Learnt, share: f32) {
                each!(self, learnt, model, learnt => model.decay(learnt, share))
            }

            fn is_informed(&self, learnt: &Learnt) -> bool {
                each!(self, learnt, model, learnt => model.is_informed(learnt))
            }

            fn end_iteration(&self, learnt: &mut Learnt) {
                each!(self, learnt, model, learnt => model.end_iteration(learnt))
            }

            fn refined(&self, learnt: &Learnt, coarseness: f32) -> Option<Learnt> {
                match (self, learnt) {
                    $((Model::$name(model), Learnt::$name(learnt)) => {
                        model.refined(learnt, coarseness).map(Learnt::$name)
                    })*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            }

            fn is_coarsest(&self, coarseness: f32) -> bool {
                each!(self, model => model.is_coarsest(coarseness))
            }

            fn profile(&self, learnt: &Learnt) -> [f32; PROFILE] {
                each!(self, learnt, model, learnt => model.profile(learnt))
            }

            fn freeze(&self, learnt: &Learnt, options: &SamplingOptions, fraction: f32) -> (Frozen, Totals) {
                match (self, learnt) {
                    $((Model::$name(model), Learnt::$name(learnt)) => {
                        let (frozen, totals) = model.freeze(learnt, options, fraction);
                        (Frozen::$name(frozen), totals)
                    })*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            }

            fn append(&self, frozen: Frozen, pool: &mut Pool) -> Range<u32> {
                match (self, frozen) {
                    $((Model::$name(model), Frozen::$name(frozen)) => model.append(frozen, &mut pool.$name),)*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => unreachable!("a region's directions are those of the model"),
                }
            }

            #[inline(always)]
            fn directions<'f>(
                &'f self,
                pool: &'f Pool,
                range: Range<usize>,
                normals: Normals,
                options: &SamplingOptions,
            ) -> InFrame<AnyDirections<'f>> {
                match self {
                    $(Model::$name(model) => {
                        let InFrame { frame, directions } = model.directions(&pool.$name, range, normals, options);
                        InFrame { frame, directions: AnyDirections::$name(directions) }
                    })*
                }
            }

            #[inline(always)]
            fn tree<'f>(&self, pool: &'f Pool, range: Range<usize>) -> Option<&'f [Node]> {
                match self {
                    $(Model::$name(model) => model.tree(&pool.$name, range)),*
                }
            }

            #[inline(always)]
            fn product<'f>(
                &'f self,
                pool: &'f Pool,
                range: Range<usize>,
                about: Vec3,
                lobe: &GlossyLobe,
            ) -> Option<InFrame<AnyDirections<'f>>> {
                match self {
                    $(Model::$name(model) => {
                        let InFrame { frame, directions } = model.product(&pool.$name, range, about, lobe)?;
                        Some(InFrame { frame, directions: AnyDirections::$name(directions) })
                    })*
                }
            }

            fn evaluator<'l>(&'l self, learnt: &'l Learnt, smoothing: f32) -> Evaluator<'l> {
                each!(self, learnt, model, learnt => model.evaluator(learnt, smoothing))
            }

            fn nodes(&self, learnt: &Learnt) -> usize {
                each!(self, learnt, model, learnt => model.nodes(learnt))
            }

            fn bytes(&self, learnt: &Learnt) -> usize {
                each!(self, learnt, model, learnt => model.bytes(learnt))
            }

            fn usual_bytes(&self) -> usize {
                each!(self, model => model.usual_bytes())
            }

            fn pool_bytes(&self, pool: &Pool) -> usize {
                match self {
                    $(Model::$name(model) => model.pool_bytes(&pool.$name)),*
                }
            }

            fn is_sound(&self, learnt: &Learnt) -> bool {
                match (self, learnt) {
                    $((Model::$name(model), Learnt::$name(learnt)) => model.is_sound(learnt),)*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => false,
                }
            }
        }
    };
}

models! {
    Tree: HemisphereTree => TreeDirections<'f>,
    Hemisphere: HemisphereBins => BinDirections<'f>,
    Sphere: SphereBins => BinDirections<'f>,
    Quadtree: SphereQuadtree => Quadtree<'f>,
}

impl Model {
    /// The one that the settings ask for.
    pub fn new(settings: &GuidingSettings) -> Model {
        if settings.method == GuidingMethod::SdTree {
            let (rho, filter) = (settings.rho, settings.directional_filter);
            return Model::Quadtree(SphereQuadtree::within(rho, filter, settings.memory));
        }
        match settings.table {
            DirectionTable::Hemisphere => Model::Hemisphere(HemisphereBins::new(settings.strata)),
            DirectionTable::Sphere => Model::Sphere(SphereBins::new(settings.strata)),
            DirectionTable::Tree => Model::Tree(HemisphereTree::new(settings.split_share, settings.split_visits)),
        }
    }
}
