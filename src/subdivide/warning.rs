//! What is wrong or odd about a hollow solid.

use super::{HollowSolid, Level, Settings};
use crate::settings::quote::figure;
use crate::settings::warning::Warning;

impl HollowSolid {
    /// What is wrong or odd about it; `settings` are those it was made with.
    pub fn warnings(&self, settings: &Settings) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |code, message: String| {
            warnings.push(Warning::new(code, message));
        };
        let free = self.trial.fold_free(settings.scheme);
        if settings.thickness >= free.thickness {
            let [x, y, z] = free.at.to_array().map(figure);
            warn(
                "folds",
                format!(
                    "the inner surface folds below ({x}, {y}, {z}): at level {} it is free of folds up to thickness {}",
                    self.trial.level,
                    figure(free.thickness)
                ),
            );
        }
        if !self.folded.is_empty() {
            let message = format!(
                "{} triangles of the inner shell are folded",
                self.folded.len()
            );
            warn("folded_triangles", message);
        }
        if !self.intersections.is_empty() {
            let message = format!(
                "the solid cuts or touches itself at {} pairs of triangles",
                self.intersections.len()
            );
            warn("intersections", message);
        }
        if self.averaged_normals > 0 {
            let message = format!(
                "{} vertices have no normal of their own and got the average of their neighbours'",
                self.averaged_normals
            );
            warn("averaged_normals", message);
        }
        if let Level::Fixed(level) = settings.level
            && level < self.forced
        {
            let message = format!(
                "faces of other than four corners and semi-sharp tags take {} subdivision steps: the wall is laid at that level",
                self.forced
            );
            warn("forced_steps", message);
        }
        warnings
    }
}
