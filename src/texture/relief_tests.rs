use super::*;
use crate::image::picture::Samples;
use crate::image::srgb;
use crate::texture::description::ImageTexture;
use crate::texture::texels::Texels;

fn texture(width: usize, height: usize, texel: impl Fn(usize, usize) -> [u8; 3]) -> Texture {
    let values = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    Texture::new(Texels { width, height, channels: 3, data: Samples::U8(values, srgb::DECODE_8.clone()) })
}

fn relief(kind: ReliefKind, strength: f32, scale: [f32; 2]) -> Relief {
    Relief {
        map: TextureMap { index: 0, scale, offset: [0.0; 2], nearest: false, tint: Rgb::ONE, clamp: false },
        kind,
        strength,
    }
}

/// x as wide as 1 and y as wide as 2 in texture coordinates; a shear and a mirroring besides.
fn tangents(mirrored: bool) -> Tangents {
    let uvs = [[0.0, 0.0], [if mirrored { -1.0 } else { 1.0 }, 0.0], [0.0, 0.5]];
    Tangents::of([Vec3::ZERO, Vec3::X, Vec3::Y], uvs).unwrap()
}

fn frames() -> [Frame; 2] {
    let s = Vec3::new(0.6, 0.8, 0.0);
    [Frame::from_normal(Vec3::Z), Frame { s, t: Vec3::Z.cross(s), n: Vec3::Z }]
}

fn assert_near(found: Vec3, wanted: Vec3) {
    assert!((found - wanted).length() < 0.01, "{found} is not {wanted}");
}

#[test]
fn red_leans_along_u_and_green_along_v() {
    let textures = [texture(1, 1, |_, _| [218, 128, 218])];
    let (red, half) = (std::f32::consts::FRAC_1_SQRT_2, 0.5f32.atan());
    for frame in frames() {
        let world =
            |relief: Relief, mirrored| frame.to_world(relief.normal(&textures, [0.3, 0.4], &frame, tangents(mirrored)));
        let one = [1.0; 2];
        assert_near(world(relief(ReliefKind::Normals, 1.0, one), false), Vec3::new(red, 0.0, red));
        // u runs the other way
        assert_near(world(relief(ReliefKind::Normals, 1.0, one), true), Vec3::new(-red, 0.0, red));
        assert_near(world(relief(ReliefKind::Normals, 1.0, [-2.0, 1.0]), false), Vec3::new(-red, 0.0, red));
        assert_near(world(relief(ReliefKind::Normals, 0.5, one), false), Vec3::new(half.sin(), 0.0, half.cos()));
        assert_near(world(relief(ReliefKind::Normals, 0.0, one), false), Vec3::Z);
    }
    let green = [texture(1, 1, |_, _| [128, 218, 218])];
    for mirrored in [false, true] {
        let frame = frames()[1];
        let normal = relief(ReliefKind::Normals, 1.0, [1.0; 2]).normal(&green, [0.3, 0.4], &frame, tangents(mirrored));
        // handedness: v keeps its side, whichever way u runs
        assert_near(frame.to_world(normal), Vec3::new(0.0, red, red));
    }
}

#[test]
fn heights_lean_downhill() {
    // a step of 16 levels from texel to texel along u
    let textures = [texture(8, 4, |x, _| [(x * 16) as u8; 3])];
    let per_texel = 16.0 / 255.0;
    let frame = frames()[1];
    let slope = |kind, strength, scale: [f32; 2]| {
        let uv = [0.5 / scale[0], 0.4];
        let n = frame.to_world(relief(kind, strength, scale).normal(&textures, uv, &frame, tangents(false)));
        assert!(n.y.abs() < 1e-5);
        -n.x / n.z
    };
    let close = |found: f32, wanted: f32| assert!((found / wanted - 1.0).abs() < 1e-3, "{found} is not {wanted}");
    // eight texels are as wide as 1
    close(slope(ReliefKind::Heights, 2.0, [1.0; 2]), 2.0 * 8.0 * per_texel);
    // the picture twice as small is twice as steep
    close(slope(ReliefKind::Heights, 2.0, [2.0, 1.0]), 2.0 * 16.0 * per_texel);
    close(slope(ReliefKind::TexelHeights, 3.0, [1.0; 2]), 3.0 * per_texel);
    close(slope(ReliefKind::TexelHeights, 3.0, [2.0, 1.0]), 3.0 * per_texel);
    // along v, where two units are one of the coordinate, up in the picture is towards larger v
    let rows = [texture(4, 8, |_, y| [(y * 16) as u8; 3])];
    let n = relief(ReliefKind::Heights, 1.0, [1.0; 2]).normal(&rows, [0.3, 0.5], &frame, tangents(false));
    let n = frame.to_world(n);
    close(n.y / n.z, 8.0 * per_texel / 2.0);
}

#[test]
fn pictures_of_normals_are_told_from_pictures_of_heights() {
    let wave = |x: usize| (128.0 + 40.0 * (x as f32).sin()) as u8;
    assert!(texture(9, 9, |x, y| [wave(x), wave(y), 245]).looks_like_normals());
    assert!(texture(1, 1, |_, _| [218, 128, 218]).looks_like_normals());
    assert!(texture(1, 1, |_, _| [128, 128, 255]).looks_like_normals());
    assert!(!texture(9, 9, |x, _| [wave(x); 3]).looks_like_normals());
    // a grey as bright as to be long
    assert!(!texture(9, 9, |_, _| [201; 3]).looks_like_normals());
    assert!(!texture(9, 9, |x, _| [wave(x), 90, 60]).looks_like_normals(), "a photograph");
}

#[test]
fn degenerate_coordinates_turn_nothing() {
    assert!(Tangents::of([Vec3::ZERO, Vec3::X, Vec3::Y], [[0.5, 0.5]; 3]).is_none());
    let textures = [texture(1, 1, |_, _| [218, 128, 218])];
    let frame = frames()[0];
    for kind in [ReliefKind::Normals, ReliefKind::Heights] {
        assert_eq!(relief(kind, 1.0, [0.0, 1.0]).normal(&textures, [0.2; 2], &frame, tangents(false)), Vec3::Z);
    }
    // a normal below the surface lies in it
    let below = [texture(1, 1, |_, _| [218, 128, 37])];
    let n = relief(ReliefKind::Normals, 1.0, [1.0; 2]).normal(&below, [0.2; 2], &frame, tangents(false));
    assert!(n.z == 0.0 && (n.length() - 1.0).abs() < 1e-6);
}

#[test]
fn the_cache_decides_once_what_a_picture_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    image::RgbImage::from_pixel(2, 2, image::Rgb([128, 128, 255])).save(&path).unwrap();
    let image = ImageTexture { path, scale: [1.0; 2], offset: [0.0; 2], nearest: false, tint: Rgb::ONE, clamp: false };
    let texture = ReliefTexture { image, kind: ReliefKind::NormalsOrTexelHeights, strength: 1.0 };
    assert_eq!(Relief::new(&texture, &mut TextureCache::default()).unwrap().kind, ReliefKind::Normals);
}
