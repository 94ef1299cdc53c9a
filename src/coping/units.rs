//! Tags in other units than their mesh.

use glam::DVec3;

use super::rule::{Condition, TagFile};
use crate::mesh::Bounds;

/// Factors between units that get mixed up.
const FACTORS: [f64; 6] = [1000.0, 1e-3, 25.4, 1.0 / 25.4, 10.0, 0.1];

/// How far outside the part's box, in its diagonals, a place still belongs to it.
const NEAR: f64 = 0.1;

/// The factor that the part would have to be scaled by for the tags' places to lie at
/// it: where no place does as it is and all do then.
///
/// Places are points of planes and flood fills, and boxes. The origin fits every
/// scale and says nothing.
pub(super) fn factor(file: &TagFile, part: &Bounds) -> Option<f64> {
    let conditions = file.rules.iter().flat_map(|rule| &rule.conditions);
    let places: Vec<Bounds> = conditions.filter_map(place).collect();
    if places.is_empty() {
        return None;
    }
    let fits = |place: &Bounds, factor: f64| {
        let margin = NEAR * part.diagonal() * factor;
        let (low, high) = (part.min * factor - margin, part.max * factor + margin);
        place.min.cmple(high).all() && place.max.cmpge(low).all()
    };
    if places.iter().any(|place| fits(place, 1.0)) {
        return None;
    }
    let all = |factor: &f64| places.iter().all(|place| fits(place, *factor));
    FACTORS.into_iter().find(all)
}

fn place(condition: &Condition) -> Option<Bounds> {
    let place = match condition {
        Condition::Plane { point, .. } | Condition::Near { point, .. } => Bounds::of([*point]),
        Condition::Box { min, max, .. } => Bounds {
            min: *min,
            max: *max,
        },
        Condition::Facets(_) | Condition::Names { .. } => return None,
    };
    (place.min != DVec3::ZERO || place.max != DVec3::ZERO).then_some(place)
}
