//! Shapes, as meshes.

use super::parameters::Parameters;
use super::world::{MaterialRef, World, is_regular};
use crate::Result;
use crate::error::SourceLocation;
use crate::format::tessellate;
use crate::geometry::Mesh;
use crate::geometry::mesh::{ABSENT, Attribute, Indices};
use crate::scene::adaptation::Adaptation;
use crate::scene::model::{MeshSource, Model};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use std::rc::Rc;
use std::sync::Arc;

/// The state in which a shape is made.
pub(super) struct Placed {
    pub(crate) transform: DAffine3,
    pub(crate) reverse: bool,
    pub(crate) material: MaterialRef,
    pub(crate) area_light: Option<Rc<Parameters>>,
    pub(crate) object: Option<String>,
}

/// What a shape lets through.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Alpha {
    Opaque,
    Constant(f64),
    /// A texture's name.
    Texture(String, SourceLocation),
}

/// A shape, before anything is known of what it is made of.
pub(super) struct Shape {
    pub(crate) source: MeshSource,
    pub(crate) transform: DAffine3,
    pub(crate) material: MaterialRef,
    pub(crate) area_light: Option<Rc<Parameters>>,
    pub(crate) object: Option<String>,
    pub(crate) alpha: Alpha,
    /// By which a light divides its power: of one triangle, or of the round shape without its transform.
    pub(crate) area: Option<f64>,
    pub(crate) at: SourceLocation,
}

/// What a shape is made of triangles, where these stand in its own space, and the area that a light's power is spread over.
struct Made {
    source: MeshSource,
    own: DAffine3,
    area: Option<f64>,
}

/// A shape; `None` where it is not seen.
pub(super) fn read(world: &World, p: &Parameters, placed: Placed) -> Result<Option<Shape>> {
    let made = match p.plugin.as_str() {
        "trianglemesh" => Some(memory(triangles(p)?, &placed)),
        "bilinearmesh" => Some(memory(patches(p)?, &placed)),
        "plymesh" => Some(ply(world, p, &placed)?),
        "sphere" => Some(sphere(world, p, &placed)?),
        "disk" => disk(p, &placed)?,
        "cylinder" => cylinder(p, &placed)?,
        "loopsubdiv" => {
            return Err(p.error("subdivision surfaces (\"loopsubdiv\") are not read: store the mesh they become"));
        }
        kind => return Err(p.error(format!("the shape \"{kind}\" has no counterpart"))),
    };
    let alpha = alpha(p)?;
    p.ignore(&["shadowalpha", "edgelength", "splitmethod", "S"]);
    p.finish(&world.warnings);
    let Some(Made { source, own, area }) = made else {
        world.warnings.add(&p.at, format!("this {} has no area, and is not seen", p.plugin));
        return Ok(None);
    };
    let transform = placed.transform * own;
    if !is_regular(&transform.matrix3) || !transform.is_finite() {
        world.warnings.add(&p.at, format!("the transform flattens this {}, which is not seen", p.plugin));
        return Ok(None);
    }
    let Placed { material, area_light, object, .. } = placed;
    Ok(Some(Shape { source, transform, material, area_light, object, alpha, area, at: p.at.clone() }))
}

fn alpha(p: &Parameters) -> Result<Alpha> {
    match p.find("alpha") {
        None => Ok(Alpha::Opaque),
        Some(found) if found.kind == "texture" => {
            let name = p.text("alpha")?.unwrap_or_default().to_string();
            Ok(Alpha::Texture(name, found.at.clone()))
        }
        Some(_) => Ok(Alpha::Constant(p.number("alpha", 1.0)?)),
    }
}

/// A mesh of the text. Each of its triangles is a light of its own there.
fn memory(mut mesh: Mesh, placed: &Placed) -> Made {
    adaptation(placed).apply(&mut mesh);
    let area = mean_area(&mesh, &placed.transform);
    let model = Model { mesh, material_names: vec![String::new()], ..Model::default() };
    Made { source: MeshSource::Memory(Arc::new(model)), own: DAffine3::IDENTITY, area }
}

/// Normals say what is outside; where there are none, it is where the corners go round counter-clockwise.
fn adaptation(placed: &Placed) -> Adaptation {
    Adaptation { by_normals: true, flip: placed.reverse, ..Adaptation::default() }
}

/// Of the triangles in the world; `None` where they differ.
fn mean_area(mesh: &Mesh, to_world: &DAffine3) -> Option<f64> {
    let linear = to_world.matrix3;
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|p| linear * p.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    let first = (!mesh.triangles.is_empty()).then(|| area(0))?;
    let alike = (1..mesh.triangles.len()).all(|t| (area(t) - first).abs() <= 1e-3 * first);
    (alike && first > 0.0).then_some(first)
}

fn triangles(p: &Parameters) -> Result<Mesh> {
    let positions = p.vectors("P")?.ok_or_else(|| p.error("a trianglemesh needs `P`"))?;
    let indices = match p.numbers("indices")? {
        Some(numbers) => self::indices(p, numbers, positions.len())?,
        None if positions.len() == 3 => vec![0, 1, 2],
        None => return Err(p.error("a trianglemesh needs `indices`")),
    };
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(p.error("`indices` must be groups of 3"));
    }
    let normals = of_vertices(p, "N", positions.len())?;
    let uvs = match p.find("uv").is_some() {
        true => of_vertices(p, "uv", positions.len())?,
        false => of_vertices(p, "st", positions.len())?,
    };
    // as there, each triangle has a half of the picture where nothing is said
    let whole = || Attribute {
        values: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        indices: Indices::Own(vec![[0, 1, 2]; triangles.len()]),
    };
    Ok(Mesh {
        materials: vec![0; triangles.len()],
        triangles: triangles.to_vec(),
        normals: usable(normals, triangles),
        uvs: Some(uvs.map_or_else(whole, |values| Attribute { values, indices: Indices::OfPositions })),
        colors: None,
        positions,
    })
}

/// Indices of vertices that there are.
fn indices(p: &Parameters, numbers: &[f64], vertices: usize) -> Result<Vec<u32>> {
    let whole = |&x: &f64| (x.fract() == 0.0 && (0.0..vertices as f64).contains(&x)).then_some(x as u32);
    let found: Option<Vec<u32>> = numbers.iter().map(whole).collect();
    found.ok_or_else(|| {
        let wrong = numbers.iter().find(|x| whole(x).is_none()).copied().unwrap_or_default();
        p.error(format!("`indices` names the vertex {wrong}, of {vertices}"))
    })
}

/// What each vertex has, of which there must be as many.
fn of_vertices<const N: usize>(p: &Parameters, name: &str, vertices: usize) -> Result<Option<Vec<[f32; N]>>> {
    match p.groups::<N>(name)? {
        Some(groups) if groups.len() != vertices => {
            Err(p.error(format!("`{name}` is of {} vertices, and `P` of {vertices}", groups.len())))
        }
        found => Ok(found),
    }
}

/// Triangles with a normal that has no direction go without.
fn usable(normals: Option<Vec<[f32; 3]>>, triangles: &[[u32; 3]]) -> Option<Attribute<[f32; 3]>> {
    let mut values = normals?;
    let there: Vec<bool> = values.iter().map(|n| Vec3::from(*n).length_squared() >= f32::MIN_POSITIVE).collect();
    values.iter_mut().zip(&there).filter(|(_, there)| !**there).for_each(|(n, _)| *n = [0.0, 0.0, 1.0]);
    let own = |t: &[u32; 3]| if t.iter().all(|&i| there[i as usize]) { *t } else { [ABSENT; 3] };
    let whole = there.iter().all(|there| *there);
    let indices = if whole { Indices::OfPositions } else { Indices::Own(triangles.iter().map(own).collect()) };
    Some(Attribute { values, indices })
}

/// Cells along a side of a patch that is not flat.
const CELLS: u32 = 8;

/// Bilinear patches; flat ones are two triangles.
fn patches(p: &Parameters) -> Result<Mesh> {
    let points = p.vectors("P")?.ok_or_else(|| p.error("a bilinearmesh needs `P`"))?;
    let indices = match p.numbers("indices")? {
        Some(numbers) => self::indices(p, numbers, points.len())?,
        None if points.len() == 4 => vec![0, 1, 2, 3],
        None => return Err(p.error("a bilinearmesh needs `indices`")),
    };
    let (patches, rest) = indices.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(p.error("`indices` must be groups of 4"));
    }
    let normals = of_vertices::<3>(p, "N", points.len())?;
    let uvs = of_vertices::<2>(p, "uv", points.len())?;
    p.ignore(&["emissionfilename"]);
    let mut mesh = Mesh { uvs: None, ..Mesh::default() };
    let (mut own_normals, mut own_uvs) = (Vec::new(), Vec::new());
    for patch in patches {
        let [a, b, c, d] = patch.map(|i| Vec3::from(points[i as usize]));
        let flat =
            (b - a).cross(c - a).dot(d - a).abs() <= 1e-5 * (b - a).length() * (c - a).length() * (d - a).length();
        let cells = if flat { 1 } else { CELLS };
        let first = mesh.positions.len() as u32;
        let corner =
            |values: [Vec3; 4], s: f32, t: f32| values[0].lerp(values[1], s).lerp(values[2].lerp(values[3], s), t);
        for row in 0..=cells {
            for column in 0..=cells {
                let [s, t] = [column, row].map(|i| i as f32 / cells as f32);
                mesh.positions.push(corner([a, b, c, d], s, t).into());
                if let Some(normals) = &normals {
                    own_normals.push(corner(patch.map(|i| normals[i as usize].into()), s, t).into());
                }
                let uv = uvs.as_ref().map_or(Vec3::new(s, t, 0.0), |uvs| {
                    corner(patch.map(|i| Vec3::new(uvs[i as usize][0], uvs[i as usize][1], 0.0)), s, t)
                });
                own_uvs.push([uv.x, uv.y]);
            }
        }
        for cell in 0..cells * cells {
            let (row, column) = (cell / cells, cell % cells);
            let at = |r: u32, c: u32| first + (row + r) * (cells + 1) + column + c;
            mesh.triangles.extend([[at(0, 0), at(0, 1), at(1, 1)], [at(0, 0), at(1, 1), at(1, 0)]]);
        }
    }
    mesh.materials = vec![0; mesh.triangles.len()];
    mesh.normals = usable(normals.map(|_| own_normals), &mesh.triangles);
    mesh.uvs = Some(Attribute { values: own_uvs, indices: Indices::OfPositions });
    Ok(mesh)
}

fn ply(world: &World, p: &Parameters, placed: &Placed) -> Result<Made> {
    let name = p.text("filename")?.ok_or_else(|| p.error("a plymesh needs `filename`"))?;
    if p.find("displacement").is_some() {
        world.warnings.add(&p.at, "a displacement of the mesh has no counterpart: it is as it is in its file");
    }
    let source = MeshSource::Adapted(world.file(name), adaptation(placed));
    Ok(Made { source, own: DAffine3::IDENTITY, area: None })
}

/// Whether the shape is whole about its axis, and along it.
fn whole(p: &Parameters, low: f64, high: f64) -> Result<()> {
    let (zmin, zmax) = (p.number("zmin", low)?, p.number("zmax", high)?);
    if p.number("phimax", 360.0)? < 360.0 || zmin > low || zmax < high {
        return Err(p.error(format!("a part of a {} is not read", p.plugin)));
    }
    Ok(())
}

fn sphere(world: &World, p: &Parameters, placed: &Placed) -> Result<Made> {
    let radius = p.number("radius", 1.0)?;
    if radius <= 0.0 {
        return Err(p.error("`radius` must be greater than 0"));
    }
    whole(p, -radius, radius)?;
    let area = Some(4.0 * std::f64::consts::PI * radius * radius);
    let model = world.spheres[usize::from(placed.reverse)].get_or_init(|| round(tessellate::sphere(), placed));
    let source = MeshSource::Memory(model.clone());
    Ok(Made { source, own: DAffine3::from_scale(DVec3::splat(radius)), area })
}

fn disk(p: &Parameters, placed: &Placed) -> Result<Option<Made>> {
    let (radius, inner) = (p.number("radius", 1.0)?, p.number("innerradius", 0.0)?.max(0.0));
    if p.number("phimax", 360.0)? < 360.0 {
        return Err(p.error("a part of a disk is not read"));
    }
    if radius <= inner {
        return Ok(None);
    }
    let linear = DMat3::from_diagonal(DVec3::new(radius, radius, 1.0));
    let own = DAffine3 { matrix3: linear, translation: DVec3::Z * p.number("height", 0.0)? };
    let area = Some(std::f64::consts::PI * (radius * radius - inner * inner));
    let source = MeshSource::Memory(round(tessellate::ring(inner / radius), placed));
    Ok(Some(Made { source, own, area }))
}

fn cylinder(p: &Parameters, placed: &Placed) -> Result<Option<Made>> {
    let radius = p.number("radius", 1.0)?;
    let (zmin, zmax) = (p.number("zmin", -1.0)?, p.number("zmax", 1.0)?);
    let (low, high) = (zmin.min(zmax), zmin.max(zmax));
    whole(p, low, high)?;
    if radius <= 0.0 || high <= low {
        return Ok(None);
    }
    let own =
        DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(radius, radius, high - low)), translation: DVec3::Z * low };
    let area = Some(2.0 * std::f64::consts::PI * radius * (high - low));
    let mut model = (*tessellate::cylinder()).clone();
    Adaptation { flip_v: true, ..Adaptation::default() }.apply(&mut model.mesh);
    Ok(Some(Made { source: MeshSource::Memory(round(Arc::new(model), placed)), own, area }))
}

/// A mesh that stands for a round shape.
fn round(model: Arc<Model>, placed: &Placed) -> Arc<Model> {
    if placed.reverse { Arc::new(crate::scene::adaptation::flipped(&model)) } else { model }
}
