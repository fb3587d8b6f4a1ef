//! Phototaxis: a path tracer on Embree that learns where the light is while it renders.
//!
//! # Data flow
//!
//! ```text
//! argv ─ cli ─► scene file / OBJ ─► Scene ─► embree scene
//!                                    │
//!      render: iterations × tiles ◄──┘     (budget, seeds, progress)
//!         │  one tile = a batch of paths, advanced bounce by bounce in packets
//!         ▼
//!      integrator ── position, facing normal ──► guiding: state → directional distribution
//!         │   ▲  └─ transitions ───────────────► recorder (owned by the tile)
//!         │   └── bsdf, light, mixture (BSDF + guide: the one place where both sampling and pdf live)
//!         ▼
//!      film ─► EXR / PNG      inspect: a guide that has learnt, against what is traced
//!                             compare: whole renders by several methods, in turns
//! ```
//!
//! # Invariants
//!
//! 1. [`embree`] knows triangles and ids, never materials. [`guiding`] never imports [`integrator`], [`bsdf`] or
//!    [`embree`]: it sees positions, normals and directions. Nothing outside [`cli`] prints or exits.
//! 2. The guide is frozen during an iteration. Sampling and pdf read one snapshot, so MIS weights are exact and every
//!    iteration is an unbiased estimate. Learning takes `&mut self` between rounds, and changes no snapshot.
//! 3. The same scene, seed and sample budget give the same image, bit for bit, with any number of threads: what the
//!    tiles learnt is folded in the order of tiles.
//!    A signal or the clock may cut a render in the middle of a pass. Which samples it then lacks is decided by where they
//!    are, not by their values (but see [`integrator::stop`]), and each pixel counts its own.
//! 4. A guide may change the noise, never the answer.
//! 5. Scaling all emission scales the image and changes nothing else: no absolute floor or epsilon in the guide.
//!
//! # Words
//!
//! `wo` and `wi` both leave the surface. *Throughput* is what a path's light is multiplied by. A *pdf* is a density per
//! steradian, a *pmf* a probability. A *state* is a cell of the guide, an *action* a stratum of its hemisphere, *Q* the
//! radiance (luminance) that arrives at a state from an action. *spp* counts samples per pixel.

pub mod bench;
pub mod bsdf;
pub mod cli;
pub mod compare;
pub mod embree;
pub mod error;
pub mod film;
pub mod generate;
pub mod geometry;
pub mod guiding;
pub mod inspect;
pub mod integrator;
pub mod light;
pub mod math;
pub mod paper;
pub mod render;
pub mod scene;
pub mod stats;

pub use error::{Error, Result};
