//! Parts with known mid-surfaces, their dimensions drawn by number.

use glam::{DVec2, DVec3};
use midsurf::mesh::TriMesh;

use crate::{Given, Random, Shape};

/// Wall thickness about which all dimensions are drawn.
pub const THICKNESS: f64 = 2.0;

/// Families made here, and whether their dimensions vary.
pub const FAMILIES: [(&str, bool); 10] = [
    ("torus", false),
    ("wye", false),
    ("wyes", true),
    ("ells", true),
    ("slants", true),
    ("tapers", true),
    ("steps", true),
    ("ribs", true),
    ("grids", true),
    ("engravings", true),
];

/// A part of a family.
pub fn make(family: &str, random: &mut Random) -> Option<Given> {
    Some(match family {
        "torus" => torus(),
        "wye" => star([0, 1, 2].map(|k| (120.0 * f64::from(k), 1.0))),
        "wyes" => wyes(random),
        "ells" => ells(random),
        "slants" => slants(random),
        "tapers" => tapers(random),
        "steps" => steps(random),
        "ribs" => ribs(random),
        "grids" => grids(random),
        "engravings" => engravings(random),
        _ => return None,
    })
}

/// A surface without fading borders that shrinks to a point.
const fn disk(sheets: u32, seams: usize, junctions: usize) -> Shape {
    Shape {
        sheets,
        seams,
        junctions,
        fading: 0,
        euler: 1,
    }
}

/// A closed tube: two tori one in the other, each of `ROUND` by `ACROSS` quads.
fn torus() -> Given {
    const ROUND: u32 = 64;
    const ACROSS: u32 = 32;
    const RADIUS: f64 = 12.0;
    let turn = |k: u32, n: u32| std::f64::consts::TAU * f64::from(k % n) / f64::from(n);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (tube, outwards) in [(4.0, true), (3.0, false)] {
        let first = positions.len() as u32;
        for i in 0..ROUND {
            for j in 0..ACROSS {
                let (u, v) = (turn(i, ROUND), turn(j, ACROSS));
                let from_axis = RADIUS + tube * v.cos();
                positions.push(DVec3::new(
                    from_axis * u.cos(),
                    from_axis * u.sin(),
                    tube * v.sin(),
                ));
            }
        }
        let at = |i: u32, j: u32| first + (i % ROUND) * ACROSS + j % ACROSS;
        for (i, j) in (0..ROUND).flat_map(|i| (0..ACROSS).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let halves = [[a, b, c], [a, c, d]];
            triangles.extend(halves.map(|[p, q, r]| if outwards { [p, q, r] } else { [p, r, q] }));
        }
    }
    Given {
        coping: vec![false; triangles.len()],
        mesh: TriMesh {
            positions,
            triangles,
        },
        want: Some(Shape {
            euler: 0,
            ..disk(1, 0, 0)
        }),
    }
}

/// A counter-clockwise outline; whether the side that starts at a corner closes
/// a wall.
type Outline = Vec<(DVec2, bool)>;

/// Plates that meet along a line: directions in degrees, ascending, and
/// thicknesses in those of the family.
fn star<const N: usize>(arms: [(f64, f64); N]) -> Given {
    const LENGTH: f64 = 14.0;
    let arm = |k: usize| {
        let (angle, thickness) = arms[k % N];
        let along = DVec2::from_angle(angle.to_radians());
        (along, along.perp(), 0.5 * THICKNESS * thickness)
    };
    let mut outline = Outline::new();
    for k in 0..N {
        let (along, left, half) = arm(k);
        let (next, right, other) = arm(k + 1);
        outline.push((LENGTH * along - half * left, true));
        outline.push((LENGTH * along + half * left, false));
        // Where the left face of this arm meets the right face of the next.
        let way = (-other * right - half * left).perp_dot(next) / along.perp_dot(next);
        outline.push((half * left + way * along, false));
    }
    let want = if N == 2 {
        disk(1, 0, 0)
    } else {
        disk(N as u32, 1, 0)
    };
    extruded(&outline, 12.0, want)
}

fn wyes(random: &mut Random) -> Given {
    let first = random.between(85.0, 150.0);
    let second = first + random.between(85.0_f64.max(205.0 - first), 150.0);
    let thickness = [(); 3].map(|()| random.between(0.6, 1.4));
    star([
        (0.0, thickness[0]),
        (first, thickness[1]),
        (second, thickness[2]),
    ])
}

fn ells(random: &mut Random) -> Given {
    let angle = random.between(60.0, 150.0);
    star([
        (0.0, random.between(0.6, 1.4)),
        (angle, random.between(0.6, 1.4)),
    ])
}

/// A plate with a web that leans.
fn slants(random: &mut Random) -> Given {
    let lean = DVec2::from_angle(random.between(40.0, 90.0).to_radians());
    let (half, length) = (0.5 * THICKNESS * random.between(0.4, 1.3), 14.0);
    let foot = |side: f64| {
        let start = half * side * -lean.perp();
        let x = start.x + lean.x * (THICKNESS - start.y) / lean.y;
        DVec2::new(x, THICKNESS)
    };
    let (right, left) = (foot(1.0), foot(-1.0));
    let end = |side: f64| (length + THICKNESS) * lean + half * side * -lean.perp();
    let outline = vec![
        (DVec2::new(-18.0, 0.0), false),
        (DVec2::new(22.0, 0.0), true),
        (DVec2::new(22.0, THICKNESS), false),
        (right, false),
        (end(1.0), true),
        (end(-1.0), false),
        (left, false),
        (DVec2::new(-18.0, THICKNESS), true),
    ];
    extruded(&outline, 12.0, disk(3, 1, 0))
}

fn tapers(random: &mut Random) -> Given {
    let (thin, thick) = (random.between(0.3, 0.9), random.between(1.0, 2.0));
    let lean = random.between(0.0, thick - thin);
    let outline = [
        (0.0, 0.0, false),
        (30.0, lean, true),
        (30.0, lean + thin, false),
        (0.0, thick, true),
    ];
    extruded(
        &outline.map(|(x, y, end)| (DVec2::new(x, THICKNESS * y), end)),
        16.0,
        disk(1, 0, 0),
    )
}

fn steps(random: &mut Random) -> Given {
    let mut height = random.between(0.7, 1.0);
    let mut tops = vec![(0.0, height)];
    for k in 1..=2 {
        let x = 12.0 * f64::from(k);
        tops.push((x, height));
        height *= random.between(1.1, 1.5);
        tops.push((x, height));
    }
    tops.push((36.0, height));
    let ends = [(DVec2::ZERO, false), (DVec2::new(36.0, 0.0), true)];
    let top = (tops.iter().rev().enumerate())
        .map(|(k, &(x, y))| (DVec2::new(x, THICKNESS * y), k + 1 == tops.len()));
    let outline: Outline = ends.into_iter().chain(top).collect();
    extruded(&outline, 12.0, disk(1, 0, 0))
}

/// A plate with webs across it.
fn ribs(random: &mut Random) -> Given {
    const APART: f64 = 12.0;
    let count = 1 + (4.0 * random.unit()) as usize;
    let length = APART * (count + 1) as f64;
    let mut outline = vec![
        (DVec2::ZERO, false),
        (DVec2::new(length, 0.0), true),
        (DVec2::new(length, THICKNESS), false),
    ];
    for k in (1..=count).rev() {
        let x = APART * k as f64 + random.between(-2.0, 2.0);
        let half = 0.5 * THICKNESS * random.between(0.3, 1.3);
        let top = THICKNESS + random.between(7.0, 12.0);
        outline.extend([
            (DVec2::new(x + half, THICKNESS), false),
            (DVec2::new(x + half, top), true),
            (DVec2::new(x - half, top), false),
            (DVec2::new(x - half, THICKNESS), false),
        ]);
    }
    outline.push((DVec2::new(0.0, THICKNESS), true));
    extruded(&outline, 12.0, disk(2 * count as u32 + 1, count, 0))
}

/// A plate with webs that cross.
fn grids(random: &mut Random) -> Given {
    let mut webs = || {
        let count = 1 + (2.0 * random.unit()) as usize;
        let mut lines = vec![0.0];
        for k in 1..=count {
            let x = 12.0 * k as f64;
            let half = 0.5 * THICKNESS * random.between(0.4, 1.2);
            lines.extend([x - half, x + half]);
        }
        lines.push(12.0 * (count + 1) as f64);
        (count, lines)
    };
    let ((n, xs), (m, ys)) = (webs(), webs());
    let top = THICKNESS + random.between(7.0, 12.0);
    let zs = [0.0, THICKNESS, top];
    let solid = |i: usize, j: usize, k: usize| k == 0 || i % 2 == 1 || j % 2 == 1;
    let (width, depth) = (xs[xs.len() - 1], ys[ys.len() - 1]);
    let is_end = |p: DVec3, normal: DVec3| {
        let side = normal.x * (p.x - 0.5 * width) + normal.y * (p.y - 0.5 * depth);
        let outer = normal.x.abs() * 0.5 * width + normal.y.abs() * 0.5 * depth;
        (normal.z == 0.0 && (side - outer).abs() < 1e-9) || p.z > 0.999 * top
    };
    let webs = n * (m + 1) + m * (n + 1);
    let want = disk(((n + 1) * (m + 1) + webs) as u32, webs + n * m, n * m);
    blocks([&xs, &ys, &zs], solid, is_end, want)
}

/// A plate with grooves cut into its face that end on it.
fn engravings(random: &mut Random) -> Given {
    let width = THICKNESS * random.between(0.3, 2.0);
    let depth = THICKNESS * random.between(0.05, 0.5);
    let xs = [0.0, 6.0, 6.0 + width, 20.0, 20.0 + width, 34.0];
    let ys = [0.0, 5.0, 5.0 + random.between(4.0, 14.0), 24.0];
    let zs = [0.0, THICKNESS - depth, THICKNESS];
    let solid = |i: usize, j: usize, k: usize| k == 0 || i.is_multiple_of(2) || j != 1;
    let is_end = |p: DVec3, normal: DVec3| {
        let at = |x: f64, end: f64| x == 0.0 || x == end;
        (normal.x != 0.0 && at(p.x, 34.0)) || (normal.y != 0.0 && at(p.y, 24.0))
    };
    blocks([&xs, &ys, &zs], solid, is_end, disk(1, 0, 0))
}

/// An outline in the plane, `height` long across it; both caps close walls.
fn extruded(outline: &[(DVec2, bool)], height: f64, want: Shape) -> Given {
    let n = outline.len() as u32;
    let points: Vec<DVec2> = outline.iter().map(|o| o.0).collect();
    let low = points.iter().map(|p| p.extend(0.0));
    let positions = low.chain(points.iter().map(|p| p.extend(height))).collect();
    let (mut triangles, mut coping) = (Vec::new(), Vec::new());
    for [a, b, c] in ears(&points) {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
        coping.extend([true; 2]);
    }
    for a in 0..n {
        let b = (a + 1) % n;
        triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        coping.extend([outline[a as usize].1; 2]);
    }
    Given {
        mesh: TriMesh {
            positions,
            triangles,
        },
        coping,
        want: Some(want),
    }
}

/// Triangles of a counter-clockwise outline, the ear of the best shape first.
fn ears(points: &[DVec2]) -> Vec<[u32; 3]> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let area =
        |a: usize, b: usize, c: usize| (points[b] - points[a]).perp_dot(points[c] - points[a]);
    let mut triangles = Vec::new();
    while left.len() > 2 {
        let n = left.len();
        let corner = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
        let is_ear = |k: &usize| {
            let [a, b, c] = corner(*k);
            let within =
                |p: usize| area(a, b, p) >= 0.0 && area(b, c, p) >= 0.0 && area(c, a, p) >= 0.0;
            let others = left.iter().filter(|&&p| p != a && p != b && p != c);
            area(a, b, c) > 0.0 && !others.copied().any(within)
        };
        let height = |k: usize| {
            let [a, b, c] = corner(k);
            let square = |p: usize, q: usize| points[p].distance_squared(points[q]);
            area(a, b, c) / square(a, b).max(square(b, c)).max(square(c, a))
        };
        let ear = (0..n)
            .filter(is_ear)
            .max_by(|&i, &j| height(i).total_cmp(&height(j)));
        let ear = ear.expect("an outline that does not cross itself");
        triangles.push(corner(ear).map(|v| v as u32));
        left.remove(ear);
    }
    triangles
}

/// The boundary of the solid blocks between planes across the three axes;
/// `is_end` says of a rectangle, by its middle and outward normal, whether it
/// closes a wall. No two solid blocks meet in an edge or a corner alone.
fn blocks(
    planes: [&[f64]; 3],
    solid: impl Fn(usize, usize, usize) -> bool,
    is_end: impl Fn(DVec3, DVec3) -> bool,
    want: Shape,
) -> Given {
    let count = planes.map(|p| p.len());
    let at = |i: [usize; 3]| DVec3::from_array([0, 1, 2].map(|a| planes[a][i[a]]));
    let filled = |i: [i64; 3]| {
        let inside = (0..3).all(|a| (0..count[a] as i64 - 1).contains(&i[a]));
        inside && solid(i[0] as usize, i[1] as usize, i[2] as usize)
    };
    let (mut positions, mut triangles, mut coping) = (Vec::new(), Vec::new(), Vec::new());
    let mut numbers = std::collections::BTreeMap::new();
    let cells = (0..count[0] - 1)
        .flat_map(|i| (0..count[1] - 1).map(move |j| (i, j)))
        .flat_map(|(i, j)| (0..count[2] - 1).map(move |k| [i, j, k]));
    for cell in cells.filter(|&[i, j, k]| solid(i, j, k)) {
        for (axis, up) in [0, 1, 2].into_iter().flat_map(|a| [(a, false), (a, true)]) {
            let mut beside = cell.map(|i| i as i64);
            beside[axis] += if up { 1 } else { -1 };
            if filled(beside) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |s: usize, t: usize| {
                let mut i = cell;
                i[axis] += usize::from(up);
                i[u] += s;
                i[v] += t;
                i
            };
            let mut ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            if !up {
                ring.reverse();
            }
            let middle = 0.5 * (at(ring[0]) + at(ring[2]));
            let mut normal = DVec3::ZERO;
            normal[axis] = if up { 1.0 } else { -1.0 };
            let [a, b, c, d] = ring.map(|i| {
                *numbers.entry(i).or_insert_with(|| {
                    positions.push(at(i));
                    positions.len() as u32 - 1
                })
            });
            triangles.extend([[a, b, c], [a, c, d]]);
            coping.extend([is_end(middle, normal); 2]);
        }
    }
    Given {
        mesh: TriMesh {
            positions,
            triangles,
        },
        coping,
        want: Some(want),
    }
}
