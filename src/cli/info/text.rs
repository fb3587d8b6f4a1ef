//! The same for people.

use super::report::{Light, Material, Picture, Report};
use crate::io::memory;
use serde_json::Value;

/// Lines, without their ends.
pub(super) fn lines(report: &Report) -> Vec<String> {
    let mut lines = head(report);
    let section = |title: &str, items: Vec<String>| match items.is_empty() {
        true => vec![],
        false => [vec![String::new(), title.to_string()], items].concat(),
    };
    lines.extend(section("lights", report.lights.iter().map(light).collect()));
    lines.extend(section("materials", report.materials.iter().flat_map(material).collect()));
    lines.extend(section("textures", report.textures.iter().map(picture).collect()));
    lines.extend(section("warnings", report.warnings.iter().map(|warning| format!("  {warning}")).collect()));
    lines
}

fn head(report: &Report) -> Vec<String> {
    let Report { bounds, memory, camera, .. } = report;
    let line = |name: &str, value: String| format!("{name:12} {value}");
    let found = if camera.found { "found by what can be seen" } else { "of the scene file" };
    let bytes = |bytes: u64| memory::text(bytes);
    let named = [("vfov", camera.vfov), ("view_height", camera.view_height)];
    let field: String = named.iter().filter_map(|(key, x)| x.map(|x| format!("{key} {x}, "))).collect();
    let mut lines = vec![
        line("scene", report.scene.clone()),
        line(
            "loaded in",
            format!("{:.2} s, prepared for rays in {:.2} s", report.load_wall_seconds, report.build_wall_seconds),
        ),
        line("triangles", format!("{} in {} meshes, {} instances", report.triangles, report.meshes, report.instances)),
        line("bounds", format!("{} to {}", value(&bounds.low), value(&bounds.high))),
        line(
            "memory",
            format!(
                "{} meshes, {} textures, {} Embree",
                bytes(memory.meshes as u64),
                bytes(memory.textures as u64),
                bytes(memory.embree)
            ),
        ),
        line(
            "camera",
            format!(
                "{found}: {}, origin {}, target {}, up {}, {field}{} x {} pixels",
                camera.projection,
                value(&camera.origin),
                value(&camera.target),
                value(&camera.up),
                camera.width,
                camera.height
            ),
        ),
    ];
    if !report.cameras.is_empty() {
        lines.push(line("cameras", report.cameras.join(", ")));
    }
    lines
}

fn light(light: &Light) -> String {
    let added = if light.added { ", added since there is no other" } else { "" };
    let power = format!("{:.4} W{added}", light.power);
    match (&light.material, light.triangles, light.area) {
        (Some(material), Some(triangles), Some(area)) => {
            format!("  surfaces of {material}: {triangles} triangles, area {area:.4}, {power}")
        }
        _ => {
            let parameters: Vec<String> =
                light.parameters.iter().map(|(key, v)| format!("{key} {}", value(v))).collect();
            format!("  {} {}: {power}", light.kind, parameters.join(", "))
        }
    }
}

fn material(material: &Material) -> Vec<String> {
    let Material { name, kind, source, triangles, area, .. } = material;
    let name = if name.is_empty() { "(no name)" } else { name };
    let by = match *source {
        "default" => "which nobody describes",
        "library" => "by the model's library",
        _ => "by the scene file",
    };
    let head = format!("  {name}: {kind}, {by}; {triangles} triangles, area {area:.4}");
    let parameters = material.parameters.iter().map(|parameter| {
        let default = if parameter.from == "default" { "  (default)" } else { "" };
        format!("    {} = {}{default}", parameter.key, value(&parameter.value))
    });
    [head].into_iter().chain(parameters).collect()
}

fn picture(picture: &Picture) -> String {
    let users = picture.materials.join(", ");
    let state = match (&picture.error, picture.width, picture.height, picture.bytes) {
        (None, Some(width), Some(height), Some(bytes)) => {
            format!("{width} x {height}, {}", memory::text(bytes as u64))
        }
        (error, ..) => error.clone().unwrap_or_default(),
    };
    format!("  {}: {state} ({users})", picture.path.display())
}

/// A value in a line.
fn value(value: &Value) -> String {
    match value {
        Value::Object(fields) => {
            let fields: Vec<String> = fields.iter().map(|(key, v)| format!("{key} {}", self::value(v))).collect();
            fields.join(", ")
        }
        Value::Array(items) => format!("[{}]", items.iter().map(self::value).collect::<Vec<_>>().join(", ")),
        Value::String(text) => text.clone(),
        Value::Null => "none".into(),
        other => other.to_string(),
    }
}
