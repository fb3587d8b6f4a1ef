//! Emitters that are seen through in places: leaves of a lampshade, grids, letters.

use crate::math::warp;
use std::sync::Arc;

/// The opacity of emissive triangles as it varies over them.
///
/// A ray that arrives at a point is stopped there, and sees the emission, with this probability; otherwise it goes on as
/// if there were no surface. Next-event estimation weighs emission by the same number, so that both have one mean.
pub(crate) trait EmitterOpacity: Send + Sync {
    /// In [0, 1]. `weights` are barycentric, of the second and third corner of the triangle as [`EmissiveTriangle`] has
    /// them.
    ///
    /// [`EmissiveTriangle`]: super::EmissiveTriangle
    fn opacity(&self, triangle: u32, weights: [f32; 2]) -> f32;
}

/// The opacity of one triangle.
#[derive(Clone)]
pub(super) struct TriangleOpacity {
    map: Arc<dyn EmitterOpacity>,
    triangle: u32,
}

/// Points along each side of the square by which a mean is estimated.
const POINTS: u32 = 4;

impl TriangleOpacity {
    pub fn new(map: &Arc<dyn EmitterOpacity>, triangle: u32) -> TriangleOpacity {
        TriangleOpacity { map: map.clone(), triangle }
    }

    /// At the point that a light draws with the same numbers.
    pub fn at(&self, u: [f32; 2]) -> f32 {
        self.map.opacity(self.triangle, warp::square_to_triangle(u))
    }

    /// Its mean over a few points, and one more that counts as opaque (Laplace's rule of succession): a light that only
    /// seems to be transparent everywhere is still drawn. In (0, 1].
    pub fn mean(&self) -> f64 {
        let centre = |i: u32| (i as f32 + 0.5) / POINTS as f32;
        let points = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| [centre(i), centre(j)]));
        let sum: f64 = points.map(|u| self.at(u) as f64).sum();
        (sum + 1.0) / ((POINTS * POINTS) as f64 + 1.0)
    }
}

impl std::fmt::Debug for TriangleOpacity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "opacity of triangle {}", self.triangle)
    }
}
