//! Small parts and a source of points.

use std::collections::HashMap;

use glam::DVec3;

use crate::field::Field;

/// Indexed triangles with coping tags.
#[derive(Clone, Default)]
pub(in crate::field) struct Shape {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub coping: Vec<bool>,
}

impl Shape {
    pub(in crate::field) fn field(&self) -> Field {
        Field::from_triangles(self.corners(), self.triangles.clone(), self.coping.clone())
    }

    pub(in crate::field) fn corners(&self) -> Vec<[DVec3; 3]> {
        let corner = |v: u32| self.points[v as usize];
        self.triangles.iter().map(|t| t.map(corner)).collect()
    }

    pub(in crate::field) fn map(&self, f: impl Fn(DVec3) -> DVec3) -> Shape {
        let points = self.points.iter().map(|&p| f(p)).collect();
        Shape {
            points,
            ..self.clone()
        }
    }

    pub(in crate::field) fn drop_last(&mut self, count: usize) {
        self.triangles.truncate(self.triangles.len() - count);
        self.coping.truncate(self.triangles.len());
    }

    pub(in crate::field) fn push(&mut self, triangle: [u32; 3], coping: bool) {
        self.triangles.push(triangle);
        self.coping.push(coping);
    }
}

/// Extrudes a polygon (counter-clockwise) along z from 0 to `height`; caps are
/// triangulated by `caps` and tagged as coping.
pub(in crate::field) fn extrude(outline: &[(f64, f64)], caps: &[[u32; 3]], height: f64) -> Shape {
    let n = outline.len() as u32;
    let mut shape = Shape::default();
    for z in [0.0, height] {
        shape
            .points
            .extend(outline.iter().map(|&(x, y)| DVec3::new(x, y, z)));
    }
    for i in 0..n {
        let j = (i + 1) % n;
        shape.push([i, j, n + j], false);
        shape.push([i, n + j, n + i], false);
    }
    for &[a, b, c] in caps {
        shape.push([c, b, a], true);
        shape.push([n + a, n + b, n + c], true);
    }
    shape
}

pub(in crate::field) fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    let outline = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)];
    extrude(&outline, &[[0, 1, 2], [0, 2, 3]], z)
}

/// Flange 4 by 1, web 1 by 3, symmetric about x = 2.
pub(in crate::field) fn tee() -> Shape {
    let outline = [
        (0.0, 0.0),
        (4.0, 0.0),
        (4.0, 1.0),
        (2.5, 1.0),
        (2.5, 4.0),
        (1.5, 4.0),
        (1.5, 1.0),
        (0.0, 1.0),
    ];
    let caps = [
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 6],
        [0, 6, 7],
        [3, 4, 5],
        [3, 5, 6],
    ];
    extrude(&outline, &caps, 3.0)
}

/// Unit icosphere of `20 * 4^levels` triangles.
pub(in crate::field) fn icosphere(levels: u32) -> Shape {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut shape = Shape::default();
    for (s, t) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        shape.points.extend([
            DVec3::new(s, t * g, 0.0),
            DVec3::new(0.0, s, t * g),
            DVec3::new(t * g, 0.0, s),
        ]);
    }
    // The faces of the hull: triples of mutual neighbours, turned outward.
    let p = shape.points.clone();
    let near = |a: usize, b: usize| (p[a].distance(p[b]) - 2.0).abs() < 1e-9;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let out = (p[b] - p[a]).cross(p[c] - p[a]).dot(p[a]) > 0.0;
                    let (b, c) = if out { (b, c) } else { (c, b) };
                    shape.push([a as u32, b as u32, c as u32], false);
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut finer = Shape {
            points: shape.points,
            ..Shape::default()
        };
        for [a, b, c] in shape.triangles {
            let mut middle = |u: u32, v: u32| {
                *middles.entry((u.min(v), u.max(v))).or_insert_with(|| {
                    let m = finer.points[u as usize] + finer.points[v as usize];
                    finer.points.push(m * 0.5);
                    finer.points.len() as u32 - 1
                })
            };
            let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
            for t in [[a, x, z], [x, b, y], [z, y, c], [x, y, z]] {
                finer.push(t, false);
            }
        }
        shape = finer;
    }
    shape.map(|p| p.normalize())
}

/// A bumpy closed surface; every eighth triangle is tagged as coping.
pub(in crate::field) fn bumpy(levels: u32) -> Shape {
    let mut shape = icosphere(levels).map(|p| {
        let bump = (5.0 * p.x).sin() * (4.0 * p.y).cos() + (6.0 * p.z + p.x).sin();
        p * (1.0 + 0.12 * bump)
    });
    for i in (0..shape.coping.len()).step_by(8) {
        shape.coping[i] = true;
    }
    shape
}

/// The shape with a smaller copy of itself, turned inside out, as its hollow.
pub(in crate::field) fn shell(outer: Shape, inner_size: f64) -> Shape {
    let mut shape = outer.map(|p| p * inner_size);
    for t in &mut shape.triangles {
        t.swap(1, 2);
    }
    let n = shape.points.len() as u32;
    shape.points.extend(outer.points);
    for (t, coping) in outer.triangles.into_iter().zip(outer.coping) {
        shape.push(t.map(|v| v + n), coping);
    }
    shape
}

/// Small random numbers without a crate: a linear congruence, upper bits.
pub(in crate::field) struct Dice(pub(in crate::field) u64);

impl Dice {
    pub(in crate::field) fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(in crate::field) fn point(&mut self, (low, high): (DVec3, DVec3)) -> DVec3 {
        let r = DVec3::new(self.unit(), self.unit(), self.unit());
        let margin = (high - low) * 0.2;
        low - margin + (high - low + 2.0 * margin) * r
    }
}

/// Grid over the box and a bit beyond: hits mid-planes, edges and corners.
pub(in crate::field) fn grid((low, high): (DVec3, DVec3), n: i32) -> Vec<DVec3> {
    let mut points = Vec::new();
    for i in -1..=n + 1 {
        for j in -1..=n + 1 {
            for k in -1..=n + 1 {
                let r = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) / f64::from(n);
                points.push(low + (high - low) * r);
            }
        }
    }
    points
}
