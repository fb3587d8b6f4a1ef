//! The list of spatial partitions. A new one is a file of its own, a line here, and a name in the settings.

use super::voronoi::SurfaceVoronoi;
use super::{Gathered, Grid, KdTree, RegionId, RegionLookup, SpatialPartition, TwoLevelGrid};
use crate::guiding::settings::{GuidingMethod, GuidingSettings};
use crate::simd::{LANES, Mask, Vec3Lanes};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Divisor of the memory budget: the coarse cells of a two-level grid take at most 1/8 of it.
const CELLS_SHARE: u64 = 8;

macro_rules! partitions {
    ($($name:ident: $type:ty),* $(,)?) => {
        /// Any of the partitions.
        #[derive(Clone, Debug)]
        pub enum Partition {
            $($name($type)),*
        }

        /// What a partition stores. Variants are told apart by their order: new ones come last.
        #[derive(Clone, Serialize, Deserialize)]
        pub enum StoredPartition {
            $($name(<$type as SpatialPartition>::Stored)),*
        }

        /// Calls what all partitions have.
        macro_rules! each {
            ($self:expr, $partition:ident => $call:expr) => {
                match $self {
                    $(Partition::$name($partition) => $call),*
                }
            };
        }

        impl SpatialPartition for Partition {
            type Stored = StoredPartition;

            #[inline(always)]
            fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
                each!(self, it => it.locate(p, n, jitter))
            }

            #[inline(always)]
            fn locate_lanes(&self, asked: Mask, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 3]) -> Option<[RegionId; LANES]> {
                each!(self, it => it.locate_lanes(asked, p, n, jitter))
            }

            fn is_oriented(&self) -> bool {
                each!(self, it => it.is_oriented())
            }

            fn normal(&self, key: RegionId) -> Option<Vec3> {
                each!(self, it => it.normal(key))
            }

            fn holds(&self, key: RegionId) -> bool {
                each!(self, it => it.holds(key))
            }

            fn dense(&self) -> Option<usize> {
                each!(self, it => it.dense())
            }

            fn bytes(&self) -> usize {
                each!(self, it => it.bytes())
            }

            fn frozen(&self) -> Partition {
                match self {
                    $(Partition::$name(it) => Partition::$name(it.frozen())),*
                }
            }

            fn adapts_to_vertices(&self) -> bool {
                each!(self, it => it.adapts_to_vertices())
            }

            fn expect_vertices(&mut self, vertices: &[(Vec3, Vec3)]) {
                each!(self, it => it.expect_vertices(vertices))
            }

            fn observe(&mut self, points: &[(Vec3, Vec3)]) {
                each!(self, it => it.observe(points))
            }

            fn settle(&mut self) -> bool {
                each!(self, it => it.settle())
            }

            fn cells(&self) -> usize {
                each!(self, it => it.cells())
            }

            fn cell_of(&self, key: RegionId) -> usize {
                each!(self, it => it.cell_of(key))
            }

            fn parts_per_region(&self) -> usize {
                each!(self, it => it.parts_per_region())
            }

            fn divide(&mut self, cell: usize) -> Option<Range<usize>> {
                each!(self, it => it.divide(cell))
            }

            fn parts(&self, key: RegionId) -> Vec<(RegionId, f32)> {
                each!(self, it => it.parts(key))
            }

            fn neighbours(&self, key: RegionId) -> Vec<RegionId> {
                each!(self, it => it.neighbours(key))
            }

            fn stored(&self) -> StoredPartition {
                match self {
                    $(Partition::$name(it) => StoredPartition::$name(it.stored())),*
                }
            }

            fn gathered(&self) -> Option<Gathered> {
                each!(self, it => it.gathered())
            }

            fn restore_gathered(&mut self, gathered: Gathered) {
                each!(self, it => it.restore_gathered(gathered))
            }

            fn restore(&mut self, stored: StoredPartition, memory: usize) -> Result<(), String> {
                match (self, stored) {
                    $((Partition::$name(it), StoredPartition::$name(stored)) => it.restore(stored, memory),)*
                    #[allow(unreachable_patterns, reason = "a list of one")]
                    _ => Err("what was learnt is of another kind than guiding.method asks for".into()),
                }
            }
        }
    };
}

partitions! {
    Grid: Grid,
    TwoLevel: TwoLevelGrid,
    Voronoi: SurfaceVoronoi,
    KdTree: KdTree,
}

impl Partition {
    /// The one that the settings ask for; `None` where they ask for no guide. `bounds` are the scene's, `triangles` all
    /// of its surfaces in world space, `bytes_per_region` what is usually learnt of a region.
    pub fn new(
        settings: &GuidingSettings,
        (low, high): (Vec3, Vec3),
        triangles: impl Iterator<Item = [Vec3; 3]> + Clone,
        bytes_per_region: usize,
    ) -> Option<Partition> {
        Some(match settings.method {
            GuidingMethod::None => return None,
            GuidingMethod::Grid => Partition::Grid(Grid::new(low, high, settings.resolution, settings.normals)),
            GuidingMethod::Adaptive | GuidingMethod::Auto => {
                let most = (settings.memory / CELLS_SHARE) as usize;
                Partition::TwoLevel(TwoLevelGrid::within(low, high, settings.resolution, settings.levels, most))
            }
            GuidingMethod::Voronoi => Partition::Voronoi(SurfaceVoronoi::new(settings, triangles, bytes_per_region)),
            // without jitter there is none to move a record by
            GuidingMethod::SdTree => Partition::KdTree(KdTree::new(low, high, settings.jitter, false)),
        })
    }
}
