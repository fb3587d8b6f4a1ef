//! The laboratory: what measures the renderer, its methods and its guide, and makes the scenes for it. The renderer needs
//! nothing of it; the feature `lab` builds it.

pub mod bench;
pub mod compare;
pub mod convergence;
pub(crate) mod generate;
pub mod paper;
