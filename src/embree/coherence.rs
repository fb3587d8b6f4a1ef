//! What Embree is told of the rays of a packet.

/// Whether the rays of a packet run side by side. Camera rays gain two to five times by saying so; bounced rays
/// and shadow rays lose half.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coherence {
    Coherent,
    Incoherent,
}
