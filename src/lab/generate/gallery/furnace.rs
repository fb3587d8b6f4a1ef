//! A furnace of few triangles, and the picture that it must give.

use super::{View, head, mesh};
use crate::lab::generate::SceneFiles;
use crate::lab::generate::obj_writer::{Material, Model};
use crate::lab::generate::shapes::icosphere;
use glam::DVec3;

const VIEW: View =
    View { eye: DVec3::new(0.2, 0.1, 0.3), target: DVec3::new(0.0, 0.0, -1.0), vfov: 60.0, exposure: -2.0 };

/// Le = 1 and a = 1/2 on every side: L = Le/(1 − a) = 2. Twelve segments would leave out 2⁻¹¹ of it, 48 leave out nothing
/// that 32 bits can tell.
pub(crate) fn oven() -> SceneFiles {
    let about = "A closed ball that glows with 1 and reflects half of what it receives: 2 everywhere.";
    let glow = Material { emission: [1.0; 3], ..Material::diffuse("glow", [0.5; 3]) };
    let model = Model {
        about: "a closed ball with emission 1 and albedo 1/2, its faces inward",
        objects: vec![("ball", icosphere(2, "glow").flipped())],
        materials: vec![glow],
    };
    let toml = head(about, &VIEW).replace("max_depth = 12", "max_depth = 48");
    SceneFiles { toml: toml + &mesh("oven"), model }
}

/// An even sky, seen past a triangle that lies behind the eye.
pub(crate) fn known() -> SceneFiles {
    let about = "What the scene `oven` looks like, by its closed form: 2 everywhere.";
    let behind = "translate = [0, 0, 10]\n\n[[light]]\ntype = \"constant\"\nradiance = 2\n";
    SceneFiles { toml: head(about, &VIEW) + &mesh("triangle") + behind, model: Model::default() }
}
