//! What the operating system gives: files, written as a whole or not at all, and read without trusting what they claim;
//! memory; clocks.

pub(crate) mod atomic;
pub(crate) mod canon;
pub(crate) mod clock;
pub(crate) mod contain;
pub(crate) mod memory;
pub(crate) mod paths;
mod temporary;
