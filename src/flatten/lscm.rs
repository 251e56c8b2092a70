//! Least squares conformal map with a free boundary (Lévy, Petitjean, Ray, Maillot, "Least Squares
//! Conformal Maps for Automatic Texture Atlas Generation", 2002), in the form Dirichlet energy
//! minus area (Desbrun, Meyer, Alliez, "Intrinsic Parameterizations of Surface Meshes", 2002). The
//! similarity that it leaves free is taken away by pinning the two ends of the boundary that are
//! farthest apart over the mesh.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DMat2, DVec2};

use super::border::Border;
use super::jacobian::rescale;
use super::pattern::PINNED;
use super::system::BlockSystem;
use super::{Disk, FlattenError, UvMap};

/// Gradients of a triangle's three hat functions in its own plane, from its rest shape.
pub(super) fn hat_gradients(rest: &DMat2) -> [DVec2; 3] {
    let (g1, g2) = (rest.row(0), rest.row(1));
    [-(g1 + g2), g1, g2]
}

/// The conformal map of least energy, scaled to the 3D area. It may flip triangles. Errors when the
/// disk has no boundary to pin.
pub fn lscm(disk: &Disk) -> Result<UvMap, FlattenError> {
    let [first, last] = pins(disk)?;
    let mut uv = vec![DVec2::ZERO; disk.positions.len()];
    uv[last as usize].x = disk.area().sqrt();

    let mut unknown = vec![PINNED; disk.positions.len()];
    let mut count = 0;
    for v in 0..unknown.len() as u32 {
        if v != first && v != last {
            unknown[v as usize] = count;
            count += 1;
        }
    }
    let corners = disk.triangles.iter().map(|t| t.map(|v| unknown[v as usize])).collect();
    let mut system = BlockSystem::new(count as usize, corners)?;
    let mut rhs = vec![0.0; 2 * count as usize];
    for (t, triangle) in disk.triangles.iter().enumerate() {
        let gradients = hat_gradients(&disk.rest[t]);
        for k in 0..3 {
            let next = (k + 1) % 3;
            system.add_diagonal(t, k, block(disk.areas[t], gradients[k], gradients[k]));
            system.add_edge(t, k, block(disk.areas[t], gradients[k], gradients[next]));
            for other in [next, (k + 2) % 3] {
                let (row, column) = (unknown[triangle[k] as usize], triangle[other] as usize);
                if row != PINNED && unknown[column] == PINNED {
                    let known = block(disk.areas[t], gradients[k], gradients[other]) * uv[column];
                    rhs[2 * row as usize] -= known.x;
                    rhs[2 * row as usize + 1] -= known.y;
                }
            }
        }
    }
    system.factorize(0.0)?;
    let mut x = rhs.clone();
    system.solve(&mut x);
    // One refinement wins back what a long chart's poor condition costs.
    let mut residual = system.multiply(&x);
    residual.iter_mut().zip(&rhs).for_each(|(r, b)| *r = b - *r);
    system.solve(&mut residual);
    for (p, &i) in uv.iter_mut().zip(&unknown) {
        if i != PINNED {
            let i = 2 * i as usize;
            *p = DVec2::new(x[i] + residual[i], x[i + 1] + residual[i + 1]);
        }
    }
    Ok(rescale(disk, uv))
}

/// The part of the energy's Hessian that joins two corners with hat gradients g (row) and h
/// (column): A(g·h) from the Dirichlet energy, ±A(g×h) from the area.
fn block(area: f64, g: DVec2, h: DVec2) -> DMat2 {
    let (same, turned) = (area * g.dot(h), area * g.perp_dot(h));
    DMat2::from_cols(DVec2::new(same, turned), DVec2::new(-turned, same))
}

/// Two boundary vertices far apart along the edges of the mesh: the farthest from the first vertex
/// of the longest loop, and the farthest from that.
fn pins(disk: &Disk) -> Result<[u32; 2], FlattenError> {
    let border = Border::of(disk);
    let longest = border.loops.iter().max_by_key(|l| l.len()).ok_or(FlattenError::NotADisk)?;
    let graph = edge_graph(disk);
    let farthest = |from: u32| {
        let distance = distances(&graph, from);
        let reached = longest.iter().copied().filter(|&v| distance[v as usize].is_finite());
        reached.max_by(|&v, &w| distance[v as usize].total_cmp(&distance[w as usize]))
    };
    let start = longest.first().copied().ok_or(FlattenError::NotADisk)?;
    let first = farthest(start).unwrap_or(start);
    let last = farthest(first).unwrap_or(start);
    if first == last { Err(FlattenError::NotADisk) } else { Ok([first, last]) }
}

/// Neighbours of each vertex along edges, with the length of the edge.
fn edge_graph(disk: &Disk) -> Vec<Vec<(u32, f64)>> {
    let mut graph = vec![Vec::new(); disk.positions.len()];
    for t in &disk.triangles {
        for k in 0..3 {
            let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
            let length = disk.positions[a].distance(disk.positions[b]);
            graph[a].push((b as u32, length));
            graph[b].push((a as u32, length));
        }
    }
    graph
}

/// Shortest distance of every vertex from one of them (Dijkstra 1959).
fn distances(graph: &[Vec<(u32, f64)>], from: u32) -> Vec<f64> {
    let mut distance = vec![f64::INFINITY; graph.len()];
    distance[from as usize] = 0.0;
    // Positive numbers order as their bits do.
    let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
    while let Some(Reverse((bits, v))) = queue.pop() {
        if f64::from_bits(bits) > distance[v as usize] {
            continue;
        }
        for &(w, length) in &graph[v as usize] {
            let through = distance[v as usize] + length;
            if through < distance[w as usize] {
                distance[w as usize] = through;
                queue.push(Reverse((through.to_bits(), w)));
            }
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{certify, quality, samples, singular_values};
    use std::f64::consts::TAU;

    #[test]
    fn developable_surfaces_are_mapped_exactly() {
        for disk in [
            samples::plane(12, 9, 3.0, 1.0).0,
            samples::tube(24, 6, TAU, 0.4, 0.4, 3.0),
            samples::tube(300, 1, TAU, 1.0, 0.4, 1.2),
            samples::open_box(),
        ] {
            let uv = lscm(&disk).unwrap();
            let q = quality(&disk, &uv);
            assert!(q.flips == 0 && q.max - 1.0 < 1e-8, "{q:?}");
            assert!(certify(&disk, &uv).is_injective());
        }
    }

    #[test]
    fn a_long_strip_keeps_its_precision() {
        let disk = samples::tube(4000, 1, 40.0 * TAU, 1.0, 1.0, 0.05);
        let q = quality(&disk, &lscm(&disk).unwrap());
        assert!(q.flips == 0 && q.max - 1.0 < 1e-4, "{q:?}");
    }

    #[test]
    fn a_height_field_is_mapped_nearly_conformally() {
        let disk = samples::bent(30, 30, |x, y| {
            glam::DVec3::new(x, y, 0.1 * (5.0 * x).sin() * (4.0 * y).cos())
        });
        let uv = lscm(&disk).unwrap();
        assert!(certify(&disk, &uv).is_injective());
        for f in 0..disk.triangles.len() {
            let (s1, s2) = singular_values(disk.jacobian(f, &uv));
            assert!(s1 / s2 < 1.2);
        }
    }

    #[test]
    fn a_closed_surface_is_refused() {
        let corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)];
        let positions = corners.map(glam::DVec3::from).to_vec();
        let closed = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        assert_eq!(lscm(&Disk::new(positions, closed)), Err(FlattenError::NotADisk));
    }
}
