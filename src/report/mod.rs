//! What to say of inputs and results, for whoever tells a person: the command,
//! its reports, the Python package.

pub mod bodies;
pub mod detection;
pub mod extraction;
pub mod info;
mod missed;
pub mod words;
