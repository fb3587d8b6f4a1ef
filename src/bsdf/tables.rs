//! Tables that materials share.

use super::MicrofacetDistribution;
use super::coat::{CoatTable, Entering};
use super::microfacet::Microfacet;
use super::multiple_scattering::LossTable;
use std::collections::HashMap;
use std::sync::Arc;

/// Builds each table once.
#[derive(Debug, Default)]
pub struct BsdfTables {
    coats: HashMap<(u32, u32, bool, Entering), Arc<CoatTable>>,
    losses: HashMap<(u32, bool), Arc<LossTable>>,
    all_losses: Option<Arc<LossTable>>,
}

impl BsdfTables {
    /// A coat over a base that gets this of the light.
    pub(super) fn coat(
        &mut self,
        eta: f32,
        alpha: f32,
        kind: MicrofacetDistribution,
        entering: Entering,
    ) -> Arc<CoatTable> {
        let key = (eta.to_bits(), alpha.to_bits(), kind == MicrofacetDistribution::Ggx, entering);
        let build = match entering {
            Entering::Refracted => CoatTable::new,
            Entering::Conserving => CoatTable::conserving,
            Entering::All => CoatTable::additive,
        };
        self.coats.entry(key).or_insert_with(|| Arc::new(build(eta, Microfacet::new(kind, alpha)))).clone()
    }

    /// What one surface of facets loses by single scattering.
    pub(super) fn loss(&mut self, microfacet: &Microfacet) -> Arc<LossTable> {
        let key = (microfacet.alpha().to_bits(), microfacet.kind() == MicrofacetDistribution::Ggx);
        self.losses.entry(key).or_insert_with(|| Arc::new(LossTable::new(microfacet))).clone()
    }

    /// What surfaces of every roughness lose, of Trowbridge's and Reitz' facets ("GGX").
    pub(super) fn losses(&mut self) -> Arc<LossTable> {
        self.all_losses.get_or_insert_with(|| Arc::new(LossTable::of_all_roughnesses())).clone()
    }
}
