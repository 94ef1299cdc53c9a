//! What `midsurf subdivide` tells of a hollow solid: figures, colours.

use glam::DVec3;
use midsurf::io::write::Shade;
use midsurf::settings::quote::figure;
use midsurf::subdivide::{FoldFree, HollowSolid, Settings, Trial};
use serde_json::{Value, json};

use crate::cli::shared::console::say;

/// Folded triangles and crossing pairs that the report lists; all are counted.
const LISTED: usize = 1000;

/// The figures of a solid, for the report.
pub(super) fn figures(solid: &HollowSolid, settings: &Settings) -> Value {
    let mesh = &solid.hollow.mesh;
    let trial = |trial: &Trial| {
        json!({
            "levels": trial.level,
            "epsilon": trial.epsilon,
            "fold_free_crust": fold_free(trial.fold_free[0]),
            "fold_free_direct": fold_free(trial.fold_free[1]),
        })
    };
    let [least, most] = range(&solid.thickness);
    json!({
        "result": {
            "levels": solid.trial.level,
            "forced_steps": solid.forced,
            "faces": solid.faces,
            "crowded_faces": solid.crowded_faces,
            "averaged_normals": solid.averaged_normals,
            "vertices": mesh.positions.len(),
            "triangles": mesh.triangles.len(),
            "shell_vertices": solid.samples.outer.len(),
            "shell_triangles": solid.hollow.shell,
            "volume": mesh.volume(),
            "thickness": { "min": least, "mean": mean(&solid.thickness), "max": most },
            "epsilon": solid.trial.epsilon,
            "crust_length": { "min": solid.crust_length[0], "max": solid.crust_length[1] },
            "fold_free": fold_free(solid.trial.fold_free(settings.scheme)),
            "folded_triangles": solid.folded.len(),
            "folded": solid.folded.iter().take(LISTED).map(|f| f.0).collect::<Vec<u32>>(),
            "intersections": solid.intersections.len(),
            "intersecting": solid.intersections.iter().take(LISTED)
                .map(|(a, b)| [a.0, b.0]).collect::<Vec<_>>(),
        },
        "levels_tried": solid.trials.iter().map(trial).collect::<Vec<Value>>(),
    })
}

/// Infinity is null in JSON: no thickness folds.
fn fold_free(free: FoldFree) -> Value {
    if free.thickness.is_finite() {
        json!({ "thickness": free.thickness, "at": free.at.to_array() })
    } else {
        json!({ "thickness": null, "at": null })
    }
}

pub(super) fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, 0.0], |[low, high], &x| {
        [low.min(x), f64::max(high, x)]
    })
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub(super) fn summary(solid: &HollowSolid, settings: &Settings, verbose: u8) {
    let mesh = &solid.hollow.mesh;
    let trial = &solid.trial;
    let [least, most] = range(&solid.thickness);
    say(format_args!(
        "levels       {} ({} forced), {} faces, {} of them with several extraordinary vertices",
        trial.level, solid.forced, solid.faces, solid.crowded_faces
    ));
    say(format_args!(
        "thickness    {} to {}, asked for {}; epsilon {}",
        figure(least),
        figure(most),
        figure(settings.thickness),
        figure(trial.epsilon)
    ));
    let [crust, direct] = trial.fold_free.map(|free| figure(free.thickness));
    say(format_args!(
        "fold-free    up to {crust} by crust, {direct} directly"
    ));
    say(format_args!(
        "mesh         {} vertices, {} triangles, volume {}",
        mesh.positions.len(),
        mesh.triangles.len(),
        figure(mesh.volume())
    ));
    say(format_args!(
        "folded       {} triangles",
        solid.folded.len()
    ));
    say(format_args!(
        "crossing     {} pairs",
        solid.intersections.len()
    ));
    if verbose > 0 {
        for trial in &solid.trials {
            let [crust, direct] = trial.fold_free.map(|free| figure(free.thickness));
            say(format_args!(
                "level {:<6} epsilon {}, fold-free up to {crust} by crust, {direct} directly",
                trial.level,
                figure(trial.epsilon)
            ));
        }
    }
}

/// Paints the wall by its thickness.
pub(super) fn shade<'a>(values: &'a [f64], normals: &'a [DVec3]) -> Option<Shade<'a>> {
    Some(Shade {
        name: "thickness",
        values,
        normals,
    })
}
