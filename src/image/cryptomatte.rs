//! Cryptomatte: which named things a pixel shows, and how much of each (J. Friedman, A. C. Jones, "Fully automatic ID mattes
//! with support for motion blur and transparency", SIGGRAPH 2015; Cryptomatte specification 1.2).

use super::Layer;
use super::exr::Attribute;
use std::collections::BTreeMap;

/// Ranks in a layer: number and coverage twice, as red and green, blue and alpha.
const RANKS_IN_LAYER: usize = 2;

/// Things of one kind, by name.
pub(crate) struct Matte<'a> {
    /// `CryptoObject`, `CryptoMaterial`.
    pub(crate) name: &'a str,
    /// What the numbers of things stand for.
    pub(crate) names: &'a [String],
}

impl Matte<'_> {
    /// The layers: three of two ranks each, the largest coverage first. `pixels`: numbers with their coverage in [0, 1].
    pub(crate) fn layers(&self, ranks: usize, pixels: &[Vec<(u32, f32)>]) -> Vec<Layer> {
        let ids: Vec<f32> = self.names.iter().map(|name| id(hash(name))).collect();
        let ranked: Vec<Vec<(f32, f32)>> = pixels.iter().map(|pixel| ranked(pixel, &ids)).collect();
        let channel = |rank: usize, of: fn((f32, f32)) -> f32| -> Vec<f32> {
            ranked.iter().map(|pixel| pixel.get(rank).copied().map_or(0.0, of)).collect()
        };
        (0..ranks.div_ceil(RANKS_IN_LAYER))
            .map(|k| {
                let (first, second) = (RANKS_IN_LAYER * k, RANKS_IN_LAYER * k + 1);
                let channels = [
                    ("R", channel(first, |(id, _)| id)),
                    ("G", channel(first, |(_, coverage)| coverage)),
                    ("B", channel(second, |(id, _)| id)),
                    ("A", channel(second, |(_, coverage)| coverage)),
                ];
                let channels = channels.map(|(suffix, values)| (suffix.to_string(), values)).into();
                Layer { name: format!("{}{k:02}", self.name), channels }
            })
            .collect()
    }

    /// What the header says of them.
    pub(crate) fn attributes(&self) -> impl Iterator<Item = (String, Attribute)> {
        let prefix = format!("cryptomatte/{}", &format!("{:08x}", hash(self.name))[..7]);
        let manifest: BTreeMap<&str, String> =
            self.names.iter().map(|name| (name.as_str(), format!("{:08x}", id(hash(name)).to_bits()))).collect();
        let manifest = serde_json::to_string(&manifest).unwrap_or_default();
        let fields = [
            ("name", self.name.to_string()),
            ("hash", "MurmurHash3_32".to_string()),
            ("conversion", "uint32_to_float32".to_string()),
            ("manifest", manifest),
        ];
        fields.into_iter().map(move |(field, text)| (format!("{prefix}/{field}"), Attribute::Text(text)))
    }
}

/// A pixel's things, each once, by falling coverage.
fn ranked(pixel: &[(u32, f32)], ids: &[f32]) -> Vec<(f32, f32)> {
    let mut all: Vec<(f32, f32)> = Vec::with_capacity(pixel.len());
    for &(number, coverage) in pixel {
        let Some(&id) = ids.get(number as usize) else { continue };
        // two things of one name are one
        match all.iter_mut().find(|(own, _)| own.to_bits() == id.to_bits()) {
            Some((_, sum)) => *sum += coverage,
            None => all.push((id, coverage)),
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

fn hash(name: &str) -> u32 {
    // a slice is read without fail
    murmur3::murmur3_32(&mut name.as_bytes(), 0).unwrap_or_default()
}

/// A hash as a number that is finite and no denormal one, which programs change.
fn id(hash: u32) -> f32 {
    let exponent = hash >> 23 & 255;
    f32::from_bits(if exponent == 0 || exponent == 255 { hash ^ 1 << 23 } else { hash })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_specification() {
        // MurmurHash3_x86_32 with seed 0: test vectors of its author's reference implementation
        assert_eq!((hash(""), hash("test"), hash("Hello, world!")), (0, 0xba6b_d213, 0xc036_3e43));
        assert!((0..=255u32).all(|exponent| id(exponent << 23 | 5).is_normal()));
        assert_eq!(id(0x4000_0000), 2.0, "other hashes are their own bits");
    }

    #[test]
    fn the_largest_coverage_comes_first_and_equal_names_are_one() {
        let names = ["a", "b", "a"].map(String::from);
        let matte = Matte { name: "CryptoObject", names: &names };
        let pixels = [vec![(0, 0.25), (1, 0.4), (2, 0.35)], vec![(1, 1.0)], vec![]];
        let layers = matte.layers(6, &pixels);
        assert_eq!(
            layers.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(),
            ["CryptoObject00", "CryptoObject01", "CryptoObject02"]
        );
        let [r, g, b, a] = [0, 1, 2, 3].map(|k| &layers[0].channels[k].1);
        assert_eq!((r[0], g[0], b[0], a[0]), (id(hash("a")), 0.6, id(hash("b")), 0.4));
        assert_eq!((r[1], g[1], b[1], a[1]), (id(hash("b")), 1.0, 0.0, 0.0));
        assert!(
            layers[1..].iter().all(|layer| layer.channels.iter().all(|(_, values)| values.iter().all(|v| *v == 0.0)))
        );
        let attributes: BTreeMap<String, Attribute> = matte.attributes().collect();
        let manifest = attributes.iter().find(|(name, _)| name.ends_with("/manifest")).unwrap().1;
        let expected =
            format!("{{\"a\":\"{:08x}\",\"b\":\"{:08x}\"}}", id(hash("a")).to_bits(), id(hash("b")).to_bits());
        assert_eq!(*manifest, Attribute::Text(expected));
    }
}
