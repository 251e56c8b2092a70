//! A proxy's chart as charts of the fine surface: the faces that carry its label, cut open where the proxy's
//! chart is, each piece with its map (`prolong`).

use std::collections::VecDeque;

use glam::DVec2;

use super::pieces::{Pieces, Seams};
use super::{IN_WAY, near};
use crate::charts::{self, Chart, ChartOptions, ChartShape, PartMesh, Piece};
use crate::contract::{Canceled, Run};
use crate::flatten::{self, Border};
use crate::mesh::{NONE, Proxy, Surface};
use crate::tasks;

/// Rings of faces around an overlap in which a cut is closed.
const CLOSED: u32 = 12;

/// Neighbouring faces that lie farther apart on the proxy's map, in its mean edges, are none.
const FAR: f64 = 5.0;

/// Charts of the fine surface, or the fine faces at which one of the proxy could not be carried.
pub type Refined = Result<Vec<Chart>, Vec<u32>>;

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

/// A chart of the proxy, and the fine faces that carry its label.
pub struct Counterpart<'a> {
    pub chart: &'a Chart,
    /// The fine faces.
    pub mesh: PartMesh<'a>,
    /// Whether each half-edge is closed, as it is on the proxy.
    glued: Vec<bool>,
    /// Whether the sides of each half-edge come to touch that do not on the proxy.
    apart: Vec<bool>,
}

/// A piece of a counterpart as a disk of its own, and its border.
pub struct Opened {
    pub piece: Piece,
    pub border: Border,
}

impl Refiner<'_> {
    /// A chart of the proxy on the fine surface: `faces` (ascending) carry its label. Where it must be divided on
    /// the proxy the fine faces at which it fails; the `last` time it is divided here.
    pub fn refine(
        &self,
        chart: &Chart,
        faces: Vec<u32>,
        peel: bool,
        last: bool,
    ) -> Result<Refined, Canceled> {
        let Some(&first) = chart.faces.first() else { return Ok(Ok(Vec::new())) };
        if !self.proxy.collapsed[first as usize] {
            return Ok(Ok(vec![self.as_it_is(chart)]));
        }
        let last = last || chart.faces.len() == 1;
        let part = tasks::link("counterpart", || self.counterpart(chart, faces));
        let all: Vec<u32> = (0..part.mesh.len() as u32).collect();
        let mut charts = Vec::new();
        for faces in part.mesh.components(&all, |h| part.glued[h as usize]) {
            self.run.cancel.check()?;
            let opened = tasks::link("open", || self.opened(&part, &faces, &part.glued));
            let mut mapped = self.mapped(&part, opened, last)?;
            if let Err(trouble) = &mapped
                && let Some(made) = self.closed(&part, &faces, trouble)?
            {
                mapped = Ok(made);
            }
            let trouble = match mapped {
                Ok(made) => {
                    let whole = faces.len() == all.len();
                    let shape = if whole { made.shape } else { ChartShape::General };
                    charts.push(Chart { shape, ..made });
                    continue;
                }
                Err(trouble) => trouble,
            };
            let peeled = match peel || last {
                true => self.peeled(&part, &faces, &trouble, last)?,
                false => None,
            };
            match peeled {
                Some(made) => charts.extend(made),
                None if last => charts.extend(self.split(&part, &faces)?),
                None => return Ok(Err(trouble)),
            }
        }
        Ok(Ok(charts))
    }

    fn counterpart<'a>(&'a self, chart: &'a Chart, faces: Vec<u32>) -> Counterpart<'a> {
        let coarse = &chart.cut_map;
        let mesh = PartMesh::new(self.fine, faces);
        let label = |h: u32| self.labels[mesh.faces[h as usize / 3] as usize];
        let glued = |h: u32| {
            let t = mesh.twin[h as usize];
            t != NONE && !self.pieces.parts(label(h), label(t))
        };
        let beside = self.beside(chart, &mesh, glued);
        let middle = |of: u32| {
            let corners = chart.disk.triangles[of as usize].map(|v| coarse[v as usize]);
            corners.iter().sum::<DVec2>() / 3.0
        };
        let edge = flatten::scale(&chart.disk, coarse)
            * (chart.disk.area() / chart.faces.len() as f64 * 4.0 / 3f64.sqrt()).sqrt();
        // Sides that had something between them, which is gone, touch: they are no neighbours on the map.
        let apart = |h: u32| {
            let [a, b] = [h, mesh.twin[h as usize]].map(|h| beside[h as usize / 3]);
            let known = a != b && a != NONE && b != NONE;
            known && middle(a).distance(middle(b)) > FAR * edge
        };
        let half_edges = 0..3 * mesh.len() as u32;
        let inner = |h: u32| mesh.twin[h as usize] != NONE;
        let apart: Vec<bool> = half_edges.clone().map(|h| inner(h) && apart(h)).collect();
        let glued: Vec<bool> = half_edges.map(|h| glued(h) && !apart[h as usize]).collect();
        Counterpart { chart, mesh, glued, apart }
    }

    /// A piece without the cut that overlaps, where that is short.
    fn closed(
        &self,
        part: &Counterpart,
        faces: &[u32],
        trouble: &[u32],
    ) -> Result<Option<Chart>, Canceled> {
        let mesh = &part.mesh;
        let at = (0..mesh.len() as u32)
            .filter(|&f| trouble.binary_search(&mesh.faces[f as usize]).is_ok());
        let near = near(&mesh.twin, at.collect(), CLOSED);
        let inside = |h: usize| {
            let t = mesh.twin[h];
            t != NONE && !part.apart[h] && near[h / 3] && near[t as usize / 3]
        };
        let closed: Vec<bool> =
            part.glued.iter().enumerate().map(|(h, &glued)| glued || inside(h)).collect();
        let is_whole = || mesh.components(faces, |h| closed[h as usize]) == [faces];
        if closed == part.glued || !is_whole() {
            return Ok(None);
        }
        Ok(self.mapped(part, self.opened(part, faces, &closed), false)?.ok())
    }

    /// A piece without the few faces that are in its way, and these as charts of their own.
    fn peeled(
        &self,
        part: &Counterpart,
        faces: &[u32],
        trouble: &[u32],
        last: bool,
    ) -> Result<Option<Vec<Chart>>, Canceled> {
        let mesh = &part.mesh;
        // Connected faces of some.
        let components = |own: &dyn Fn(u32) -> bool| {
            let faces: Vec<u32> = faces.iter().copied().filter(|&f| own(f)).collect();
            mesh.components(&faces, |h| {
                part.glued[h as usize] && own(h / 3) && own(mesh.twin[h as usize] / 3)
            })
        };
        let in_way = |f: u32| trouble.binary_search(&mesh.faces[f as usize]).is_ok();
        let rest = components(&|f| !in_way(f));
        let Some(main) = rest.into_iter().max_by_key(Vec::len) else { return Ok(None) };
        if (main.len() as f64) < (1.0 - IN_WAY) * faces.len() as f64 {
            return Ok(None);
        }
        // Where more than one chart comes of it, one cut through the chart makes fewer.
        let others = components(&|f| main.binary_search(&f).is_err());
        if others.len() > 1 && !last {
            return Ok(None);
        }
        let general = |made: Chart| Chart { shape: ChartShape::General, ..made };
        let piece = self.opened(part, &main, &part.glued);
        let Ok(made) = self.mapped(part, piece, false)? else { return Ok(None) };
        let mut charts = vec![general(made)];
        for faces in others {
            match self.mapped(part, self.opened(part, &faces, &part.glued), true)? {
                Ok(made) => charts.push(general(made)),
                Err(_) if last => charts.extend(self.split(part, &faces)?),
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(charts))
    }

    /// Faces divided on the fine surface.
    fn split(&self, part: &Counterpart, faces: &[u32]) -> Result<Vec<Chart>, Canceled> {
        let faces = faces.iter().map(|&f| part.mesh.faces[f as usize]).collect();
        let failed = Chart { faces, part: part.chart.part, ..Chart::default() };
        charts::split_chart(self.fine, &failed, self.options, self.run)
    }

    /// The face of the proxy's chart that each fine face lies on, or that is next over faces to which it is
    /// glued; [`NONE`] where there is none.
    fn beside(&self, chart: &Chart, mesh: &PartMesh, glued: impl Fn(u32) -> bool) -> Vec<u32> {
        let own = |&f: &u32| {
            let face = self.proxy.face[f as usize];
            let at = chart.faces.binary_search(&face).ok()?;
            self.fits(self.labels[f as usize], face).then_some(at as u32)
        };
        let mut beside: Vec<u32> = mesh.faces.iter().map(|f| own(f).unwrap_or(NONE)).collect();
        let mut queue: VecDeque<u32> =
            (0..beside.len() as u32).filter(|&f| beside[f as usize] != NONE).collect();
        while let Some(f) = queue.pop_front() {
            for h in (3 * f..3 * f + 3).filter(|&h| glued(h)) {
                let g = mesh.twin[h as usize] / 3;
                if beside[g as usize] == NONE {
                    beside[g as usize] = beside[f as usize];
                    queue.push_back(g);
                }
            }
        }
        beside
    }

    /// Whether a face of the proxy lies in the piece of a label, or in one that is glued to it.
    pub fn fits(&self, label: u32, face: u32) -> bool {
        let piece = self.pieces.of_face[face as usize];
        piece != NONE
            && self.pieces.chart[piece as usize] == self.pieces.chart[label as usize]
            && !self.pieces.parts(label, piece)
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
    fn opened(&self, part: &Counterpart, faces: &[u32], glued: &[bool]) -> Opened {
        let mesh = &part.mesh;
        let piece = tasks::link("cut open", || mesh.cut_open(faces.to_vec(), glued));
        let border = tasks::link("border", || Border::of(&piece.disk));
        let topology = |border: &Border| (border.loops.len(), border.euler);
        let have = topology(&border);
        if have == (1, 1) || have == topology(&Border::of(&part.chart.disk)) {
            return Opened { piece, border };
        }
        let whole =
            PartMesh::new(self.fine, faces.iter().map(|&f| mesh.faces[f as usize]).collect());
        // Half-edges of the whole, as those of the mesh.
        let of_mesh = |h: u32| 3 * faces[h as usize / 3] + h % 3;
        let opened = charts::open_where(&whole, |h| {
            whole.twin[h as usize] != NONE && glued[of_mesh(h) as usize]
        });
        let all = (0..whole.len() as u32).collect();
        let Piece { disk, vertices, .. } = whole.cut_open(all, &opened);
        let border = Border::of(&disk);
        Opened { piece: Piece { faces: faces.to_vec(), disk, vertices }, border }
    }
}
