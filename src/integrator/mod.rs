//! How light finds its way: paths, in batches, bounce by bounce.

mod arrivals;
mod backup;
pub mod batch;
pub mod mixture;
pub mod path;
pub mod probe;
mod roulette;
mod settings;
pub mod stop;

pub use batch::{Batch, BatchResult, Counters, Task};
pub use path::PathIntegrator;
pub use roulette::Efficiency;
pub use settings::{IntegratorSettings, Roulette};
pub use stop::Stop;
