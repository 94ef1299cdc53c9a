//! Triangles that a plane parts, told before exact signs are asked for.
//!
//! Most candidates are neighbours, and most neighbours lie in one plane or
//! nearly so, where exact signs are dearest. A few directions part nearly all
//! of them. What is said here is proven: every product is held against a bound
//! on its rounding.

use glam::DVec3;

/// Relative to the lengths that are multiplied; rounding is a thousandth of it.
const CLEAR: f64 = 1e-12;

/// Lengths below this are left to the exact signs: their squares may vanish.
const LEAST: f64 = 1e-140;

/// Sine of an angle below which a triangle's height is not trusted.
const THIN: f64 = 1e-6;

/// Whether two triangles certainly have no point in common beyond what they
/// share: `own[k]` is the corner of the second that is corner `k` of the first.
pub(super) fn parted(mine: [DVec3; 3], theirs: [DVec3; 3], own: [Option<usize>; 3]) -> bool {
    let shared: [bool; 3] = own.map(|j| j.is_some());
    let shared_there = [0, 1, 2].map(|j| own.contains(&Some(j)));
    let pick = |flags: [bool; 3], which: bool| (0..3).filter(move |&k| flags[k] == which);
    match shared.iter().filter(|&&s| s).count() {
        0 => apart(mine, theirs),
        1 => {
            let origin = pick(shared, true).map(|k| mine[k]).next();
            let origin = origin.unwrap_or(DVec3::ZERO);
            let rays = |corners: [DVec3; 3], flags| {
                let mut free = pick(flags, false).map(|k| corners[k] - origin);
                [(); 2].map(|()| free.next().unwrap_or(DVec3::ZERO))
            };
            cones_apart(rays(mine, shared), rays(theirs, shared_there))
        }
        2 => {
            let mut edge = pick(shared, true).map(|k| mine[k]);
            let (Some(a), Some(b)) = (edge.next(), edge.next()) else {
                return false;
            };
            let height = |corners: [DVec3; 3], flags| {
                let apex = pick(flags, false).next().map(|k| corners[k] - a)?;
                let square = apex.cross(b - a);
                (square.length() > THIN * apex.length() * a.distance(b)).then_some(square)
            };
            // Folded flat onto each other, these are parallel.
            let heights = (height(mine, shared), height(theirs, shared_there));
            matches!(heights, (Some(x), Some(y)) if x.dot(y) < 0.5 * x.length() * y.length())
        }
        _ => false,
    }
}

/// Without a common corner: along the way between the middles, and across the
/// edges in the triangles' planes.
fn apart(mine: [DVec3; 3], theirs: [DVec3; 3]) -> bool {
    let origin = mine[0];
    let [mine, theirs] = [mine, theirs].map(|t| t.map(|p| p - origin));
    let reach = (mine.iter().chain(&theirs)).fold(0.0, |most: f64, p| most.max(p.length()));
    let parts = |normal: DVec3| {
        let [a, b, c] = mine.map(|p| p.dot(normal));
        let [d, e, f] = theirs.map(|p| p.dot(normal));
        let (gap, length) = (d.min(e).min(f) - a.max(b).max(c), normal.length());
        length > LEAST && reach > LEAST && gap > CLEAR * reach * length
    };
    let middle = |[a, b, c]: [DVec3; 3]| a + b + c;
    let outward = |[a, b, c]: [DVec3; 3]| {
        let normal = (b - a).cross(c - a);
        [b - a, c - b, a - c].map(|edge| edge.cross(normal))
    };
    parts(middle(theirs) - middle(mine))
        || outward(mine).into_iter().any(parts)
        || outward(theirs).into_iter().any(|normal| parts(-normal))
}

/// With one: both as cones from there, parted between the rays nearest to each
/// other or between their middles.
fn cones_apart(mine: [DVec3; 2], theirs: [DVec3; 2]) -> bool {
    let beyond =
        |ray: DVec3, normal: DVec3| ray.dot(normal) > CLEAR * ray.length() * normal.length();
    let parts = |normal: DVec3| {
        mine.iter().all(|&ray| beyond(ray, -normal))
            && theirs.iter().all(|&ray| beyond(ray, normal))
    };
    let [mine, theirs] = [mine, theirs].map(|rays| rays.map(DVec3::normalize_or_zero));
    if parts((theirs[0] + theirs[1]) - (mine[0] + mine[1])) {
        return true;
    }
    let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let nearest = pairs
        .into_iter()
        .max_by(|&(i, j), &(k, l)| mine[i].dot(theirs[j]).total_cmp(&mine[k].dot(theirs[l])));
    nearest.is_some_and(|(i, j)| parts(theirs[j] - mine[i]))
}
