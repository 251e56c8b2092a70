//! What the pictures promise.

use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::camera::Camera;
use super::canvas::Canvas;
use super::palette::{hex, part_color};
use super::raster::{Visible, center};
use super::{SheetCell, SheetError, contact_sheet, preview_png, uv_layout_svg};
use crate::contract::{Cancel, Run};
use crate::mesh::rays::Rays;
use crate::mesh::{NONE, Surface};
use crate::metrics::Measured;
use crate::metrics::fixtures::{cube, grid, measured, uvs};

/// A cube of six charts and two parts.
fn with_cube<T>(f: impl FnOnce(&Measured) -> T) -> T {
    let (surface, uvs) = cube();
    let charts: Vec<u32> = (0..12).map(|f| f / 2).collect();
    let parts: Vec<u32> = (0..12).map(|f| f / 6).collect();
    f(&measured(&surface, &uvs, &charts, &parts))
}

/// Width, height and pixels of a PNG.
fn decode(png: &[u8]) -> (u32, u32, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    (info.width, info.height, data.as_chunks().0.to_vec())
}

#[test]
fn the_layout_has_one_outline_a_chart_and_one_title_a_part() {
    let names = ["lid & hinge <1>".to_owned(), "box".to_owned()];
    let svg = with_cube(|m| uv_layout_svg(m, &names, &Cancel::default())).unwrap();
    assert_eq!(svg.matches("stroke-width=\"1.2\"").count(), 6);
    assert_eq!(svg.matches("<g ").count(), 2);
    assert!(svg.contains("<title>lid &amp; hinge &lt;1&gt;</title>"));
    assert!(svg.contains(&hex(part_color(0))) && svg.contains(&hex(part_color(1))));
    // The first side lies at u, v in 0.05 to 0.30: left, and low, since v points up inside.
    assert!(svg.contains("d=\"M50.00 950.00L300.00 950.00L300.00 700.00L50.00 700.00Z\""), "{svg}");
    // Its diagonal is the only line within.
    assert_eq!(svg.matches("stroke-opacity=\"0.55\"").count(), 6);
    assert!(
        svg.contains("M300.00 700.00L50.00 950.00") || svg.contains("M50.00 950.00L300.00 700.00")
    );
}

#[test]
fn large_layouts_have_outlines_only() {
    // The grid of the fixtures welds in quadratic time: build a large one by hand.
    let n = 102u32;
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let positions: Vec<DVec3> = (0..(n + 1) * (n + 1))
        .map(|v| DVec3::new(f64::from(v / (n + 1)), f64::from(v % (n + 1)), 0.0))
        .collect();
    let mut triangles = vec![];
    let mut twin = vec![];
    for i in 0..n {
        for j in 0..n {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            let f = |i: u32, j: u32, second: u32| 2 * (i * n + j) + second;
            let inside = |yes: bool, h: u32| if yes { h } else { NONE };
            twin.extend([
                inside(j > 0, 3 * f(i, j.wrapping_sub(1).min(n), 1) + 1),
                inside(i + 1 < n, 3 * f(i + 1, j, 1) + 2),
                3 * f(i, j, 1),
                3 * f(i, j, 0) + 2,
                inside(j + 1 < n, 3 * f(i, j + 1, 0)),
                inside(i > 0, 3 * f(i.wrapping_sub(1).min(n), j, 0) + 1),
            ]);
        }
    }
    let faces = triangles.len();
    let uvs: Vec<[[f32; 2]; 3]> = triangles
        .iter()
        .map(|t| {
            t.map(|v| {
                [positions[v as usize].x, positions[v as usize].y].map(|x| x as f32 / n as f32)
            })
        })
        .collect();
    let surface = Surface {
        positions,
        triangles,
        twin,
        normals: vec![DVec3::Z; faces],
        areas: vec![0.5; faces],
        sheet_mate: vec![NONE; faces],
        diagonal: f64::from(n) * 2f64.sqrt(),
        ..Surface::default()
    };
    let zeros = vec![0; faces];
    let input = measured(&surface, &uvs, &zeros, &zeros);
    let svg = uv_layout_svg(&input, &[], &Cancel::default()).unwrap();
    assert!(faces > 20_000 && svg.len() < 16_000, "{} bytes", svg.len());
    assert_eq!(svg.matches('Z').count(), 1);
    assert_eq!(svg.matches('L').count(), 4 * n as usize - 1);
}

#[test]
fn the_nearest_face_is_seen() {
    let (surface, _) = cube();
    let size = 64;
    let camera = Camera::framing(surface.positions.iter().copied(), size).unwrap();
    let seen = Visible::new(&surface, &camera, size, &Cancel::default()).unwrap();
    let rays = Rays::new(&surface);
    // The eye, found again from three directions that the camera turns.
    let turn = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| camera.turned(v));
    let back = |v: DVec3| DVec3::from_array(turn.map(|t| t.dot(v)));
    let eye = surface.positions[0] - back(camera.place(surface.positions[0]));
    let mut covered = 0;
    for pixel in 0..size * size {
        let direction = back(camera.unsee(center(pixel, size), 1.0).as_dvec3());
        let hit = rays.closest_hit(eye, direction, f64::INFINITY, NONE);
        // Pixels on an edge may go either way.
        let off_edge = hit.is_none_or(|h| {
            surface.triangles[h.face as usize].iter().zip([1, 2, 0]).all(|(a, k)| {
                let p = camera.see(surface.positions[*a as usize]).at;
                let q = camera
                    .see(surface.positions[surface.triangles[h.face as usize][k] as usize])
                    .at;
                let c = center(pixel, size);
                ((q - p).perp_dot(c - p) / (q - p).length()).abs() > 0.01
            })
        });
        if off_edge {
            assert_eq!(seen.face[pixel], hit.map_or(NONE, |h| h.face), "pixel {pixel}");
        }
        covered += usize::from(hit.is_some());
    }
    assert!(covered > 1000);
    // Front, right and top: the sides +z, +x, +y.
    let mut sides: Vec<u32> = seen.face.iter().filter(|f| **f != NONE).map(|f| f / 2).collect();
    sides.sort_unstable();
    sides.dedup();
    assert_eq!(sides, [1, 3, 5]);
}

#[test]
fn neighbours_share_no_pixel_and_leave_none_out() {
    let mut canvas = Canvas::gradient(40, 40, Vec3::ZERO, Vec3::ZERO);
    let [a, b, c, d] = [(3.3, 2.1), (36.0, 5.0), (33.3, 37.9), (4.7, 30.5)].map(Vec2::from);
    canvas.fill([a, b, c], Vec3::X);
    let first = canvas.pixels.iter().filter(|p| p.x > 0.0).count();
    let mut other = Canvas::gradient(40, 40, Vec3::ZERO, Vec3::ZERO);
    other.fill([a, c, d], Vec3::Y);
    let second = other.pixels.iter().filter(|p| p.y > 0.0).count();
    canvas.fill([a, c, d], Vec3::Y);
    let both = canvas.pixels.iter().filter(|p| p.x + p.y > 0.0).count();
    assert_eq!(first + second, both);
    let area = 0.5 * ((c - a).perp_dot(d - b)).abs();
    assert!((both as f32 - area).abs() < 25.0, "{both} pixels for an area of {area}");
}

#[test]
fn the_picture_shows_the_object_its_parts_and_its_layout() {
    let png = with_cube(|m| preview_png(m, None, &Run::quiet())).unwrap();
    let (width, height, pixels) = decode(&png);
    assert_eq!((width, height), (1152, 768));
    let at = |x: usize, y: usize| pixels[y * width as usize + x];
    // Checker: the middle of the large panel has light and dark squares.
    let light = |p: [u8; 3]| p.iter().map(|c| u32::from(*c)).sum::<u32>();
    let row: Vec<u32> = (200..560).map(|x| light(at(x, 384))).collect();
    let (low, high) = (row.iter().min().unwrap(), row.iter().max().unwrap());
    assert!(high - low > 250, "{low} to {high}");
    let changes = row.windows(2).filter(|w| w[0].abs_diff(w[1]) > 100).count();
    assert!(changes > 8, "{changes} changes");
    // Seams are red.
    let red = (0..768 * 768)
        .filter(|i| {
            let [r, g, b] = at(i % 768, i / 768);
            r > 120 && g < 90 && b < 100
        })
        .count();
    assert!(red > 300, "{red} red pixels");
    // Parts: the top side of the cube is in the first part or second; both colours are there.
    let blue =
        (768..1152).filter(|x| (0..384).any(|y| at(*x, y)[2] > at(*x, y)[0].saturating_add(60)));
    let orange =
        (768..1152).filter(|x| (0..384).any(|y| at(*x, y)[0] > at(*x, y)[2].saturating_add(60)));
    assert!(blue.count() > 50 && orange.count() > 50);
    // Layout: the page is white where nothing is, coloured where the first chart is (low left).
    let page = |u: f64, v: f64| {
        at(768 + (12.0 + u * 360.0) as usize, 384 + (12.0 + (1.0 - v) * 360.0) as usize)
    };
    assert_eq!(page(0.97, 0.97), [255; 3]);
    let inside = page(0.12, 0.22);
    assert!(inside[2] > inside[0] + 40, "{inside:?}");
}

#[test]
fn a_sheet_has_a_cell_an_object_with_its_checker_its_layout_and_its_words() {
    let preview = with_cube(|m| preview_png(m, None, &Run::quiet())).unwrap();
    let caption = vec!["cube".to_owned(), "six charts".to_owned()];
    let full = SheetCell { preview: Some(preview), caption: caption.clone() };
    let empty = SheetCell { preview: None, caption };
    let cells = [full.clone(), empty, full];
    let (width, height, pixels) = decode(&contact_sheet(&cells, 2).unwrap());
    assert_eq!((width, height), (2 * 456 + 8, 2 * 264 + 8));
    let cell = |column: usize, row: usize| {
        let at = |x: usize, y: usize| pixels[(8 + row * 264 + y) * 920 + 8 + column * 456 + x];
        // Seams of the checker, sheet of the layout, ink of the words.
        let red = |[r, g, b]: [u8; 3]| r > 110 && g < 100 && b < 110;
        let seams = (0..256 * 256).filter(|i| red(at(i % 256, i / 256))).count();
        let paper = (256..448).filter(|x| at(*x, 12) == [255; 3]).count();
        let dark = |[r, ..]: [u8; 3]| r < 130;
        let ink = (0..192 * 64).filter(|i| dark(at(256 + i % 192, 192 + i / 192))).count();
        (seams, paper, ink)
    };
    let (seams, paper, ink) = cell(0, 0);
    assert!(seams > 50 && paper > 150 && ink > 50, "{seams} {paper} {ink}");
    assert_eq!(cell(0, 1), (seams, paper, ink));
    assert_eq!(cell(1, 0), (0, 192, ink), "only its words");
    assert_eq!(cell(1, 1), (0, 192, 0), "nobody's place");
    let foreign = SheetCell { preview: Some(contact_sheet(&[], 1).unwrap()), caption: vec![] };
    assert!(matches!(contact_sheet(&[foreign], 1), Err(SheetError::Foreign { .. })));
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let place = |x: f64, y: f64| {
        let (sin, cos) = (TAU * x).sin_cos();
        DVec3::new(cos * (1.0 + y), 2.0 * y, sin * (1.0 + y))
    };
    let (surface, p) = grid(24, 6, place);
    let uv = uvs(&p, |[u, v]| [0.9 * u, 0.4 * v]);
    let zeros = vec![0; p.len()];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let input = measured(&surface, &uv, &zeros, &zeros);
            let svg = uv_layout_svg(&input, &["cone".to_owned()], &Cancel::default()).unwrap();
            (preview_png(&input, None, &Run::quiet()).unwrap(), svg)
        })
    };
    assert!(with(1) == with(2));
}

#[test]
fn nothing_and_faces_without_coordinates_can_be_drawn() {
    let nothing = Surface { diagonal: 1.0, ..Surface::default() };
    assert!(preview_png(&measured(&nothing, &[], &[], &[]), None, &Run::quiet()).is_ok());
    let (surface, mut uvs) = cube();
    let mut charts = [0; 12];
    uvs[3] = [[f32::NAN; 2]; 3];
    charts[3] = NONE;
    let input = measured(&surface, &uvs, &charts, &charts);
    assert!(preview_png(&input, None, &Run::quiet()).is_ok());
    let svg = uv_layout_svg(&input, &[], &Cancel::default()).unwrap();
    assert!(!svg.contains("NaN"));
}

#[test]
fn a_canceled_run_draws_nothing() {
    let run = Run::quiet();
    run.cancel.cancel();
    assert!(with_cube(|m| preview_png(m, None, &run)).is_err());
}
