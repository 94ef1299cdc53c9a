//! What commands share: flags, numbers, input, output, and what they say.

pub(crate) mod config;
pub(crate) mod console;
pub(crate) mod elements;
pub(crate) mod failure;
pub(crate) mod figures;
pub(crate) mod groups;
pub(crate) mod input;
pub(crate) mod memory;
pub(crate) mod numbers;
pub(crate) mod pool;
pub(crate) mod progress;
pub(crate) mod reading;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod shell;
pub(crate) mod solid;
