//! The `midsurf` command.
fn main() {}
