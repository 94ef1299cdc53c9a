//! Why a command failed, and the exit code for it.
//!
//! What to do about an error stands at the error, in the library, and may name
//! several flags. What is printed keeps the clauses whose flags the command
//! that failed has.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use midsurf::intake::IntakeError;
use midsurf::io::Place;
use midsurf::settings::quote::bounded;
use midsurf::settings::remedy::fitting;

use super::console::log;
use miette::{Diagnostic, LabeledSpan, Report, SourceCode};

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

    /// A file that an engine refused.
    pub(crate) fn refused(file: &Path, error: &dyn Diagnostic) -> Failure {
        Failure::at(Place::Whole, file, error)
    }

    /// A place in a file that the library refused.
    pub(crate) fn at(place: Place, file: &Path, error: &dyn Diagnostic) -> Failure {
        Failure::input(Explained::within(place, file, error))
    }

    /// A file of which nothing comes.
    pub(crate) fn fruitless(file: &Path, error: &dyn Diagnostic) -> Failure {
        Failure::output(Explained::within(Place::Whole, file, error))
    }

    /// Flags that do not go together.
    pub(crate) fn usage(message: impl Into<String>, help: impl Into<String>) -> Failure {
        Failure::input(Explained::new(message, help))
    }

    /// A result that could not be written.
    pub(crate) fn output(error: impl Diagnostic + Send + Sync + 'static) -> Failure {
        Failure::NoResult(Report::new(error))
    }

    /// No result, in words.
    pub(crate) fn no_result(message: impl Into<String>, help: impl Into<String>) -> Failure {
        Failure::output(Explained::new(message, help))
    }

    /// Calls a flag that the help names by the command's own name for it.
    pub(crate) fn calling(self, flag: &str, own: &str) -> Failure {
        let call = |report: Report| {
            let help = report
                .help()
                .map(|help| help.to_string().replace(flag, own));
            Report::new(Told { report, help })
        };
        match self {
            Failure::Input(report) => Failure::Input(call(report)),
            Failure::NoResult(report) => Failure::NoResult(call(report)),
            stdout => stdout,
        }
    }

    /// Prints the error and its causes to stderr, with such help as names only
    /// flags of the command. A reader that went away is no error.
    pub(crate) fn print(self, flags: &[String]) {
        let mut stderr = io::stderr();
        let _ = match self {
            Failure::Input(report) | Failure::NoResult(report) => {
                let help = report.help();
                let help = help.and_then(|help| fitting(&help.to_string(), flags));
                let report = Report::new(Told { report, help });
                log(&format!("Error: {report}"));
                if let Some(help) = report.help() {
                    log(&format!("help: {help}"));
                }
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

impl From<IntakeError> for Failure {
    fn from(error: IntakeError) -> Failure {
        match error {
            IntakeError::Memory { .. } => Failure::output(error),
            error => Failure::input(error),
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Failure {
        Failure::Stdout(error)
    }
}

/// A message with help, for the report printer.
#[derive(Debug)]
struct Explained {
    message: String,
    help: Option<String>,
}

impl Explained {
    fn new(message: impl Into<String>, help: impl Into<String>) -> Explained {
        Explained {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    fn within(place: Place, file: &Path, error: &dyn Diagnostic) -> Explained {
        Explained {
            message: format!("{}: {error}", place.within(file)),
            help: error.help().map(|help| help.to_string()),
        }
    }
}

impl fmt::Display for Explained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Explained {}

impl Diagnostic for Explained {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        help(&self.help)
    }
}

/// A report with other help, its message short and without control characters.
#[derive(Debug)]
struct Told {
    report: Report,
    help: Option<String>,
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&bounded(&self.report.to_string()))
    }
}

impl std::error::Error for Told {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.report.source()
    }
}

impl Diagnostic for Told {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        help(&self.help)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.report.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.report.labels()
    }
}

fn help(text: &Option<String>) -> Option<Box<dyn fmt::Display + '_>> {
    text.as_ref()
        .map(|text| Box::new(text) as Box<dyn fmt::Display>)
}
