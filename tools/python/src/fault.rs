//! Errors as exceptions: the words of the library, and of its remedies those
//! that the function at hand has an argument for.

use std::fmt::Display;

use midsurf::settings::quote::{bounded, shown_path};
use midsurf::settings::remedy::fitting;
use midsurf::settings::warning::Warning;
use miette::Diagnostic;
use pyo3::prelude::*;
use std::path::Path;

/// What went wrong, before it is an exception.
#[derive(Debug)]
pub(crate) struct Fault {
    /// Whether the input was good and nothing came of it.
    fruitless: bool,
    message: String,
    help: Option<String>,
}

impl Fault {
    /// Bad input that the library reported.
    pub(crate) fn input(error: &dyn Diagnostic) -> Fault {
        Fault {
            fruitless: false,
            message: error.to_string(),
            help: error.help().map(|help| help.to_string()),
        }
    }

    /// The same of a file or of what stands for it.
    pub(crate) fn refused(name: &Path, error: &dyn Diagnostic) -> Fault {
        let fault = Fault::input(error);
        Fault {
            message: format!("{}: {}", shown_path(name), fault.message),
            ..fault
        }
    }

    /// Good input of which nothing comes.
    pub(crate) fn fruitless(name: &Path, error: &dyn Diagnostic) -> Fault {
        Fault {
            fruitless: true,
            ..Fault::refused(name, error)
        }
    }

    /// An argument without sense.
    pub(crate) fn argument(name: &str, problem: impl Display) -> Fault {
        Fault {
            fruitless: false,
            message: format!("{name}: {problem}"),
            help: None,
        }
    }

    /// As an exception out of a function that has these arguments.
    pub(crate) fn raise(self, arguments: &[&str]) -> PyErr {
        // Flags have dashes where arguments have lines.
        let flag = |name: &&str| match *name {
            "groups" => "group".to_owned(),
            name => name.replace('_', "-"),
        };
        let flags: Vec<String> = arguments.iter().map(flag).collect();
        let help = self.help.and_then(|help| fitting(&help, &flags));
        let (message, help) = (bounded(&self.message), help.map(|help| spelt(&help)));
        if self.fruitless {
            no_result(message, help)
        } else {
            exception("InputError", message, help)
        }
    }
}

/// An exception for good input of which nothing comes.
pub(crate) fn no_result(message: String, help: Option<String>) -> PyErr {
    exception("NoResultError", message, help)
}

fn exception(class: &str, message: String, help: Option<String>) -> PyErr {
    Python::attach(|py| {
        let made = py
            .import("midsurf._errors")
            .and_then(|module| module.getattr(class))
            .and_then(|class| class.call1((message, help)));
        match made {
            Ok(value) => PyErr::from_value(value),
            Err(error) => error,
        }
    })
}

/// Warnings as pairs of code and message.
pub(crate) fn pairs(warnings: &[Warning]) -> Vec<(&'static str, String)> {
    let pair = |w: &Warning| (w.code, spelt(&bounded(&w.message)));
    warnings.iter().map(pair).collect()
}

/// A text with the flags that it names spelt as arguments: `--memory-limit` as
/// `memory_limit`.
fn spelt(text: &str) -> String {
    let mut pieces = text.split("--");
    let mut out = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let is_flag = piece.starts_with(|c: char| c.is_ascii_lowercase());
        if !is_flag || out.ends_with(|c: char| c.is_alphanumeric()) {
            out.push_str("--");
            out.push_str(piece);
            continue;
        }
        let end = piece.find(|c: char| !(c.is_ascii_lowercase() || c == '-'));
        let (flag, rest) = piece.split_at(end.unwrap_or(piece.len()));
        out.push_str(&flag.replace('-', "_"));
        out.push_str(rest);
    }
    out
}
