//! Which vertices a primitive uses. Many primitives may share one large vertex buffer, and each is to cost
//! no more than its own corners.

/// Numbers the vertices that primitives use, leaving out the others; made once for many primitives.
#[derive(Default)]
pub(in crate::mesh) struct Renumbering {
    /// New number of each old vertex, [`u32::MAX`] between calls.
    slots: Vec<u32>,
}

impl Renumbering {
    /// The vertices that triangles of vertices below `count` use, ascending.
    pub fn used(&mut self, triangles: &[[u32; 3]], count: usize) -> Vec<u32> {
        let used = self.mark(triangles, count);
        self.forget(&used);
        used
    }

    /// Rewrite triangles of vertices below `count` to the used vertices, which come back in
    /// ascending order.
    pub fn apply(&mut self, triangles: &mut [[u32; 3]], count: usize) -> Vec<u32> {
        let used = self.mark(triangles, count);
        if used.len() < count {
            for (number, &vertex) in used.iter().enumerate() {
                self.slots[vertex as usize] = number as u32;
            }
            for vertex in triangles.as_flattened_mut() {
                *vertex = self.slots[*vertex as usize];
            }
        }
        self.forget(&used);
        used
    }

    /// The used vertices, ascending; their slots are no longer free.
    fn mark(&mut self, triangles: &[[u32; 3]], count: usize) -> Vec<u32> {
        if self.slots.len() < count {
            self.slots.resize(count, u32::MAX);
        }
        let mut used = Vec::new();
        for &vertex in triangles.as_flattened() {
            let slot = &mut self.slots[vertex as usize];
            if *slot == u32::MAX {
                *slot = 0;
                used.push(vertex);
            }
        }
        used.sort_unstable();
        used
    }

    fn forget(&mut self, used: &[u32]) {
        for &vertex in used {
            self.slots[vertex as usize] = u32::MAX;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renumbering_keeps_the_order_and_forgets_between_calls() {
        let mut numbers = Renumbering::default();
        let mut triangles = [[9, 4, 7], [4, 9, 2]];
        assert_eq!(numbers.used(&triangles, 10), [2, 4, 7, 9]);
        assert_eq!(numbers.apply(&mut triangles, 10), [2, 4, 7, 9]);
        assert_eq!(triangles, [[3, 1, 2], [1, 3, 0]]);
        let mut triangles = [[5, 4, 3]];
        assert_eq!(numbers.apply(&mut triangles, 6), [3, 4, 5]);
        assert_eq!(triangles, [[2, 1, 0]]);
        assert_eq!(numbers.apply(&mut triangles, 3), [0, 1, 2]);
        assert_eq!(triangles, [[2, 1, 0]], "all are used: each keeps its number");
    }
}
