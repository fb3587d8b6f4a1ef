//! How light finds its way: paths, in batches, bounce by bounce.

mod backward_pass;
pub mod batch;
pub mod mixture;
pub mod path;
pub mod probe;
mod roulette;
mod settings;
pub mod stop;
mod vertex_record;

pub use batch::{Batch, BatchResult, Counters, Task};
pub use path::PathIntegrator;
pub use roulette::RouletteNormalisation;
pub use settings::{IntegratorSettings, Roulette};
pub use stop::Stop;
