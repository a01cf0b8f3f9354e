//! What was asked for at the start.

use std::path::PathBuf;

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tab {
    Images,
    Points,
}

impl Tab {
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "images" => Some(Self::Images),
            "points" => Some(Self::Points),
            _ => None,
        }
    }
}

/// What was asked for at the start.
pub struct Options {
    pub pair: Option<[PathBuf; 2]>,
    pub disparities: String,
    pub tab: Tab,
    pub one_to_one: bool,
    pub trace: bool,
}

/// The options of the command line; nothing if help is asked for.
pub fn parse() -> Result<Option<Options>, String> {
    let data = [env!("CARGO_MANIFEST_DIR"), "..", "data", "motorcycle"].iter().collect::<PathBuf>();
    let mut paths = Vec::new();
    let mut options =
        Options { pair: None, disparities: "64".into(), tab: Tab::Images, one_to_one: false, trace: false };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().and_then(|value| value.into_string().ok()).unwrap_or_default();
        match argument.to_str() {
            Some("-h" | "--help") => return Ok(None),
            Some("--disp") => options.disparities = value(),
            Some("--tab") => {
                let name = value();
                options.tab =
                    Tab::named(&name).ok_or_else(|| format!("--tab is {name:?}, but must be one of images, points"))?;
            }
            Some("--one-to-one") => options.one_to_one = true,
            Some("--trace") => options.trace = true,
            Some(other) if other.starts_with("--") => {
                return Err(format!("{other:?} is no option; see viewer --help"));
            }
            _ => paths.push(PathBuf::from(argument)),
        }
    }
    options.pair = match <[PathBuf; 2]>::try_from(paths) {
        Ok(pair) => Some(pair),
        Err(none) if none.is_empty() => {
            let pair = ["left.png", "right.png"].map(|name| data.join(name));
            pair.iter().all(|path| path.exists()).then_some(pair)
        }
        Err(other) => {
            return Err(format!("{} paths were given, but must be 2 or none; see viewer --help", other.len()));
        }
    };
    Ok(Some(options))
}
