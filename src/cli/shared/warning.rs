//! What is told besides a result.

use glam::DVec3;
use serde::Serialize;

/// A warning for stderr and for reports.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Warning {
    /// Stable.
    pub(crate) code: &'static str,
    pub(crate) message: String,
    /// Where, for reports.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) places: Vec<DVec3>,
}

impl Warning {
    /// About no place, or one that the message names.
    pub(crate) fn new(code: &'static str, message: impl Into<String>) -> Warning {
        Warning {
            code,
            message: message.into(),
            places: Vec::new(),
        }
    }
}
