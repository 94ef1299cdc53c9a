//! Disjoint sets of small integers.

/// Union-find whose representative is always the lowest member, so that the
/// result does not depend on the order of the joins.
pub(crate) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Sets of one member each.
    pub(crate) fn new(count: usize) -> Sets {
        Sets {
            parent: (0..count as u32).collect(),
        }
    }

    /// Lowest member of the item's set.
    pub(crate) fn find(&mut self, item: u32) -> u32 {
        let mut at = item;
        while self.parent[at as usize] != at {
            // Path halving.
            let up = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = up;
            at = up;
        }
        at
    }

    /// Joins the sets of two items.
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// Consecutive labels in order of lowest member, and how many.
    pub(crate) fn labels(mut self) -> (Vec<u32>, usize) {
        let mut labels = vec![0; self.parent.len()];
        let mut count = 0;
        for item in 0..self.parent.len() as u32 {
            let root = self.find(item);
            if root == item {
                labels[item as usize] = count;
                count += 1;
            } else {
                labels[item as usize] = labels[root as usize];
            }
        }
        (labels, count as usize)
    }
}
