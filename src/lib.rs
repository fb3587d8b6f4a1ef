//! Phototaxis: a path tracer on Embree that learns where the light is while it renders.
//!
//! # Data flow
//!
//! ```text
//! argv ─ cli ─► format: a scene file or OBJ ─► SceneFile ─► Scene ─► embree scene
//!                                               │
//!      render: iterations × tiles ◄─────────────┘     (budget, seeds, progress)
//!         │  one tile = a batch of paths, advanced bounce by bounce in packets
//!         ▼
//!      integrator ── position, facing normal ──► guiding: state → directional distribution
//!         │   ▲  └─ transitions ───────────────► recorder (owned by the tile)
//!         │   └── bsdf, light, mixture (BSDF + guide: the one place where both sampling and pdf live)
//!         ▼
//!      film ─► image: EXR / PNG     inspect: a guide that has learnt, against what is traced
//!                                   lab: whole renders by several methods, in turns
//! ```
//!
//! # Layers
//!
//! Folders use only those before them in this list, and a test (`tests/all/layers.rs`) keeps it so:
//! [`simd`], [`io`], [`math`], `document`, [`stats`] · [`geometry`], [`embree`] · [`image`], `draw`, [`denoise`], [`texture`], `fields`,
//! [`film`] · [`bsdf`], [`light`] · [`guiding`] · [`scene`] · [`integrator`] · [`render`] ·
//! [`format`] · [`inspect`] · `lab` · [`cli`].
//!
//! # Invariants
//!
//! 1. [`embree`] knows triangles and ids, never materials. [`guiding`] needs [`math`] and [`simd`] alone: it sees
//!    positions, normals and directions. Nothing outside [`cli`] prints or exits. `unsafe` is in [`embree`],
//!    [`simd`] and [`denoise`].
//! 2. The guide is frozen during an iteration. Sampling and pdf read one snapshot, so MIS weights are exact and every
//!    iteration is an unbiased estimate. Learning takes `&mut self` between rounds, and changes no snapshot.
//! 3. The same scene, seed and sample budget give the same image, bit for bit, with any number of threads, by one build
//!    at one instruction set of Embree's (docs/processors.md): what the tiles learnt is folded in the order of tiles.
//! 4. A guide may change the noise, never the answer.
//! 5. Scaling all emission scales the image and changes nothing else: no absolute floor or epsilon in the guide.
//!
//! # Words
//!
//! `wo` and `wi` both leave the surface. *Throughput* is what a path's light is multiplied by. A *pdf* is a density per
//! steradian, a *pmf* a probability. A *state* is a cell of the guide, an *action* a stratum of its hemisphere, *Q* the
//! radiance (luminance) that arrives at a state from an action. *spp* counts samples per pixel. From loading to the finished
//! picture all light is in the scene's own unit, [`light::LightUnit`].

// Without the laboratory the compiler cannot tell what only it uses from what nothing uses.
#![cfg_attr(not(feature = "lab"), allow(dead_code, unused_imports))]

pub mod bsdf;
pub mod cli;
pub mod denoise;
pub(crate) mod document;
pub(crate) mod draw;
pub mod embree;
pub(crate) mod error;
pub(crate) mod fields;
pub mod film;
pub mod format;
pub mod geometry;
pub mod guiding;
pub mod image;
pub mod inspect;
pub mod integrator;
pub(crate) mod io;
#[cfg(feature = "lab")]
pub mod lab;
pub(crate) mod light;
pub mod math;
pub mod platform;
pub mod render;
pub mod scene;
pub(crate) mod simd;
pub mod stats;
pub mod texture;

pub use error::{Error, Result};
