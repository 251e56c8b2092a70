//! Symmetric positive definite systems in the UV coordinates of a triangle mesh: one 2×2 block for
//! each vertex and each edge. The pattern is analysed once and factorised as often as the values
//! change (sparse Cholesky of `faer`, one thread, so that the result is the same on every machine
//! with the same instructions).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use glam::DMat2;

use super::FlattenError;
use super::pattern::{PINNED, Pattern};

/// The blocks of one system, its pattern's analysis, and its factor.
pub(super) struct BlockSystem {
    /// Lower triangle by columns: unknown `v` has the columns 2v and 2v + 1.
    columns: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
    /// For edge k (corner k to k + 1) of each triangle, the place of its block in the two columns.
    slots: Vec<[[usize; 2]; 3]>,
    triangles: Vec<[u32; 3]>,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl BlockSystem {
    /// Analyse the pattern of `unknowns` vertices joined by triangles, whose corners are unknowns
    /// or [`PINNED`].
    pub fn new(unknowns: usize, triangles: Vec<[u32; 3]>) -> Result<Self, FlattenError> {
        let pattern = Pattern::of(unknowns, &triangles)?;
        Self::on(&pattern, triangles)
    }

    /// The same where the pattern of these triangles is known.
    pub fn on(pattern: &Pattern, triangles: Vec<[u32; 3]>) -> Result<Self, FlattenError> {
        let (edges, unknowns) = (&pattern.edges, pattern.unknowns);
        // The block column of v: its diagonal block, then the blocks of its larger neighbours.
        let mut columns = Vec::with_capacity(2 * unknowns + 1);
        let mut rows = Vec::with_capacity(3 * unknowns + 4 * edges.len());
        let mut places = vec![[0; 2]; edges.len()];
        let starts = &pattern.starts;
        for v in 0..unknowns as u32 {
            let own = starts[v as usize] as usize..starts[v as usize + 1] as usize;
            for half in 0..2 {
                columns.push(rows.len() as u32);
                rows.extend((2 * v + half)..(2 * v + 2));
                for e in own.clone() {
                    places[e][half as usize] = rows.len();
                    rows.extend([2 * edges[e].1, 2 * edges[e].1 + 1]);
                }
            }
        }
        columns.push(rows.len() as u32);
        let slot = |e: u32| if e == PINNED { [0; 2] } else { places[e as usize] };
        let slots = pattern.edge_of.iter().map(|edges| edges.map(slot)).collect();

        let n = 2 * unknowns;
        let lower = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let (order, inverse) = pattern.permutation(2);
        let symbolic = factorize_symbolic_cholesky(
            lower,
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, n)),
            CholeskySymbolicParams {
                // Two unknowns a vertex make blocks everywhere. Measured: 4 to 7 % of a body's seconds, and
                // nothing lost where there is little to factorise.
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .map_err(|_| FlattenError::Singular)?;
        let request = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let memory = MemBuffer::new(request);
        let factor = vec![0.0; symbolic.len_val()];
        let values = vec![0.0; rows.len()];
        Ok(Self { columns, rows, values, slots, triangles, symbolic, factor, memory })
    }

    /// Set every block to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Add a symmetric block to the diagonal, at corner `k` of triangle `t`.
    pub fn add_diagonal(&mut self, t: usize, k: usize, block: DMat2) {
        let v = self.triangles[t][k];
        if v != PINNED {
            let [left, right] = self.diagonal(v);
            self.values[left] += block.x_axis.x;
            self.values[left + 1] += block.x_axis.y;
            self.values[right] += block.y_axis.y;
        }
    }

    /// Add a block at row corner `k`, column corner `k + 1` of triangle `t`, and its transpose
    /// across the diagonal.
    pub fn add_edge(&mut self, t: usize, k: usize, block: DMat2) {
        let (a, b) = (self.triangles[t][k], self.triangles[t][(k + 1) % 3]);
        if a == b || a == PINNED || b == PINNED {
            return;
        }
        let block = if a > b { block } else { block.transpose() };
        let [left, right] = self.slots[t][k];
        self.values[left] += block.x_axis.x;
        self.values[left + 1] += block.x_axis.y;
        self.values[right] += block.y_axis.x;
        self.values[right + 1] += block.y_axis.y;
    }

    /// Where the two columns of a vertex begin.
    fn diagonal(&self, v: u32) -> [usize; 2] {
        [0, 1].map(|half| self.columns[2 * v as usize + half] as usize)
    }

    /// Factorise the values. The diagonal is raised by the share `damping` (Levenberg–Marquardt),
    /// and by more where rounding has made the matrix indefinite; an unknown without any triangle
    /// gets 1, so that it stays where it is.
    pub fn factorize(&mut self, damping: f64) -> Result<(), FlattenError> {
        let mut raise = damping;
        for _ in 0..4 {
            for v in 0..(self.columns.len() as u32 - 1) / 2 {
                for at in self.diagonal(v) {
                    let value = self.values[at];
                    self.values[at] = if value > 0.0 { value * (1.0 + raise) } else { 1.0 };
                }
            }
            if self.try_factorize() {
                return Ok(());
            }
            raise = (1e3 * raise).max(1e-12);
        }
        Err(FlattenError::Singular)
    }

    fn try_factorize(&mut self) -> bool {
        let n = self.columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.columns, None, &self.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values);
        let done = self.symbolic.factorize_numeric_llt(
            &mut self.factor,
            matrix,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        done.is_ok()
    }

    /// Solve for the right side `rhs` (u and v of each unknown in turn), in place.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        let n = rhs.len();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// The matrix times `x`.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (column, &xc) in x.iter().enumerate() {
            let range = self.columns[column] as usize..self.columns[column + 1] as usize;
            for (&row, &value) in self.rows[range.clone()].iter().zip(&self.values[range]) {
                let row = row as usize;
                y[row] += value * xc;
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::samples;
    use glam::DVec2;

    #[test]
    fn solves_what_it_multiplies() {
        let triangles = samples::grid(5, 4);
        let mut system = BlockSystem::new(30, triangles.clone()).unwrap();
        for t in 0..triangles.len() {
            for k in 0..3 {
                system.add_diagonal(t, k, DMat2::from_diagonal(DVec2::new(5.0, 4.0)));
                let block = DMat2::from_cols(DVec2::new(-1.0, 0.3), DVec2::new(-0.2, -0.9));
                system.add_edge(t, k, block);
            }
        }
        let x: Vec<f64> = (0..60).map(|i| (i as f64).sin()).collect();
        let mut y = system.multiply(&x);
        system.factorize(0.0).unwrap();
        system.solve(&mut y);
        assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn an_indefinite_matrix_is_refused_and_a_loose_vertex_is_not() {
        let mut system = BlockSystem::new(3, vec![[0, 1, PINNED]]).unwrap();
        system.add_diagonal(0, 0, DMat2::IDENTITY);
        system.add_diagonal(0, 1, DMat2::IDENTITY);
        let mut rhs = vec![1.0; 6];
        system.factorize(0.0).unwrap();
        system.solve(&mut rhs);
        assert_eq!(rhs, [1.0; 6]);
        system.add_edge(0, 0, DMat2::IDENTITY * 2.0);
        assert_eq!(system.factorize(0.0), Err(FlattenError::Singular));
    }
}
