//! Places: where outputs are written. Before anything is computed, each is checked: it can be written, and it is neither an input
//! nor another output, even under another name.

use crate::engine::disk::{self, temporary};
use crate::engine::pair::Pair;
use anyhow::{Context as _, Result, bail, ensure};
use std::collections::HashSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The longest file name in bytes on all common file systems.
const MAX_NAME: usize = 255;

/// What identifies a file under any name: its canonical path, and its device and inode, which hard links share.
fn identities(path: &Path) -> Vec<(PathBuf, [u64; 2])> {
    let by_place = fs::canonicalize(path).ok().map(|place| (place, [0; 2]));
    #[cfg(unix)]
    let by_content = {
        use std::os::unix::fs::MetadataExt as _;
        fs::metadata(path).ok().map(|kind| (PathBuf::new(), [kind.dev(), kind.ino()]))
    };
    #[cfg(not(unix))]
    let by_content = None;
    by_place.into_iter().chain(by_content).collect()
}

/// Whether a folder ignores case in names, found out with a temporary file.
pub fn is_caseless(folder: &Path) -> bool {
    let Ok(trial) = temporary(folder, "") else { return false };
    let shouted = trial.path().file_name().map(|name| name.to_string_lossy().to_uppercase());
    shouted.is_some_and(|name| folder.join(name).exists())
}

fn differ_in_case_alone(a: &Path, b: &Path) -> bool {
    let small = |path: &Path| path.to_string_lossy().to_lowercase();
    a != b && small(a) == small(b)
}

/// Where each file will really be written. None is an input, and no two are the same.
pub fn places<'a>(paths: impl Iterator<Item = &'a Path>, inputs: &[&Path]) -> Result<Vec<PathBuf>> {
    let inputs: HashSet<_> = inputs.iter().flat_map(|path| identities(path)).collect();
    let mut found: Vec<PathBuf> = Vec::new();
    let mut known = HashSet::new();
    for path in paths {
        let place = writable_place(path)?;
        let identities = identities(&place);
        ensure!(
            !identities.iter().any(|identity| inputs.contains(identity)),
            "output {path:?} is an input, too; give another name"
        );
        let folder = place.parent().unwrap_or(Path::new("/"));
        let is_same = |other: &PathBuf| *other == place || (differ_in_case_alone(other, &place) && is_caseless(folder));
        ensure!(
            !found.iter().any(is_same) && identities.into_iter().all(|identity| known.insert(identity)),
            "output {path:?} is given twice; give each output its own name"
        );
        found.push(place);
    }
    Ok(found)
}

/// Where a file will really be written, with links followed; it is checked that it can be.
pub fn writable_place(path: &Path) -> Result<PathBuf> {
    ensure!(
        !path.as_os_str().as_encoded_bytes().ends_with(std::path::MAIN_SEPARATOR_STR.as_bytes()),
        "output {path:?} is the name of a folder; give the name of a file"
    );
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    match fs::metadata(folder) {
        Ok(kind) => {
            ensure!(kind.is_dir(), "output {path:?} lies in {folder:?}, which is not a folder; give another path")
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            bail!(
                "output {path:?} lies in {folder:?}, which does not exist; create the folder or give another path{}",
                gpu_stereo::files::hint(path)
            )
        }
        Err(error) => return Err(disk::unwritten(error, format_args!("output {path:?}"))),
    }
    let place = match fs::metadata(path) {
        Ok(kind) => {
            ensure!(!kind.is_dir(), "output {path:?} is a folder; give the name of a file");
            ensure!(kind.is_file(), "output {path:?} is not a regular file; give another name");
            ensure!(
                !kind.permissions().readonly(),
                "output {path:?} is read-only; make it writable or give another name"
            );
            fs::canonicalize(path)
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            // A link stays a link even if its target does not exist yet.
            if let Ok(target) = fs::read_link(path) {
                return writable_place(&folder.join(&target))
                    .with_context(|| format!("output {path:?} is a link to {target:?}, which cannot be made"));
            }
            fs::canonicalize(folder).map(|folder| folder.join(path.file_name().unwrap_or_default()))
        }
        Err(error) => Err(error),
    };
    let place = place.with_context(|| format!("output {path:?} cannot be written; give another path"))?;
    ensure_writable(place.parent().unwrap_or(Path::new("/")), path)?;
    Ok(place)
}

/// Refuses a folder in which no file can be created.
fn ensure_writable(folder: &Path, path: &Path) -> Result<()> {
    // The superuser could write to read-only folders, too. (On Windows the flag of a folder means something else.)
    let read_only = cfg!(unix) && fs::metadata(folder).is_ok_and(|kind| kind.permissions().readonly());
    ensure!(!read_only, "output {path:?} lies in a read-only folder; make the folder writable or give another path");
    temporary(folder, "").map(drop).with_context(|| {
        format!("output {path:?} lies in a folder that cannot be written; check its permissions or give another path")
    })
}

/// Creates a folder, but not its parents, and checks that files can be written into it.
pub fn make_folder(folder: &Path, out: &Path) -> Result<()> {
    match fs::create_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound && fs::symlink_metadata(folder).is_err() => {
            bail!(
                "output {out:?} lies in a folder that does not exist; create it or give another path{}",
                gpu_stereo::files::hint(out)
            )
        }
        Err(error) if error.kind() != ErrorKind::AlreadyExists && !folder.is_dir() => {
            return Err(error).with_context(|| format!("output folder {folder:?} cannot be made; give another path"));
        }
        _ => {}
    }
    if let (false, Ok(target)) = (folder.exists(), fs::read_link(folder)) {
        bail!("output {out:?} is a link to {target:?}, which does not exist; create the folder or give another path");
    }
    ensure!(folder.is_dir(), "output {out:?} is a file; give a folder, a printf pattern or the name of a video");
    temporary(folder, "")
        .map(drop)
        .with_context(|| format!("output folder {folder:?} cannot be written; check its permissions or give another"))
}

/// Creates a folder with its parents, and checks that files can be written into it.
pub fn ensure_folder(folder: &Path) -> Result<()> {
    let kind = fs::metadata(folder);
    ensure!(!kind.is_ok_and(|kind| !kind.is_dir()), "output folder {folder:?} is a file; give another name");
    let made = fs::create_dir_all(folder).and_then(|()| temporary(folder, "").map(drop));
    made.with_context(|| {
        format!("output folder {folder:?} cannot be written; check its permissions or give another name")
    })
}

/// Checks files of a folder and of folders below it that are created when needed: nothing is in their way, and none is an input,
/// even under another name. `others`: inputs besides the pairs.
pub fn ensure_no_input<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    pairs: impl IntoIterator<Item = &'a Pair>,
    others: &'a [PathBuf],
) -> Result<()> {
    let images = pairs.into_iter().flat_map(|pair| [pair.left.as_path(), &pair.right]);
    ensure_apart(outputs, images.chain(others.iter().map(PathBuf::as_path)))
}

/// The same with any inputs.
pub fn ensure_apart<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    let mut there = Vec::new();
    let mut folders = HashSet::new();
    for path in outputs {
        ensure_free(path)?;
        if let Some(folder) = path.parent().filter(|folder| folders.insert(*folder)) {
            ensure_can_be_made(folder, path)?;
        }
        there.extend(identities(path).into_iter().map(|identity| (path, identity)));
    }
    if there.is_empty() {
        return Ok(()); // without a look at each input
    }
    let inputs: HashSet<_> = inputs.into_iter().flat_map(identities).collect();
    match there.iter().find(|(_, identity)| inputs.contains(identity)) {
        Some((path, _)) => bail!("output {path:?} is an input, too; give another folder"),
        None => Ok(()),
    }
}

/// Refuses names that are too long, and paths where something else than a file or a link is.
fn ensure_free(path: &Path) -> Result<()> {
    for part in path.iter().map(|part| part.as_encoded_bytes().len()) {
        ensure!(
            part <= MAX_NAME,
            "output {path:?} has a name of {part} bytes, but at most {MAX_NAME} are possible; give a shorter one"
        );
    }
    match fs::symlink_metadata(path) {
        Ok(kind) if kind.is_dir() => bail!("output {path:?} is a folder; remove it, or give another folder or name"),
        Ok(kind) if !kind.is_file() && !kind.is_symlink() => {
            bail!("output {path:?} is not a regular file; remove it, or give another folder or name")
        }
        Err(error) if !matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            Err(error).with_context(|| format!("output {path:?} cannot be written; give another folder or name"))
        }
        _ => Ok(()),
    }
}

/// Refuses a folder that cannot be created: its nearest existing parent is no folder or cannot be written.
fn ensure_can_be_made(folder: &Path, path: &Path) -> Result<()> {
    let there = folder.ancestors().find(|part| *part == Path::new("") || fs::symlink_metadata(part).is_ok());
    let there = there.filter(|part| *part != Path::new("")).unwrap_or(Path::new("."));
    ensure!(
        there.is_dir(),
        "output {path:?} needs the folder {there:?}, which is not a folder; remove it, or give another name"
    );
    ensure_writable(there, path)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn files_are_the_same_whatever_leads_to_them() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("in.png"), "in").unwrap();
        fs::write(at("a.png"), "a").unwrap();
        fs::hard_link(at("in.png"), at("hard.png")).unwrap();
        fs::hard_link(at("a.png"), at("b.png")).unwrap();
        symlink("in.png", at("soft.png")).unwrap();
        symlink("new.png", at("dangling.png")).unwrap();
        symlink("dangling.png", at("twice.png")).unwrap();
        symlink("nowhere/new.png", at("lost.png")).unwrap();
        symlink("loop.png", at("loop.png")).unwrap();
        let told = |names: &[&str]| {
            let paths: Vec<_> = names.iter().map(|name| at(name)).collect();
            let found = places(paths.iter().map(PathBuf::as_path), &[&at("in.png")]);
            found.map_err(|error| format!("{error:#}"))
        };
        for name in ["in.png", "soft.png", "hard.png", "./in.png"] {
            assert!(told(&[name]).unwrap_err().contains("is an input"), "{name}");
        }
        for names in
            [["a.png", "b.png"], ["new.png", "dangling.png"], ["dangling.png", "twice.png"], ["c.png", "./c.png"]]
        {
            assert!(told(&names).unwrap_err().contains("is given twice"), "{names:?}");
        }
        assert_eq!(told(&["twice.png"]).unwrap(), [fs::canonicalize(folder.path()).unwrap().join("new.png")]);
        assert!(told(&["lost.png"]).unwrap_err().contains("is a link to \"nowhere/new.png\", which cannot be made"));
        assert!(told(&["loop.png"]).unwrap_err().contains("cannot be written"));
        assert!(told(&["c.png/"]).unwrap_err().contains("name of a folder"));
        let caseless = is_caseless(folder.path());
        assert_eq!(told(&["c.png", "C.PNG"]).is_err(), caseless);
    }

    #[test]
    fn nothing_is_in_the_way_of_files_of_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        fs::write(at("in.png"), "in").unwrap();
        fs::hard_link(at("in.png"), at("hard.png")).unwrap();
        fs::create_dir(at("folder.png")).unwrap();
        let told = |name: &str| {
            let path = at(name);
            ensure_apart([path.as_path()], [at("in.png").as_path()])
                .err()
                .map(|error| format!("{error:#}"))
                .unwrap_or_default()
        };
        assert_eq!((told("new.png"), told("new/a/b.png")), (String::new(), String::new()));
        for (name, words) in [
            ("folder.png", "is a folder"),
            ("file/a/b.png", "which is not a folder"),
            ("hard.png", "is an input"),
            (&format!("{}.png", "n".repeat(252)), "256 bytes"),
            (&format!("new/{}/a.png", "n".repeat(256)), "256 bytes"),
        ] {
            assert!(told(name).contains(words), "{name}: {}", told(name));
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
