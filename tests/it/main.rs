//! Integration tests, one module a room.

mod bodies;
mod broken_files;
mod cli_input;
mod closes;
mod common;
mod config;
mod detect;
mod elements;
mod end_to_end;
mod exactness;
mod far;
mod files;
mod fuzz;
mod harm;
mod info;
mod invariance;
mod mesh;
mod offset;
mod openings;
mod parts;
mod readers;
mod readme;
mod repair;
mod reports;
mod reshape;
mod rethicken;
mod schema;
mod shell;
mod snapshots;
mod subdivide;
mod surfaces;
mod tags;
mod thicken;
#[cfg(feature = "view")]
mod view;
mod writers;
