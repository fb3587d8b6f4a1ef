//! The film: what is sampled, pixel by pixel, and how it becomes one picture.

pub mod accumulate;
pub(crate) mod alike;
mod allotted;
pub(crate) mod blur;
mod exact;
mod extra_layer;
mod features;
mod group;
mod halves;
pub(crate) mod ids;
mod joint;
mod picture;
mod radiance_layer;
pub(crate) mod relative_error;
mod settings;
mod surplus;
pub(crate) mod tile;

pub(crate) use allotted::TileShare;
pub(crate) use exact::{ExactFilm, TileSums};
pub(crate) use extra_layer::ExtraLayer;
pub(crate) use joint::JointFilm;
pub(crate) use radiance_layer::LightPath;
pub use radiance_layer::RadianceLayer;
pub(crate) use settings::SIDE;
pub use settings::{Combine, FilmSettings, Filter, MAX_SIDE};
