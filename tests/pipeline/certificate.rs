//! No job succeeds without a valid atlas: what the lattice of final coordinates would lose is enlarged.

use std::fmt::Write;

use uvsegnet::contract::{Quality, Rotation, SegmentationSource, UnwrapOptions};

use super::{quick, unwrap};

/// A square of side 1 and, above it, a needle as long and so high.
fn needle(height: f64) -> String {
    let mut text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n".to_owned();
    let _ = write!(text, "v 0 0 1\nv 1 0 1\nv 0.5 {height:e} 1\nf 5 6 7\n");
    text
}

fn options() -> UnwrapOptions {
    UnwrapOptions { quality: Quality::Fast, segmentation: SegmentationSource::Authored, ..quick() }
}

#[test]
fn a_needle_keeps_its_height_on_every_lattice() {
    let with = |height, udim, density: Option<&str>| {
        let options = UnwrapOptions { udim, density: density.map(str::to_owned), ..options() };
        unwrap(needle(height).as_bytes(), None, &options).unwrap().metrics
    };
    for (udim, density) in [(true, None), (false, Some("1=0.01")), (true, Some("1=0.01"))] {
        let m = with(3e-7, udim, density);
        assert!(m.atlas.certificate.valid, "{:?}", m.atlas.certificate);
        assert_eq!(m.atlas.certificate.zero_area_3d, 0, "the needle has area");
    }
}

/// A square of side 1 and, above it, a sheet of cells that are this wide.
fn fine_sheet(cells: u32, cell: f64) -> String {
    let mut text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n".to_owned();
    for j in 0..=cells {
        for i in 0..=cells {
            let _ = writeln!(text, "v {} {} 1", f64::from(i) * cell, f64::from(j) * cell);
        }
    }
    for j in 0..cells {
        for i in 0..cells {
            let a = 5 + j * (cells + 1) + i;
            let _ = writeln!(text, "f {a} {} {} {}", a + 1, a + cells + 2, a + cells + 1);
        }
    }
    text
}

#[test]
fn faces_that_the_lattice_would_lose_are_enlarged_and_told() {
    let cases = [(5e-6, false, 1), (5e-6, true, 1), (2e-5, true, 1), (2e-5, false, 0)];
    for (cell, udim, least) in cases {
        // Upright: how a turned face is rounded is chance.
        let (rotation, density) = (Rotation::None, Some("1=0.01".into()));
        let options = UnwrapOptions { udim, rotation, density, ..options() };
        let m = unwrap(fine_sheet(6, cell).as_bytes(), None, &options).unwrap().metrics;
        assert!(m.atlas.certificate.valid, "{cell} {udim}: {:?}", m.atlas.certificate);
        assert_eq!(m.repairs.enlarged_faces.min(1), least, "{cell} {udim}");
        assert_eq!(m.charts.iter().map(|c| c.faces).sum::<u64>(), 74);
    }
}
