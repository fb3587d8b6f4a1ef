//! Shapes in space: meshes, frames, and what a ray meets.

pub(crate) mod interaction;
pub(crate) mod mesh;
pub(crate) mod placement;
pub(crate) mod ray;
pub(crate) mod rounding;
pub(crate) mod surfaces;

pub use interaction::SurfaceInteraction;
pub use mesh::{Attribute, Indices, Mesh, MeshColors};
pub(crate) use placement::Placement;
pub use ray::{Hit, HitRows, NOTHING, Ray, RayRows};
pub(crate) use surfaces::Surfaces;
