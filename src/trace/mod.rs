//! Tracing: the mid-surface followed through the lattice (Bloomenthal 2011,
//! sections 3 and 4).
//!
//! * [`walk`]: from tetrahedron to tetrahedron wherever the mid-surface leads,
//!   in parallel.
//! * [`edge`]: crossings of one lattice edge.
//! * [`follow`]: contours in a face, seams and borders through a tetrahedron.
//! * [`tet`]: loops and triangles of a tetrahedron.
//! * [`feet`]: footpoints of the vertices found.
//! * [`tolerances`]: the lengths by which all of them decide.
//! * [`probe`] and [`solve`]: how the field is asked, and ties solved.

pub mod edge;
pub mod feet;
pub mod follow;
#[cfg(test)]
mod oracle;
pub mod probe;
pub mod solve;
pub mod tet;
pub mod tolerances;
pub mod walk;
