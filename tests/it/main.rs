//! Integration tests, one module a room.

mod broken_files;
mod cli_input;
mod common;
mod parts;
mod readers;
mod tags;
mod writers;
