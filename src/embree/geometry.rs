//! What an Embree scene is made of: meshes on shared buffers, see-through meshes, instances.

use super::scene::Scene;
use super::sys;
use glam::Affine3A;
use std::ffi::c_void;
use std::sync::Arc;

/// No coordinate is larger, be it of a triangle or of a ray's origin. Embree multiplies two edges and a distance: where
/// these are 2·10¹² each, the sum of the six products is 5·10³⁷, and twice that (its robust test) is within an `f32`.
/// Squares of coordinates and sums of these are as well. (Embree itself only drops what is beyond 1.8·10¹⁸.)
pub(crate) const LARGEST_COORDINATE: f32 = 1e12;

/// What is traced is no smaller, in its largest extent. The same products of edges a hundred times shorter are then 10⁻³⁴
/// or more, where an `f32` still has all of its digits (down to 10⁻³⁸).
pub(crate) const SMALLEST_EXTENT: f32 = 1e-10;

/// Decides, hit by hit, whether a ray goes on: `true` where triangle `primitive` is seen through at the barycentric
/// weights `(u, v)`. Called from inside traversal, on any thread; it must depend on nothing but its arguments,
/// or images would depend on the order of traversal.
pub(crate) trait OpacityTest: Send + Sync {
    fn passes(&self, primitive: u32, u: f32, v: f32) -> bool;
}

/// A scene that stands in another one, with a transform of its own.
pub(crate) struct Instance {
    pub(crate) scene: Arc<Scene>,
    pub(crate) to_world: Affine3A,
}

/// A boxed test behind one thin pointer, as Embree's user data wants it.
pub(super) struct Filter(pub Box<dyn OpacityTest>);

/// Embree's filter callback: clears the lanes whose ray passes through.
///
/// # Safety
/// Called by Embree, with a geometry whose user pointer is a live [`Filter`].
pub(super) unsafe extern "C" fn filter(arguments: *const sys::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes valid arguments; the user pointer is set in `SceneBuilder::add_mesh` to a box that
    // the scene owns.
    let (arguments, test) = unsafe {
        let a = &*arguments;
        (a, &*a.geometryUserPtr.cast::<Filter>())
    };
    let n = arguments.N as usize;
    for lane in 0..n {
        // SAFETY: `valid` has N elements; the hit is an SoA packet of N lanes whose fields are, in this order,
        // Ng (3), u, v, primID (Embree manual, RTCHitN).
        unsafe {
            let valid = arguments.valid.add(lane);
            if *valid != -1 {
                continue;
            }
            let field = |k: usize| arguments.hit.cast::<c_void>().cast::<f32>().add(k * n + lane);
            let (u, v, primitive) = (*field(3), *field(4), (*field(5)).to_bits());
            // A panic must not cross into C: a test that fails stops the ray.
            let passes = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| test.0.passes(primitive, u, v)));
            if passes.unwrap_or(false) {
                *valid = 0;
            }
        }
    }
}
