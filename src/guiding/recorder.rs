//! What a tile learnt: transitions, in the order of its paths, sorted only by the shard that will read them.

use crate::guiding::hue::Hue;
use crate::guiding::packed_direction::PackedDirection;
use crate::guiding::spatial::RegionId;
use crate::guiding::visibility::ShadowOutcome;
use crate::math::rng::mix;
use glam::Vec3;

/// Shards of the table that are updated in parallel. Fixed, so that no result depends on the number of threads.
pub const SHARDS: usize = 32;

/// The shard that owns a state.
#[inline]
pub fn shard_of(key: RegionId) -> usize {
    (mix(key.0) >> 59) as usize
}

/// One visit to a state: the direction in which the path went on, and the radiance that arrived from there.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    pub key: RegionId,
    /// Away from the surface, world space.
    pub wi: PackedDirection,
    /// Shading normal on the side of the path.
    pub normal: PackedDirection,
    /// Radiance (luminance) that arrived along `wi`, by the rule in use.
    pub target: f32,
    /// The same as roulette's moments take it: the next vertex by what its table expects on average, whatever the rule.
    pub bootstrapped: f32,
    /// Its colour.
    pub hue: Hue,
    /// Density of the mixture that drew `wi`, of the BSDF alone and of the guide alone, per steradian; the last is
    /// negative where the guide knew nothing.
    pub pdf: f32,
    pub bsdf_pdf: f32,
    pub guide_pdf: f32,
    /// Luminance of f·|cosθ|, divided by the albedo. Where it is negative, its amount says how much the direction brought, and
    /// nothing of the region's irradiance.
    pub scattered: f32,
    /// Rays that the rest of the path took, 65535 at most.
    pub rays: u16,
    /// Of the vertex in this state. A vertex from which several directions were taken tells it with one of them.
    pub shadow: ShadowOutcome,
}

impl Transition {
    /// How much light the direction brought, over the albedo and the density with which it was drawn.
    #[inline]
    pub(super) fn contribution(&self) -> f32 {
        self.target * self.scattered.abs() / self.pdf
    }
}

/// Owned by one tile while it renders, then folded into the table in the order of tiles.
#[derive(Debug)]
pub struct Recorder {
    shards: Vec<Vec<Transition>>,
    points: Vec<(Vec3, Vec3)>,
}

impl Recorder {
    pub fn new() -> Recorder {
        Recorder { shards: (0..SHARDS).map(|_| Vec::new()).collect(), points: Vec::new() }
    }

    /// The same without what it holds, but with the room for it.
    pub fn emptied(mut self) -> Recorder {
        self.shards.iter_mut().for_each(Vec::clear);
        self.points.clear();
        self
    }

    #[inline]
    pub fn push(&mut self, transition: Transition) {
        self.shards[shard_of(transition.key)].push(transition);
    }

    /// Takes a path vertex, and its unit normal on the side of the path, that sites may be placed by.
    #[inline]
    pub fn push_point(&mut self, p: Vec3, n: Vec3) {
        self.points.push((p, n));
    }

    /// Vertices of [`Recorder::push_point`], in their order.
    pub fn points(&self) -> &[(Vec3, Vec3)] {
        &self.points
    }

    pub fn shard(&self, shard: usize) -> &[Transition] {
        &self.shards[shard]
    }

    /// Transitions recorded.
    pub fn len(&self) -> usize {
        self.shards.iter().map(Vec::len).sum()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Default for Recorder {
    fn default() -> Recorder {
        Recorder::new()
    }
}
