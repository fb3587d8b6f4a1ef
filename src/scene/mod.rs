//! From files to an immutable scene.

pub mod description;
pub mod obj;
