//! Where Voronoi sites go, and until when there are none.

use super::{Facet, Voronoi, sites_by_area, sites_from_visits};
use crate::guiding::settings::GuidingSettings;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::num::NonZero;
use std::sync::Arc;

/// Share of the memory that sites and their tables may take, were all of the usual size: states come to shards unevenly.
const SHARE: f64 = 0.75;

/// Points that are kept at most.
const MAX_POINTS: usize = 1 << 20;

/// Points that a site needs at least, and points beside each site that tell where look-ups are to be expected.
const POINTS_PER_SITE: usize = 4;

/// Seeds of the sites by area and of the points beside them; they have nothing to do with a picture's seed.
const SEEDS: [u64; 2] = [1, 2];

/// Path vertices, gathered until they are enough to place sites by.
#[derive(Clone, Debug)]
pub struct SitePlacement {
    sites: usize,
    /// Points kept at most.
    room: usize,
    pub(super) gathered: Gathered,
}

/// Some of the vertices that were seen.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Gathered {
    points: Vec<(Vec3, Vec3)>,
    /// One of `stride` vertices is kept.
    stride: NonZero<usize>,
    seen: usize,
}

impl Gathered {
    const NOTHING: Gathered = Gathered { points: Vec::new(), stride: NonZero::<usize>::MIN, seen: 0 };
}

impl SitePlacement {
    /// For so many sites, within so many bytes.
    pub fn new(sites: usize, memory: u64) -> SitePlacement {
        // placing them makes a copy
        let room = (memory / (2 * size_of::<(Vec3, Vec3)>() as u64)) as usize;
        // an even number, so that the next point is kept after every second went
        let room = room.clamp(2, MAX_POINTS) & !1;
        SitePlacement { sites, room, gathered: Gathered::NOTHING }
    }

    /// Gathers points. Where they become too many, every second goes, and of those to come.
    pub fn visit(&mut self, new: &[(Vec3, Vec3)]) {
        let Gathered { points, stride, seen } = &mut self.gathered;
        for point in new {
            if seen.is_multiple_of(stride.get()) {
                if points.len() == self.room {
                    *points = points.iter().step_by(2).copied().collect();
                    *stride = stride.saturating_add(stride.get());
                }
                points.push(*point);
            }
            *seen += 1;
        }
    }

    /// The sites by what was gathered; `None` where there was nothing.
    pub fn sites(&self) -> Option<Arc<Voronoi>> {
        let points = &self.gathered.points;
        let n = self.sites.min(points.len().div_ceil(POINTS_PER_SITE));
        Voronoi::new(sites_from_visits(points, n), points).map(Arc::new)
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.gathered.points[..])
    }
}

/// How many sites there are to be, where so many bytes are usually learnt of a region.
pub fn sites_within(settings: &GuidingSettings, bytes_per_region: usize) -> usize {
    let bytes = bytes_per_region + Voronoi::bytes_per_site();
    let most = (settings.memory as f64 * SHARE / bytes as f64).max(1.0) as usize;
    if settings.sites == 0 { most } else { most.min(settings.sites as usize) }
}

/// `n` sites spread over the triangles by area.
pub fn by_area(triangles: impl Iterator<Item = [Vec3; 3]> + Clone, n: usize) -> Option<Arc<Voronoi>> {
    let facets = triangles.map(|corners| Facet { corners, two_sided: true });
    let sites = sites_by_area(facets.clone(), n, SEEDS[0]);
    let beside = sites_by_area(facets, POINTS_PER_SITE * sites.len(), SEEDS[1]);
    let samples: Vec<_> = beside.iter().map(|site| (site.p, site.n)).collect();
    Voronoi::new(sites, &samples).map(Arc::new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Rng;

    fn placing(room: usize) -> SitePlacement {
        SitePlacement { sites: 100, room, gathered: Gathered::NOTHING }
    }

    fn points(n: usize) -> Vec<(Vec3, Vec3)> {
        let mut rng = Rng::new(1);
        (0..n).map(|_| (Vec3::new(rng.f32(), 0.0, rng.f32()), Vec3::Y)).collect()
    }

    #[test]
    fn too_many_points_are_thinned_evenly() {
        let (points, mut placing) = (points(1000), placing(64));
        points.chunks(7).for_each(|some| placing.visit(some));
        let Gathered { points: kept, stride, .. } = placing.gathered;
        let expected: Vec<_> = points.iter().step_by(stride.get()).copied().collect();
        assert!(kept == expected, "stride {stride}, {} points", kept.len());
        assert_eq!((stride.get(), kept.len()), (16, 63));
    }

    #[test]
    fn sites_are_as_many_as_asked_for_and_points_allow() {
        for (n, sites) in [(0, None), (1, Some(1)), (40, Some(10)), (1000, Some(100))] {
            let mut placing = placing(1 << 10);
            placing.visit(&points(n));
            assert_eq!(placing.sites().map(|voronoi| voronoi.len()), sites, "{n} points");
        }
    }

    #[test]
    fn zero_sites_are_as_many_as_there_is_room_for() {
        let with = |sites, memory| sites_within(&GuidingSettings { sites, memory, ..GuidingSettings::default() }, 1000);
        assert_eq!(with(7, 1 << 30), 7);
        let all = with(0, 1 << 24);
        assert!(all > 1000 && with(u32::MAX, 1 << 24) == all && with(0, 1 << 25) / 2 == all, "{all}");
    }
}
