//! A quadtree over the sphere in world space (Müller et al. 2017, with the directional filter of Müller 2019).

mod building;
mod frozen;
mod model;

pub(crate) use frozen::Quadtree;
pub(crate) use model::SphereQuadtree;
#[cfg(test)]
pub(crate) use {
    building::Fineness,
    frozen::{Branch, QuadNode, encode},
};
