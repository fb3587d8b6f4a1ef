//! Valid text files of each kind, small enough that thousands are read in a second, and the words of their languages.

use crate::pictures;
use std::path::Path;

pub const OBJ: [&str; 5] = [
    "# a quad\nmtllib input.mtl other.mtl\no quad\nv -1 0 1\nv 1 0 1\nv 1 0.5 -1\nv -1 0 -1\nvn 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
     usemtl wood\ns off\nf 1/1/1 2/2/1 3/3/1 4//1\n",
    "v 0 0 0\nv 1 0 0\nv 0 1 0 1.0\nv 2 2 2 1 0.5 0.25\nvt 0.5\nvn 0 0 0\nvn 1 2 3\nf -4 -3 -2\nf 1/1 2/1 3/1\nf 1//1 2//2 4//2\n\
     usemtl\nf 1 2 3 4\nf 1 1 2\nl 1 2\np 1\n",
    "v 0 0 0 \\\n\nv 1 0 \\\r\n 0\r\nv 1 1 0\r\nv 0.5 0.1 0\r\nv 0 1 0\r\ng a b\r\nusemtl Material #25\r\nf 1 2 3 4 5\r\n",
    "v 0 0 0\rv 1e0 0 0\rv 0 1.5e-3 0\rf 1 2 3\r",
    "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv nan 0 0\nv 1e39 0 0\nf 1 2 3 4 5\nusemtl glow\nf 5 4 3 2 1\ncurv 0 1 1 2\n",
];

pub const OBJ_WORDS: [&[u8]; 24] = [
    b"v ",
    b"vt ",
    b"vn ",
    b"vp ",
    b"f ",
    b"l ",
    b"p ",
    b"o ",
    b"g ",
    b"s ",
    b"usemtl ",
    b"mtllib ",
    b"\nf -1 -2 -3\n",
    b"//",
    b"/",
    b"1/2/3",
    b"\\\n",
    b"\\\r\n",
    b"\r",
    b"#",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\0",
    b"usemtl wood\n",
];

pub const MTL: [&str; 3] = [
    "# made by hand\nnewmtl wood\nNs 250\nKa 1 1 1\nKd 0.8 0.6 0.4\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.45\nd 1\nillum 2\n\
     map_Kd -s 2 3 1 -o 0.5 .25 wood.png # note\nmap_d mask.png\n",
    "newmtl glow\r\nKe 17 12 4\r\nKd 0 0 0\r\nTr 0.25\r\nTf 1 1 1\r\nillum 7\r\nPr 0.3\r\nPm 1\r\nmap_Bump -bm 0.5 b.png\r\n",
    "Kd 1\nnewmtl a b\nKd spectral x.rfl 1\nd -halo 0.5\nmap_Ke -mm 0 2 -clamp on e.png\nnewmtl a b\nNs 1e9\nsharpness 60\n",
];

pub const MTL_WORDS: [&[u8]; 28] = [
    b"newmtl ",
    b"Kd ",
    b"Ks ",
    b"Ke ",
    b"Ka ",
    b"Ns ",
    b"Ni ",
    b"Tr ",
    b"d ",
    b"Tf ",
    b"illum ",
    b"Pr ",
    b"Pm ",
    b"Ps ",
    b"Pc ",
    b"aniso ",
    b"map_Kd ",
    b"map_Ks ",
    b"map_d ",
    b"map_Ke ",
    b"bump ",
    b"-s ",
    b"-o ",
    b"-mm ",
    b"-halo ",
    b"spectral ",
    b"xyz ",
    b"\\\n",
];

pub const TOML: [&str; 3] = [
    include_str!("../../scenes/cornell.toml"),
    "[camera]\norigin = [0, 1, 5]\ntarget = [0, 1, 0]\nvfov = 40\n[film]\nwidth = 8\nheight = 6\nfilter = 'tent'\n\
     [[mesh]]\npath = 'input.obj'\nrotate = { axis = [0, 1, 0], angle = 30 }\nscale = [1, 2, 0.5]\ntranslate = [0.3, 0, 0]\n\
     material = 'Glass'\n[[mesh]]\npath = 'input.obj'\ngroup = 'tree'\n\
     [[instance]]\ngroup = 'tree'\nmatrix = [1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0]\n[[instance]]\ngroup = 'tree'\n\
     [material.Glass]\ntype = 'dielectric'\nint_ior = 1.5\next_ior = 1\nalpha = 0.1\n\
     [material.wood]\ntype = 'plastic'\nreflectance = { texture = 'a.png', scale = [4, 4], nearest = true }\nalpha = 0.05\n\
     opacity = { texture = 'a.png', channel = 'luminance' }\n\
     [material.glow]\ntype = 'diffuse'\nemission = [1, 2, 3]\nemission_two_sided = true\n\
     [material.'a b']\ntype = 'conductor'\neta = [0.1, 0.3, 1.4]\nk = [3.9, 2.3, 1.6]\nalpha = 0.1\ndistribution = 'beckmann'\n\
     [[light]]\ntype = 'environment'\npath = 'sky.exr'\nscale = 0.5\nrotate_y = 90\n\
     [[light]]\ntype = 'directional'\ndirection = [0, -1, 0.25]\nirradiance = 3\n",
    "[film]\nwidth = 4\nheight = 4\n[[mesh]]\npath = 'input.obj'\n[material.wood]\ntype = 'principled'\nbase_color = [0.2, 0.3, 0.4]\n\
     metallic = 0.5\nroughness = 0.3\nspecular = 0.5\nclearcoat = 1\nsheen = 0.5\n\
     [material.glow]\ntype = 'diffuse_transmitter'\nreflectance = 0.2\ntransmittance = 0.3\nopacity = 0.5\n\
     [[light]]\ntype = 'point'\nposition = [0, 3, 0]\nintensity = 10\n[[light]]\ntype = 'constant'\nradiance = 1\n\
     [[light]]\ntype = 'sun'\ndirection = [0, -1, 0.2]\nirradiance = 3\nangular_diameter = 5\n\
     [guiding]\nmethod = 'voronoi'\nmemory = '16 MiB'\ntable = 'sphere'\nstrata = 8\nsites = 100\n[integrator]\nmax_depth = 4\nroulette = 'none'\n\
     [render]\nspp = 1\nseed = 7\nlayers = ['direct', 'P']\n",
];

pub const TOML_WORDS: [&[u8]; 40] = [
    b"[camera]\n",
    b"[film]\n",
    b"[[mesh]]\n",
    b"[[light]]\n",
    b"[[instance]]\n",
    b"[material.x]\n",
    b"[guiding]\n",
    b"[render]\n",
    b"width",
    b"height",
    b"origin",
    b"target",
    b"up",
    b"vfov",
    b"path",
    b"scale",
    b"rotate",
    b"to_world",
    b"type",
    b"alpha",
    b"'dielectric'",
    b"'plastic'",
    b"'conductor'",
    b"'principled'",
    b"'null'",
    b"'mirror'",
    b"'environment'",
    b"memory",
    b"resolution",
    b"'1e30 TiB'",
    b"true",
    b"1979-05-27",
    b"'''",
    b"\"\"\"",
    b"{",
    b"}",
    b"[",
    b"]",
    b"=",
    b"\xe2\x82\xac",
];

pub const JSON: [&str; 1] = [r#"{
 "name": "small", "obj": "input.obj", "extra": 1,
 "camera": {"type": "perspective", "origin": [0, 1, 5], "target": [0, 1, 4], "up": [0, 1, 0], "vfov_deg": 30,
            "width": 6, "height": 4, "mirrored_x": true, "to_world": [[1, 0], [0, 1]]},
 "materials": {
  "wood": {"type": "diffuse", "reflectance": {"texture": "a.png", "filter": "nearest"}, "opacity": {"texture": "a.png"}},
  "Lamp": {"type": "diffuse", "reflectance": 0, "emission": [1, 2, 3]},
  "Steel": {"type": "conductor", "specular_reflectance": [1, 1, 1]},
  "glow": {"type": "phong", "reflectance": [0.1, 0.2, 0.3], "exponent": 48},
  "Car": {"type": "principled", "base_color": 0.2, "alpha": 0.25, "anisotropic": 0.5, "spec_trans": 0}
 },
 "emitters": [
  {"type": "area", "object": "o", "material": "Lamp", "radiance": [1, 2, 4]},
  {"type": "envmap", "filename": "sky.exr"},
  {"type": "constant", "radiance": 2},
  {"type": "point", "position": [1, 2, 3], "intensity": [1, 1, 1]}
 ]
}"#];

pub const JSON_WORDS: [&[u8]; 24] = [
    b"\"obj\"",
    b"\"camera\"",
    b"\"materials\"",
    b"\"emitters\"",
    b"\"type\"",
    b"\"phong\"",
    b"\"exponent\"",
    b"\"width\"",
    b"null",
    b"true",
    b"false",
    b"{}",
    b"[]",
    b"{",
    b"}",
    b"[",
    b"]",
    b",",
    b":",
    b"\\u0000",
    b"\\ud800",
    b"1e999",
    b"-",
    b"\"",
];

pub const PLAN: [&str; 2] = [
    include_str!("../../scenes/gallery/gallery.toml"),
    "title = \"How fine a grid\"\ncompare = [\"none\", \"coarse\", \"sweep:guiding.strata=4,8\"]\nbaseline = \"none\"\nspp = [5, 10]\n\
     runs = 5\nseed = 0\nreference_noise = 0.05\nreference_time = 600\n[set]\n\"film.width\" = 320\n[[scene]]\npath = \"door.toml\"\n\
     name = \"door\"\nset = { \"guiding.memory\" = \"64 MiB\" }\nsamples = 1\n[methods.coarse]\n\"guiding.method\" = \"grid\"\n\
     guiding.resolution = 8\n[methods.none]\n[gallery]\nalarm = 0.01\nslower = 2\n[[why]]\nscenes = [\"door\"]\n\
     methods = [\"coarse\"]\nfails = [\"efficiency\"]\nsays = \"Eight cells are too few.\"\n",
];

pub const PLAN_WORDS: [&[u8]; 24] = [
    b"[[scene]]\n",
    b"[methods.x]\n",
    b"[set]\n",
    b"[gallery]\n",
    b"[[why]]\n",
    b"runs",
    b"seed",
    b"time",
    b"spp",
    b"compare",
    b"\"sweep:a=1,2;b=3,4\"",
    b"\"sweep:",
    b"baseline",
    b"reference",
    b"reference_scene",
    b"samples",
    b"name",
    b"path",
    b"set",
    b"says",
    b"= []\n",
    b"{",
    b"}",
    b"=",
];

pub const RUNS: &str = concat!(
    r#"{"plan":{"format":2,"hash":"h","title":"t"}}"#,
    "\n",
    r#"{"reference":{"scene":"s","reference":{"source":"made","path":"r.exr","samples":64,"wall_seconds":1.5,"relmse_noise":null}}}"#,
    "\n",
    r#"{"repeat":{"scene":"s","method":"none","spp":8,"equal":true}}"#,
    "\n",
    r#"{"run":{"scene":"s","method":"none","budget":"4 spp","seed":3,"samples":4,"wall_seconds":2.0,"cpu_seconds":4.0,"learn_wall_seconds":0.0,"film_wall_seconds":0.1,"#,
    r#""mse":0.5,"relmse":null,"relmse_trimmed":0.1,"mape":0.2,"smape":0.2,"flip":0.1,"worst_permille":8.0,"mean":[0.5,0.25,0.125],"#,
    r#""non_finite":0,"broken_pixels":0,"rays":4000,"shadow_rays":2000,"paths":1000,"mean_path_length":4.0,"zero_share":0.5,"#,
    r#""guide_bytes":0,"guide_states":0,"peak_bytes":null,"iterations":[{"samples":4,"wall_seconds":1.0,"learn_wall_seconds":0.0,"#,
    r#""mean_path_length":4.0,"zero_share":0.5,"guide_hit_share":0.0}],"blocks":[1.0,2.0,0.5]}}"#,
    "\n",
);

pub const RUNS_WORDS: [&[u8]; 20] = [
    b"\"plan\"",
    b"\"run\"",
    b"\"reference\"",
    b"\"repeat\"",
    b"\"format\"",
    b"\"hash\"",
    b"\"blocks\"",
    b"\"mean\"",
    b"null",
    b"true",
    b"\n",
    b"{",
    b"}",
    b"[",
    b"]",
    b",",
    b":",
    b"1e999",
    b"\"made\"",
    b"\"file\"",
];

pub const GUIDE_WORDS: [&[u8]; 8] = [
    b"\0",
    b"\x80\x80\x80\x80\x10",
    b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"\xff\xff\x03",
    b"\0\0\xc0\x7f",
    b"\0\0\x80\x7f",
    b"\0\0\0\0\0\0\xf0\x7f",
    b"\0\0\x80\xff",
];

/// What the scenes above name, beside them.
pub fn write_companions(folder: &Path) {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("a.png", &pictures::png()[3]);
    write("sky.exr", &pictures::exr()[2]);
    write("cornell.obj", OBJ[0].as_bytes());
    write("input.obj", format!("mtllib input.mtl\n{}usemtl glow\nf 1 2 3\n", OBJ[0]).as_bytes());
    write("input.mtl", MTL.concat().as_bytes());
}

/// A quadrilateral and a triangle in ASCII, and in both byte orders.
pub fn ply() -> Vec<Vec<u8>> {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty double y\nproperty short \
             z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int \
             vertex_indices\nend_header\n"
        )
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let faces: [&[i32]; 2] = [&[0, 1, 2, 3], &[0, 1, 2]];
    let mut ascii = header("ascii");
    corners.iter().for_each(|[x, y]| ascii += &format!("{x} {y} 0 255 128 0\n"));
    ascii += "4 0 1 2 3\n3 0 1 2\n";
    let binary = |format: &str, big: bool| {
        let mut bytes = header(format).into_bytes();
        let mut put = |number: &[u8]| {
            if big { bytes.extend(number.iter().rev()) } else { bytes.extend(number) }
        };
        for [x, y] in corners {
            put(&(x as f32).to_le_bytes());
            put(&f64::to_le_bytes(y));
            [0, 0, 255, 128, 0].iter().for_each(|byte: &u8| put(&[*byte]));
        }
        for face in faces {
            put(&[face.len() as u8]);
            face.iter().for_each(|index| put(&index.to_le_bytes()));
        }
        bytes
    };
    vec![ascii.into_bytes(), binary("binary_little_endian", false), binary("binary_big_endian", true)]
}

pub const PLY_WORDS: [&[u8]; 14] = [
    b"ply\n",
    b"format ascii 1.0\n",
    b"format binary_big_endian 1.0\n",
    b"element vertex 4294967295\n",
    b"element face 1\n",
    b"property list uint double vertex_index\n",
    b"property list uchar float texcoord\n",
    b"property char nx\n",
    b"end_header\n",
    b"\r",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"nan ",
    b"-1 ",
];

pub const XML: [&str; 2] = [
    "<scene version=\"3.0.0\"><default name=\"n\" value=\"4\"/><integrator type=\"path\"><integer name=\"max_depth\" value=\"$n\"/></integrator>\
     <sensor type=\"thinlens\"><float name=\"fov\" value=\"40\"/><transform name=\"to_world\"><lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/>\
     </transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"8\"/></film></sensor><bsdf type=\"twosided\" id=\"b\"><bsdf type=\"roughconductor\">\
     <string name=\"material\" value=\"Cu\"/><float name=\"alpha\" value=\"0.2\"/></bsdf></bsdf><shape type=\"sphere\"><ref id=\"b\"/></shape>\
     <shape type=\"cylinder\"><emitter type=\"area\"><spectrum name=\"radiance\" value=\"400:1, 700:2\"/></emitter></shape></scene>\n",
    "<scene version=\"0.6.0\"><shape type=\"obj\"><string name=\"filename\" value=\"input.obj\"/><transform name=\"toWorld\"><scale value=\"2\"/>\
     <rotate y=\"1\" angle=\"30\"/><matrix value=\"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"/></transform><bsdf type=\"plastic\"><texture type=\"bitmap\" \
     name=\"diffuseReflectance\"><string name=\"filename\" value=\"a.png\"/></texture></bsdf></shape><emitter type=\"spot\"/></scene>\n",
];

pub const XML_WORDS: [&[u8]; 20] = [
    b"<shape type=\"disk\">",
    b"</shape>",
    b"<bsdf type=\"mask\">",
    b"</bsdf>",
    b"<ref id=\"b\"/>",
    b"<include filename=\"input.xml\"/>",
    b"<default name=\"n\" value=\"$n$n\"/>",
    b"$n",
    b"&amp;",
    b"<!DOCTYPE a [<!ENTITY b \"c\">]>",
    b"<![CDATA[",
    b"value=\"1e39\"",
    b"value=\"-1\"",
    b"value=\"#ffffff\"",
    b"<transform name=\"to_world\">",
    b"<scale value=\"0\"/>",
    b"<emitter type=\"point\"/>",
    b"<sensor type=\"perspective\"/>",
    b"\"",
    b"/>",
];

pub const GLTF: &str = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,\
    AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\
    \"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],\"materials\":[{\"alphaMode\":\"BLEND\",\
    \"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.5]},\"emissiveFactor\":[1,1,1]}],\"meshes\":[{\"primitives\":[{\"attributes\":\
    {\"POSITION\":0},\"material\":0}]}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],\
    \"nodes\":[{\"mesh\":0,\"children\":[1]},{\"camera\":0,\"translation\":[0,0,3]}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}";

pub const GLTF_WORDS: [&[u8]; 16] = [
    b"\"byteOffset\":4294967295",
    b"\"byteStride\":4",
    b"\"count\":4294967296",
    b"\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5125},\"values\":{\"bufferView\":0}},",
    b"\"indices\":0",
    b"\"mode\":5",
    b"\"children\":[0]",
    b"\"matrix\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]",
    b"\"type\":\"SCALAR\"",
    b"\"componentType\":5121",
    b"1e39",
    b"-1",
    b"null",
    b"[]",
    b"{}",
    b",",
];
