//! What is told besides a result.

use serde::Serialize;

/// A warning, for people and for reports.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Names the kind; stable.
    pub code: &'static str,
    /// What is odd, where, and what was done about it.
    pub message: String,
}
