//! Nearest-point queries: ours cold and warm, and parry3d's, on one mesh.
//!
//! The mesh is a closed freeform surface of 81,920 triangles (a subdivided
//! icosahedron with smooth bumps); the points lie at random in a narrow band of
//! two percent of the diagonal to both sides. One thread.

use std::collections::HashMap;
use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use divan::counter::ItemsCount;
use glam::DVec3;
use midsurf::internals::field::Field;
use midsurf::mesh::FaceId;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

/// Points a round.
const POINTS: usize = 20_000;
/// Rounds; the median is printed.
const ROUNDS: usize = 9;
/// Half width of the band, relative to the diagonal.
const BAND: f64 = 0.02;

static SCENE: LazyLock<Scene> = LazyLock::new(Scene::new);

struct Scene {
    field: Field,
    /// The same surface with one triangle gone: winding number instead of
    /// pseudonormals.
    open: Field,
    parry: TriMesh,
    /// In no order: each query finds the caches cold.
    points: Vec<DVec3>,
    /// One random walk in the band, as a follower would make it.
    walk: Vec<DVec3>,
    /// The walk's previous footpoint.
    hints: Vec<FaceId>,
    diagonal: f64,
}

fn main() {
    if std::env::args().any(|a| a == "--bench") {
        report();
    }
    divan::main();
}

fn report() {
    let s = &*SCENE;
    println!(
        "{} triangles, {POINTS} points, ns a query:",
        s.field.face_count()
    );
    for &p in &s.points {
        let other = s.parry.project_local_point(parry(p), false).point;
        let apart = s.field.footpoint(p).distance - other.distance(parry(p));
        assert!(
            apart.abs() < 1e-12,
            "{p} is {apart:e} off parry3d's distance"
        );
    }
    let mut seen = Vec::new();
    let mut found = Vec::new();
    let reach = s.diagonal * 0.1;
    row("footpoint", || time(&s.points, |p, _| s.field.footpoint(p)));
    row("footpoint, walk", || {
        time(&s.walk, |p, _| s.field.footpoint(p))
    });
    row("footpoint_near, walk", || {
        time(&s.walk, |p, i| s.field.footpoint_near(p, s.hints[i]))
    });
    row("parry3d", || {
        time(&s.points, |p, _| {
            s.parry.project_local_point(parry(p), false)
        })
    });
    row("parry3d, walk", || {
        time(&s.walk, |p, _| s.parry.project_local_point(parry(p), false))
    });
    row("inside", || time(&s.points, |p, _| s.field.inside(p)));
    row("inside, open part", || {
        time(&s.points, |p, _| s.open.inside(p))
    });
    row("footpoints_within 1 %", || {
        time(&s.points, |p, _| {
            s.field.footpoints_within(p, s.diagonal * 0.01, &mut seen)
        })
    });
    row("hits, segment of 10 %", || {
        time(&s.points, |p, _| {
            s.field.hits(p, p + DVec3::X * reach, &mut found)
        })
    });
    let start = Instant::now();
    black_box(surface(6));
    let bare = start.elapsed();
    let start = Instant::now();
    let (points, triangles) = surface(6);
    black_box(field(&points, &triangles));
    println!(
        "{:>24} {:8.0} ms",
        "build",
        (start.elapsed() - bare).as_secs_f64() * 1e3
    );
}

fn row(name: &str, mut round: impl FnMut() -> f64) {
    let mut times: Vec<f64> = (0..ROUNDS).map(|_| round()).collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{name:>24} {:8.0}   (best {:.0})",
        times[ROUNDS / 2],
        times[0]
    );
}

/// Nanoseconds a call.
fn time<R>(points: &[DVec3], mut f: impl FnMut(DVec3, usize) -> R) -> f64 {
    let start = Instant::now();
    for (i, &p) in points.iter().enumerate() {
        black_box(f(black_box(p), i));
    }
    start.elapsed().as_secs_f64() * 1e9 / points.len() as f64
}

#[divan::bench]
fn footpoint(bencher: divan::Bencher) {
    let s = &*SCENE;
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        time(&s.points, |p, _| s.field.footpoint(p));
    });
}

#[divan::bench]
fn footpoint_near(bencher: divan::Bencher) {
    let s = &*SCENE;
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        time(&s.walk, |p, i| s.field.footpoint_near(p, s.hints[i]));
    });
}

#[divan::bench]
fn parry3d(bencher: divan::Bencher) {
    let s = &*SCENE;
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        time(&s.points, |p, _| {
            s.parry.project_local_point(parry(p), false)
        });
    });
}

impl Scene {
    fn new() -> Scene {
        let (points, triangles) = surface(6);
        let field = field(&points, &triangles);
        let open = self::field(&points, &triangles[1..]);
        let vertices = points.iter().copied().map(parry).collect();
        let parry = TriMesh::new(vertices, triangles.clone()).expect("closed surface");
        let (low, high) = field.bounds();
        let diagonal = low.distance(high);
        let mut dice = Dice(1);
        let band: Vec<DVec3> = (0..POINTS)
            .map(|_| {
                let face = FaceId((dice.unit() * triangles.len() as f64) as u32);
                let [a, b, c] = field.corners(face);
                let (u, v) = (dice.unit(), dice.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let height = (dice.unit() * 2.0 - 1.0) * BAND * diagonal;
                a + (b - a) * u + (c - a) * v + field.normal(face) * height
            })
            .collect();
        let mut walk = Vec::new();
        let mut hints = Vec::new();
        let mut p = band[0];
        let mut hint = field.footpoint(p).face;
        for _ in 0..POINTS {
            walk.push(p);
            hints.push(hint);
            let foot = field.footpoint(p);
            hint = foot.face;
            let step = DVec3::new(dice.unit(), dice.unit(), dice.unit()) * 2.0 - 1.0;
            let next = p + step * 0.004 * diagonal;
            // Turned back at the rim of the band.
            let pull = if foot.distance > BAND * diagonal {
                0.2
            } else {
                0.0
            };
            p = next.lerp(foot.point, pull);
        }
        Scene {
            field,
            open,
            parry,
            points: band,
            walk,
            hints,
            diagonal,
        }
    }
}

fn parry(p: DVec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn field(points: &[DVec3], triangles: &[[u32; 3]]) -> Field {
    let corners = triangles
        .iter()
        .map(|t| t.map(|v| points[v as usize]))
        .collect();
    Field::from_triangles(corners, triangles.to_vec(), vec![false; triangles.len()])
}

/// Icosahedron split `levels` times, then pushed out and in by smooth bumps.
fn surface(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (s, t) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        points.push(DVec3::new(s, t * g, 0.0));
        points.push(DVec3::new(0.0, s, t * g));
        points.push(DVec3::new(t * g, 0.0, s));
    }
    let mut triangles = Vec::new();
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let (p, q, r) = (points[a], points[b], points[c]);
                if near(p, q) && near(q, r) && near(r, p) {
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    let (b, c) = if outward { (b, c) } else { (c, b) };
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |u: u32, v: u32| {
                *middles.entry((u.min(v), u.max(v))).or_insert_with(|| {
                    points.push((points[u as usize] + points[v as usize]) * 0.5);
                    points.len() as u32 - 1
                })
            };
            let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
        triangles = finer;
    }
    for p in &mut points {
        let unit = p.normalize();
        let bump = (5.0 * unit.x).sin() * (4.0 * unit.y).cos() + (6.0 * unit.z + unit.x).sin();
        *p = unit * (1.0 + 0.12 * bump);
    }
    (points, triangles)
}

/// Linear congruence, upper bits.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
