//! Pictures of meshes: what they must show.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

use super::canvas::Ink;
use super::*;
use graspd_core::mesh::RawMesh;
use graspd_core::mesh::solids::{cube, cuboid, sphere};

fn prepared(raw: RawMesh) -> Mesh {
    Mesh::prepare(raw).unwrap()
}

/// Width, height and the pixels of a PNG: red, green, blue, opacity.
pub(super) fn decoded(png: Vec<u8>) -> (u32, u32, Vec<[u8; 4]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let pixels = bytes.chunks_exact(4);
    let pixels = pixels.map(|pixel| pixel.try_into().unwrap()).collect();
    (info.width, info.height, pixels)
}

/// The pixels of a preview.
fn pixels(mesh: &Mesh, width: u32, background: Background) -> Vec<[u8; 4]> {
    let (.., pixels) = decoded(preview(mesh, &Options { width, background }).unwrap());
    pixels
}

fn count(pixels: &[[u8; 4]], wanted: Ink) -> usize {
    let (wanted, _) = wanted.paint();
    pixels.iter().filter(|pixel| pixel[..3] == wanted).count()
}

#[test]
fn a_ball_covers_as_much_as_its_disc() {
    let mesh = prepared(sphere(3.0, 60, 120));
    let pixels = pixels(&mesh, 800, Background::Transparent);
    let covered: f64 = pixels.iter().map(|pixel| f64::from(pixel[3]) / 255.0).sum();
    // Each of the two discs fills 84 % of the height; nothing else is drawn except the axes.
    let discs = 2.0 * std::f64::consts::PI * (0.42_f64 * 400.0).powi(2);
    assert!((covered / discs - 1.0).abs() < 0.01, "{covered} of {discs}");
}

#[test]
fn closed_surfaces_have_no_cracks() {
    // A crack would show the inside of the far side, or the background.
    let mesh = prepared(sphere(1.0, 97, 101));
    let [width, height] = [600, 300];
    let pixels = pixels(&mesh, width, Background::Transparent);
    for (n, pixel) in pixels.iter().enumerate() {
        let (x, y) = (n as u32 % width, n as u32 / width);
        let from_middle = f64::from(x % height) + 0.5 - 150.0;
        let radius = from_middle.hypot(f64::from(y) + 0.5 - 150.0);
        if (15.0..120.0).contains(&radius) {
            assert_eq!(pixel[3], 255, "{x} {y}");
            assert!(pixel[0] >= pixel[2], "{x} {y} {pixel:?}");
        }
    }
}

#[test]
fn position_and_size_of_a_body_do_not_matter() {
    let picture = |scale: f64, offset: f64| {
        let mut raw = cuboid([0.0; 3], [2.0, 1.0, 0.5]);
        for vertex in &mut raw.vertices {
            *vertex = *vertex * scale + Vector3::new(offset, -offset, offset);
        }
        pixels(&prepared(raw), 256, Background::Light)
    };
    let reference = picture(1.0, 0.0);
    for (scale, offset) in [(1e-9, 0.0), (1e9, 0.0), (1e-3, 1024.0), (1e12, -1e15)] {
        let other = picture(scale, offset);
        let different = reference.iter().zip(&other).filter(|(a, b)| {
            let parts = a.iter().zip(*b);
            parts.map(|(a, b)| a.abs_diff(*b)).max() > Some(2)
        });
        assert!(different.count() < 20, "{scale} {offset}");
    }
}

#[test]
fn edges_behind_the_body_are_faint() {
    // The face at −y is missing, which only the left view shows.
    let mut raw = cube(1.0);
    raw.triangles.retain(|triangle| {
        let corners = triangle.map(|index| raw.vertices[index as usize]);
        corners.iter().any(|corner| corner.y > 0.0)
    });
    let mesh = prepared(raw);
    let pixels = pixels(&mesh, 512, Background::Light);
    let (left, right): (Vec<_>, Vec<_>) = pixels
        .chunks(256)
        .enumerate()
        .partition(|(n, _)| n % 2 == 0);
    let of = |half: &[(usize, &[[u8; 4]])]| -> usize {
        half.iter().map(|(_, row)| count(row, Ink::Border)).sum()
    };
    // All four edges are visible on the left, and two on the outline on the right.
    let (left, right) = (of(&left), of(&right));
    assert!(right > 50 && left > 3 * right / 2, "{left} {right}");
    assert_eq!(count(&pixels, Ink::NonManifold), 0);
}

#[test]
fn a_fin_stands_on_a_magenta_edge() {
    let mut raw = cube(1.0);
    raw.vertices.push(Point3::new(1.5, -0.5, 0.5));
    raw.triangles.push([1, 5, 8]);
    let pixels = pixels(&prepared(raw), 512, Background::Dark);
    assert!(count(&pixels, Ink::NonManifold) > 50);
}

#[test]
fn every_width_is_clamped() {
    let mesh = prepared(cube(1.0));
    for (wanted, width) in [(0, 64), (64, 64), (65, 65), (u32::MAX, 4096)] {
        let found = pixels(&mesh, wanted, Background::Light).len();
        assert_eq!(found, (width * (width / 2)) as usize);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn flat_and_needle_like_bodies_are_drawn_in_any_attitude(
        sides in prop::array::uniform3(-3.0..3.0_f64),
        turn in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let mut raw = cuboid([0.0; 3], sides.map(|power| 10_f64.powf(power)));
        let rotation = Rotation3::new(Vector3::from(turn));
        for vertex in &mut raw.vertices {
            *vertex = rotation * *vertex;
        }
        let pixels = pixels(&prepared(raw), 200, Background::Transparent);
        // Above the axes; about 40 pixels belong to the two marks.
        let drawn = pixels[..200 * 65].iter().filter(|pixel| pixel[3] > 0).count();
        prop_assert!(drawn > 100, "{drawn}");
        prop_assert_eq!(count(&pixels, Ink::Border), 0);
    }
}
