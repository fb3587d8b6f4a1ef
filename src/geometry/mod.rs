//! Shapes in space: meshes, frames, and what a ray meets.

pub mod interaction;
pub mod mesh;
pub mod placement;
pub mod ray;
pub mod rounding;
pub mod surfaces;

pub use interaction::SurfaceInteraction;
pub use mesh::{Attribute, Indices, Mesh};
pub use placement::Placement;
pub use ray::{Hit, HitRows, NOTHING, Ray, RayRows};
pub use surfaces::Surfaces;
