//! Hollow solids from Catmull-Clark control meshes (after Wang and Cheng, "A
//! Heuristic Offsetting Scheme for Catmull-Clark Subdivision Surfaces").
mod cage;
mod corner;
mod crust;
mod grid;
mod limit;
mod patch;
mod refine;
mod ring;

pub use cage::{Cage, CageError, Polygon};
pub use crust::{Crust, Scheme};
pub use grid::{Grid, Samples};
pub use limit::{Face, LimitSurface, MOST_SAMPLES};
pub use patch::Jet;
pub use refine::{Boundary, Quads, refine};
