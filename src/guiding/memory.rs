//! How many bytes a guide takes: the one place that knows.
//!
//! All that is learnt of a region is counted together with its part of the snapshot, which is made of it.

use super::directional::DirectionalModel;
use super::region::Region;
use super::region_index::RegionIndex;
use super::snapshot::RegionInfo;
use super::spatial::RegionId;

/// Bytes of a region of which no direction is known: itself, its place in the map at full load, and its part of the
/// snapshot, the index included.
pub(super) const fn bytes_besides_directions<L>() -> usize {
    size_of::<Region<L>>()
        + 2 * (size_of::<(RegionId, u32)>() + 1)
        + size_of::<RegionInfo>()
        + RegionIndex::BYTES_PER_REGION
}

/// Bytes of a region.
pub(super) fn region_bytes<D: DirectionalModel>(model: &D, region: &Region<D::Learnt>) -> usize {
    bytes_besides_directions::<D::Learnt>() + model.bytes(&region.directions)
}

/// Bytes that most regions take.
pub(super) fn usual_region_bytes<D: DirectionalModel>(model: &D) -> usize {
    bytes_besides_directions::<D::Learnt>() + model.usual_bytes()
}
