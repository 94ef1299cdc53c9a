//! Why a command failed, and the exit code for it.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use midsurf::dual_contour::GridError;
use midsurf::extract::ExtractError;
use midsurf::io::{LoadedMesh, Place};
use midsurf::mesh::PartError;
use miette::{Diagnostic, Report};

/// Help for cells that would not fit into memory.
const TOO_FINE: &str =
    "take a larger --cell, or raise --memory-limit if the machine has more memory";

/// A failed command.
pub(crate) enum Failure {
    /// Wrong usage or bad input: exit code 2.
    Input(Report),
    /// Good input, but no result: exit code 4.
    NoResult(Report),
    /// Standard output did not take the data.
    Stdout(io::Error),
}

impl Failure {
    /// Bad input or output that the library reported.
    pub(crate) fn input(error: impl Diagnostic + Send + Sync + 'static) -> Failure {
        Failure::Input(Report::new(error))
    }

    /// A part that the library refused; the message gains file and line.
    pub(crate) fn part(error: PartError, file: &Path, place: Place) -> Failure {
        let message = format!("{}: {error}", place.within(file));
        Failure::input(Explained {
            message,
            help: error.help().map(|help| help.to_string()),
        })
    }

    /// Flags that do not go together.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Failure {
        Failure::input(Explained {
            message: message.into(),
            help: Some(help.into()),
        })
    }

    /// Settings that do not fit the part.
    pub(crate) fn extract(error: &ExtractError, file: &Path) -> Failure {
        let help = match error {
            ExtractError::BadCell(_) => "give a positive length, or leave --cell away",
            ExtractError::NoThickness => {
                "`midsurf tags PART TAGS` shows what is tagged; --cell takes a length"
            }
            ExtractError::TooFine(_) => TOO_FINE,
            ExtractError::Stopped => "start again",
        };
        Failure::input(Explained {
            message: format!("{}: {error}", file.display()),
            help: Some(help.to_owned()),
        })
    }

    /// A grid that is refused: what to do about it.
    pub(crate) fn grid_help(error: &GridError) -> &'static str {
        match error {
            GridError::TooFine(_) => TOO_FINE,
            GridError::NoGrid { .. } => "move it nearer to the origin, or take a larger --cell",
        }
    }

    /// A result that could not be written.
    pub(crate) fn output(error: impl Diagnostic + Send + Sync + 'static) -> Failure {
        Failure::NoResult(Report::new(error))
    }

    /// No result, in words.
    pub(crate) fn no_result(message: impl Into<String>, help: impl Into<String>) -> Failure {
        Failure::NoResult(Report::new(Explained {
            message: message.into(),
            help: Some(help.into()),
        }))
    }

    /// Prints the error and its causes to stderr. A reader that went away is
    /// no error.
    pub(crate) fn print(&self) {
        let mut stderr = io::stderr();
        let _ = match self {
            Failure::Input(report) | Failure::NoResult(report) => {
                write!(stderr, "Error: {report:?}")
            }
            Failure::Stdout(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            Failure::Stdout(error) => writeln!(stderr, "Error: standard output: {error}"),
        };
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Failure::Input(_) => ExitCode::from(2),
            Failure::NoResult(_) => ExitCode::from(4),
            Failure::Stdout(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                ExitCode::SUCCESS
            }
            Failure::Stdout(_) => ExitCode::from(4),
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Failure {
        Failure::Stdout(error)
    }
}

/// Where the file states the triangle that an error names.
pub(crate) fn place_of(error: &PartError, loaded: &LoadedMesh) -> Place {
    error
        .triangle()
        .map_or(Place::Whole, |triangle| loaded.place_of(triangle))
}

/// A message with help, for the report printer.
#[derive(Debug)]
struct Explained {
    message: String,
    help: Option<String>,
}

impl fmt::Display for Explained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Explained {}

impl Diagnostic for Explained {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help
            .as_ref()
            .map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }
}
