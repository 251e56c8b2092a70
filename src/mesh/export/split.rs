//! Vertices from corners: corners with equal keys share a vertex.

use rayon::slice::ParallelSliceMut;

use crate::tasks;

/// The distinct keys in ascending order, and for each corner the index of its key. With the old
/// vertex as the head of the key, new vertices stay in the order of the old ones.
pub(in crate::mesh) fn split<K: Ord + Copy + Send>(
    corners: impl Iterator<Item = K>,
) -> (Vec<K>, Vec<u32>) {
    let mut order: Vec<(K, u32)> = corners.zip(0u32..).collect();
    tasks::even("split", order.len(), || order.par_sort_unstable());
    let mut keys: Vec<K> = Vec::new();
    let mut index = vec![0; order.len()];
    for (key, corner) in order {
        if keys.last() != Some(&key) {
            keys.push(key);
        }
        index[corner as usize] = keys.len() as u32 - 1;
    }
    (keys, index)
}

#[cfg(test)]
mod tests {
    use super::split;

    #[test]
    fn equal_corners_share_a_vertex() {
        let (keys, index) = split([(7, 'b'), (2, 'a'), (7, 'a'), (7, 'b')].into_iter());
        assert_eq!(keys, [(2, 'a'), (7, 'a'), (7, 'b')]);
        assert_eq!(index, [2, 0, 1, 2]);
    }
}
