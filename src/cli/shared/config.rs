//! `--config FILE`: flags from a TOML file.
//!
//! A key is a flag of the command without its dashes; a table with a command's name
//! holds for that command alone. What stands on the command line goes before.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use midsurf::settings::quote::{quoted, shown_path};
use serde_json::{Value, json};
use toml::{Table, Value as Item};

use super::failure::Failure;
use super::report::named;

/// Most bytes of such a file.
const MOST: u64 = 1 << 20;

const FLAG: &str = "--config";

/// What was read: facts of the process, as its arguments are.
static USED: OnceLock<(PathBuf, Value)> = OnceLock::new();

/// The file that flags were read from, if there is one.
pub(crate) fn file() -> Option<&'static Path> {
    USED.get().map(|(file, _)| file.as_path())
}

/// The file and its keys, for reports.
pub(crate) fn told() -> Value {
    USED.get().map_or(
        Value::Null,
        |(file, keys)| json!({ "file": named(file), "keys": keys }),
    )
}

/// Arguments with those of a `--config` file added.
pub(crate) fn expand(
    mut arguments: Vec<OsString>,
    whole: &Command,
) -> Result<Vec<OsString>, Failure> {
    let Some(file) = config_file(&arguments) else {
        return Ok(arguments);
    };
    let table = read(&file)?;
    // Whatever is wrong on the command line is told later.
    let matches = whole.clone().ignore_errors(true);
    let Ok(matches) = matches.try_get_matches_from(&arguments) else {
        return Ok(arguments);
    };
    let chain = chain(whole, &matches);
    let mut added = Vec::new();
    for (key, item) in effective(&table, &chain) {
        let found = (chain.iter().rev())
            .find_map(|(command, matches)| Some((flag(command, &key)?, *matches)));
        let Some((flag, matches)) = found else {
            let command = chain.last().map_or("midsurf", |(c, _)| c.get_name());
            return Err(Failure::usage(
                format!(
                    "{}: {command} has no flag {}",
                    shown_path(&file),
                    quoted(&format!("--{key}"))
                ),
                "keys are flags without their dashes, or tables with the name of a command",
            ));
        };
        let id = flag.get_id().as_str();
        if matches.value_source(id) != Some(ValueSource::CommandLine) {
            let words = words(&key, item, flag);
            added.extend(words.ok_or_else(|| bad_value(&file, &key))?);
        }
    }
    // Nothing after `--` is a flag.
    let end = arguments.iter().position(|argument| argument == "--");
    let end = end.unwrap_or(arguments.len());
    arguments.splice(end..end, added);
    let keys = serde_json::to_value(&table).unwrap_or(Value::Null);
    // Set once: nothing else calls this.
    let _ = USED.set((file, keys));
    Ok(arguments)
}

fn bad_value(file: &Path, key: &str) -> Failure {
    Failure::usage(
        format!(
            "{}: the value of {} is none that a flag can have",
            shown_path(file),
            quoted(key)
        ),
        "give a string, a number, true, false, or a list of these",
    )
}

/// The file that the arguments name.
fn config_file(arguments: &[OsString]) -> Option<PathBuf> {
    let mut flags = arguments.iter().take_while(|argument| *argument != "--");
    while let Some(argument) = flags.next() {
        if argument == FLAG {
            return flags.next().map(PathBuf::from);
        }
        let joined = argument.to_str().and_then(|text| text.strip_prefix(FLAG));
        if let Some(name) = joined.and_then(|rest| rest.strip_prefix('=')) {
            return Some(PathBuf::from(name));
        }
    }
    None
}

fn read(file: &Path) -> Result<Table, Failure> {
    let refuse = |words: String| {
        Failure::usage(
            format!("{}: {words}", shown_path(file)),
            "give --config a TOML file whose keys are flags, as `cell = \"0.5t\"`",
        )
    };
    let meta = std::fs::metadata(file).map_err(|error| refuse(error.to_string()))?;
    if !meta.is_file() || meta.len() > MOST {
        return Err(refuse(format!("this is no file of at most {MOST} bytes")));
    }
    let text = std::fs::read_to_string(file).map_err(|error| refuse(error.to_string()))?;
    (text.parse::<Table>()).map_err(|error| refuse(error.message().to_owned()))
}

/// The command that was named, behind those above it.
fn chain<'a>(whole: &'a Command, matches: &'a ArgMatches) -> Vec<(&'a Command, &'a ArgMatches)> {
    let mut chain = vec![(whole, matches)];
    while let Some((command, matches)) = chain.last().copied() {
        let Some((name, inner)) = matches.subcommand() else {
            break;
        };
        let Some(found) = command.find_subcommand(name) else {
            break;
        };
        chain.push((found, inner));
    }
    chain
}

/// Keys that hold for a command: those of its table before those of all commands.
fn effective<'t>(table: &'t Table, chain: &[(&Command, &ArgMatches)]) -> Vec<(String, &'t Item)> {
    let is_command = |key: &str| chain[0].0.find_subcommand(key).is_some();
    let mut all: Vec<(String, &Item)> = Vec::new();
    let mut put = |key: &str, item| {
        let key = key.replace('_', "-");
        all.retain(|(other, _)| *other != key);
        all.push((key, item));
    };
    for (key, item) in table.iter().filter(|(key, _)| !is_command(key)) {
        put(key, item);
    }
    let own = chain
        .get(1)
        .and_then(|(command, _)| table.get(command.get_name()));
    for (key, item) in own.and_then(Item::as_table).into_iter().flatten() {
        put(key, item);
    }
    all
}

fn flag<'c>(command: &'c Command, key: &str) -> Option<&'c Arg> {
    command
        .get_arguments()
        .find(|flag| flag.get_long() == Some(key))
}

/// A key and its value as arguments; none if it can be no flag's.
fn words(key: &str, item: &Item, flag: &Arg) -> Option<Vec<OsString>> {
    let bare = || OsString::from(format!("--{key}"));
    let takes_value = flag.get_action().takes_values();
    match item {
        Item::Boolean(on) if !takes_value => Some(if *on { vec![bare()] } else { Vec::new() }),
        Item::Integer(count) if matches!(flag.get_action(), ArgAction::Count) => {
            Some((0..(*count).clamp(0, 9)).map(|_| bare()).collect())
        }
        Item::Array(items) => {
            let each = items.iter().map(|item| words(key, item, flag));
            each.collect::<Option<Vec<_>>>().map(|all| all.concat())
        }
        _ if !takes_value => None,
        item => {
            let value = match item {
                Item::String(text) => text.clone(),
                Item::Integer(number) => number.to_string(),
                Item::Float(number) => number.to_string(),
                Item::Boolean(on) => on.to_string(),
                _ => return None,
            };
            let mut word = bare();
            word.push("=");
            word.push(OsStr::new(&value));
            Some(vec![word])
        }
    }
}
