//! How what takes long says where it is.

/// Stages as they begin, for progress displays: stage name, done and expected.
pub type Progress<'p> = dyn Fn(&'static str, u64, u64) + Sync + 'p;
