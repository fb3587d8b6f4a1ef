//! Files: written as a whole or not at all, and read without trusting what they claim.

pub mod atomic;
pub(crate) mod canon;
pub(crate) mod contain;
pub mod memory;
mod temporary;
