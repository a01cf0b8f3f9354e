//! Errors of the command line, with a tip where a typing error or the option of another program is recognised. No tip is better
//! than a misleading one.

use crate::args::{near, ours, squeezed, value};
use crate::terminal::{name, plain};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command};
use std::ffi::OsString;
use std::path::Path;

/// An error of the command line in one line: what was given, a tip or what is allowed, and where to read more.
pub fn error_line(mut error: clap::Error, root: &Command, args: &[OsString]) -> String {
    if error.kind() == ErrorKind::InvalidUtf8 {
        let wrong: Vec<_> =
            args.iter().filter(|arg| arg.to_str().is_none()).map(|arg| format!("{:?}", name(arg))).collect();
        return format!(
            "{} is not Unicode, which only names of files need not be; see gpu-stereo --help",
            wrong.join(", ")
        );
    }
    let verb = verb(root, args);
    let called = verb.as_ref().map_or("gpu-stereo".into(), |verb| format!("gpu-stereo {verb}"));
    if let Some(word) = error.get(ContextKind::InvalidSubcommand)
        && error.kind() == ErrorKind::ArgumentConflict
    {
        // Clap takes every surplus word for a subcommand.
        let meant = similar_verb(root, args)
            .unwrap_or_else(|| "give two images, with sweep or compare before them, or two maps after eval".into());
        return format!("unexpected argument '{}' found; {meant}; see gpu-stereo --help", plain(&word.to_string()));
    }
    let unknown = match (error.kind(), error.get(ContextKind::InvalidArg)) {
        (ErrorKind::UnknownArgument, Some(ContextValue::String(unknown))) => Some(unknown.clone()),
        _ => None,
    };
    let mut tip = unknown.and_then(|unknown| tip(&unknown, root, verb.as_deref(), args));
    if let (Some(ContextValue::String(given)), Some(ContextValue::Strings(known))) =
        (error.get(ContextKind::InvalidValue), error.get(ContextKind::ValidValue))
    {
        tip = near(given, known.iter().map(String::as_str)).map(|near| format!("a similar value is {near}"));
    }
    // Clap quotes what was typed without escaping it.
    let shown: Vec<_> = error.context().filter_map(|(kind, value)| Some((kind, shown(value)?))).collect();
    for (kind, value) in shown {
        error.insert(kind, value);
    }
    let text = error.render().to_string();
    let is_advice = |line: &str| line.starts_with("Usage:") || line.starts_with("For more information");
    // Clap's own tips name any word with the same beginning.
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("tip:"));
    let told: Vec<_> = lines.take_while(|line| !is_advice(line)).collect();
    let tip = tip.map(|tip| format!("; {tip}")).unwrap_or_default();
    let told = told.join(" ");
    format!("{}{tip}; see {called} --help", told.strip_prefix("error: ").unwrap_or(&told))
}

/// What was typed, with control characters escaped.
fn shown(value: &ContextValue) -> Option<ContextValue> {
    match value {
        ContextValue::String(text) => Some(ContextValue::String(plain(text))),
        ContextValue::Strings(texts) => Some(ContextValue::Strings(texts.iter().map(|text| plain(text)).collect())),
        _ => None,
    }
}

/// The verb of a command line, without the program's name.
fn verb(root: &Command, args: &[OsString]) -> Option<String> {
    let first = args.first()?.to_str()?;
    root.get_subcommands().map(Command::get_name).find(|name| *name == first).map(Into::into)
}

/// The verb that the first word most likely means.
fn similar_verb(root: &Command, args: &[OsString]) -> Option<String> {
    let first = args.first()?.to_str()?;
    near(first, root.get_subcommands().map(Command::get_name)).map(|verb| format!("a similar verb is {verb}"))
}

/// The long options of a command, aliases among them.
pub fn longs(command: &Command) -> Vec<(&str, &Arg)> {
    let of = |arg| {
        Arg::get_long(arg).into_iter().chain(arg.get_all_aliases().unwrap_or_default()).map(move |long| (long, arg))
    };
    command.get_arguments().flat_map(of).collect()
}

/// An option with its value.
fn with_value((long, arg): &(&str, &Arg)) -> String {
    let values = arg.get_value_names().filter(|_| arg.get_action().takes_values()).unwrap_or_default();
    let values: String = values.iter().map(|value| format!(" <{value}>")).collect();
    format!("--{long}{values}")
}

/// What an unknown argument of `verb` most likely means.
fn tip(unknown: &str, root: &Command, verb: Option<&str>, args: &[OsString]) -> Option<String> {
    let command = verb.and_then(|verb| root.find_subcommand(verb)).unwrap_or(root);
    let option = unknown.trim_start_matches('-');
    if option == unknown {
        let in_quotes = || "a glob must be in quotes, or the shell replaces it by names".into();
        return similar_verb(root, args).filter(|_| verb.is_none()).or_else(|| Some(in_quotes()));
    }
    // Clap has cut it into letters; as a whole it may be the name of a file.
    let whole = args.iter().filter_map(|arg| arg.to_str()).find(|arg| arg.starts_with(unknown)).unwrap_or(unknown);
    if Path::new(whole).exists() {
        return Some(format!("write ./{} for the file of that name", plain(whole)));
    }
    let known = longs(command);
    let names: Vec<_> = known.iter().map(|(long, _)| *long).collect();
    let shown = |long: &str| known.iter().find(|(name, _)| *name == long).map(with_value).unwrap_or_default();
    match ours(option, &names) {
        Some("disp") => {
            return Some(format!(
                "{} is how many disparities are searched, --min-disp the smallest one",
                shown("disp")
            ));
        }
        Some(long) => return Some(format!("use {}", shown(long))),
        None => {}
    }
    // Other programs switch things off by --no-NAME.
    let off = squeezed(option).strip_prefix("no").and_then(|rest| ours(rest, &names));
    if let Some(long) = off.filter(|long| value(long, "off") == Some("off")) {
        return Some(format!("use --{long} off"));
    }
    if let Some(format) = verb.and_then(|_| by_format(option, &names)) {
        return Some(format);
    }
    match squeezed(option).as_str() {
        "left" | "right" | "l" | "r" | "leftimage" | "rightimage" | "leftimg" | "rightimg" | "input" | "inputleft"
        | "inputright" | "i" | "images" => {
            return Some("the images are given without an option, the left one first".into());
        }
        "gpu" | "cpu" if names.contains(&"backend") => return Some(format!("use --backend {}", squeezed(option))),
        _ => {}
    }
    elsewhere(option, root, command)
        .or_else(|| near(option, names.iter().copied()).map(|long| format!("a similar option is {}", shown(long))))
}

/// What a single run writes by an option, verbs that write many files write by --format.
fn by_format(option: &str, names: &[&str]) -> Option<String> {
    let format = ours(option, &["depth", "points", "right", "color", "mask", "confidence"])?;
    let folder = if names.contains(&"maps") { "--maps <FOLDER> " } else { "" };
    let ending = if format == "points" { "ply" } else { "png" };
    names.contains(&"format").then(|| format!("use {folder}--format {format}, which writes NAME_{format}.{ending}"))
}

/// Which other verbs have this option.
fn elsewhere(option: &str, root: &Command, command: &Command) -> Option<String> {
    let mut found = None;
    let mut places = Vec::new();
    for other in [root].into_iter().chain(root.get_subcommands()).filter(|other| other.get_name() != command.get_name())
    {
        let known = longs(other);
        let names: Vec<_> = known.iter().map(|(long, _)| *long).collect();
        let Some(place) = ours(option, &names).and_then(|long| names.iter().position(|name| *name == long)) else {
            continue;
        };
        found.get_or_insert_with(|| with_value(&known[place]));
        places.push(if other.get_name() == root.get_name() { "a single run" } else { other.get_name() });
    }
    found.map(|found| format!("{found} is an option of {}, not of this", places.join(", ")))
}
