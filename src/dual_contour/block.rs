//! Blocks of 8 x 8 x 8 nodes: how they are numbered, and what is kept of them.

use glam::IVec3;

/// Nodes along a block.
pub(super) const SIDE: i32 = 8;
/// Nodes of a block.
const NODES: usize = 512;

/// One bit a node of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Bits([u64; NODES / 64]);

impl Bits {
    #[inline]
    pub fn get(&self, i: usize) -> bool {
        self.0[i / 64] >> (i % 64) & 1 != 0
    }

    #[inline]
    pub fn set(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }

    /// Number of bits set below `i`.
    #[inline]
    pub fn rank(&self, i: usize) -> usize {
        let whole: u32 = self.0[..i / 64].iter().map(|w| w.count_ones()).sum();
        (whole + (self.0[i / 64] & ((1 << (i % 64)) - 1)).count_ones()) as usize
    }

    pub fn or(&mut self, other: &Bits) {
        for (word, more) in self.0.iter_mut().zip(other.0) {
            *word |= more;
        }
    }

    pub fn count(&self) -> usize {
        self.0.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Bits set, in order.
    pub fn ones(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(w, &word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                (rest != 0).then(|| {
                    let bit = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    w * 64 + bit
                })
            })
        })
    }

    /// By node, the bit of the next node along an axis; `beyond` is the next
    /// block, all zeros if there is none.
    pub fn step_down(&self, beyond: Option<&Bits>, axis: usize) -> Bits {
        let zero = Bits::default();
        let (own, next) = (&self.0, &beyond.unwrap_or(&zero).0);
        Bits(std::array::from_fn(|z| match axis {
            0 => {
                let last = 0x8080_8080_8080_8080;
                (own[z] >> 1 & !last) | (next[z] << 7 & last)
            }
            1 => own[z] >> 8 | next[z] << 56,
            _ => {
                if z + 1 < own.len() {
                    own[z + 1]
                } else {
                    next[0]
                }
            }
        }))
    }

    fn each(&self, other: &Bits, with: impl Fn(u64, u64) -> u64) -> Bits {
        Bits(std::array::from_fn(|i| with(self.0[i], other.0[i])))
    }

    pub fn xor(&self, other: &Bits) -> Bits {
        self.each(other, |a, b| a ^ b)
    }

    pub fn and(&self, other: &Bits) -> Bits {
        self.each(other, |a, b| a & b)
    }

    pub fn without(&self, other: &Bits) -> Bits {
        self.each(other, |a, b| a & !b)
    }

    pub fn is_empty(&self) -> bool {
        self.0 == [0; NODES / 64]
    }

    pub fn put(&mut self, i: usize, value: bool) {
        let bit = 1 << (i % 64);
        if value {
            self.0[i / 64] |= bit;
        } else {
            self.0[i / 64] &= !bit;
        }
    }
}

/// Nodes of a block in the layer at its lower or upper side across an axis.
pub(super) fn layer(axis: usize, upper: bool) -> Bits {
    let at = if upper { SIDE as usize - 1 } else { 0 };
    Bits(std::array::from_fn(|z| match axis {
        0 => 0x0101_0101_0101_0101 << at,
        1 => 0xff << (8 * at),
        _ => {
            if z == at {
                u64::MAX
            } else {
                0
            }
        }
    }))
}

/// Number of a node within its block; x runs fastest.
#[inline]
pub(super) fn local(at: IVec3) -> usize {
    let l = at & IVec3::splat(SIDE - 1);
    (l.x + SIDE * (l.y + SIDE * l.z)) as usize
}

/// Block of a node.
#[inline]
pub(super) fn block_of(at: IVec3) -> IVec3 {
    at >> 3
}

/// Node with a local number in a block.
pub(super) fn node_of(key: IVec3, local: usize) -> IVec3 {
    let l = local as i32;
    key * SIDE + IVec3::new(l % SIDE, l / SIDE % SIDE, l / (SIDE * SIDE))
}

/// Nodes `SIDE * key` up to `SIDE * key + 7` along each axis.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub key: IVec3,
    /// Valid nodes.
    pub valid: Bits,
    /// Nodes inside the solid, valid or not.
    pub inside: Bits,
    /// Nearest element of each valid node.
    pub elements: Vec<u32>,
}

impl Block {
    pub fn empty(key: IVec3) -> Block {
        Block {
            key,
            valid: Bits::default(),
            inside: Bits::default(),
            elements: Vec::new(),
        }
    }

    /// Makes a node valid.
    pub fn learn(&mut self, at: usize, inside: bool, element: u32) {
        let rank = self.valid.rank(at);
        if self.valid.get(at) {
            self.elements[rank] = element;
        } else {
            self.valid.set(at);
            self.elements.insert(rank, element);
        }
        self.inside.put(at, inside);
    }
}
