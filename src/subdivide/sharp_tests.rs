//! Creases, corners and holes.

use glam::{DMat3, DQuat, DVec3};

use super::tests::{agrees_with_its_subdivisions, cage, jumps};
use super::*;

const ENDLESS: f64 = INFINITELY_SHARP;

fn creased(name: &str, creases: &[([u32; 2], f64)], corners: &[(u32, f64)]) -> Cage {
    let tags = Tags {
        creases: creases.to_vec(),
        corners: corners.to_vec(),
        ..Tags::default()
    };
    cage(name).tagged(&tags).expect(name)
}

/// Edges of a mesh, each once.
fn edges(cage: &Cage) -> Vec<[u32; 2]> {
    let rings = (0..cage.face_count()).map(|face| cage.face(face));
    let mut edges: Vec<[u32; 2]> = rings
        .flat_map(|ring| (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Every edge of the face at most one of whose vertices is creased like this.
fn around_face(cage: &Cage, face: usize, sharp: f64) -> Vec<([u32; 2], f64)> {
    let ring = cage.face(face);
    let side = |k: usize| [ring[k], ring[(k + 1) % ring.len()]];
    (0..ring.len()).map(|k| (side(k), sharp)).collect()
}

fn surface(cage: &Cage) -> LimitSurface {
    let (mesh, _) = refined(cage, 0, Boundary::default()).expect("small");
    LimitSurface::new(mesh, Boundary::default()).expect("small")
}

/// Semi-sharp edges part no sector of a limit surface, though two of them meet at a vertex.
#[test]
fn creases_that_will_decay_end_no_sector() {
    let creases = around_face(&cage("cube"), 0, 1.0);
    let mesh = Quads::new(creased("cube", &creases, &[])).expect("quadrilaterals");
    let surface = LimitSurface::new(mesh, Boundary::default()).expect("small");
    assert!(surface.normals().iter().all(|n| n.is_finite()));
}

/// Tagged cages of every kind of vertex: creases, darts, corners of one sector
/// and of several, a sharp vertex on no crease, and creases that end at a
/// boundary.
fn tagged() -> Vec<(&'static str, Cage)> {
    let loops = |name: &str| {
        let creases = around_face(&cage(name), 0, ENDLESS);
        creased(name, &creases, &[])
    };
    let path = |name: &str, edges: usize| {
        let mesh = cage(name);
        let first = mesh.fan(0).next().expect("a face");
        let mut creases = vec![([0, mesh.end(first)], ENDLESS)];
        while creases.len() < edges {
            let ([_, from], _) = creases[creases.len() - 1];
            let far = mesh.fan(from).map(|h| mesh.end(h));
            let known = |v: &u32| creases.iter().all(|(edge, _)| !edge.contains(v));
            let to = far.filter(known).last().expect("a way on");
            creases.push(([from, to], ENDLESS));
        }
        creased(name, &creases, &[])
    };
    let all = |name: &str| {
        let creases: Vec<_> = edges(&cage(name))
            .into_iter()
            .map(|e| (e, ENDLESS))
            .collect();
        creased(name, &creases, &[])
    };
    vec![
        ("loop on cube", loops("cube")),
        ("loop on torus", loops("torus")),
        ("loop on valence_mix", loops("valence_mix")),
        ("dart on cube", path("cube", 1)),
        ("darts on valence_mix", path("valence_mix", 3)),
        ("darts on torus", path("torus", 2)),
        ("crease to the rim", path("open_curved", 2)),
        ("all edges of genus3", all("genus3")),
        (
            "sharp vertex",
            creased("cube", &[], &[(0, ENDLESS), (6, ENDLESS)]),
        ),
        (
            "sharp vertex on a loop",
            creased(
                "torus",
                &around_face(&cage("torus"), 0, ENDLESS),
                &[(cage("torus").face(0)[0], ENDLESS)],
            ),
        ),
    ]
}

#[test]
fn creased_faces_are_what_their_subdivisions_are() {
    for (name, cage) in tagged() {
        agrees_with_its_subdivisions(name, &cage, Boundary::default());
    }
}

#[test]
fn a_fully_creased_cube_stays_a_cube() {
    let cube = cage("cube");
    let creases: Vec<_> = edges(&cube).into_iter().map(|e| (e, ENDLESS)).collect();
    let cube = creased("cube", &creases, &[]);
    let half = cube.positions()[0].abs().max_element();
    for scheme in [Scheme::Crust, Scheme::Direct] {
        // A direct wall folds where samples are nearer to a crease than it is thick.
        let levels: &[u32] = if scheme == Scheme::Crust {
            &[0, 1]
        } else {
            &[0]
        };
        for &level in levels {
            let settings = Settings {
                thickness: 0.2 * half,
                samples: 5,
                level: Level::Fixed(level),
                scheme,
                boundary: Boundary::default(),
            };
            let solid = hollow_out(&cube, &settings, &|_| ()).expect("a cube");
            let on = |p: &DVec3, half: f64| (p.abs().max_element() - half).abs() < 1e-14 * half;
            assert!(
                solid.samples.outer.iter().all(|p| on(p, half)),
                "{scheme:?}"
            );
            assert!(
                solid.samples.inner.iter().all(|p| on(p, 0.8 * half)),
                "{scheme:?}"
            );
            let volume = (2.0 * half).powi(3) * (1.0 - 0.8_f64.powi(3));
            assert!((solid.hollow.mesh.volume() / volume - 1.0).abs() < 1e-13);
            let epsilon = solid.trial.epsilon;
            assert!(epsilon.abs() < 1e-13, "{scheme:?} {level}: {epsilon:e}");
            assert_eq!(solid.intersections, [], "{scheme:?} {level}");
            assert_eq!(solid.folded, []);
        }
    }
}

/// Cubic B-spline of a closed polygon, on its side from vertex 0 to vertex 1.
fn spline(polygon: &[DVec3], t: f64) -> DVec3 {
    let n = polygon.len();
    let s = 1.0 - t;
    let weights = [
        s.powi(3) / 6.0,
        (3.0 * t.powi(3) - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s.powi(3) - 6.0 * s * s + 4.0) / 6.0,
        t.powi(3) / 6.0,
    ];
    (0..4).map(|k| weights[k] * polygon[(k + n - 1) % n]).sum()
}

#[test]
fn a_creased_loop_is_the_spline_of_its_vertices() {
    for name in ["cube", "torus", "valence_mix", "head"] {
        let mesh = cage(name);
        let creased = creased(name, &around_face(&mesh, 0, ENDLESS), &[]);
        let surface = surface(&creased);
        let ring: Vec<DVec3> = mesh.face(0).iter().map(|&v| mesh.position(v)).collect();
        let size = mesh.diagonal();
        for side in 0..4 {
            let mut polygon = ring.clone();
            polygon.rotate_left(side);
            let twin = mesh.twin(side as u32).expect("closed");
            for t in [0.0, 0.125, 0.4, 0.5, 0.9, 1.0] {
                let (u, v) = grid::on_side(side as u32, t);
                let (far_u, far_v) = grid::on_side(twin % 4, 1.0 - t);
                let expected = spline(&polygon, t);
                let own = surface.at(0, u, v).point;
                let other = surface.at(twin as usize / 4, far_u, far_v).point;
                assert!(own.distance(expected) < 1e-14 * size, "{name} {side} {t}");
                assert!(other.distance(expected) < 1e-14 * size, "{name} {side} {t}");
            }
        }
    }
}

#[test]
fn sharp_vertices_stay_and_the_sides_of_a_crease_part() {
    let mesh = cage("valence_mix");
    let corner = mesh.face(0)[2];
    let sharp = creased("valence_mix", &[], &[(corner, ENDLESS)]);
    assert_eq!(
        surface(&sharp).limits()[corner as usize],
        mesh.position(corner)
    );

    // What happens inside the loop is nothing to the faces outside.
    let mut positions = mesh.positions().to_vec();
    let inner: Vec<u32> = mesh.face(0).to_vec();
    let creases: Vec<([u32; 2], f64)> = (0..mesh.face_count())
        .filter(|&face| mesh.face(face).contains(&inner[0]))
        .flat_map(|face| around_face(&mesh, face, ENDLESS))
        .filter(|(edge, _)| !edge.contains(&inner[0]))
        .collect();
    let before = surface(&creased("valence_mix", &creases, &[]));
    positions[inner[0] as usize] += DVec3::new(0.1, 0.2, 0.3);
    let faces: Vec<Polygon> = (0..mesh.face_count())
        .map(|face| Polygon::from_slice(mesh.face(face)))
        .collect();
    let tags = Tags {
        creases,
        ..Tags::default()
    };
    let moved = Cage::new(positions, &faces).and_then(|cage| cage.tagged(&tags));
    let after = surface(&moved.expect("sound"));
    let mut apart = 0;
    for face in 0..mesh.face_count() {
        let same = [(0.0, 0.0), (0.3, 0.8), (1.0, 0.5)]
            .iter()
            .all(|&(u, v)| before.at(face, u, v) == after.at(face, u, v));
        let within = mesh.face(face).contains(&inner[0]);
        assert_ne!(same, within, "face {face}");
        apart += usize::from(!within);
    }
    assert!(apart > 0);
}

#[test]
fn surfaces_bend_at_their_creases_alone() {
    let places = [0.5_f64.powi(20), 0.125, 0.5, 0.6875];
    let torus = creased("torus", &around_face(&cage("torus"), 0, ENDLESS), &[]);
    // The loop's vertices are the only ones that are not regular.
    let [regular, across] = jumps(&surface(&torus), &places);
    assert!(regular < 1e-12 && across > 1e-3, "{regular:e} {across:e}");
}

/// Sharp for k steps is infinitely sharp for k steps, then smooth.
#[test]
fn whole_sharpness_is_gone_after_as_many_steps() {
    for name in ["cube", "valence_mix", "open_curved"] {
        let mesh = cage(name);
        for steps in [1_u32, 2, 3] {
            let tag = |sharp: f64| {
                let mut creases = around_face(&mesh, 0, sharp);
                creases.truncate(3);
                creased(name, &creases, &[(mesh.face(1)[1], sharp)])
            };
            let (semi, taken) =
                refined(&tag(f64::from(steps)), 0, Boundary::default()).expect(name);
            assert_eq!(taken, steps, "{name}");
            assert_eq!(semi.cage().steps_to_sharp(), 0);
            let (sharp, _) = refined(&tag(ENDLESS), steps, Boundary::default()).expect(name);
            assert_eq!(
                semi.cage().positions(),
                sharp.cage().positions(),
                "{name} {steps}"
            );
        }
    }
}

/// A fraction of a step blends the smooth and the sharp place of every vertex.
#[test]
fn fractions_blend_the_rules() {
    for name in ["cube", "torus", "valence_mix"] {
        let mesh = cage(name);
        let at = |sharp: f64| {
            let cage = creased(name, &around_face(&mesh, 0, sharp), &[]);
            refine(&cage, Boundary::default())
                .expect(name)
                .cage()
                .positions()
                .to_vec()
        };
        let (smooth, sharp) = (at(0.0), at(1.0));
        for share in [0.25, 0.7] {
            for ((p, &a), &b) in at(share).iter().zip(&smooth).zip(&sharp) {
                assert!(
                    p.distance(a.lerp(b, share)) < 1e-15 * mesh.diagonal(),
                    "{name}"
                );
            }
        }
    }
}

/// The mask of a vertex with two edges of sharpness 0.5 and 0.3, and 1.4 and
/// 0.3, worked out by hand from the rules.
#[test]
fn uneven_sharpness_fades_by_its_mean() {
    let mesh = cage("cube");
    let ring = mesh.face(0).to_vec();
    let step = |first: f64, second: f64| {
        let creases = [([ring[0], ring[1]], first), ([ring[1], ring[2]], second)];
        let cage = creased("cube", &creases, &[]);
        refine(&cage, Boundary::default())
            .expect("cube")
            .cage()
            .position(ring[1])
    };
    let [a, p, b] = [0, 1, 2].map(|k| mesh.position(ring[k]));
    let crease = 0.75 * p + 0.125 * (a + b);
    let smooth = step(0.0, 0.0);
    assert!(step(0.5, 0.3).distance(smooth.lerp(crease, 0.4)) < 1e-15);
    // The first edge stays sharp for another step, so only the second fades, to
    // a dart, which moves as a smooth vertex.
    assert!(step(1.4, 0.3).distance(smooth.lerp(crease, 0.3)) < 1e-15);
}

#[test]
fn turning_and_scaling_the_cage_turns_and_scales_the_surface() {
    let turn = DMat3::from_quat(DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize());
    for (name, cage) in tagged() {
        let faces: Vec<Polygon> = (0..cage.face_count())
            .map(|face| Polygon::from_slice(cage.face(face)))
            .collect();
        let positions = cage.positions().iter().map(|&p| 3.0 * (turn * p)).collect();
        let turned = Cage::new(positions, &faces).and_then(|turned| turned.tagged(&cage.tags()));
        let [plain, turned] = [surface(&cage), surface(&turned.expect(name))];
        for (&m, &n) in plain.mitres().iter().zip(turned.mitres()) {
            assert!((turn * m).distance(n) < 1e-9 * m.length(), "{name} {m} {n}");
        }
        for face in 0..plain.face_count() {
            let (p, q) = (
                plain.at(face, 0.3, 0.8).point,
                turned.at(face, 0.3, 0.8).point,
            );
            assert!(
                (3.0 * (turn * p)).distance(q) < 1e-13 * cage.diagonal(),
                "{name}"
            );
        }
    }
}

#[test]
fn creased_walls_are_closed_and_as_thick_as_asked_at_corners() {
    for (name, cage) in tagged() {
        let settings = Settings {
            thickness: 0.02 * cage.diagonal(),
            samples: 4,
            level: Level::Fixed(1),
            scheme: Scheme::Crust,
            boundary: Boundary::default(),
        };
        let solid = hollow_out(&cage, &settings, &|_| ()).expect(name);
        let census = solid.hollow.mesh.edges().census();
        assert!(census.is_closed(), "{name}: {census:?}");
        let most = solid.thickness.iter().copied().fold(0.0, f64::max);
        assert!(most < settings.thickness * 1.5, "{name}: {most}");
    }
}

#[test]
fn holes_shape_their_neighbours_and_leave_a_rim() {
    let torus = cage("torus");
    let tags = |holes: &[u32]| Tags {
        holes: holes.to_vec(),
        ..Tags::default()
    };
    let open = torus.clone().tagged(&tags(&[0, 1])).expect("two faces");
    assert!(torus.is_closed() && !open.is_closed());
    let settings = Settings {
        thickness: 0.1,
        samples: 3,
        level: Level::Fixed(1),
        scheme: Scheme::Crust,
        boundary: Boundary::default(),
    };
    let [whole, holed] =
        [&torus, &open].map(|cage| hollow_out(cage, &settings, &|_| ()).expect("torus"));
    assert!(holed.hollow.mesh.edges().census().is_closed());
    assert_eq!(holed.hollow.shell, whole.hollow.shell - 2 * 4 * 9 * 2);
    // A subset of the whole one's samples, each with its own thickness.
    for (p, t) in holed.samples.outer.iter().zip(&holed.thickness) {
        let at = whole
            .samples
            .outer
            .iter()
            .position(|q| q == p)
            .expect("the same sample");
        assert!(*t >= whole.thickness[at] * (1.0 - 1e-12));
    }
    let used = holed.hollow.mesh.triangles.as_flattened().iter().max();
    assert_eq!(
        used.map(|&v| v as usize + 1),
        Some(holed.hollow.mesh.positions.len())
    );

    let all: Vec<u32> = (0..torus.face_count() as u32).collect();
    assert_eq!(
        torus.clone().tagged(&tags(&all)).err(),
        Some(CageError::AllHoles)
    );
    let missing = all.len() as u32;
    assert_eq!(
        torus.clone().tagged(&tags(&[0, missing])).err(),
        Some(CageError::NoSuchHole {
            tag: 1,
            face: missing
        })
    );
    // Two faces with one vertex in common alone.
    let touching = (1..torus.face_count()).find(|&face| {
        let shared = torus
            .face(face)
            .iter()
            .filter(|v| torus.face(0).contains(v));
        shared.count() == 1
    });
    let touching = touching.expect("a neighbour") as u32;
    let pinched = torus.clone().tagged(&tags(&[0, touching]));
    assert!(matches!(pinched.err(), Some(CageError::PinchedHole { .. })));
}

/// Without a boundary rule, the faces at the rim only shape the others: those
/// are what they are in the mesh with a rim of any rule.
#[test]
fn no_boundary_rule_takes_the_rim_away() {
    let sheet = cage("open_curved");
    let settings = |boundary| Settings {
        thickness: 0.05,
        samples: 3,
        level: Level::Fixed(1),
        scheme: Scheme::Crust,
        boundary,
    };
    let whole = hollow_out(&sheet, &settings(Boundary::EdgeOnly), &|_| ()).expect("a sheet");
    match hollow_out(&sheet, &settings(Boundary::None), &|_| ()) {
        Ok(inner) => {
            assert!(inner.samples.outer.len() < whole.samples.outer.len());
            assert!(inner.hollow.mesh.edges().census().is_closed());
            let known = |p: &DVec3| whole.samples.outer.contains(p);
            assert!(inner.samples.outer.iter().all(known));
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn tags_of_nothing_are_named() {
    let refused = |creases: &[([u32; 2], f64)], corners: &[(u32, f64)]| {
        let tags = Tags {
            creases: creases.to_vec(),
            corners: corners.to_vec(),
            ..Tags::default()
        };
        cage("cube").tagged(&tags).err()
    };
    let ring = cage("cube").face(0).to_vec();
    let (from, to) = (ring[0], ring[2]);
    let error = CageError::NoSuchEdge { tag: 0, from, to };
    assert_eq!(refused(&[([from, to], 1.0)], &[]), Some(error));
    assert!(refused(&[([0, 99], 1.0)], &[]).is_some());
    let error = CageError::NoSuchCorner { tag: 1, vertex: 8 };
    assert_eq!(refused(&[], &[(0, 1.0), (8, 1.0)]), Some(error));
}

/// Where OpenSubdiv 3.5.0 puts the vertices of the first step in the second, of
/// the cube below: uniform creases, all sharpness exact in single precision.
const OPENSUBDIV: [[f64; 3]; 26] = [
    [0.6770833333333334, -0.6979166666666667, -0.6875],
    [0.6412037037037036, 0.630787037037037, -0.6099537037037037],
    [0.8888888888888888, 0.6597222222222222, 0.6597222222222222],
    [0.7210648148148148, -0.6012731481481481, 0.6116898148148148],
    [-0.6875, -1.0, -0.6875],
    [-0.8020833333333333, -0.8020833333333333, 0.7708333333333333],
    [-0.6018518518518517, 0.6018518518518517, 0.6018518518518517],
    [-0.5092592592592592, 0.5196759259259259, -0.5196759259259259],
    [0.9737413194444444, 0.0048828125, 0.010091145833333336],
    [
        -0.9153645833333334,
        -0.03385416666666667,
        0.007378472222222224,
    ],
    [0.029513888888888895, 0.9168836805555556, -0.001953125],
    [
        -0.006293402777777776,
        -0.9634331597222222,
        -0.021592881944444448,
    ],
    [
        0.025173611111111112,
        -0.002712673611111112,
        0.9176432291666667,
    ],
    [0.015625, -0.026258680555555552, -0.9294704861111112],
    [
        0.7620442708333333,
        -0.012369791666666685,
        -0.7600911458333333,
    ],
    [
        0.9061414930555556,
        0.8763563368055556,
        0.0035264756944444614,
    ],
    [0.9861111111111112, 0.006076388888888881, 0.9314236111111112],
    [
        0.8118489583333334,
        -0.7923177083333334,
        -0.014322916666666671,
    ],
    [-0.96875, -1.0, 0.03125],
    [
        -0.7096354166666667,
        -0.024739583333333343,
        0.7057291666666666,
    ],
    [-0.6640625, 0.6650390625, 0.019856770833333322],
    [
        -0.6653645833333333,
        -0.04850260416666667,
        -0.6663411458333333,
    ],
    [0.028645833333333343, 0.6861979166666667, 0.6861979166666666],
    [
        0.021484374999999983,
        0.6979166666666667,
        -0.6959635416666667,
    ],
    [
        0.010416666666666671,
        -0.9791666666666667,
        -0.9479166666666667,
    ],
    [
        -0.007486979166666671,
        -0.7054036458333334,
        0.7024739583333334,
    ],
];

#[test]
fn semi_sharp_steps_are_those_of_opensubdiv() {
    let creases = [
        ([0, 1], 0.5),
        ([1, 2], 1.5),
        ([2, 3], 10.0),
        ([3, 0], 0.75),
        ([4, 5], 2.25),
        ([0, 4], 10.0),
        ([1, 7], 0.25),
    ];
    let cage = creased("cube", &creases, &[(6, 0.5), (5, 1.25)]);
    let one = refine(&cage, Boundary::default()).expect("a step");
    let two = refine(one.cage(), Boundary::default()).expect("a step");
    // A vertex keeps its number.
    let ours = &two.cage().positions()[..one.cage().positions().len()];
    assert_eq!(ours.len(), OPENSUBDIV.len());
    for theirs in OPENSUBDIV.map(DVec3::from_array) {
        let nearest = ours.iter().map(|p| p.distance(theirs));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-14, "{theirs}: {nearest:e}");
    }
}
