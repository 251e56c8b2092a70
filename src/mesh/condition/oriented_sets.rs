//! Disjoint sets with parity: which faces hang together, and which of them are wound against each other
//! (union–find, Tarjan 1975, doi:10.1145/321879.321884, with a sign on each link).

/// Disjoint sets of faces, each with the way it is wound against the face that stands for its set.
pub struct OrientedSets {
    above: Vec<u32>,
    against: Vec<bool>,
}

impl OrientedSets {
    /// `count` sets of one face each.
    pub fn new(count: usize) -> Self {
        Self { above: (0..count as u32).collect(), against: vec![false; count] }
    }

    /// The face that stands for the set of `f`, and whether `f` is wound against it.
    fn root(&mut self, f: u32) -> (u32, bool) {
        let (mut root, mut against) = (f, false);
        while self.above[root as usize] != root {
            against ^= self.against[root as usize];
            root = self.above[root as usize];
        }
        let (mut at, mut own) = (f, against);
        while self.above[at as usize] != root && at != root {
            let next = self.above[at as usize];
            let step = std::mem::replace(&mut self.against[at as usize], own);
            self.above[at as usize] = root;
            own ^= step;
            at = next;
        }
        (root, against)
    }

    /// Make one set of those of two faces, which are wound against each other or not. Returns whether that can
    /// be so.
    pub fn join(&mut self, f: u32, g: u32, against: bool) -> bool {
        let ((a, of_f), (b, of_g)) = (self.root(f), self.root(g));
        if a == b {
            return (of_f ^ of_g) == against;
        }
        self.above[a.max(b) as usize] = a.min(b);
        self.against[a.max(b) as usize] = of_f ^ of_g ^ against;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_with_one_turn_too_many_is_refused() {
        let mut sets = OrientedSets::new(5);
        assert!(sets.join(0, 1, false) && sets.join(1, 2, true) && sets.join(3, 4, true));
        assert!(sets.join(2, 0, true) && !sets.join(2, 0, false));
        assert!(sets.join(4, 2, false), "another set is wound as is needed");
        assert!(sets.join(3, 0, false) && !sets.join(3, 0, true));
        assert_eq!(
            [0, 1, 2, 3, 4].map(|f| sets.root(f)),
            [(0, false), (0, false), (0, true), (0, false), (0, true)]
        );
    }
}
