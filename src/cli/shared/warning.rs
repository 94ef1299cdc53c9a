//! What is told besides a result.

use serde::Serialize;

/// A warning for stderr and for reports.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Warning {
    /// Stable.
    pub(crate) code: &'static str,
    pub(crate) message: String,
}
