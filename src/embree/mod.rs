//! Embree behind a safe wrapper.
//!
//! It knows triangles and ids, never materials: what a hit means is the caller's business. One source serves
//! Embree 3.13 and 4 (`compat`); the declarations are made by the build script from the installed headers, so
//! the struct layouts are always those of the library that is linked.
#![allow(
    unsafe_code,
    reason = "the foreign function interface to Embree; vector intrinsics in `simd` and the interface in `denoise` are the crate's only other unsafe code"
)]

mod batch;
mod build;
mod coherence;
mod compat;
mod device;
mod geometry;
mod isa;
mod packet;
mod scene;
mod single;
#[cfg(test)]
mod tests;
mod width;

/// Embree's C API as bindgen sees it.
#[allow(non_camel_case_types, non_snake_case, non_upper_case_globals, dead_code, missing_docs)]
#[allow(clippy::all, clippy::undocumented_unsafe_blocks, reason = "generated code")]
mod sys {
    include!(concat!(env!("OUT_DIR"), "/embree.rs"));
}

pub(crate) use batch::{HitBatch, ShadowBatch};
pub use build::{BuildOptions, BuildQuality};
pub(crate) use coherence::Coherence;
pub use device::Device;
pub(crate) use geometry::{Instance, LARGEST_COORDINATE, OpacityTest, SMALLEST_EXTENT};
pub use isa::{ISA_VARIABLE, Isa};
pub(crate) use packet::{HitPacket, Packet8, Packet16, Shadow8, Shadow16, ShadowPacket};
pub(crate) use scene::{Scene, SceneBuilder, Triangles};
