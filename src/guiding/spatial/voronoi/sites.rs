//! Where sites go: evenly over the surfaces, or where paths go.

use super::Site;
use crate::math::rng::Rng;
use crate::math::warp::square_to_triangle;
use glam::{DVec3, Vec3};

/// A triangle that is to have sites: on the side from which its corners run counter-clockwise, or on both.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    pub corners: [Vec3; 3],
    pub two_sided: bool,
}

impl Facet {
    /// Area of all its sides; 0 where it has none, or none that can be told.
    fn area(&self) -> f64 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let area = 0.5 * (b - a).cross(c - a).length() * if self.two_sided { 2.0 } else { 1.0 };
        if area.is_finite() { area } else { 0.0 }
    }

    /// The point at `u` of the side that lies at `share`, in [0, 1), of its area.
    fn site(&self, share: f64, u: [f32; 2]) -> Option<Site> {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        let n = (b - a).cross(c - a).try_normalize()?;
        let [v, w] = square_to_triangle(u).map(|weight| weight as f64);
        let n = if self.two_sided && share >= 0.5 { -n } else { n };
        Some(Site { p: (a + (b - a) * v + (c - a) * w).as_vec3(), n: n.as_vec3() })
    }
}

/// `n` sites spread over the facets with one density per area of side; the same seed gives the same sites. One site falls
/// into each n-th part of the area, summed up in the order of facets, and where many fall into one facet they follow
/// the additive recurrence R2 (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences") there. Facets
/// without area get none, and without any area there are no sites. (Sites where area is: Dahm & Keller 2017, §2.)
pub fn sites_by_area(facets: impl Iterator<Item = Facet> + Clone, n: usize, seed: u64) -> Vec<Site> {
    // 1/g and 1/g² of the plastic number g
    const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let step = facets.clone().map(|facet| facet.area()).sum::<f64>() / n as f64;
    if !step.is_finite() || step <= 0.0 {
        return Vec::new();
    }
    let mut rng = Rng::new(seed);
    let shift = [rng.f64(), rng.f64()];
    let mut sites = Vec::with_capacity(n);
    let (mut begin, mut k, mut next) = (0.0, 0.0, rng.f64() * step);
    for facet in facets {
        let area = facet.area();
        while next < begin + area && sites.len() < n {
            let u = [0, 1].map(|i| ((shift[i] + k * R2[i]).fract() as f32).min(crate::math::ONE_MINUS_EPSILON));
            sites.extend(facet.site((next - begin) / area, u));
            k += 1.0;
            next = (k + rng.f64()) * step;
        }
        begin += area;
    }
    sites
}

/// At most `n` sites out of `points`, path vertices with facing normals: spread out, and as dense as the points are. The
/// same points in the same order give the same sites; O(m log n) for m points.
///
/// The points are cut in two, by normals where these differ much, else at the median along the longest side of their box,
/// until there are `n` parts of nearly equal numbers; the point nearest to the mean of each part becomes a site. Points
/// without a finite position and normal are left out. Copies of one point are one site.
pub fn sites_from_visits(points: &[(Vec3, Vec3)], n: usize) -> Vec<Site> {
    let mut visits: Vec<Site> = points.iter().filter_map(|&(p, n)| super::valid(Site { p, n })).collect();
    let mut sites = Vec::new();
    if n > 0 && !visits.is_empty() {
        thin(&mut visits, n, &mut sites);
    }
    sites
}

/// Extent of a normal's component from which on a part holds normals that do not agree: 60° about an axis.
const NORMAL_EXTENT: f32 = 1.0;

fn thin(visits: &mut [Site], n: usize, sites: &mut Vec<Site>) {
    let (p, normal) = (extent(visits, |site| site.p), extent(visits, |site| site.n));
    let cut = if n == 1 {
        None
    } else if (normal.1 - normal.0).max_element() > NORMAL_EXTENT {
        let axis = (normal.1 - normal.0).max_position();
        let middle = 0.5 * (normal.0[axis] + normal.1[axis]);
        Some(partition(visits, |site| site.n[axis] <= middle))
    } else if (p.1 - p.0).max_element() > 0.0 {
        Some(cut_at_median(visits, (p.1 - p.0).max_position()))
    } else {
        None
    };
    let Some(cut) = cut else { return sites.push(representative(visits)) };
    let share = (n as f64 * cut as f64 / visits.len() as f64).round() as usize;
    let (below, above) = visits.split_at_mut(cut);
    let share = share.clamp(1, n - 1);
    thin(below, share, sites);
    thin(above, n - share, sites);
}

/// Componentwise least and largest.
fn extent(visits: &[Site], of: impl Fn(&Site) -> Vec3) -> (Vec3, Vec3) {
    visits
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), site| (low.min(of(site)), high.max(of(site))))
}

/// Sorts by the coordinate as far as to have two parts of nearly equal numbers and no coordinate in both; returns where
/// the second begins. The points differ in that coordinate.
fn cut_at_median(visits: &mut [Site], axis: usize) -> usize {
    let middle = visits.len() / 2;
    visits.select_nth_unstable_by(middle, |a, b| a.p[axis].total_cmp(&b.p[axis]));
    let median = visits[middle].p[axis];
    match partition(visits, |site| site.p[axis] < median) {
        0 => partition(visits, |site| site.p[axis] <= median),
        cut => cut,
    }
}

/// Moves those that satisfy `first` to the front and counts them.
fn partition(visits: &mut [Site], first: impl Fn(&Site) -> bool) -> usize {
    let mut cut = 0;
    for i in 0..visits.len() {
        if first(&visits[i]) {
            visits.swap(i, cut);
            cut += 1;
        }
    }
    cut
}

/// The visit that is nearest to the mean of all.
fn representative(visits: &[Site]) -> Site {
    let mean = (visits.iter().map(|site| site.p.as_dvec3()).sum::<DVec3>() / visits.len() as f64).as_vec3();
    let distance = |site: &Site| (site.p - mean).length_squared();
    *visits.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a part holds a visit")
}
