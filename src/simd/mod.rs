//! Sixteen numbers side by side: lanes, masks of lanes, and packing some lanes of several packets into full ones.
//!
//! A packet of rays has [`LANES`] rays, and what belongs to a packet is kept row by row, a `[T; LANES]` for each
//! quantity. Loops over such rows become vector instructions of whatever width the processor has. What the compiler does
//! not find by itself is written with intrinsics in `instructions`, beside a version for any processor.
#![allow(
    unsafe_code,
    reason = "vector intrinsics; the crate's only other unsafe code is the interfaces to Embree and to Open Image Denoise"
)]

#[cfg(test)]
pub(crate) mod disassembly;
mod instructions;
mod lanes;
mod packing;
mod prefetch;

pub(crate) use lanes::MaskLanes;
pub(crate) use lanes::{LANES, Lanes, each, mask, normalize_or, pick, truncate};
pub use lanes::{Mask, Vec3Lanes};
pub(crate) use packing::Packing;
pub(crate) use prefetch::prefetch;
