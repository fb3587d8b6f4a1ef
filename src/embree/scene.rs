//! Embree's scene: built once, then only asked.

use super::build::{BuildOptions, BuildQuality};
use super::coherence::Coherence;
use super::device::Device;
use super::geometry::{Filter, Instance, OpacityTest, filter};
use super::sys;
use crate::{Error, Result};
use glam::Vec3;
use std::sync::Arc;

/// The buffers of a mesh, which Embree reads in place.
#[derive(Clone, Copy)]
pub(crate) struct Triangles<'a> {
    /// With spare capacity for one more vertex: Embree reads vertices with 16-byte loads, four bytes past the last one.
    pub(crate) positions: &'a Vec<[f32; 3]>,
    /// Indices into `positions`.
    pub(crate) triangles: &'a [[u32; 3]],
}

/// Collects geometry for a [`Scene`]. The geometries of a scene are numbered in the order in which they are added.
pub(crate) struct SceneBuilder {
    scene: Scene,
    quality: BuildQuality,
}

/// A committed scene. Queries may come from any number of threads.
pub(crate) struct Scene {
    handle: sys::RTCScene,
    device: Arc<Device>,
    /// There are kernels for packets of 8 rays, and none for 16.
    takes_halves: bool,
    /// Embree reads these buffers during queries: they are kept until the scene is released.
    buffers: Vec<Arc<dyn Send + Sync>>,
    #[allow(clippy::vec_box, reason = "Embree keeps their addresses, which a growing vector would change")]
    filters: Vec<Box<Filter>>,
    instanced: Vec<Arc<Scene>>,
}

// SAFETY: a committed scene may be queried from any thread (manual, "Thread safety"), and after `SceneBuilder::commit`
// nothing modifies it.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

impl SceneBuilder {
    /// An empty scene.
    pub(crate) fn new(device: &Arc<Device>, options: BuildOptions) -> Result<SceneBuilder> {
        // SAFETY: the device is live; a null scene is caught by `check`.
        let handle = unsafe { sys::rtcNewScene(device.handle()) };
        device.check("making a scene")?;
        let scene = Scene {
            handle,
            device: device.clone(),
            takes_halves: device.takes_halves(),
            buffers: Vec::new(),
            filters: Vec::new(),
            instanced: Vec::new(),
        };
        let flags = if options.robust { sys::RTC_SCENE_FLAG_ROBUST } else { sys::RTC_SCENE_FLAG_NONE };
        // SAFETY: the scene is live.
        unsafe {
            sys::rtcSetSceneFlags(handle, flags);
            sys::rtcSetSceneBuildQuality(handle, options.quality.as_embree());
        }
        Ok(SceneBuilder { scene, quality: options.quality })
    }

    /// Adds a mesh without copying it, and returns its geometry id. The scene keeps `owner`, to which the buffers belong
    /// that `buffers` names.
    ///
    /// # Errors
    /// Where an index is out of range, or where `positions` has no spare capacity.
    pub(crate) fn add_mesh<T: Send + Sync + 'static>(
        &mut self,
        owner: Arc<T>,
        buffers: impl FnOnce(&T) -> Triangles<'_>,
        opacity: Option<Box<dyn OpacityTest>>,
    ) -> Result<u32> {
        let Triangles { positions, triangles } = buffers(&owner);
        check_buffers(positions, triangles)?;
        let device = self.scene.device.clone();
        // SAFETY: the device is live.
        let geometry = unsafe { sys::rtcNewGeometry(device.handle(), sys::RTC_GEOMETRY_TYPE_TRIANGLE) };
        device.check("making a mesh")?;
        // SAFETY: both buffers are borrowed from the value of `owner`, which this scene keeps until after its release, and to
        // which nobody can have exclusive access meanwhile: they neither move nor change. Indices are in range, and the last
        // vertex is followed by readable memory (both checked above).
        unsafe {
            let (float3, uint3) = (sys::RTC_FORMAT_FLOAT3, sys::RTC_FORMAT_UINT3);
            let (vertices, indices) = (positions.as_ptr().cast(), triangles.as_ptr().cast());
            let (vertex, index) = (sys::RTC_BUFFER_TYPE_VERTEX, sys::RTC_BUFFER_TYPE_INDEX);
            sys::rtcSetSharedGeometryBuffer(geometry, vertex, 0, float3, vertices, 0, 12, positions.len());
            sys::rtcSetSharedGeometryBuffer(geometry, index, 0, uint3, indices, 0, 12, triangles.len());
        }
        if let Some(test) = opacity {
            let test = Box::new(Filter(test));
            let pointer: *const Filter = &*test;
            // SAFETY: the box is kept by this scene until after its release, and its address does not change.
            unsafe {
                sys::rtcSetGeometryUserData(geometry, pointer.cast_mut().cast());
                sys::rtcSetGeometryIntersectFilterFunction(geometry, Some(filter));
                sys::rtcSetGeometryOccludedFilterFunction(geometry, Some(filter));
            }
            self.scene.filters.push(test);
        }
        self.scene.buffers.push(owner);
        self.attach(geometry)
    }

    /// Adds an instance; returns its id, which hits carry as `instance`.
    pub(crate) fn add_instance(&mut self, instance: Instance) -> Result<u32> {
        let device = self.scene.device.clone();
        let m = instance.to_world.to_cols_array();
        // SAFETY: device and instanced scene are live, the latter kept by this scene; the matrix is read during
        // the call, as three columns and a translation of three floats each.
        let geometry = unsafe {
            let geometry = sys::rtcNewGeometry(device.handle(), sys::RTC_GEOMETRY_TYPE_INSTANCE);
            sys::rtcSetGeometryInstancedScene(geometry, instance.scene.handle);
            sys::rtcSetGeometryTransform(geometry, 0, sys::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m.as_ptr().cast());
            geometry
        };
        self.scene.instanced.push(instance.scene);
        self.attach(geometry)
    }

    fn attach(&mut self, geometry: sys::RTCGeometry) -> Result<u32> {
        // SAFETY: geometry and scene are live. The scene takes a reference of its own, so ours is given back.
        let id = unsafe {
            // Embree 4 starts with another mask than Embree 3.
            sys::rtcSetGeometryMask(geometry, u32::MAX);
            // A scene of low quality builds each of its meshes by that of the mesh, and meshes start with medium.
            sys::rtcSetGeometryBuildQuality(geometry, self.quality.as_embree());
            sys::rtcCommitGeometry(geometry);
            let id = sys::rtcAttachGeometry(self.scene.handle, geometry);
            sys::rtcReleaseGeometry(geometry);
            id
        };
        self.scene.device.check("adding a geometry")?;
        Ok(id)
    }

    /// Builds the acceleration structure, with Embree's own threads.
    pub(crate) fn commit(self) -> Result<Scene> {
        // SAFETY: the scene is live, and no query runs: it has not been given out yet.
        unsafe { sys::rtcCommitScene(self.scene.handle) };
        self.scene.device.check("building the acceleration structure")?;
        Ok(self.scene)
    }
}

impl Scene {
    /// Corners of the bounding box; `None` for an empty scene.
    pub(crate) fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut b = sys::RTCBounds::default();
        // SAFETY: the scene is committed; the struct is bindgen's own and so aligned.
        unsafe { sys::rtcGetSceneBounds(self.handle, &mut b) };
        let (low, high) = (Vec3::new(b.lower_x, b.lower_y, b.lower_z), Vec3::new(b.upper_x, b.upper_y, b.upper_z));
        low.cmple(high).all().then_some((low, high))
    }

    /// The device that the scene was made with.
    pub(crate) fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// What may be said of rays. Embree 3.13.5 does not return from coherent shadow packets on instances (rays whose
    /// directions differ, 16 wide, AVX-512), so coherence, which is only ever a hint, is kept from scenes with instances.
    pub(super) fn allowed(&self, coherence: Coherence) -> Coherence {
        if self.instanced.is_empty() { coherence } else { Coherence::Incoherent }
    }

    /// Whether packets of 16 rays are asked in halves.
    pub(super) fn takes_halves(&self) -> bool {
        self.takes_halves
    }

    pub(super) fn handle(&self) -> sys::RTCScene {
        self.handle
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: this is the only owner of the reference that rtcNewScene gave. Buffers, filters and instanced
        // scenes are fields, and fields are dropped after this body.
        unsafe { sys::rtcReleaseScene(self.handle) };
    }
}

fn check_buffers(positions: &Vec<[f32; 3]>, triangles: &[[u32; 3]]) -> Result<()> {
    if positions.capacity() == positions.len() {
        return Err(Error::Scene("a mesh's positions need spare capacity for one more vertex".into()));
    }
    let n = positions.len() as u32;
    match triangles.iter().position(|t| t.iter().any(|&i| i >= n)) {
        Some(k) => Err(Error::Scene(format!("triangle {k} of a mesh has an index outside of its {n} vertices"))),
        None => Ok(()),
    }
}
