//! One record per vertex for the backward pass that trains the guide: how its path got there. Structure of arrays, packed as
//! the rays are.

use super::backward_pass::Targets;
use crate::guiding::{PackedDirection, RegionId};
use crate::math::Rgb;
use crate::simd::{LANES, Lanes, Packing, Vec3Lanes};

/// How a path came to a vertex: the direction in which it left the last one, where something can be learnt there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathSegment {
    pub(crate) key: RegionId,
    pub(crate) wi: PackedDirection,
    /// Shading normal of the last vertex on the side of the path.
    pub(crate) normal: PackedDirection,
    /// Densities of `wi`: of the mixture, of the BSDF's guided lobes alone, of the guide alone (negative where it knew
    /// nothing).
    pub(crate) pdf: f32,
    pub(crate) bsdf_pdf: f32,
    pub(crate) guide_pdf: f32,
    /// Luminance of f·|cosθ| over that of the albedo, of the guided lobes; 0 where there are none. Negative: of lobes that the guide
    /// stands in for by a product only, and that say nothing of the irradiance.
    pub(crate) scattered: f32,
}

/// The way from one vertex to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexRecord {
    /// The last vertex, by its place in its wave.
    pub(crate) parent: u32,
    /// f·|cosθ|/p of the direction, roulette and splitting included; without the diffuse lobes where the last vertex has
    /// others beside them, and the target expects what its table says of these.
    pub(crate) weight: Targets<Rgb>,
    pub(crate) edge: Option<PathSegment>,
}

/// The same for a packet, side by side.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct VertexRecordLanes {
    pub(crate) parent: [u32; LANES],
    /// 1 where something is to be learnt of the edge.
    pub(crate) teaches: [u32; LANES],
    pub(crate) weight: Targets<Vec3Lanes>,
    pub(crate) key: [u64; LANES],
    /// As [`PackedDirection::bits`].
    pub(crate) wi: [u32; LANES],
    pub(crate) normal: [u32; LANES],
    pub(crate) pdf: Lanes,
    pub(crate) bsdf_pdf: Lanes,
    pub(crate) guide_pdf: Lanes,
    pub(crate) scattered: Lanes,
}

impl VertexRecordLanes {
    /// From nowhere, with nothing to learn: paths begin so.
    pub(crate) const NONE: VertexRecordLanes = VertexRecordLanes {
        parent: [u32::MAX; LANES],
        teaches: [0; LANES],
        weight: Targets { rule: Vec3Lanes::ZERO, moments: Vec3Lanes::ZERO },
        key: [0; LANES],
        wi: [0; LANES],
        normal: [0; LANES],
        pdf: [0.0; LANES],
        bsdf_pdf: [0.0; LANES],
        guide_pdf: [0.0; LANES],
        scattered: [0.0; LANES],
    };

    fn set(&mut self, k: usize, arrival: &VertexRecord) {
        self.parent[k] = arrival.parent;
        self.teaches[k] = arrival.edge.is_some() as u32;
        self.weight.rule.set(k, arrival.weight.rule);
        self.weight.moments.set(k, arrival.weight.moments);
        if let Some(PathSegment { key, wi, normal, pdf, bsdf_pdf, guide_pdf, scattered }) = arrival.edge {
            (self.key[k], self.wi[k], self.normal[k]) = (key.0, wi.bits(), normal.bits());
            (self.pdf[k], self.bsdf_pdf[k], self.guide_pdf[k]) = (pdf, bsdf_pdf, guide_pdf);
            self.scattered[k] = scattered;
        }
    }

    #[inline(always)]
    fn edge(&self, k: usize) -> Option<PathSegment> {
        (self.teaches[k] != 0).then(|| PathSegment {
            key: RegionId(self.key[k]),
            wi: PackedDirection::from_bits(self.wi[k]),
            normal: PackedDirection::from_bits(self.normal[k]),
            pdf: self.pdf[k],
            bsdf_pdf: self.bsdf_pdf[k],
            guide_pdf: self.guide_pdf[k],
            scattered: self.scattered[k],
        })
    }

    #[inline(always)]
    fn pack(&self, packing: &Packing, [first, second]: [&mut VertexRecordLanes; 2]) {
        packing.put(&self.parent, [&mut first.parent, &mut second.parent]);
        packing.put(&self.teaches, [&mut first.teaches, &mut second.teaches]);
        self.weight.rule.pack(packing, [&mut first.weight.rule, &mut second.weight.rule]);
        self.weight.moments.pack(packing, [&mut first.weight.moments, &mut second.weight.moments]);
        packing.put(&self.key, [&mut first.key, &mut second.key]);
        packing.put(&self.wi, [&mut first.wi, &mut second.wi]);
        packing.put(&self.normal, [&mut first.normal, &mut second.normal]);
        packing.put(&self.pdf, [&mut first.pdf, &mut second.pdf]);
        packing.put(&self.bsdf_pdf, [&mut first.bsdf_pdf, &mut second.bsdf_pdf]);
        packing.put(&self.guide_pdf, [&mut first.guide_pdf, &mut second.guide_pdf]);
        packing.put(&self.scattered, [&mut first.scattered, &mut second.scattered]);
    }
}

/// The arrivals of a wave, in the order of its rays.
#[derive(Debug, Default)]
pub(crate) struct VertexRecords {
    packets: Vec<VertexRecordLanes>,
    len: usize,
}

impl VertexRecords {
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// So many from nowhere.
    pub(crate) fn begin(&mut self, len: usize) {
        self.packets.clear();
        self.packets.resize(len.div_ceil(LANES), VertexRecordLanes::NONE);
        self.len = len;
    }

    pub(crate) fn push(&mut self, arrival: &VertexRecord) {
        let packet = self.len / LANES;
        if packet == self.packets.len() {
            self.packets.push(VertexRecordLanes::NONE);
        }
        self.packets[packet].set(self.len % LANES, arrival);
        self.len += 1;
    }

    /// Adds those of a packet that `packing`, made for this length, has chosen.
    #[inline(always)]
    pub(crate) fn pack(&mut self, packing: &Packing, arrivals: &VertexRecordLanes) {
        arrivals.pack(packing, packing.packets(&mut self.packets, || VertexRecordLanes::NONE));
        self.len += packing.count();
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> VertexRecord {
        debug_assert!(i < self.len);
        let (packet, k) = (&self.packets[i / LANES], i % LANES);
        let weight = Targets { rule: packet.weight.rule.get(k), moments: packet.weight.moments.get(k) };
        VertexRecord { parent: packet.parent[k], weight, edge: packet.edge(k) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn packed_arrivals_are_those_that_were_put_in() {
        let arrival = |k: u32| {
            let key = RegionId((k as u64) << 33 | 1);
            let [wi, normal] = [Vec3::X, Vec3::NEG_Y].map(PackedDirection::new);
            let [pdf, bsdf_pdf, guide_pdf, scattered] = [1.0, 2.0, 3.0, 4.0].map(|times| times * k as f32);
            let edge = PathSegment { key, wi, normal, pdf, bsdf_pdf, guide_pdf, scattered };
            let weight = Targets { rule: Rgb::splat(k as f32), moments: Rgb::splat(-0.5 * k as f32) };
            VertexRecord { parent: 100 + k, weight, edge: (!k.is_multiple_of(3)).then_some(edge) }
        };
        let mut lanes = VertexRecordLanes::NONE;
        (0..LANES).for_each(|k| lanes.set(k, &arrival(k as u32)));
        let (mut arrivals, mut expected) = (VertexRecords::default(), Vec::new());
        for chosen in [0b1010_0101, 0xffff, 0, 0xfffe, 0x7fff] {
            arrivals.pack(&Packing::new(chosen, arrivals.len()), &lanes);
            expected.extend((0..16).filter(|k| chosen >> k & 1 == 1).map(arrival));
            arrivals.push(&arrival(20));
            expected.push(arrival(20));
        }
        assert_eq!(arrivals.len(), expected.len());
        for (i, expected) in expected.iter().enumerate() {
            assert_eq!(format!("{:?}", arrivals.get(i)), format!("{expected:?}"));
        }
        arrivals.begin(3);
        assert!((0..3).all(|i| arrivals.get(i).edge.is_none() && arrivals.get(i).parent == u32::MAX));
    }
}
