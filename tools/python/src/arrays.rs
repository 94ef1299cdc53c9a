//! Numpy arrays in and out.
//!
//! Meshes go out as they lie in memory: the arrays take their memory over, or
//! look at it and keep its owner alive. Of what comes in one copy is made,
//! which the library then owns.
#![allow(unsafe_code)]

use std::mem::{ManuallyDrop, align_of, offset_of, size_of};

use glam::DVec3;
use midsurf::mesh::TriMesh;
use midsurf::surface::{MidTriangle, MidVertex};
use numpy::ndarray::{ArrayView1, ArrayView2, ShapeBuilder};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::surface::Surface;

/// Rows of three numbers.
pub(crate) type Rows<'py, T> = Bound<'py, PyArray2<T>>;

/// A mesh of arrays; whether its corners exist is asked elsewhere.
pub(crate) fn mesh_in(
    vertices: &PyReadonlyArray2<'_, f64>,
    triangles: &PyReadonlyArray2<'_, u32>,
) -> TriMesh {
    let triangles = triangles.as_array();
    TriMesh {
        positions: points_in(vertices),
        triangles: (triangles.rows().into_iter())
            .map(|row| [row[0], row[1], row[2]])
            .collect(),
    }
}

/// Points of three columns.
pub(crate) fn points_in(points: &PyReadonlyArray2<'_, f64>) -> Vec<DVec3> {
    let points = points.as_array();
    let rows = points.rows().into_iter();
    rows.map(|row| DVec3::new(row[0], row[1], row[2])).collect()
}

/// Whether both arrays have three columns.
pub(crate) fn are_triples(
    vertices: &PyReadonlyArray2<'_, f64>,
    triangles: &PyReadonlyArray2<'_, u32>,
) -> bool {
    vertices.shape()[1] == 3 && triangles.shape()[1] == 3
}

/// The arrays of a mesh, which take its memory over.
pub(crate) fn mesh_out(py: Python<'_>, mesh: TriMesh) -> PyResult<(Rows<'_, f64>, Rows<'_, u32>)> {
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    let positions = PyArray1::from_vec(py, flat(mesh.positions));
    let corners = PyArray1::from_vec(py, mesh.triangles.into_flattened());
    Ok((
        positions.reshape([vertices, 3])?,
        corners.reshape([triangles, 3])?,
    ))
}

/// Points as numbers, in the same memory.
pub(crate) fn flat(points: Vec<DVec3>) -> Vec<f64> {
    const { assert!(size_of::<DVec3>() == 3 * size_of::<f64>()) };
    const { assert!(align_of::<DVec3>() == align_of::<f64>()) };
    let mut points = ManuallyDrop::new(points);
    let (first, len, room) = (points.as_mut_ptr(), points.len(), points.capacity());
    // SAFETY: `DVec3` is three f64 in order (`repr(C)`), without gaps and aligned
    // as these, by the two lines above; so length and room are three times as many
    // of the same allocation, which nobody else frees.
    unsafe { Vec::from_raw_parts(first.cast::<f64>(), 3 * len, 3 * room) }
}

/// What can be looked at of a vertex or a triangle.
#[derive(Clone, Copy)]
pub(crate) enum Field {
    /// Position of a vertex: three f64.
    Position,
    /// Thickness at a vertex: one f64.
    Thickness,
    /// Radius of the ball at a vertex: one f64.
    Radius,
    /// Corners of a triangle: three u32.
    Corners,
    /// Sheet of a triangle: one u32.
    Sheet,
}

impl Field {
    /// Bytes from the start of a vertex or triangle.
    fn offset(self) -> usize {
        match self {
            Field::Position => offset_of!(MidVertex, position),
            Field::Thickness => offset_of!(MidVertex, ball.thickness),
            Field::Radius => offset_of!(MidVertex, ball.radius),
            Field::Corners => offset_of!(MidTriangle, corners),
            Field::Sheet => offset_of!(MidTriangle, sheet),
        }
    }
}

/// A number at every vertex, in the surface's own memory.
pub(crate) fn vertex_numbers(of: Bound<'_, Surface>, field: Field) -> Bound<'_, PyArray1<f64>> {
    let vertices = of.get().surface().vertices();
    let (count, first) = (vertices.len(), vertices.as_ptr().cast::<u8>());
    numbers::<f64>(of, first, count, size_of::<MidVertex>(), field)
}

/// Three numbers at every vertex, in the surface's own memory.
pub(crate) fn vertex_rows(of: Bound<'_, Surface>, field: Field) -> Rows<'_, f64> {
    let vertices = of.get().surface().vertices();
    let (count, first) = (vertices.len(), vertices.as_ptr().cast::<u8>());
    rows::<f64>(of, first, count, size_of::<MidVertex>(), field)
}

/// A number of every triangle, in the surface's own memory.
pub(crate) fn triangle_numbers(of: Bound<'_, Surface>, field: Field) -> Bound<'_, PyArray1<u32>> {
    let triangles = of.get().surface().triangles();
    let (count, first) = (triangles.len(), triangles.as_ptr().cast::<u8>());
    numbers::<u32>(of, first, count, size_of::<MidTriangle>(), field)
}

/// Three numbers of every triangle, in the surface's own memory.
pub(crate) fn triangle_rows(of: Bound<'_, Surface>, field: Field) -> Rows<'_, u32> {
    let triangles = of.get().surface().triangles();
    let (count, first) = (triangles.len(), triangles.as_ptr().cast::<u8>());
    rows::<u32>(of, first, count, size_of::<MidTriangle>(), field)
}

fn numbers<T: Element>(
    of: Bound<'_, Surface>,
    first: *const u8,
    count: usize,
    stride: usize,
    field: Field,
) -> Bound<'_, PyArray1<T>> {
    if count == 0 {
        return PyArray1::from_vec(of.py(), Vec::new());
    }
    const { assert!(size_of::<MidVertex>().is_multiple_of(size_of::<f64>())) };
    const { assert!(size_of::<MidTriangle>().is_multiple_of(size_of::<u32>())) };
    // SAFETY: `first` is that of `count` things of `stride` bytes, each with a `T` at
    // the field's offset; strides are whole numbers of `T`, by the two lines above.
    // The surface is frozen and its memory never moves, and the array keeps it alive.
    let array = unsafe {
        let shape = count.strides(stride / size_of::<T>());
        let view = ArrayView1::from_shape_ptr(shape, first.add(field.offset()).cast::<T>());
        PyArray1::borrow_from_array(&view, of.into_any())
    };
    array.readwrite().make_nonwriteable();
    array
}

fn rows<T: Element>(
    of: Bound<'_, Surface>,
    first: *const u8,
    count: usize,
    stride: usize,
    field: Field,
) -> Rows<'_, T> {
    if count == 0 {
        return PyArray2::zeros(of.py(), [0, 3], false);
    }
    // SAFETY: as in `numbers`, with three `T` in a row.
    let array = unsafe {
        let shape = (count, 3).strides((stride / size_of::<T>(), 1));
        let view = ArrayView2::from_shape_ptr(shape, first.add(field.offset()).cast::<T>());
        PyArray2::borrow_from_array(&view, of.into_any())
    };
    array.readwrite().make_nonwriteable();
    array
}
