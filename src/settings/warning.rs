//! What is told besides a result.

use glam::DVec3;
use serde::Serialize;

/// A warning, for people and for reports.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Names the kind; stable.
    pub code: &'static str,
    /// What is odd, where, and what was done about it.
    pub message: String,
    /// Where, for reports.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<DVec3>,
}

impl Warning {
    /// About no place, or one that the message names.
    pub fn new(code: &'static str, message: impl Into<String>) -> Warning {
        Warning {
            code,
            message: message.into(),
            places: Vec::new(),
        }
    }
}
