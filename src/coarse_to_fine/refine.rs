//! A proxy's chart as charts of the fine surface: the faces that carry its label, cut open where the proxy's
//! chart is, and its map carried over the record (prolongation), mended, relaxed and proved.

use glam::DVec2;

use super::pieces::{Pieces, Seams};
use crate::charts::{self, Chart, ChartOptions, ChartShape, PartMesh, Piece, StartKind};
use crate::contract::{Canceled, Run};
use crate::flatten::{self, Border, Disk, SlimOptions, UvMap};
use crate::mesh::{NONE, Place, Proxy, Surface};

/// Descent steps of a proxy's map before it is carried over.
const STEPS: u32 = 20;

/// Energy that noise and roughness, which the proxy has not, may add to its map's.
const NOISE: f64 = 0.04;

/// Sweeps over the vertices of a map that was carried over.
const SWEEPS: u32 = 8;

/// What every chart is refined with.
pub struct Refiner<'a> {
    pub fine: &'a Surface,
    pub proxy: &'a Proxy,
    pub pieces: &'a Pieces,
    /// Piece of each fine face.
    pub labels: &'a [u32],
    pub options: &'a ChartOptions,
    pub clearance: f64,
    pub run: &'a Run,
}

impl Refiner<'_> {
    /// A chart of the proxy on the fine surface: `faces` (ascending) carry its label. `None` where it must be
    /// divided on the proxy; the `last` time it is divided here.
    pub fn refine(
        &self,
        chart: &Chart,
        faces: Vec<u32>,
        last: bool,
    ) -> Result<Option<Vec<Chart>>, Canceled> {
        let Some(&first) = chart.faces.first() else { return Ok(Some(Vec::new())) };
        if !self.proxy.collapsed[first as usize] {
            return Ok(Some(vec![self.as_it_is(chart)]));
        }
        let last = last || chart.faces.len() == 1;
        let whole = faces.len();
        let options = SlimOptions { iterations: STEPS, ..Default::default() };
        let coarse = flatten::slim(&chart.disk, &chart.cut_map, &options, &self.run.cancel)?;
        let mesh = PartMesh::new(self.fine, faces);
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let label = |h: u32| self.labels[mesh.faces[h as usize / 3] as usize];
        let glued = |h: u32| {
            let t = mesh.twin[h as usize];
            t != NONE && !self.pieces.parts(label(h), label(t))
        };
        let mut charts = Vec::new();
        for faces in mesh.components(&all, glued) {
            self.run.cancel.check()?;
            let piece = self.opened(chart, &mesh, faces, glued);
            let whole = piece.faces.len() == whole;
            match self.mapped(chart, &coarse, &mesh, piece)? {
                Ok(made) => {
                    let shape = if whole { made.shape } else { ChartShape::General };
                    charts.push(Chart { shape, ..made });
                }
                Err(failed) if last => {
                    charts.extend(charts::split_chart(self.fine, &failed, self.options, self.run)?);
                }
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(charts))
    }

    /// A chart of faces that were not collapsed.
    fn as_it_is(&self, chart: &Chart) -> Chart {
        let faces: Vec<u32> = chart.faces.iter().map(|&f| self.proxy.left_of[f as usize]).collect();
        let mut vertices = vec![0; chart.vertices.len()];
        for (&f, triangle) in faces.iter().zip(&chart.disk.triangles) {
            for (&v, &vertex) in triangle.iter().zip(&self.fine.triangles[f as usize]) {
                vertices[v as usize] = vertex;
            }
        }
        Chart { faces, vertices, ..chart.clone() }
    }

    /// Faces cut open as the proxy's chart is, or where noise has left a hole or a handle more, to a disk.
    fn opened(
        &self,
        chart: &Chart,
        mesh: &PartMesh,
        faces: Vec<u32>,
        glued: impl Fn(u32) -> bool,
    ) -> Piece {
        let piece = mesh.cut_open_where(faces.clone(), &glued);
        let topology = |disk: &Disk| {
            let border = Border::of(disk);
            (border.loops.len(), border.euler)
        };
        let have = topology(&piece.disk);
        if have == (1, 1) || have == topology(&chart.disk) {
            return piece;
        }
        let whole =
            PartMesh::new(self.fine, faces.iter().map(|&f| mesh.faces[f as usize]).collect());
        let opened = charts::open_where(&whole, |h| {
            let t = whole.twin[h as usize];
            let label = |h: u32| self.labels[whole.faces[h as usize / 3] as usize];
            t != NONE && !self.pieces.parts(label(h), label(t))
        });
        let all = (0..whole.len() as u32).collect();
        let Piece { disk, vertices, .. } = whole.cut_open(all, &opened);
        Piece { faces, disk, vertices }
    }

    /// The chart of a piece with the best map that is proved, or, where none is, with one that is not.
    fn mapped(
        &self,
        chart: &Chart,
        coarse: &UvMap,
        mesh: &PartMesh,
        piece: Piece,
    ) -> Result<Result<Chart, Chart>, Canceled> {
        let Piece { faces, disk, vertices } = piece;
        let faces: Vec<u32> = faces.iter().map(|&f| mesh.faces[f as usize]).collect();
        let sound = |uv: &UvMap| charts::is_sound(&disk, uv, self.clearance);
        // The cut may have been made with a higher bound, for `max_charts`.
        let reached = flatten::quality(&chart.disk, coarse).mean - 1.0;
        let most = self.options.distortion_bound.max(reached) + NOISE;
        let fits = |uv: &UvMap| flatten::quality(&disk, uv).mean - 1.0 <= most;
        let carried = flatten::extend(&disk, self.prolonged(chart, coarse, &faces, &disk));
        let mut found = None;
        if let Some(mended) = carried.and_then(|carried| flatten::untangle(&disk, carried)) {
            let relaxed = flatten::relax(&disk, mended.clone(), SWEEPS, &self.run.cancel)?;
            found = [relaxed, mended].into_iter().find(|uv| fits(uv) && sound(uv));
        }
        let made = |uv: UvMap, start_kind| Chart {
            part: chart.part,
            shape: chart.shape.clone(),
            start: uv.clone(),
            cut_map: uv,
            start_kind,
            faces: faces.clone(),
            vertices: vertices.clone(),
            disk: disk.clone(),
        };
        if let Some(uv) = found {
            return Ok(Ok(made(flatten::rescale(&disk, uv), StartKind::Prolonged)));
        }
        // The classical start.
        let (start, kind) = flatten::start_map(&disk);
        if sound(&start) {
            let uv = flatten::relax(&disk, start.clone(), SWEEPS, &self.run.cancel)?;
            let uv = if sound(&uv) { uv } else { start.clone() };
            if fits(&uv) {
                return Ok(Ok(made(flatten::rescale(&disk, uv), kind.into())));
            }
        }
        Ok(Err(made(start, kind.into())))
    }

    /// The map carried over: each vertex where it lies in its proxy face, NaN beyond the chart's proxy.
    fn prolonged(&self, chart: &Chart, coarse: &UvMap, faces: &[u32], disk: &Disk) -> UvMap {
        let mut uv = vec![DVec2::NAN; disk.positions.len()];
        let corners = |face: u32| {
            let at = chart.faces.binary_search(&face).ok()?;
            Some(chart.disk.triangles[at].map(|v| coarse[v as usize]))
        };
        let fits = |label: u32, face: u32| {
            let piece = self.pieces.of_face[face as usize];
            piece != NONE
                && self.pieces.chart[piece as usize] == self.pieces.chart[label as usize]
                && !self.pieces.parts(label, piece)
        };
        for (&f, triangle) in faces.iter().zip(&disk.triangles) {
            let label = self.labels[f as usize];
            for (k, &v) in triangle.iter().enumerate() {
                let Place { face, weights } =
                    self.proxy.places[self.proxy.corners[f as usize][k] as usize];
                if let Some(c) = corners(face).filter(|_| fits(label, face)) {
                    uv[v as usize] = c.iter().zip(weights).map(|(p, w)| *p * f64::from(w)).sum();
                }
            }
        }
        uv
    }
}
