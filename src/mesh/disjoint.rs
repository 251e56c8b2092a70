//! Disjoint sets (union–find, Tarjan 1975, doi:10.1145/321879.321884). Joined by `join` alone, a set's
//! root is its least number, so that it does not depend on the order of the joins.

/// Sets of numbers 0, 1, 2, …
#[derive(Debug, Clone)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The number that stands for the set of `x`.
    pub fn root(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            self.0[x as usize] = self.0[self.0[x as usize] as usize];
            x = self.0[x as usize];
        }
        x
    }

    /// Make one set of those of `a` and `b`. Returns whether they were two.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// Put the set of root `gone` under root `keep`, where it matters which of the two stays.
    pub fn hang(&mut self, gone: u32, keep: u32) {
        self.0[gone as usize] = keep;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_number_stands_for_its_set() {
        let mut sets = DisjointSets::new(6);
        assert!(sets.join(5, 3) && sets.join(4, 5) && !sets.join(3, 4));
        assert_eq!([0, 1, 2, 3, 4, 5].map(|x| sets.root(x)), [0, 1, 2, 3, 3, 3]);
        assert!(sets.join(4, 0));
        assert_eq!(sets.root(5), 0);
    }
}
