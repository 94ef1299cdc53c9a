//! Tetrahedra of whole walks through simple parts, against labels of the
//! nearest wall.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::store::{Store, inner_vertex};
use super::{BLOCK_BITS, Tracer};
use crate::lattice::{Lattice, TetKey};
use crate::settings::progress::Stop;
use crate::surface::marked::Line;
use crate::trace::oracle::{Dice, Oracle};
use crate::trace::tet::{TetSurface, VertexKey};

/// A finished walk at a cell size, on a lattice shifted by a share of a cell.
fn walked<'a>(
    oracle: &Oracle,
    walls: &'a crate::walls::Walls<'a>,
    cell: f64,
    shift: DVec3,
) -> Tracer<'a> {
    let (low, high) = oracle.field.bounds();
    let lattice = Lattice::covering(low - shift * cell, high, cell).unwrap();
    let mut tracer = Tracer::new(walls, lattice, BLOCK_BITS);
    tracer.run(&|_, _, _| (), &Stop::default()).unwrap();
    tracer
}

/// The two walls of a piece of a sheet: those at all its corners.
fn walls_of(
    oracle: &Oracle,
    store: &mut Store,
    tet: &TetSurface,
    corners: &[VertexKey],
) -> BTreeSet<u32> {
    let mut at = |key: VertexKey| -> BTreeSet<u32> {
        let vertex = match key {
            VertexKey::Inner(_, n) => inner_vertex(&tet.inner[n as usize]),
            _ => store.vertex(key).unwrap(),
        };
        vertex.walls.iter().map(|&w| oracle.of(w)).collect()
    };
    (corners.iter().map(|&c| at(c)))
        .reduce(|all, more| all.intersection(&more).copied().collect())
        .unwrap_or_default()
}

/// Every piece is a closed loop between two walls, and nothing was left open.
fn check_loops(oracle: &Oracle, store: &mut Store, tet: &TetSurface) {
    assert!(
        tet.open.is_empty() && tet.matched == 0,
        "open at {:?}",
        tet.open
    );
    for polygon in &tet.polygons {
        assert!(polygon.corners.len() >= 3);
        assert_eq!(polygon.corners.len(), polygon.lines.len());
        let distinct: BTreeSet<VertexKey> = polygon.corners.iter().copied().collect();
        assert_eq!(distinct.len(), polygon.corners.len(), "{polygon:?}");
        let walls = walls_of(oracle, store, tet, &polygon.corners);
        assert!(walls.len() >= 2, "{walls:?} of {polygon:?}");
    }
    // Sides inside the tetrahedron: a seam takes three pieces or more, every
    // other line one.
    let mut uses: BTreeMap<(VertexKey, VertexKey), (usize, Line)> = BTreeMap::new();
    for polygon in &tet.polygons {
        for (k, &line) in polygon.lines.iter().enumerate() {
            let (a, b) = (
                polygon.corners[k],
                polygon.corners[(k + 1) % polygon.corners.len()],
            );
            let entry = uses.entry((a.min(b), a.max(b))).or_insert((0, line));
            assert_eq!(entry.1, line);
            entry.0 += 1;
        }
    }
    for ((a, b), (count, line)) in uses {
        match line {
            Line::Seam => assert!(count >= 3, "{count} pieces at a seam {a:?} {b:?}"),
            _ => assert_eq!(count, 1, "{line:?} {a:?} {b:?}"),
        }
    }
}

/// Pairs of walls whose labels lie side by side inside a tetrahedron, by more
/// than a few samples.
fn sampled_pairs(oracle: &Oracle, corners: [DVec3; 4]) -> BTreeSet<[u32; 2]> {
    const N: usize = 9;
    let mut count: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let at = |i: usize, j: usize, k: usize| {
        let [a, b, c] = [i, j, k].map(|n| n as f64 / N as f64);
        corners[0]
            + a * (corners[1] - corners[0])
            + b * (corners[2] - corners[0])
            + c * (corners[3] - corners[0])
    };
    let mut labels = BTreeMap::new();
    for i in 0..=N {
        for j in 0..=N - i {
            for k in 0..=N - i - j {
                labels.insert((i, j, k), oracle.label(at(i, j, k)));
            }
        }
    }
    for (&(i, j, k), &here) in &labels {
        for there in [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)] {
            if let (Some(a), Some(Some(b))) = (here, labels.get(&there))
                && a != *b
            {
                *count.entry([a.min(*b), a.max(*b)]).or_default() += 1;
            }
        }
    }
    count
        .into_iter()
        .filter(|c| c.1 >= 4)
        .map(|c| c.0)
        .collect()
}

#[test]
fn tetrahedra_agree_with_the_nearest_walls() {
    let mut dice = Dice(3);
    for (name, cells) in [
        ("plate", [3.0, 9.0]),
        ("ell", [1.4, 5.0]),
        ("tee", [1.4, 5.0]),
        ("cross", [1.4, 5.0]),
    ] {
        let oracle = Oracle::new(name);
        let walls = oracle.walls();
        for cell in cells {
            let shift = dice.point(DVec3::ZERO, DVec3::ONE);
            let tracer = walked(&oracle, &walls, cell, shift);
            let mut keys: Vec<TetKey> = tracer.reached.values().flatten().copied().collect();
            keys.sort_unstable();
            assert!(!keys.is_empty());
            let mut store = tracer.store();
            for &key in &keys {
                let tet = store.tet(key).unwrap();
                check_loops(&oracle, &mut store, &tet);
            }
            // Sampling is slow: some thirty tetrahedra, evenly.
            for key in keys.iter().step_by(keys.len() / 30 + 1) {
                let tet = store.tet(*key).unwrap();
                let pieces: BTreeSet<u32> = (tet.polygons.iter())
                    .flat_map(|p| walls_of(&oracle, &mut store, &tet, &p.corners))
                    .collect();
                let corners = key.nodes().map(|n| tracer.lattice.position(n));
                for pair in sampled_pairs(&oracle, corners) {
                    assert!(
                        pair.iter().all(|wall| pieces.contains(wall)),
                        "{name} at {cell}: no piece between {pair:?} in {corners:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn blocks_of_any_size_give_one_mesh() {
    for (name, cell) in [
        ("tee", 0.7),
        ("tee_rotated", 0.9),
        ("plate_round_edge", 0.9),
        ("bracket", 2.0),
        ("cross", 1.0),
        ("ell_bend", 1.0),
        ("plate_holes", 1.0),
        ("hemisphere_shell", 1.0),
        ("boss_gussets", 1.5),
        ("enclosure", 3.0),
    ] {
        let oracle = Oracle::new(name);
        let walls = oracle.walls();
        let (low, high) = oracle.field.bounds();
        let lattice = Lattice::covering(low, high, cell).unwrap();
        let mesh = |bits: u32| {
            let mut tracer = Tracer::new(&walls, lattice, bits);
            tracer.run(&|_, _, _| (), &Stop::default()).unwrap();
            (
                tracer.reached.len(),
                tracer.counts().tetrahedra,
                tracer.assemble(),
            )
        };
        let (blocks, tets, whole) = mesh(12);
        assert_eq!(blocks, 1);
        let mut counts = BTreeSet::new();
        for bits in [6, 5, 4, 3, 1] {
            let (blocks, again, pieced) = mesh(bits);
            counts.insert(blocks);
            assert_eq!(again, tets, "{name} by blocks of {}", 1 << bits);
            assert_eq!(pieced.triangles, whole.triangles);
            assert_eq!(pieced.lines, whole.lines);
            for (a, b) in pieced.vertices.iter().zip(&whole.vertices) {
                assert_eq!((a.at, &a.walls, a.coping), (b.at, &b.walls, b.coping));
            }
        }
        let some = counts.range(2..=8).count();
        assert!(some > 0 && counts.last() >= Some(&64), "{name}: {counts:?}");
    }
}

#[test]
fn less_memory_makes_smaller_blocks() {
    let bits = [0, 1 << 20, 1 << 24, 1 << 28, 1 << 33, u64::MAX].map(super::block_bits);
    assert!(bits.is_sorted());
    assert_eq!((bits[0], bits[5]), (1, BLOCK_BITS));
}
