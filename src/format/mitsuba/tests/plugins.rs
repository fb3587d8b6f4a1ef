//! A scene for each plug-in.

const HEAD: &str = r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="7"/></integrator>"#;

const SENSOR: &str = r#"<sensor type="perspective"><float name="fov" value="50"/>
<transform name="to_world"><lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#;

const LOOK: &str =
    r#"<transform name="to_world"><lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform>"#;

/// A floor and a wall.
const FLOOR: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="3"/>
</transform><bsdf type="diffuse"><rgb name="reflectance" value="0.6 0.5 0.4"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><translate z="-3" y="2"/>
</transform><bsdf type="diffuse"><rgb name="reflectance" value="0.4 0.5 0.6"/></bsdf></shape>"#;

const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/>
<translate y="4" x="1" z="1"/></transform><emitter type="area"><rgb name="radiance" value="9 8 6"/>
</emitter></shape>"#;

/// `%` is what the thing is made of.
const SPHERE: &str = r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/>%</shape>"#;

const SQUARE: &str = r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-20"/>
<translate y="1.1" z="0.5"/></transform>%</shape>"#;

/// What a sphere is made of.
const SPHERES: &[(&str, &str)] = &[
    ("diffuse", r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.7 0.3 0.2"/></bsdf>"#),
    ("conductor_Cu", r#"<bsdf type="conductor"><string name="material" value="Cu"/></bsdf>"#),
    (
        "roughconductor",
        r#"<bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf>"#,
    ),
    (
        "roughconductor_ggx",
        r#"<bsdf type="roughconductor"><string name="distribution" value="ggx"/><float name="alpha" value="0.4"/>
</bsdf>"#,
    ),
    ("dielectric", r#"<bsdf type="dielectric"/>"#),
    ("roughdielectric", r#"<bsdf type="roughdielectric"><float name="alpha" value="0.2"/></bsdf>"#),
    ("plastic", r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1 0.5 0.2"/></bsdf>"#),
    (
        "roughplastic",
        r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.1 0.5 0.2"/>
<boolean name="nonlinear" value="true"/></bsdf>"#,
    ),
    (
        "principled",
        r#"<bsdf type="principled"><rgb name="base_color" value="0.7 0.4 0.2"/><float name="metallic" value="0.3"/>
<float name="roughness" value="0.4"/><float name="clearcoat" value="0.5"/>
<float name="sheen" value="0.3"/></bsdf>"#,
    ),
    (
        "blend",
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.3"/><bsdf type="diffuse">
<rgb name="reflectance" value="0.9 0.1 0.1"/></bsdf><bsdf type="diffuse">
<rgb name="reflectance" value="0.1 0.1 0.9"/></bsdf></bsdf>"#,
    ),
    (
        "blend_unlike",
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.7"/><bsdf type="diffuse">
<rgb name="reflectance" value="0.9 0.1 0.1"/></bsdf><bsdf type="roughconductor">
<string name="material" value="Au"/><float name="alpha" value="0.3"/></bsdf></bsdf>"#,
    ),
    (
        "blend_of_blends",
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="blendbsdf">
<float name="weight" value="0.3"/><bsdf type="diffuse"/><bsdf type="roughconductor">
<float name="alpha" value="0.3"/></bsdf></bsdf><bsdf type="roughplastic"/></bsdf>"#,
    ),
    (
        "principled_transmissive",
        r#"<bsdf type="principled"><rgb name="base_color" value="0.7 0.4 0.2"/><float name="metallic" value="0.2"/>
<float name="roughness" value="0.4"/><float name="spec_trans" value="0.4"/></bsdf>"#,
    ),
    (
        "null_blend",
        r#"<bsdf type="blendbsdf"><float name="weight" value="0.4"/><bsdf type="null"/><bsdf type="diffuse"/></bsdf>"#,
    ),
];

/// What a square is made of.
const SQUARES: &[(&str, &str)] = &[
    ("thindielectric", r#"<bsdf type="thindielectric"><string name="int_ior" value="water"/></bsdf>"#),
    (
        "bitmap",
        r#"<bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/></texture></bsdf></bsdf>"#,
    ),
    (
        "bitmap_uv",
        r#"<bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/><transform name="to_uv"><scale x="2" y="3"/>
<translate x="0.2" y="0.1"/></transform><string name="filter_type" value="nearest"/></texture></bsdf>
</bsdf>"#,
    ),
    (
        "bitmap_raw",
        r#"<bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/><boolean name="raw" value="true"/></texture></bsdf></bsdf>"#,
    ),
    (
        "bitmap_turned",
        r#"<bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/><transform name="to_uv"><scale x="2" y="3"/><rotate z="1" angle="90"/>
<translate x="0.2" y="0.1"/></transform><string name="filter_type" value="nearest"/></texture></bsdf>
</bsdf>"#,
    ),
    (
        "checker",
        r#"<bsdf type="diffuse"><texture type="checkerboard" name="reflectance">
<rgb name="color0" value="0.9 0.1 0.1"/><rgb name="color1" value="0.1 0.1 0.9"/><transform name="to_uv">
<scale x="2" y="1.5"/></transform></texture></bsdf>"#,
    ),
    (
        "mask",
        r#"<bsdf type="mask"><texture type="bitmap" name="opacity"><string name="filename" value="mask.png"/>
</texture><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#,
    ),
    (
        "blend_by_picture",
        r#"<bsdf type="twosided"><bsdf type="blendbsdf"><texture type="bitmap" name="weight">
<string name="filename" value="pic.png"/></texture><bsdf type="diffuse"><rgb name="reflectance" value="0.8 0.1 0.1"/></bsdf>
<bsdf type="roughplastic"/></bsdf></bsdf>"#,
    ),
    (
        "mask_of_greys",
        r#"<bsdf type="mask"><texture type="bitmap" name="opacity"><string name="filename" value="pic.png"/>
</texture><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf>"#,
    ),
    (
        "normalmap",
        r#"<bsdf type="twosided"><bsdf type="normalmap"><boolean name="use_shadowing_function" value="false"/>
<boolean name="flip_invalid_normals" value="false"/><texture type="bitmap" name="normalmap">
<boolean name="raw" value="true"/><string name="filename" value="normal.png"/></texture>
<bsdf type="diffuse"/></bsdf></bsdf>"#,
    ),
    (
        "bumpmap",
        r#"<bsdf type="twosided"><bsdf type="bumpmap"><boolean name="use_shadowing_function" value="false"/>
<boolean name="flip_invalid_normals" value="false"/><texture type="bitmap" name="bump">
<boolean name="raw" value="true"/><string name="filename" value="height.png"/></texture>
<float name="scale" value="0.2"/><bsdf type="diffuse"/></bsdf></bsdf>"#,
    ),
];

/// Shapes under the lamp.
const THINGS: &[(&str, &str)] = &[
    (
        "obj",
        r#"<shape type="obj"><string name="filename" value="quad.obj"/><transform name="to_world">
<rotate x="1" angle="60"/><translate y="1"/></transform><bsdf type="twosided"><bsdf type="diffuse">
<texture type="bitmap" name="reflectance"><string name="filename" value="pic.png"/></texture></bsdf>
</bsdf></shape>"#,
    ),
    (
        "ply",
        r#"<shape type="ply"><string name="filename" value="dome.ply"/><transform name="to_world">
<translate y="1.2"/></transform><bsdf type="twosided"><bsdf type="diffuse">
<texture type="bitmap" name="reflectance"><string name="filename" value="pic.png"/></texture></bsdf>
</bsdf></shape>"#,
    ),
    (
        "ply_plastic",
        r#"<shape type="ply"><string name="filename" value="dome.ply"/><transform name="to_world">
<translate y="1.2"/></transform><bsdf type="roughplastic"/></shape>"#,
    ),
    (
        "face_color",
        r#"<shape type="ply"><string name="filename" value="painted.ply"/><boolean name="face_normals" value="true"/>
<transform name="to_world">
<translate y="1.2"/></transform><bsdf type="twosided"><bsdf type="diffuse">
<texture type="mesh_attribute" name="reflectance"><string name="name" value="face_color"/><float name="scale" value="0.8"/>
</texture></bsdf></bsdf></shape>"#,
    ),
    (
        "face_attribute",
        r#"<shape type="ply"><string name="filename" value="painted.ply"/><boolean name="face_normals" value="true"/>
<transform name="to_world">
<translate y="1.2"/></transform><bsdf type="principled"><texture type="mesh_attribute" name="base_color">
<string name="name" value="face_tone_color"/></texture></bsdf></shape>"#,
    ),
    (
        "vertex_attribute",
        r#"<shape type="ply"><string name="filename" value="painted.ply"/><boolean name="face_normals" value="true"/>
<transform name="to_world">
<translate y="1.2"/></transform><bsdf type="twosided"><bsdf type="diffuse">
<texture type="mesh_attribute" name="reflectance"><string name="name" value="vertex_heat"/></texture></bsdf></bsdf></shape>"#,
    ),
    (
        "cube",
        r#"<shape type="cube"><transform name="to_world"><scale value="0.7"/><rotate y="1" angle="30"/>
<rotate x="1" angle="40"/><translate y="1.3"/></transform><bsdf type="diffuse">
<texture type="bitmap" name="reflectance"><string name="filename" value="pic.png"/></texture></bsdf>
</shape>"#,
    ),
    (
        "disk",
        r#"<shape type="disk"><transform name="to_world"><rotate x="1" angle="-20"/><translate y="1.1" z="0.5"/>
</transform><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/></texture></bsdf></shape>"#,
    ),
    (
        "cylinder",
        r#"<shape type="cylinder"><point name="p0" x="0" y="0" z="0"/><point name="p1" x="0" y="1.6" z="0"/>
<float name="radius" value="0.8"/><transform name="to_world"><rotate y="1" angle="17"/></transform>
<bsdf type="twosided"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/></texture></bsdf></bsdf></shape>"#,
    ),
    (
        "sphere_uv",
        r#"<shape type="sphere"><transform name="to_world"><rotate x="1" angle="-60"/><rotate y="1" angle="-60"/>
<translate y="1"/></transform><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
<string name="filename" value="pic.png"/></texture></bsdf></shape>"#,
    ),
];

/// Lights in the place of the lamp.
const LIGHTS: &[(&str, &str)] = &[
    (
        "sphere_lamp",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><float name="radius" value="0.4"/>
<emitter type="area"><rgb name="radiance" value="5 4 3"/></emitter></shape>"#,
    ),
    (
        "sphere_inside_lamp",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><float name="radius" value="20"/>
<boolean name="flip_normals" value="true"/><emitter type="area">
<rgb name="radiance" value="0.5 0.4 0.3"/></emitter></shape>"#,
    ),
    (
        "textured_lamp",
        r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="20"/><translate y="1.1" z="0.5"/>
</transform><emitter type="area"><texture type="bitmap" name="radiance">
<string name="filename" value="pic.png"/></texture></emitter></shape>"#,
    ),
    (
        "constant",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="constant"><rgb name="radiance" value="0.5 0.6 0.7"/></emitter>"#,
    ),
    (
        "constant_spectrum",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="constant"><spectrum name="radiance" value="0.5"/></emitter>"#,
    ),
    (
        "envmap",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="envmap"><string name="filename" value="env.exr"/><float name="scale" value="0.7"/>
<transform name="to_world"><rotate y="1" angle="50"/></transform></emitter>"#,
    ),
    (
        "point",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="point"><point name="position" x="1" y="3" z="2"/><rgb name="intensity" value="9 8 7"/>
</emitter>"#,
    ),
    (
        "directional",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="directional"><vector name="direction" x="0.3" y="-1" z="-0.5"/>
<rgb name="irradiance" value="2 3 4"/></emitter>"#,
    ),
    (
        "sunsky",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="sunsky"><vector name="sun_direction" x="0.3" y="0.6" z="0.5"/><transform name="to_world">
<rotate x="1" angle="-90"/></transform></emitter>"#,
    ),
    (
        "sky",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="sunsky"><vector name="sun_direction" x="0.3" y="0.6" z="0.5"/>
<float name="sun_scale" value="0"/><transform name="to_world"><rotate x="1" angle="-90"/></transform>
</emitter>"#,
    ),
    (
        "sun",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="sunsky"><vector name="sun_direction" x="0.3" y="0.6" z="0.5"/>
<float name="sky_scale" value="0"/><transform name="to_world"><rotate x="1" angle="-90"/></transform>
</emitter>"#,
    ),
    (
        "spot",
        r#"<shape type="sphere"><point name="center" x="0" y="1" z="0"/><bsdf type="diffuse"/></shape>
<emitter type="spot"><transform name="to_world">
<lookat origin="1, 3, 2" target="0, 0.5, 0" up="0, 1, 0"/></transform>
<rgb name="intensity" value="20 18 16"/><float name="cutoff_angle" value="35"/>
<float name="beam_width" value="15"/></emitter>"#,
    ),
];

/// Sensors; `LOOK` stands for a transform.
const SENSORS: &[(&str, &str)] = &[
    (
        "cam_y",
        r#"<sensor type="perspective"><float name="fov" value="40"/>
<string name="fov_axis" value="y"/>LOOK<film type="hdrfilm"><integer name="width" value="12"/>
<integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_smaller",
        r#"<sensor type="perspective"><float name="fov" value="40"/>
<string name="fov_axis" value="smaller"/>LOOK<film type="hdrfilm"><integer name="width" value="9"/>
<integer name="height" value="12"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_larger",
        r#"<sensor type="perspective"><float name="fov" value="40"/>
<string name="fov_axis" value="larger"/>LOOK<film type="hdrfilm"><integer name="width" value="9"/>
<integer name="height" value="12"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_diagonal",
        r#"<sensor type="perspective"><float name="fov" value="50"/>
<string name="fov_axis" value="diagonal"/>LOOK<film type="hdrfilm"><integer name="width" value="12"/>
<integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_focal",
        r#"<sensor type="perspective"><string name="focal_length" value="35mm"/>LOOK<film type="hdrfilm">
<integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_default",
        r#"<sensor type="perspective">LOOK<film type="hdrfilm"><integer name="width" value="12"/>
<integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_thinlens",
        r#"<sensor type="thinlens"><float name="fov" value="50"/><float name="aperture_radius" value="0.3"/>
<float name="focus_distance" value="3"/>LOOK<film type="hdrfilm"><integer name="width" value="12"/>
<integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_ortho",
        r#"<sensor type="orthographic"><transform name="to_world"><scale x="2" y="2"/>
<lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform><film type="hdrfilm">
<integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
    (
        "cam_mirror",
        r#"<sensor type="perspective"><float name="fov" value="50"/><transform name="to_world"><scale x="-1"/>
<lookat origin="1, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform><film type="hdrfilm">
<integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>"#,
    ),
];

/// A room as exporters for version 0.6 write it: shared materials, matrices, old names, a filter of its own.
const ROOM: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<scene version="0.6.0"><default name="depth" value="7"/>
<integrator type="path"><integer name="maxDepth" value="$depth"/></integrator>
<sensor type="perspective"><float name="fov" value="50"/><string name="fovAxis" value="x"/>
<transform name="toWorld"><matrix value="-1 0 0 0 0 0.99026807 -0.1391731 1.5 0 -0.1391731 -0.99026807 5 0 0 0 1"/></transform>
<sampler type="independent"><integer name="sampleCount" value="64"/></sampler>
<film type="hdrfilm"><integer name="width" value="12"/><integer name="height" value="9"/><rfilter type="box"/></film></sensor>
<bsdf type="twosided" id="Wood"><bsdf type="roughplastic"><float name="alpha" value="0.15"/>
<string name="distribution" value="ggx"/><float name="intIOR" value="1.5"/><float name="extIOR" value="1"/>
<boolean name="nonlinear" value="true"/><texture name="diffuseReflectance" type="bitmap">
<string name="filename" value="pic.png"/><string name="filterType" value="bilinear"/></texture></bsdf></bsdf>
<bsdf type="twosided" id="Steel"><bsdf type="roughconductor"><float name="alpha" value="0.2"/>
<string name="distribution" value="beckmann"/><rgb name="specularReflectance" value="0.9, 1, 1"/>
<rgb name="eta" value="1.65746, 0.880369, 0.521229"/><rgb name="k" value="9.22387, 6.26952, 4.837"/></bsdf></bsdf>
<bsdf type="twosided" id="Paint"><bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf></bsdf>
<shape type="rectangle"><transform name="toWorld"><matrix value="3 0 0 0 0 0 3 0 0 -3 0 0 0 0 0 1"/></transform>
<ref id="Wood"/></shape>
<shape type="rectangle"><transform name="toWorld"><matrix value="3 0 0 0 0 3 0 2 0 0 3 -3 0 0 0 1"/></transform>
<ref id="Paint"/></shape>
<shape type="cube"><transform name="toWorld"><matrix value="0.4 0 0.3 -0.8 0 0.6 0 0.6 -0.3 0 0.4 0.5 0 0 0 1"/></transform>
<ref id="Steel"/></shape>
<shape type="obj"><string name="filename" value="quad.obj"/><transform name="toWorld">
<matrix value="0.7 0 0 1 0 0.5 -0.5 0.9 0 0.5 0.5 0.3 0 0 0 1"/></transform><ref id="Wood"/></shape>
<shape type="rectangle"><transform name="toWorld"><matrix value="1 0 0 1 0 0 -1 4 0 1 0 1 0 0 0 1"/></transform>
<bsdf type="diffuse"><rgb name="reflectance" value="0, 0, 0"/></bsdf><emitter type="area">
<rgb name="radiance" value="9, 8, 6"/></emitter></shape>
<emitter type="envmap"><string name="filename" value="env.exr"/><float name="scale" value="0.2"/>
<transform name="toWorld"><rotate y="1" angle="120"/></transform></emitter></scene>"##;

/// All scenes, by name.
pub(super) fn scenes() -> Vec<(String, String)> {
    let mut all = vec![("room_0.6".to_string(), ROOM.to_string())];
    let mut add = |name: &str, sensor: &str, body: String| {
        all.push((name.to_string(), format!("{HEAD}\n{sensor}\n{FLOOR}\n{body}</scene>")));
    };
    let under_lamp = |body: &str| format!("{LAMP}\n{body}");
    SPHERES.iter().for_each(|(name, part)| add(name, SENSOR, under_lamp(&SPHERE.replace('%', part))));
    SQUARES.iter().for_each(|(name, part)| add(name, SENSOR, under_lamp(&SQUARE.replace('%', part))));
    THINGS.iter().for_each(|(name, part)| add(name, SENSOR, under_lamp(part)));
    LIGHTS.iter().for_each(|(name, part)| add(name, SENSOR, part.to_string()));
    let (_, seen) = SQUARES.iter().find(|(name, _)| *name == "bitmap").expect("a scene with a picture");
    for (name, sensor) in SENSORS {
        add(name, &sensor.replace("LOOK", LOOK), under_lamp(&SQUARE.replace('%', seen)));
    }
    all
}
