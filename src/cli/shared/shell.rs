//! Shell models as output: what is asked for, and the model for each file.

use std::path::{Path, PathBuf};

use midsurf::intake::Input;
use midsurf::io::write::{Dialect, ShellFormat, ShellOptions, Staged, Template, stage_shell};
use midsurf::shell::mass::MassProperties;
use midsurf::shell::{
    Faces, NORMAL_REACH, Order, ShellModel, ShellSettings, THICKNESS_TOLERANCE, ThicknessFrom,
};
use midsurf::surface::MidSurface;
use serde_json::{Value, json};

use super::failure::Failure;

/// How files for solvers (.inp, .bdf, .msh, .glb) are written.
#[derive(clap::Args)]
#[command(next_help_heading = "Shell model (.inp, .bdf, .msh, .glb)")]
pub(crate) struct ShellArgs {
    /// Order of the elements: 1 or 2; by default 2 for CalculiX, else 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=2))]
    order: Option<u8>,
    /// Whose names the elements of an .inp have
    #[arg(long, value_name = "NAME", value_enum, default_value_t = DialectArg::Calculix)]
    dialect: DialectArg,
    /// Supports, loads and steps in an .inp, ready to solve
    #[arg(long, value_name = "NAME", value_enum)]
    template: Option<TemplateArg>,
    /// Thickness of a node: diameter of the ball that touches the walls, or distance of its footpoints
    #[arg(long, value_name = "HOW", value_enum, default_value_t = ThicknessArg::Ball)]
    node_thickness: ThicknessArg,
    /// Sheets whose thickness differs by at most this share are of one class
    #[arg(long, value_name = "SHARE", default_value_t = THICKNESS_TOLERANCE, value_parser = share, allow_negative_numbers = true)]
    thickness_tolerance: f64,
    /// Radius within which normals are averaged, in thicknesses
    #[arg(long, value_name = "REACH", default_value_t = NORMAL_REACH, value_parser = reach, allow_negative_numbers = true)]
    normal_reach: f64,
    /// Where the nodes lie between the walls: 0 on one, 0.5 in the middle, 1 on the other
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = share, allow_negative_numbers = true)]
    placement: f64,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum DialectArg {
    Calculix,
    Abaqus,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum TemplateArg {
    /// Clamped at one end, loaded across at the other
    Cantilever,
    /// Natural frequencies, clamped at one end
    Modal,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ThicknessArg {
    Ball,
    Footpoints,
}

fn reach(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(reach) if (0.0..=10.0).contains(&reach) => Ok(reach),
        _ => Err("expected a number from 0 to 10".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("expected a number from 0 to 1".to_owned()),
    }
}

impl ShellArgs {
    /// Writes the models under passing names; their account for the report if
    /// there are any. Without the part its faces have no names.
    pub(crate) fn stage(
        &self,
        input: Option<&Input>,
        surface: &MidSurface,
        faces: &Faces,
        files: &[PathBuf],
    ) -> Result<(Vec<Staged>, Option<Value>), Failure> {
        let mut staged = Vec::new();
        let mut told = None;
        let mut models: Vec<(Order, ShellModel)> = Vec::new();
        for (file, format) in shell_files(files) {
            let order = match self.order {
                Some(1) => Order::Linear,
                Some(_) => Order::Quadratic,
                None => format.order(self.dialect()),
            };
            if models.iter().all(|m| m.0 != order) {
                models.push((order, self.model(input, surface, faces, order)));
            }
            for (_, model) in models.iter().filter(|m| m.0 == order) {
                told.get_or_insert_with(|| account(input, model));
                staged.push(stage_shell(model, file, self.options()).map_err(Failure::output)?);
            }
        }
        Ok((staged, told))
    }

    fn dialect(&self) -> Dialect {
        match self.dialect {
            DialectArg::Calculix => Dialect::Calculix,
            DialectArg::Abaqus => Dialect::Abaqus,
        }
    }

    fn options(&self) -> ShellOptions {
        ShellOptions {
            dialect: self.dialect(),
            template: self.template.map(|t| match t {
                TemplateArg::Cantilever => Template::Cantilever,
                TemplateArg::Modal => Template::Modal,
            }),
        }
    }

    fn model(
        &self,
        input: Option<&Input>,
        surface: &MidSurface,
        faces: &Faces,
        order: Order,
    ) -> ShellModel {
        let settings = ShellSettings {
            order,
            thickness: match self.node_thickness {
                ThicknessArg::Ball => ThicknessFrom::Ball,
                ThicknessArg::Footpoints => ThicknessFrom::Footpoints,
            },
            normal_reach: self.normal_reach,
            thickness_tolerance: self.thickness_tolerance,
        };
        let mut model = ShellModel::of(surface, faces, &settings);
        if let Some(input) = input {
            model.name_after(input);
        }
        if self.placement != model.placement {
            model.place(self.placement);
        }
        model
    }
}

/// The files that are shell models.
fn shell_files(files: &[PathBuf]) -> impl Iterator<Item = (&Path, ShellFormat)> {
    files
        .iter()
        .filter_map(|file| Some((file.as_path(), ShellFormat::of(file)?)))
}

/// What a report says of a model.
fn account(input: Option<&Input>, model: &ShellModel) -> Value {
    let sets = model.lines.iter();
    json!({
        "nodes": model.nodes.len(),
        "elements": model.elements.len(),
        "leaning_elements": model.leaning.len(),
        "guessed_thicknesses": model.guessed,
        "sheets": model.sheets,
        "thickness_classes": model.classes,
        "sets": sets.map(|s| json!({ "name": s.name, "nodes": s.nodes().len() })).collect::<Vec<_>>(),
        "mass_at_density_1": {
            "model": MassProperties::of_shell(model),
            "part": input.map(|i| MassProperties::of_solid(i.part.mesh())),
        },
    })
}
