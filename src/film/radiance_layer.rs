//! Light that a picture shows apart from all the rest.

/// Which contributions a layer of the picture holds. Their sum over layers that share nothing and leave nothing out is the
/// picture itself: they are of the same paths, weighed in the same way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum RadianceLayer {
    /// Emitters and surroundings, seen by the camera.
    Emission,
    /// Light that a surface which the camera sees has scattered: of paths with two segments.
    Direct,
    /// Light that was scattered twice or more often.
    Indirect,
    /// Light of paths with at most so many segments.
    Shortest(u32),
    /// Light of the lights in a group.
    Group(u32),
}

/// Where a contribution to a pixel comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightPath {
    /// Segments from the camera to the emitter; passing through glass counts as scattering.
    pub(crate) segments: u32,
    /// Number of the emitter's light group.
    pub(crate) group: u32,
}

impl RadianceLayer {
    /// Whether the layer holds light of this path.
    #[inline(always)]
    pub(crate) fn takes(self, path: LightPath) -> bool {
        match self {
            RadianceLayer::Emission => path.segments == 1,
            RadianceLayer::Direct => path.segments == 2,
            RadianceLayer::Indirect => path.segments > 2,
            RadianceLayer::Shortest(most) => path.segments <= most,
            RadianceLayer::Group(group) => path.group == group,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [RadianceLayer; 3] = [RadianceLayer::Emission, RadianceLayer::Direct, RadianceLayer::Indirect];

    #[test]
    fn each_path_is_in_one_of_the_named_layers() {
        for segments in 1..9 {
            let path = LightPath { segments, group: segments % 3 };
            assert_eq!((0..3).filter(|&group| RadianceLayer::Group(group).takes(path)).count(), 1);
            assert_eq!(ALL.iter().filter(|layer| layer.takes(path)).count(), 1);
            assert_eq!(RadianceLayer::Shortest(4).takes(path), segments <= 4);
        }
    }
}
