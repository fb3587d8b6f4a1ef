//! What the operating system gives: files, written as a whole or not at all, and read without trusting what they claim;
//! memory; clocks.

pub mod atomic;
pub(crate) mod canon;
pub mod clock;
pub(crate) mod contain;
pub mod memory;
mod temporary;
