//! Surface Voronoi cells as a partition: until there are sites, path vertices are gathered to place them by.

use super::placement::{Gathered, SitePlacement, by_area, sites_within};
use super::{Site, Voronoi};
use crate::guiding::settings::{GuidingSettings, Placement};
use crate::guiding::spatial::{RegionId, RegionLookup, SpatialPartition};
use crate::simd::{LANES, Mask, Vec3Lanes};
use glam::Vec3;
use std::sync::Arc;

/// Sites and the points that are nearest to each.
#[derive(Clone, Debug)]
pub struct SurfaceVoronoi {
    /// `None` until there are sites.
    cells: Option<Arc<Voronoi>>,
    /// While there are no sites, and they go where paths go.
    placing: Option<SitePlacement>,
}

impl SurfaceVoronoi {
    /// As many sites as are asked for and there is memory for, with so many bytes for what is learnt of each.
    pub fn new(
        settings: &GuidingSettings,
        triangles: impl Iterator<Item = [Vec3; 3]> + Clone,
        bytes_per_region: usize,
    ) -> SurfaceVoronoi {
        let sites = sites_within(settings, bytes_per_region);
        match settings.placement {
            Placement::Area => SurfaceVoronoi { cells: by_area(triangles, sites), placing: None },
            Placement::Paths => {
                SurfaceVoronoi { cells: None, placing: Some(SitePlacement::new(sites, settings.memory)) }
            }
        }
    }

    fn place(&mut self, cells: Arc<Voronoi>) {
        (self.cells, self.placing) = (Some(cells), None);
    }
}

impl SpatialPartition for SurfaceVoronoi {
    /// By region.
    type Stored = Vec<Site>;

    #[inline(always)]
    fn locate(&self, p: Vec3, n: Vec3, jitter: [f32; 3]) -> Option<RegionLookup> {
        let region = self.cells.as_ref()?.state(p, n, [jitter[0], jitter[1]]);
        Some(RegionLookup::one(RegionId(region as u64)))
    }

    #[inline(always)]
    fn locate_lanes(&self, asked: Mask, p: &Vec3Lanes, n: &Vec3Lanes, jitter: [f32; 3]) -> Option<[RegionId; LANES]> {
        let states = self.cells.as_ref()?.states(asked, p, n, [jitter[0], jitter[1]]);
        Some(states.map(|state| RegionId(state.into())))
    }

    fn is_oriented(&self) -> bool {
        true
    }

    fn normal(&self, key: RegionId) -> Option<Vec3> {
        Some(self.cells.as_ref()?.frame(key.0 as u32).n)
    }

    fn holds(&self, key: RegionId) -> bool {
        self.cells.as_ref().is_some_and(|cells| key.0 < cells.len() as u64)
    }

    fn dense(&self) -> Option<usize> {
        self.cells.as_ref().map(|cells| cells.len())
    }

    fn bytes(&self) -> usize {
        let cells = self.cells.as_ref().map_or(0, |cells| cells.bytes());
        cells + self.placing.as_ref().map_or(0, SitePlacement::bytes)
    }

    fn frozen(&self) -> SurfaceVoronoi {
        SurfaceVoronoi { cells: self.cells.clone(), placing: None }
    }

    fn observe(&mut self, points: &[(Vec3, Vec3)]) {
        self.placing.iter_mut().for_each(|placing| placing.visit(points));
    }

    fn settle(&mut self) -> bool {
        let cells = self.placing.as_ref().and_then(SitePlacement::sites);
        let settled = cells.is_some();
        cells.into_iter().for_each(|cells| self.place(cells));
        settled
    }

    fn stored(&self) -> Vec<Site> {
        self.cells.iter().flat_map(|cells| cells.sites()).collect()
    }

    fn gathered(&self) -> Option<Gathered> {
        self.placing.as_ref().map(|placing| placing.gathered.clone())
    }

    fn restore_gathered(&mut self, gathered: Gathered) {
        self.placing.iter_mut().for_each(|placing| placing.gathered = gathered.clone());
    }

    fn restore(&mut self, sites: Vec<Site>, memory: usize) -> Result<(), String> {
        let count = sites.len();
        if count == 0 {
            return Ok(());
        }
        if count.saturating_mul(Voronoi::bytes_per_site()) > memory {
            return Err(format!("its {count} sites take more than guiding.memory"));
        }
        // the sites themselves stand for the points where look-ups are to be expected
        let about: Vec<_> = sites.iter().map(|site| (site.p, site.n)).collect();
        let cells = Voronoi::new(sites, &about).filter(|cells| cells.len() == count);
        self.place(Arc::new(cells.ok_or("its sites are not ones that regions can have")?));
        Ok(())
    }
}
