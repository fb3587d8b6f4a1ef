//! What a picture file holds on demand, beside what it always holds.

use super::RadianceLayer;

/// A layer that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtraLayer {
    /// Light apart.
    Light(RadianceLayer),
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
        ("P", ExtraLayer::Position),
        ("N", ExtraLayer::GeometricNormal),
        ("cryptomatte", ExtraLayer::Cryptomatte),
    ];

    /// The light that it holds, if it holds light.
    pub(crate) fn light(self) -> Option<RadianceLayer> {
        match self {
            ExtraLayer::Light(layer) => Some(layer),
            _ => None,
        }
    }

    /// Its name in pictures.
    pub(crate) fn name(self) -> &'static str {
        let named = ExtraLayer::NAMES.iter().find(|(_, layer)| *layer == self);
        named.map_or("shortest", |(name, _)| name)
    }
}
