use super::*;
use crate::bsdf::BsdfDescription;
use crate::film::tile::Tile;
use crate::format;
use crate::integrator::path::PathIntegrator;
use crate::integrator::{Batch, Task};
use crate::light::LightDescription;
use crate::math::Rgb;
use crate::math::rng::Rng;
use crate::scene::description::Projection;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

/// A square [−1, 1]² in the plane z = 0, seen from +z, whose picture stands upright; then four colours, one for each corner.
fn square() -> Vec<u8> {
    let corners = [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut bytes = Vec::new();
    corners.iter().for_each(|[x, y]| [*x, *y, 0.0].iter().for_each(|n| bytes.extend(n.to_le_bytes())));
    corners.iter().for_each(|_| [0.0f32, 0.0, 1.0].iter().for_each(|n| bytes.extend(n.to_le_bytes())));
    corners.iter().for_each(|[x, y]| [0.5 + 0.5 * x, 0.5 - 0.5 * y].iter().for_each(|n| bytes.extend(n.to_le_bytes())));
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    [[255u8, 0, 0, 255]; 4].iter().for_each(|c| bytes.extend(c));
    bytes
}

/// Two by two texels: red and green above, blue and clear white below.
fn picture() -> Vec<u8> {
    let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]];
    let picture = image::RgbaImage::from_fn(2, 2, |x, y| image::Rgba(texels[(2 * y + x) as usize]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A file of one square that is mesh 0, with colours of vertices as mesh 1, the picture as texture 0, and a camera 3 above that sees
/// [−1, 1]²; `change` says the rest.
fn document(change: impl FnOnce(&mut Value)) -> Value {
    let bytes = square();
    let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
    let attributes = json!({ "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 });
    let mut colored = attributes.clone();
    colored["COLOR_0"] = json!(4);
    let mut document = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": bytes.len(), "uri": data("application/octet-stream", &bytes) }],
        "bufferViews": [view(0, 48), view(48, 48), view(96, 32), view(128, 12), view(140, 16)],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 4, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" },
        ],
        "images": [{ "uri": data("image/png", &picture()), "mimeType": "image/png" }],
        "samplers": [{ "magFilter": 9728 }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "materials": [{ "name": "m" }],
        "meshes": [
            { "primitives": [{ "attributes": attributes, "indices": 3, "material": 0 }] },
            { "primitives": [{ "attributes": colored, "indices": 3, "material": 0 }] },
        ],
        "cameras": [{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 10 } }],
        "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 3] }],
        "scenes": [{ "nodes": [0, 1] }],
        "scene": 0
    });
    change(&mut document);
    document
}

fn read_bytes(name: &str, bytes: &[u8]) -> (TempDir, Result<(SceneFile, Vec<String>)>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let read = format::load(&path, &["film.width=2".into(), "film.height=2".into()]);
    (folder, read)
}

fn read(document: &Value) -> (SceneFile, Vec<String>) {
    read_bytes("a.gltf", document.to_string().as_bytes()).1.unwrap()
}

/// The four pixels of the picture, row by row from above.
fn seen(document: &Value) -> Vec<Rgb> {
    let (file, warnings) = read(document);
    assert!(warnings.is_empty(), "{warnings:?}");
    let scene = file.load_scene(1).unwrap().0;
    let task = Task { tile: Tile { x: 0, y: 0, width: 2, height: 2 }, first_sample: 0, samples: 256 };
    let sums = PathIntegrator::plain(&scene, &file.integrator, 1).render(&task, &mut Batch::new()).samples.sum;
    sums.into_iter().map(|sum| sum * (scene.light_unit().value() as f32 / 256.0)).collect()
}

fn near(found: &[Rgb], wanted: &[Rgb; 4], tolerance: f32) {
    assert!(
        found.iter().zip(wanted).all(|(a, b)| (*a - *b).abs().max_element() <= tolerance),
        "{found:?} is not {wanted:?}"
    );
}

#[test]
fn pictures_stand_upright_and_are_scaled_and_moved() {
    let glowing = |transform: Value| {
        document(|d| {
            let mut texture = json!({ "index": 0 });
            if !transform.is_null() {
                texture["extensions"] = json!({ "KHR_texture_transform": transform });
            }
            d["extensionsUsed"] = json!(["KHR_texture_transform", "KHR_materials_emissive_strength"]);
            let strength = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 4 } });
            d["materials"][0] = json!({ "emissiveFactor": [1, 1, 0.5], "emissiveTexture": texture, "extensions": strength,
                "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1 } });
        })
    };
    let (red, green, blue, white) = (Rgb::X * 4.0, Rgb::Y * 4.0, Rgb::Z * 2.0, Rgb::new(4.0, 4.0, 2.0));
    near(&seen(&glowing(Value::Null)), &[red, green, blue, white], 1e-4);
    // (u, v) of the lower right quarter everywhere: a half and a half of it
    near(&seen(&glowing(json!({ "scale": [0.5, 0.5], "offset": [0.5, 0.5] }))), &[white; 4], 1e-4);
    near(&seen(&glowing(json!({ "offset": [0.5, 0.0] }))), &[green, red, white, blue], 1e-4);
}

#[test]
fn light_at_right_angles_is_reflected_as_by_lambert() {
    // a surface without a highlight; Burley's diffuse lobe is that of Lambert at right angles
    let lit = |light: Value, base: Value, mesh: usize| {
        document(|d| {
            d["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
            d["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            d["nodes"][0]["mesh"] = json!(mesh);
            d["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
            let rough = json!({ "baseColorFactor": base, "metallicFactor": 0, "roughnessFactor": 1 });
            let specular = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
            d["materials"][0] = json!({ "pbrMetallicRoughness": rough, "extensions": specular });
        })
    };
    let pi = std::f32::consts::PI;
    let sun = json!({ "type": "directional", "intensity": 2, "color": [1, 0.5, 0.25] });
    let wanted = Rgb::new(0.8 * 2.0, 0.4, 0.2 * 0.5) / pi;
    near(&seen(&lit(sun.clone(), json!([0.8, 0.4, 0.2, 1]), 0)), &[wanted; 4], 1e-3);
    near(&seen(&lit(sun, json!([0.8, 0.4, 0.2, 1]), 1)), &[wanted * Rgb::X; 4], 1e-3);
    // far enough for its directions to be nearly one
    let far = |kind: Value| {
        let mut file = lit(kind, json!([0.5, 0.5, 0.5, 1]), 0);
        file["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "translation": [0, 0, 100], "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
        file["nodes"][1]["extensions"] = json!({});
        file["scenes"][0]["nodes"] = json!([0, 1, 2]);
        file
    };
    let wanted = Rgb::splat(0.5 * 1e4 / 1e4 / pi);
    near(&seen(&far(json!({ "type": "point", "intensity": 1e4 }))), &[wanted; 4], 1e-3);
    let spot = json!({ "type": "spot", "intensity": 1e4, "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } });
    near(&seen(&far(spot)), &[wanted; 4], 1e-3);
    // its share falls from 1 at 0.2 of the corner's distance to 0 at 1: over a quarter of that disk ∫ r·share·½π dr
    let thin = json!({ "type": "spot", "intensity": 1e4, "spot": { "innerConeAngle": 0.002, "outerConeAngle": 0.01 } });
    near(&seen(&far(thin)), &[wanted * 0.3246; 4], 0.08 * wanted.x);
}

/// A black sheet, made of `material`, before a sheet of radiance 1.
fn before_light(material: Value) -> Value {
    document(|d| {
        d["extensionsUsed"] = json!(["KHR_materials_transmission"]);
        d["materials"] = json!([material, { "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] } }]);
        let mut behind = d["meshes"][0].clone();
        behind["primitives"][0]["material"] = json!(1);
        d["meshes"].as_array_mut().unwrap().push(behind);
        d["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 2, "translation": [0, 0, -1], "scale": [9, 9, 1] }));
        d["scenes"][0]["nodes"] = json!([0, 1, 2]);
    })
}

#[test]
fn alpha_cuts_out_or_thins() {
    let sheet = |mode: &str, more: Value| {
        let mut base = json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 1, "roughnessFactor": 1 });
        base["baseColorFactor"] = json!([0, 0, 0, 1]);
        base.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        before_light(json!({ "alphaMode": mode, "pbrMetallicRoughness": base }))
    };
    let (black, light) = (Rgb::ZERO, Rgb::ONE);
    near(&seen(&sheet("OPAQUE", json!({}))), &[black; 4], 0.05);
    near(&seen(&sheet("MASK", json!({}))), &[black, black, black, light], 0.05);
    let half = json!({ "baseColorFactor": [0, 0, 0, 0.5] });
    near(&seen(&sheet("BLEND", half.clone())), &[light * 0.5, light * 0.5, light * 0.5, light], 0.12);
    near(&seen(&sheet("MASK", half)), &[black, black, black, light], 0.05);
}

#[test]
fn a_pane_lets_pass_what_it_does_not_reflect() {
    let glass = json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
        "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 1], "roughnessFactor": 0, "metallicFactor": 0 } });
    let reflected = 2.0 * 0.04 / 1.04;
    let wanted = Rgb::new(1.0, 0.5, 0.25) * (1.0 - reflected);
    near(&seen(&before_light(glass)), &[wanted; 4], 0.05);
}

#[test]
fn materials_are_principled() {
    let file = document(|d| {
        d["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_materials_ior"]);
        d["materials"][0] = json!({ "name": "paint", "doubleSided": true, "normalTexture": { "index": 0, "scale": 0.5 },
            "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 0 }, "roughnessFactor": 0.5, "baseColorTexture": { "index": 0 } },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25 }, "KHR_materials_ior": { "ior": 1.25 } } });
    });
    let (file, warnings) = read(&file);
    assert!(warnings.is_empty(), "{warnings:?}");
    let paint = &file.scene.materials["paint"];
    let BsdfDescription::Principled(p) = &paint.bsdf else { panic!("{paint:?}") };
    assert_eq!((p.clearcoat, p.clearcoat_gloss), (0.75, 0.75));
    assert!((p.specular - (0.25f32 / 2.25).powi(2) / 0.08).abs() < 1e-6, "{}", p.specular);
    let Some(crate::texture::ScalarTexture::Channel(roughness, 1)) = &p.maps.roughness else { panic!("{p:?}") };
    assert_eq!(roughness.tint, Rgb::splat(0.5));
    assert_eq!(paint.relief.as_ref().unwrap().strength, 0.5);
    assert!(paint.two_sided && paint.emission_two_sided);
    file.load_scene(1).unwrap();
}

#[test]
fn nodes_stand_in_each_other_and_share_meshes() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let file = document(|d| {
        d["nodes"] = json!([
            { "translation": [0, 5, 0], "children": [1, 2, 3] },
            { "mesh": 0, "scale": [2, 2, 2] },
            { "mesh": 0, "rotation": [0, half, 0, half] },
            { "camera": 0, "name": "eye" }
        ]);
        d["cameras"][0] = json!({ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } });
        d["scenes"][0]["nodes"] = json!([0]);
    });
    let (file, _) = read(&file);
    assert_eq!((file.scene.meshes.len(), file.scene.instances.len()), (1, 2));
    let camera = file.scene.camera.as_ref().unwrap();
    assert_eq!((camera.projection, camera.target - camera.origin), (Projection::Perspective, -glam::DVec3::Z));
    assert!((camera.vfov - 0.5f32.to_degrees()).abs() < 1e-4 && file.scene.cameras[0].name == "eye");
    let (low, high) = file.load_scene(1).unwrap().0.bounds();
    assert!((low - glam::Vec3::new(-2.0, 3.0, -1.0)).abs().max_element() < 1e-3, "{low}");
    assert!((high - glam::Vec3::new(2.0, 7.0, 1.0)).abs().max_element() < 1e-3, "{high}");
    assert!(!matches!(file.scene.lights[..], [LightDescription::Point(_)]));
}

/// The same as one binary file.
fn binary(document: &Value) -> Vec<u8> {
    let mut document = document.clone();
    document["buffers"][0].as_object_mut().unwrap().remove("uri");
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = square();
    data.resize(data.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF".to_vec();
    for number in [2, 28 + text.len() + data.len(), text.len(), 0x4e4f_534a] {
        bytes.extend((number as u32).to_le_bytes());
    }
    bytes.extend(&text);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(0x004e_4942u32.to_le_bytes());
    bytes.extend(&data);
    bytes
}

#[test]
fn binary_files_are_the_same() {
    let document = document(|_| ());
    let (_folder, loaded) = read_bytes("a.glb", &binary(&document));
    let hash = |file: &SceneFile| file.load_scene(1).unwrap().0.hash_text();
    assert_eq!(hash(&loaded.unwrap().0), hash(&read(&document).0));
}

#[test]
fn faults_are_named() {
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 9] = [
        ("no glTF 2.0", |d| d["asset"] = json!({})),
        ("KHR_draco_mesh_compression\": Unsupported extension", |d| {
            d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        }),
        ("not base64", |d| d["buffers"][0]["uri"] = json!("data:application/octet-stream;base64,*")),
        ("nothing is fetched", |d| d["buffers"][0]["uri"] = json!("https://example.org/a.bin")),
        ("none.bin", |d| d["buffers"][0]["uri"] = json!("none.bin")),
        ("buffer 0 has 156 bytes, and says 9999", |d| d["buffers"][0]["byteLength"] = json!(9999)),
        ("accessor 0 reaches beyond its buffer view", |d| d["accessors"][0]["count"] = json!(5)),
        ("a triangle has the vertex", |d| d["accessors"][0]["count"] = json!(3)),
        ("more than once", |d| d["nodes"][0]["children"] = json!([0])),
    ];
    for (wanted, change) in cases {
        let file = document(change);
        let message =
            read_bytes("a.gltf", file.to_string().as_bytes()).1.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(wanted), "{message} is not {wanted}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, mut rng) = (binary(&document(|_| ())), Rng::new(3));
    let path = folder.path().join("a.glb");
    for k in 0..1500 {
        let mut bytes = whole.clone();
        if k % 3 == 0 {
            bytes.truncate(rng.next_u32() as usize % bytes.len());
        }
        for _ in 0..1 + rng.next_u32() % 4 {
            if !bytes.is_empty() {
                let at = rng.next_u32() as usize % bytes.len();
                bytes[at] = rng.next_u32() as u8;
            }
        }
        fs::write(&path, &bytes).unwrap();
        _ = format::load(&path, &[]).map(drop);
    }
}
