//! Shapes in space: meshes, frames, and what a ray meets.

pub mod frame;
pub mod interaction;
pub mod mesh;
pub mod placement;
pub mod rounding;
pub mod surfaces;

pub use frame::Frame;
pub use interaction::SurfaceInteraction;
pub use mesh::{Attribute, Indices, Mesh};
pub use placement::Placement;
pub use surfaces::Surfaces;
