//! The hybrid edge intersection (section V of the paper), for any function
//! whose elements have closed forms.
//!
//! A closed form guesses the crossing, a query verifies it (equation (8)). If
//! the guess was wrong, the query tells on which side to go on and which
//! element to try next. Where the paper halves, pieces are split at the guess:
//! it is mostly near.

use glam::DVec3;

use super::implicit::{Crossing, Implicit, Sample};

/// Splits after which every other one is in the middle.
const PATIENCE: u8 = 6;

/// Splits after which the piece is some 1e-8 of the edge even if no guess ever
/// helped.
const MOST_SPLITS: u8 = 60;

/// The part of a segment that holds the crossing.
#[derive(Clone, Copy, Debug)]
pub struct Bracket {
    /// The nearer end, from which values grow, then the farther one.
    pub ends: [DVec3; 2],
    /// There.
    pub samples: [Sample; 2],
    /// Closed forms have failed so often that this time a guess that no query
    /// is known to confirm should be left out.
    pub shaky: bool,
}

/// What the search came to.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The crossing, with the element that decides there.
    pub crossing: Crossing,
    /// The farther end's element, if the value leaps over zero at the crossing.
    pub leapt: Option<u32>,
}

/// Finds where a function crosses zero between two samples of opposite sides.
///
/// `outward` is 1 if the nearer end, from which guesses are made, is the one
/// inside the solid, -1 if the one outside. Values below `tolerance` are zero.
/// `guess` gives the fraction of a piece's way at which an element says the
/// crossing is.
pub fn hybrid(
    solid: &impl Implicit,
    ends: [DVec3; 2],
    samples: [Sample; 2],
    outward: f64,
    tolerance: f64,
    guess: impl Fn(&Bracket) -> Option<f64>,
) -> Found {
    let at = |t: f64| ends[0].lerp(ends[1], t);
    let [mut near, mut far] = [(0.0, samples[0]), (1.0, samples[1])];
    if outward * near.1.value > outward * far.1.value {
        (near, far) = (far, near);
    }
    let mut splits = 0;
    loop {
        let bracket = Bracket {
            ends: [at(near.0), at(far.0)],
            samples: [near.1, far.1],
            shaky: splits > PATIENCE && splits % 2 == 0,
        };
        let t = near.0 + guess(&bracket).unwrap_or(0.5) * (far.0 - near.0);
        let sample = solid.sample(at(t), near.1.element);
        let met = sample.value.abs() <= tolerance;
        if met || splits == MOST_SPLITS {
            return Found {
                crossing: Crossing {
                    t,
                    element: sample.element,
                    splits,
                    queries: u32::from(splits) + 1,
                },
                leapt: (!met).then_some(far.1.element),
            };
        }
        splits += 1;
        if outward * sample.value < 0.0 {
            near = (t, sample);
        } else {
            far = (t, sample);
        }
    }
}
