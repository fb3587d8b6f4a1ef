//! A quadtree over the sphere in world space (Müller et al. 2017, with the directional filter of Müller 2019).

mod building;
mod frozen;
mod model;

pub use frozen::Quadtree;
pub use model::SphereQuadtree;
#[cfg(test)]
pub use {
    building::Fineness,
    frozen::{Branch, QuadNode, encode},
};
