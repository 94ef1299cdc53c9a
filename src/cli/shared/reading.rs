//! How a part is read from its file: flags that all commands share which take one.

use midsurf::intake::Reading;
use midsurf::io::Unit;
use midsurf::settings::cell::CellSize;
use serde_json::{Value, json};

use super::numbers::positive;

/// What is done to a part as it is read.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct ReadingArgs {
    /// Merge vertices of the part within this distance
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    weld: Option<f64>,
    /// Put right also what takes a guess: gaps a little wider than noise, doubled
    /// triangles, small flat holes, pinched vertices; all is told and listed
    #[arg(long)]
    repair: bool,
    /// Multiply the part's coordinates by this
    #[arg(long, value_name = "FACTOR", value_parser = positive, allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Unit of the part's numbers, for reports; changes no number
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// How far chords of a CAD model may lie off its faces: a length in mm, a share of
    /// the wall thickness (`0.05t`) or of the diagonal (`0.1%`) [default: 32 chords a full turn]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    cad_sag: Option<CellSize>,
}

/// Which of several solids.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct SelectArgs {
    /// Of several solids in the file take this one: its number, counted from 1, its
    /// name, or `all`
    #[arg(
        long,
        value_name = "SOLID",
        default_value = "all",
        visible_alias = "body"
    )]
    solid: String,
}

/// Which of several solids, for a command that writes one as `--solid`.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct BodyArgs {
    /// Of several solids in the file take this one: its number, counted from 1, its
    /// name, or `all`
    #[arg(long, value_name = "SOLID", default_value = "all")]
    body: String,
}

impl From<&BodyArgs> for SelectArgs {
    fn from(args: &BodyArgs) -> SelectArgs {
        let solid = args.body.clone();
        SelectArgs { solid }
    }
}

impl ReadingArgs {
    /// What they ask for.
    pub(crate) fn with(&self, select: Option<&SelectArgs>) -> Reading {
        let solid = select.map(|select| select.solid.clone());
        Reading {
            weld: self.weld,
            repair: self.repair,
            scale: self.scale,
            unit: self.unit,
            cad_sag: self.cad_sag,
            solid: solid.filter(|solid| solid != "all"),
        }
    }

    /// These flags beside a command's own settings.
    pub(crate) fn beside(&self, select: Option<&SelectArgs>, mut settings: Value) -> Value {
        if let Value::Object(reading) = json!(self.with(select)) {
            reading
                .into_iter()
                .for_each(|(name, value)| settings[name] = value);
        }
        settings["solid"] = json!(select.map_or("all", |select| &select.solid));
        settings
    }
}
