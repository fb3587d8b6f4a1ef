//! `furnace`: the closed form that every estimator must meet.

use super::SceneFiles;
use super::obj_writer::{Material, Model};
use super::shapes::icosphere;

const TOML: &str = r#"# A white furnace: a closed sphere that reflects a = 1/2 of what it receives and glows with Le = 1 everywhere.
# From every point and in every direction, with neither distance nor angle in it,
#     L = Le + a L,    hence    L = Le / (1 - a) = 2.
# A path of at most n segments sees the first n terms of Le (1 + a + a^2 + ...) = 2 (1 - 2^-n): at n = 64 the rest
# is far below what a 32-bit number can tell from 2. Every pixel is exactly 2 in the mean; roulette is off so that
# nothing but the sampling of directions and lights makes noise.
[camera]
origin = [0.2, 0.1, 0.3]
target = [0, 0, -1]
up = [0, 1, 0]
vfov = 60.0

[film]
width = 64
height = 64
filter = "box"
exposure = -1.0

[[mesh]]
path = "furnace.obj"

[integrator]
max_depth = 64
next_event = true
mis = true
roulette = "none"
rr_depth = 5

[guiding]
method = "grid"

[render]
spp = 64
seed = 0
"#;

/// An inward icosphere of flat faces: many normals to a cell, and no shading normals to excuse a deviation.
pub(crate) fn scene() -> SceneFiles {
    let glow = Material { emission: [1.0; 3], ..Material::diffuse("glow", [0.5; 3]) };
    let model = Model {
        about: "a closed sphere with emission 1 and albedo 1/2, its faces inward",
        objects: vec![("sphere", icosphere(4, "glow").flipped())],
        materials: vec![glow],
    };
    SceneFiles { toml: TOML.to_owned(), model }
}
