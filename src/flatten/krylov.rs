//! Newton's system of a large disk: its rows put together and solved by conjugate gradients (Hestenes & Stiefel
//! 1952, doi:10.6028/jres.049.044), a few iterations and no factor, so that all of it is divided among threads. Before
//! them stand the vertices' own blocks and, for the long waves that few iterations would leave undone, a coarse grid.
//! Every iterate is a direction of descent (truncated Newton: Dembo & Steihaug 1983, doi:10.1007/BF02592055).

use glam::{DMat2, DVec2};

use super::coarse::Grid;
use super::fans::Fans;
use super::jacobian::symmetric_dirichlet_gradient;
use super::lscm::hat_gradients;
use super::model::Model;
use super::{Disk, UvMap};
use crate::tasks;

/// Residual, over that of the start, at which a system is solved well enough.
const RESIDUAL: f64 = 0.03;

/// The rows of a disk's system: a 2 × 2 block for each vertex and each of its neighbours.
pub(super) struct Rows {
    fans: Fans,
    /// Where each row begins; one more at the end.
    starts: Vec<u32>,
    /// The vertices of each row, its own first.
    columns: Vec<u32>,
}

/// The blocks of the rows, and the gradient.
pub(super) struct System {
    blocks: Vec<DMat2>,
    pub gradient: UvMap,
}

impl Rows {
    pub fn of(disk: &Disk) -> Self {
        let fans = Fans::of(disk);
        let row = |v: usize| {
            let mut row = vec![v as u32];
            for &c in fans.at(v) {
                for w in disk.triangles[c as usize / 3] {
                    if !row.contains(&w) {
                        row.push(w);
                    }
                }
            }
            row
        };
        let rows = tasks::fill("rows", disk.positions.len(), row);
        let mut starts = Vec::with_capacity(rows.len() + 1);
        starts.push(0);
        for row in &rows {
            starts.push(starts[starts.len() - 1] + row.len() as u32);
        }
        Self { fans, starts, columns: rows.concat() }
    }

    fn row(&self, v: usize) -> std::ops::Range<usize> {
        self.starts[v] as usize..self.starts[v + 1] as usize
    }

    /// The Hessian of the mean energy's model at `uv`, `model` of each Jacobian, and its gradient.
    pub fn assemble(
        &self,
        disk: &Disk,
        uv: &[DVec2],
        area: f64,
        model: impl Fn(DMat2) -> Model + Sync + Send,
    ) -> System {
        let face = |f: usize| {
            let j = disk.jacobian(f, uv);
            (disk.areas[f] > 0.0).then(|| (model(j), symmetric_dirichlet_gradient(j)))
        };
        let faces = tasks::fill("models", disk.triangles.len(), face);
        let row = |v: usize| {
            let columns = &self.columns[self.row(v)];
            let (mut blocks, mut gradient) = (vec![DMat2::ZERO; columns.len()], DVec2::ZERO);
            for &c in self.fans.at(v) {
                let (f, k) = (c as usize / 3, c as usize % 3);
                let Some((model, force)) = &faces[f] else { continue };
                let (weight, hats) = (disk.areas[f] / area, hat_gradients(&disk.rest[f]));
                gradient += *force * hats[k] * weight;
                for (w, hat) in disk.triangles[f].iter().zip(hats) {
                    if let Some(at) = columns.iter().position(|column| column == w) {
                        blocks[at] += model.block(hats[k], hat) * weight;
                    }
                }
            }
            (blocks, gradient)
        };
        let rows = tasks::fill("blocks", self.starts.len() - 1, row);
        let mut blocks = Vec::with_capacity(self.columns.len());
        let mut gradient = Vec::with_capacity(rows.len());
        for (own, force) in rows {
            blocks.extend(own);
            gradient.push(force);
        }
        System { blocks, gradient }
    }

    /// What the system's step comes to in so many iterations: H d = −g.
    pub fn solve(&self, uv: &[DVec2], system: &System, iterations: u32) -> UvMap {
        let count = self.starts.len() - 1;
        let grid = Grid::over(uv);
        let level = grid.level(|v| {
            let row = self.row(v);
            self.columns[row.clone()].iter().copied().zip(&system.blocks[row])
        });
        let inverse = tasks::fill("inverses", count, |v| {
            let own = system.blocks[self.starts[v] as usize];
            let inverse = own.inverse();
            // A vertex that nothing holds stays where it is.
            if inverse.is_finite() { inverse } else { DMat2::ZERO }
        });
        let dot = |a: &[DVec2], b: &[DVec2]| tasks::sum("dot", count, |v| a[v].dot(b[v]));
        let mut step = vec![DVec2::ZERO; count];
        let mut rest: UvMap = system.gradient.iter().map(|g| -g).collect();
        let ease = |rest: &UvMap| match &level {
            Some(level) => {
                let long = grid.eased(level, rest);
                tasks::fill("eased", count, |v| inverse[v] * rest[v] + long[v])
            }
            None => tasks::fill("eased", count, |v| inverse[v] * rest[v]),
        };
        let mut eased = ease(&rest);
        let mut along = eased.clone();
        let mut slope = dot(&rest, &eased);
        let enough = RESIDUAL * RESIDUAL * slope;
        for _ in 0..iterations {
            if slope.is_nan() || slope <= enough {
                break;
            }
            let image = tasks::fill("product", count, |v| {
                let row = self.row(v);
                let terms = self.columns[row.clone()].iter().zip(&system.blocks[row]);
                terms.map(|(&w, block)| *block * along[w as usize]).sum::<DVec2>()
            });
            let curvature = dot(&along, &image);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let length = slope / curvature;
            step = tasks::fill("step", count, |v| step[v] + along[v] * length);
            rest = tasks::fill("rest", count, |v| rest[v] - image[v] * length);
            eased = ease(&rest);
            let next = dot(&rest, &eased);
            let share = next / slope;
            along = tasks::fill("along", count, |v| eased[v] + along[v] * share);
            slope = next;
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;
    use crate::flatten::system::BlockSystem;

    #[test]
    fn many_iterations_find_what_a_factor_finds() {
        let disk = samples::barrel(12, 10);
        let uv = crate::flatten::start_map(&disk, None).0;
        let area = disk.area();
        let rows = Rows::of(&disk);
        let mut system = rows.assemble(&disk, &uv, area, Model::newton);
        let mut direct = BlockSystem::new(uv.len(), disk.triangles.clone()).unwrap();
        for f in 0..disk.triangles.len() {
            let hats = hat_gradients(&disk.rest[f]);
            let model = Model::newton(disk.jacobian(f, &uv));
            for k in 0..3 {
                let weight = disk.areas[f] / area;
                direct.add_diagonal(f, k, model.block(hats[k], hats[k]) * weight);
                direct.add_edge(f, k, model.block(hats[k], hats[(k + 1) % 3]) * weight);
            }
        }
        // The same matrix …
        let x: Vec<f64> = (0..2 * uv.len()).map(|i| (i as f64).sin()).collect();
        let pairs: UvMap = x.chunks(2).map(|p| DVec2::new(p[0], p[1])).collect();
        let want = direct.multiply(&x);
        for v in 0..uv.len() {
            let row = rows.row(v);
            let terms = rows.columns[row.clone()].iter().zip(&system.blocks[row]);
            let have: DVec2 = terms.map(|(&w, block)| *block * pairs[w as usize]).sum();
            assert!(have.distance(DVec2::new(want[2 * v], want[2 * v + 1])) < 1e-9);
        }
        // … and, raised a little so that it is definite, the same solution.
        for v in 0..uv.len() {
            system.blocks[rows.starts[v] as usize] *= 1.01;
        }
        direct.factorize(0.01).unwrap();
        let mut want: Vec<f64> = system.gradient.iter().flat_map(|g| [-g.x, -g.y]).collect();
        direct.solve(&mut want);
        let have = rows.solve(&uv, &system, 2000);
        let size = want.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off: f64 = have
            .iter()
            .zip(want.chunks(2))
            .map(|(p, q)| p.distance_squared(DVec2::new(q[0], q[1])))
            .sum();
        assert!(off.sqrt() < 0.1 * size, "{} of {size}", off.sqrt());
        let down: f64 = have.iter().zip(&system.gradient).map(|(d, g)| d.dot(*g)).sum();
        assert!(down < 0.0);
        assert!(
            rows.solve(&uv, &system, 1).iter().zip(&system.gradient).any(|(d, g)| d.dot(*g) < 0.0)
        );
    }
}
