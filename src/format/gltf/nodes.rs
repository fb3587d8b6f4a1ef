//! The tree of nodes: what stands where.

use super::Warnings;
use super::buffers::Buffers;
use super::materials::Materials;
use super::mesh;
use crate::light::{DirectionalLight, LightDescription, PointLightParameters, SpotLightParameters};
use crate::math::Rgb;
use crate::scene::description::{
    CameraDescription, InstanceDescription, MeshDescription, NamedCamera, Projection, SceneDescription,
};
use crate::scene::model::MeshSource;
use crate::{Error, Result};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::camera::Projection as View;
use gltf::khr_lights_punctual::{Kind, Light};
use gltf::scene::Transform;
use gltf::{Camera, Document, Mesh, Node};

/// Nodes may be within each other so deep.
const DEEPEST: usize = 512;

/// Reads nodes into a scene.
pub(super) struct Nodes<'a, 'b> {
    pub(crate) document: &'a Document,
    pub(crate) buffers: &'a Buffers<'a>,
    pub(crate) materials: &'a Materials,
    pub(crate) warnings: Warnings<'b>,
    pub(crate) scene: SceneDescription,
}

/// A node in the world.
struct Placed<'a> {
    node: Node<'a>,
    to_world: DAffine3,
}

impl<'a> Nodes<'a, '_> {
    /// The default scene, else the first; all nodes where there is none.
    pub(crate) fn read(&mut self) -> Result<()> {
        let document = self.document;
        let placed = self.placed(document)?;
        let mut uses = vec![0; document.meshes().len()];
        for mesh in placed.iter().filter_map(|placed| placed.node.mesh()) {
            uses[mesh.index()] += 1;
        }
        let mut grouped = vec![false; uses.len()];
        for Placed { node, to_world } in &placed {
            if let Some(mesh) = node.mesh()
                && self.is_regular(node, to_world)
            {
                let name = label(&mesh);
                if uses[mesh.index()] == 1 {
                    self.mesh(&mesh, *to_world, None)?;
                } else {
                    if !std::mem::replace(&mut grouped[mesh.index()], true) {
                        self.mesh(&mesh, DAffine3::IDENTITY, Some(&name))?;
                    }
                    let seen = self.scene.meshes.iter().any(|mesh| mesh.group.as_ref() == Some(&name));
                    let instance = InstanceDescription { group: name, transform: *to_world, location: None };
                    self.scene.instances.extend(seen.then_some(instance));
                }
            }
            if let Some(camera) = node.camera() {
                self.camera(node, &camera, to_world)?;
            }
            if let Some(light) = node.light() {
                self.light(&light, to_world)?;
            }
        }
        Ok(())
    }

    fn placed(&self, document: &'a Document) -> Result<Vec<Placed<'a>>> {
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let roots: Vec<Node> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => document.nodes().collect(),
        };
        let mut met = vec![false; document.nodes().len()];
        let mut open: Vec<(Node, DAffine3, usize)> =
            roots.into_iter().rev().map(|node| (node, DAffine3::IDENTITY, 0)).collect();
        let mut placed = Vec::new();
        while let Some((node, parent, depth)) = open.pop() {
            if std::mem::replace(&mut met[node.index()], true) {
                return Err(Error::file(
                    self.buffers.path,
                    format!("node {} is in the scene more than once", node.index()),
                ));
            }
            if depth > DEEPEST {
                return Err(Error::file(self.buffers.path, format!("more than {DEEPEST} nodes are within each other")));
            }
            let to_world = parent * local(&node);
            open.extend(node.children().map(|child| (child, to_world, depth + 1)));
            placed.push(Placed { node, to_world });
        }
        Ok(placed)
    }

    /// Whether the node flattens nothing; a warning where it does.
    fn is_regular(&mut self, node: &Node, to_world: &DAffine3) -> bool {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = to_world.matrix3;
        let regular = x.cross(y).dot(z).abs() > 1e-7 * x.length() * y.length() * z.length() && to_world.is_finite();
        if !regular {
            self.warnings.add(format!("node {} flattens its mesh, which is not seen", node.index()));
        }
        regular
    }

    fn mesh(&mut self, mesh: &Mesh, transform: DAffine3, group: Option<&str>) -> Result<()> {
        for primitive in mesh.primitives() {
            let has_colors = primitive.get(&gltf::Semantic::Colors(0)).is_some();
            let index = primitive.material().index();
            let (material, uv_set, colored) = self.materials.of(index, has_colors, &mut self.warnings);
            let name = label(mesh);
            let model = mesh::model(&primitive, (uv_set, colored), &name, self.buffers, &mut self.warnings)?;
            let Some(model) = model else { continue };
            self.scene.meshes.push(MeshDescription {
                source: MeshSource::Memory(model),
                transform,
                material: Some(material),
                material_location: None,
                group: group.map(str::to_string),
                location: None,
            });
        }
        Ok(())
    }

    /// It looks along −z, with y up.
    fn camera(&mut self, node: &Node, camera: &Camera, to_world: &DAffine3) -> Result<()> {
        let axes = to_world.matrix3;
        let flat = || Error::file(self.buffers.path, format!("node {} flattens its camera", node.index()));
        let forward = (-axes.z_axis).try_normalize().ok_or_else(flat)?;
        let up = axes.y_axis.try_normalize().ok_or_else(flat)?.as_vec3();
        let origin = to_world.translation;
        let mirrored = axes.determinant() < 0.0;
        let common =
            CameraDescription { origin, target: origin + forward, up, mirrored, ..CameraDescription::default() };
        let described = match camera.projection() {
            View::Perspective(view) => {
                let vfov = view.yfov().to_degrees();
                if !(vfov > 0.0 && vfov < 180.0) {
                    return Err(Error::file(
                        self.buffers.path,
                        format!("camera {} has no field of view", camera.index()),
                    ));
                }
                CameraDescription { vfov, ..common }
            }
            View::Orthographic(view) => {
                let view_height = 2.0 * view.ymag().abs() * axes.y_axis.length() as f32;
                if !(view_height > 0.0 && view_height.is_finite()) {
                    return Err(Error::file(self.buffers.path, format!("camera {} sees nothing", camera.index())));
                }
                CameraDescription { projection: Projection::Orthographic, view_height, ..common }
            }
        };
        let name = camera.name().or(node.name()).map_or(format!("camera {}", camera.index()), str::to_string);
        self.scene.cameras.push(NamedCamera { name, camera: described, size: [None; 2] });
        Ok(())
    }

    /// It shines along −z. Candela count as W/sr, and lux as W/m², as the radiance of surfaces does in both.
    fn light(&mut self, light: &Light, to_world: &DAffine3) -> Result<()> {
        let color = (Rgb::from(light.color()) * light.intensity()).max(Rgb::ZERO);
        let name = light.name().map_or(format!("light {}", light.index()), str::to_string);
        let flat = || Error::file(self.buffers.path, format!("light `{name}` has no direction"));
        let direction = (-to_world.matrix3.z_axis).try_normalize().ok_or_else(flat)?.as_vec3();
        let position = to_world.translation;
        let described: LightDescription = match light.kind() {
            Kind::Directional => DirectionalLight { direction, irradiance: color }.into(),
            Kind::Point => PointLightParameters { position, intensity: color }.into(),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let cutoff_angle = outer_cone_angle.to_degrees().clamp(0.01, 90.0);
                let beam_angle = inner_cone_angle.to_degrees().clamp(0.0, cutoff_angle);
                SpotLightParameters { position, direction, intensity: color, cutoff_angle, beam_angle }.into()
            }
        };
        if light.range().is_some() {
            self.warnings.add(format!("light `{name}`: its range means nothing: light goes on"));
        }
        self.scene.lights.push(described);
        Ok(())
    }
}

fn label(mesh: &Mesh) -> String {
    match mesh.name() {
        Some(name) => format!("mesh {} `{name}`", mesh.index()),
        None => format!("mesh {}", mesh.index()),
    }
}

fn local(node: &Node) -> DAffine3 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from))))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            let turn = DQuat::from_array(rotation.map(f64::from));
            let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
            DAffine3::from_scale_rotation_translation(wide(scale), turn, wide(translation))
        }
    }
}
