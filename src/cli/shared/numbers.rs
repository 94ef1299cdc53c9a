//! Numbers as a user states them.

/// Reads an angle between 0 and 180 degrees.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(angle) if angle > 0.0 && angle < 180.0 => Ok(angle),
        _ => Err("expected degrees between 0 and 180".to_owned()),
    }
}

/// Reads a positive, finite length.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => Err("expected a positive length".to_owned()),
    }
}
