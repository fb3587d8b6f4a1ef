//! What a picture file holds on demand, beside what it always holds.

use super::RadianceLayer;

/// A layer that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtraLayer {
    /// Light apart.
    Light(RadianceLayer),
    /// Light apart by the groups that lights are in, a layer for each.
    LightGroups,
    /// Where camera rays meet the scene.
    Position,
    /// Normals of the triangles that they meet.
    GeometricNormal,
    /// Which objects and materials they meet.
    Cryptomatte,
}

impl ExtraLayer {
    /// By their names in scene files and pictures.
    pub(crate) const NAMES: &[(&'static str, ExtraLayer)] = &[
        ("emission", ExtraLayer::Light(RadianceLayer::Emission)),
        ("direct", ExtraLayer::Light(RadianceLayer::Direct)),
        ("indirect", ExtraLayer::Light(RadianceLayer::Indirect)),
        ("light_groups", ExtraLayer::LightGroups),
        ("P", ExtraLayer::Position),
        ("N", ExtraLayer::GeometricNormal),
        ("cryptomatte", ExtraLayer::Cryptomatte),
    ];

    /// The light that it holds, if it holds light, where lights are in so many groups.
    pub(crate) fn light(self, groups: usize) -> Vec<RadianceLayer> {
        match self {
            ExtraLayer::Light(layer) => vec![layer],
            ExtraLayer::LightGroups => (0..groups as u32).map(RadianceLayer::Group).collect(),
            _ => Vec::new(),
        }
    }

    /// Its name in pictures.
    pub(crate) fn name(self) -> &'static str {
        let named = ExtraLayer::NAMES.iter().find(|(_, layer)| *layer == self);
        named.map_or("shortest", |(name, _)| name)
    }
}
