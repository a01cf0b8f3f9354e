//! The store: the output folder of a video or a batch, the log of its finished maps, and which of them `--resume` may keep. The
//! order of writes is such that no map is ever mistaken for another, however a process ends.

mod entry;
mod journal;
mod plan;
mod record;

use super::known::KnownFile;
use super::log::Log;
use super::pair::Pair;
use super::pipeline::{MatchedPair, PairKind, Refused, Work};
use super::places;
use crate::args::InputArgs;
use crate::engine::compute::ends;
use crate::engine::{disk, images, output_files};
use crate::terminal::message;
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use entry::Entry;
pub use entry::FailedLine;
use gpu_stereo::Params;
use gpu_stereo::files::images::ImagePair;
use gpu_stereo::files::{Facts, JsonPath};
use journal::{Begun, Dead};
pub use journal::{Journal, State};
use plan::ensure_possible;
pub use plan::{Item, Planned, suspects};
pub use record::NAME as RECORD;
use record::{Contents, Record};
use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// The log of finished maps is synced to disk at most this long after a map.
const SYNC_AFTER: Duration = Duration::from_secs(1);

/// After so many processes have died of a pair computed alone, it is not computed again.
pub const MOST_DEATHS: u32 = 2;

/// How the folder is used.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Keep what is there.
    pub resume: bool,
    /// Compute pairs again that ended processes.
    pub retry: bool,
    /// Of a video: maps of other settings are removed, where a batch refuses them; failures are not logged.
    pub video: bool,
    /// Whether each pair has a range of its own.
    pub own_ranges: bool,
    /// How images are read.
    pub input: InputArgs,
    /// What decides about the files besides the settings of the matcher: names and values.
    pub more: Vec<(&'static str, String)>,
    /// Files that no map replaces: masks, calibrations, weights.
    pub inputs: Vec<PathBuf>,
    /// The journal whose suspects are computed alone, in place of any list.
    pub suspects: Option<PathBuf>,
}

/// The output folder.
pub struct Store {
    /// Where it is.
    pub out: PathBuf,
    /// First the pairs to compute in parallel, then those to compute alone, then those that are not computed again.
    pub pairs: Vec<Pair>,
    /// What each pair becomes.
    pub items: Vec<Item>,
    /// How many pairs are computed in parallel.
    pub main: usize,
    /// For each pair to compute alone: how many processes have died of it.
    pub suspects: Vec<u32>,
    /// For each pair that is not computed again: why.
    pub passed: Vec<String>,
    /// The names of finished maps that are kept.
    kept: Vec<JsonPath>,
    /// Size and samples of the frames that are kept.
    pub kind: Option<PairKind>,
    /// How it is used.
    pub mode: Mode,
    /// Where failures are logged.
    pub failures: Log,
    record: Record,
    settings: String,
    done: Log,
    dead: Mutex<Vec<Dead>>,
    journal: OnceLock<Journal>,
    /// The contents of the images that were read.
    sources: Mutex<HashMap<usize, Vec<Facts>>>,
    begun: OnceLock<Result<(), String>>,
    synced: Mutex<Instant>,
}

impl Store {
    /// A folder for these pairs, created if missing; nothing else in it is changed yet. `advice`: the remedy for equal names.
    pub fn new(
        out: &Path,
        params: &Params,
        sources: &[(&str, &Path)],
        all: &[Planned],
        advice: &str,
        mode: Mode,
    ) -> Result<Self> {
        ensure_possible(out, all, false, advice)?;
        places::make_folder(out, out)?;
        if places::is_caseless(out) {
            ensure_possible(out, all, true, advice)?;
        }
        let outputs = all.iter().flat_map(|planned| &planned.item.outputs).map(|output| output.path.as_path());
        places::ensure_no_input(outputs, all.iter().map(|planned| &planned.pair), &mode.inputs)?;
        let record = Record::new(out, params, &mode.more, &mode.input, sources);
        let log = |name: &str| Log { path: out.join(name) };
        let store = Self {
            out: out.into(),
            pairs: Vec::new(),
            items: Vec::new(),
            main: 0,
            suspects: Vec::new(),
            passed: Vec::new(),
            kept: Vec::new(),
            kind: None,
            failures: log(plan::FAILURES),
            settings: format!("{} {:?}", record.fingerprint(), mode.input.bits),
            record,
            done: log(plan::DONE),
            dead: Mutex::new(if mode.suspects.is_none() { Dead::find(out) } else { Vec::new() }),
            journal: OnceLock::new(),
            sources: Mutex::default(),
            begun: OnceLock::new(),
            synced: Mutex::new(Instant::now()),
            mode,
        };
        store.ensure_mine(&store.record.find()?)?;
        store.failures.ensure_own()?;
        store.done.ensure_own()?;
        Ok(store)
    }

    /// Takes the pairs of this process. With `--resume`, those with finished maps are skipped.
    pub fn fill(&mut self, all: Vec<Planned>) -> Result<()> {
        let entries = if self.mode.resume { self.entries()? } else { HashMap::new() };
        if self.mode.video {
            let mine = |entry: &&Entry| entry.settings.as_ref() == Some(&self.settings);
            self.kind = entries.values().filter(mine).find_map(|entry| entry.kind.clone());
        }
        let (mut main, mut alone, mut passed) = (Vec::new(), Vec::new(), Vec::new());
        let suspects = self.mode.suspects.as_ref().map(|journal| journal::states(journal)).transpose()?;
        for Planned { pair, item, .. } in all {
            if let Some(suspects) = &suspects {
                let deaths = suspects.get(&JsonPath::from(&item.name)).map_or(0, |(begun, _)| begun.alone);
                alone.push((pair, item, deaths));
                continue;
            }
            let entry = entries.get(&JsonPath::from(&item.name)).filter(|entry| entry.is_of(&self.settings, &pair));
            match (entry, self.deaths(&pair, &item)) {
                (Some(Entry { killed: Some(why), .. }), _) if !self.mode.retry => {
                    passed.push((pair, item, why.clone()))
                }
                (Some(Entry { killed: Some(_), .. }), _) => alone.push((pair, item, 0)),
                (Some(entry), _) if entry.has(&self.out, &item) => self.kept.push(JsonPath::from(&item.name)),
                (_, Some(deaths)) if self.mode.resume => alone.push((pair, item, deaths)),
                _ => main.push((pair, item)),
            }
        }
        if self.mode.suspects.is_none() && !alone.is_empty() {
            message(&format!(
                "note: an earlier run died while it computed {} pairs; they are computed last, one by one, in a separate \
                 process",
                alone.len()
            ));
        }
        self.main = main.len();
        for (pair, item) in main {
            self.pairs.push(pair);
            self.items.push(item);
        }
        for (pair, item, deaths) in alone {
            self.pairs.push(pair);
            self.items.push(item);
            self.suspects.push(deaths);
        }
        for (pair, item, why) in passed {
            self.pairs.push(pair);
            self.items.push(item);
            self.passed.push(why);
        }
        Ok(())
    }

    /// How many pairs keep their maps.
    pub fn skipped(&self) -> usize {
        self.kept.len()
    }

    /// How many processes died of a pair computed alone; `None` if no process died while it computed the pair.
    fn deaths(&self, pair: &Pair, item: &Item) -> Option<u32> {
        let dead = self.dead();
        let begun = dead.iter().filter_map(|dead| dead.suspects.get(&JsonPath::from(&item.name)));
        let of_pair = |begun: &&Begun| **begun == Begun { alone: begun.alone, ..Begun::new(&item.name, pair, 0) };
        let deaths = begun.filter(of_pair).map(|begun| begun.alone).max();
        if self.mode.retry { deaths.map(|_| 0) } else { deaths }
    }

    fn dead(&self) -> MutexGuard<'_, Vec<Dead>> {
        self.dead.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The last entry of each name. Formats of one pair that were written by several runs are merged.
    fn entries(&self) -> Result<HashMap<JsonPath, Entry>> {
        let mut entries: HashMap<JsonPath, Entry> = HashMap::new();
        for mut entry in self.done.read::<Entry>()? {
            if let Some(before) = entries.remove(&entry.name) {
                let same = |a: &[KnownFile], b: &[KnownFile]| {
                    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.path == b.path && a.facts.hash == b.facts.hash)
                };
                if entry.settings.is_some() && entry.settings == before.settings && same(&entry.inputs, &before.inputs)
                {
                    let missing = |known: &KnownFile| entry.outputs.iter().all(|other| other.path != known.path);
                    let kept: Vec<_> = before.outputs.into_iter().filter(missing).collect();
                    entry.outputs.extend(kept);
                }
            }
            entries.insert(entry.name.clone(), entry);
        }
        Ok(entries)
    }

    /// Refuses to mix maps with those that are there.
    fn ensure_mine(&self, found: &Contents) -> Result<()> {
        let path = &self.record.path;
        match found {
            Contents::Same | Contents::Nothing => Ok(()),
            Contents::OtherVerb(verb) => bail!(
                "the output folder has maps of gpu-stereo {verb} ({path:?}), which are not mixed with others; give another folder"
            ),
            Contents::Other(differing) if !self.mode.video => bail!(
                "the output folder has maps made with other settings: {differing} ({path:?}); run as before, or give another \
                 folder"
            ),
            Contents::Other(differing) if self.mode.resume => {
                bail!("--resume would mix maps: {differing} ({path:?}); run as before, or without it")
            }
            Contents::Other(differing) => {
                ensure!(
                    !journal::is_in_use(&self.out, self.journal.get()),
                    "another process writes maps with other settings into the output folder: {differing} ({path:?}); wait \
                     for its end, or give another folder"
                );
                Ok(())
            }
        }
    }

    /// Opens the journal and takes over those of dead processes.
    pub fn open(&self) -> Result<()> {
        let journal = match &self.mode.suspects {
            Some(path) => Journal::join(path)?,
            None => Journal::create(&self.out)?,
        };
        let alone = self.pairs[self.main..].iter().zip(&self.items[self.main..]).zip(&self.suspects);
        if self.mode.suspects.is_none() {
            journal.suspect(alone.map(|((pair, item), &deaths)| Begun::new(&item.name, pair, deaths)))?;
        }
        let _ = self.journal.set(journal);
        // A process may have died between logging a map and closing its line in the journal.
        for dead in self.dead().drain(..) {
            dead.take(self.items.iter().map(|item| JsonPath::from(&item.name)).chain(self.kept.iter().cloned()))?;
        }
        Ok(())
    }

    /// The journal, once it is open.
    pub fn journal(&self) -> Result<&Journal> {
        self.journal.get().ok_or_else(|| anyhow!("the journal is not open"))
    }

    /// Before the first map: records the settings of the folder, and invalidates the entries of maps that will be replaced.
    fn begin(&self) -> Result<()> {
        if self.mode.suspects.is_some() {
            return Ok(()); // the process that started this one has begun, or will
        }
        self.record.begin(|found| {
            self.ensure_mine(found)?;
            if matches!(found, Contents::Other(_)) {
                self.remove_maps()?;
            }
            let mut lines = Vec::new();
            if !self.mode.resume {
                let there = self.entries()?;
                let vouched =
                    |item: &&Item| there.get(&JsonPath::from(&item.name)).is_some_and(|e| e.settings.is_some());
                lines.extend(self.items.iter().filter(vouched).map(|item| Entry::empty(&item.name)));
            }
            if self.mode.video {
                let files = |item: &Item| item.outputs.iter().map(|output| self.below(&output.path)).collect();
                lines =
                    self.items.iter().map(|item| Entry { files: files(item), ..Entry::empty(&item.name) }).collect();
            }
            if lines.is_empty() {
                return Ok(());
            }
            self.done.append(&lines, true)?;
            Ok(disk::sync_folder(&self.out)?)
        })
    }

    /// Removes all maps that the log lists, and all files with the names of new ones.
    fn remove_maps(&self) -> Result<()> {
        let mut files: BTreeSet<PathBuf> = BTreeSet::new();
        for entry in self.done.read::<Entry>()? {
            files.extend(
                entry.files.into_iter().chain(entry.outputs.into_iter().map(|known| known.path)).map(|name| name.0),
            );
        }
        // Only plain names: others were not written by this program.
        files.retain(|file| file.components().all(|part| matches!(part, Component::Normal(_))));
        let own = self.items.iter().flat_map(|item| &item.outputs).map(|output| output.path.clone());
        for path in files.iter().map(|file| self.out.join(file)).chain(own) {
            let folders = path.ancestors().skip(1).take_while(|folder| *folder != self.out);
            let is_file = fs::symlink_metadata(&path).is_ok_and(|kind| !kind.is_dir());
            if is_file && folders.into_iter().all(|folder| disk::ensure_plain_folder(folder).is_ok()) {
                fs::remove_file(&path).with_context(|| format!("{path:?} cannot be removed"))?;
            }
        }
        if self.done.path.exists() {
            fs::remove_file(&self.done.path).with_context(|| format!("{:?} cannot be removed", self.done.path))?;
        }
        Ok(disk::sync_folder(&self.out)?)
    }

    /// A path relative to the folder.
    fn below(&self, path: &Path) -> JsonPath {
        path.strip_prefix(&self.out).unwrap_or(path).into()
    }

    /// The line of a pair that failed.
    pub fn failure(&self, place: usize, error: &str) -> FailedLine {
        let Begun { name, left, right, .. } = Begun::new(&self.items[place].name, &self.pairs[place], 0);
        FailedLine { name, left, right, error: error.into() }
    }

    /// Records that a pair has ended processes and is not computed again.
    pub fn convict(&self, place: usize, why: &str) -> Result<()> {
        self.begin_once().map_err(|error| anyhow!("{error}"))?;
        let Begun { name, left, right, .. } = Begun::new(&self.items[place].name, &self.pairs[place], 0);
        let inputs = [left, right].iter().filter_map(|path| KnownFile::read(&path.0)).collect();
        let (settings, killed) = (Some(self.settings.clone()), Some(why.into()));
        self.done.append(&[Entry { settings, inputs, killed, ..Entry::empty(&name.0) }], true)?;
        self.failed(place, why)
    }

    /// Calls [`Self::begin`] once, before the first map.
    pub fn begin_once(&self) -> Result<(), &String> {
        self.begun.get_or_init(|| self.begin().map_err(|error| format!("{error:#}"))).as_ref().map(|_| ())
    }

    fn write_maps(&self, matched: &MatchedPair) -> Result<Entry> {
        let item = &self.items[matched.place];
        for folder in item.outputs.iter().filter_map(|output| output.path.parent()) {
            disk::make_folder_below(&self.out, folder)?;
        }
        let facts = output_files::write(&item.outputs, &matched.matched, matched.images(), &matched.params)?;
        let outputs = item.outputs.iter().zip(facts);
        let outputs = outputs.map(|(output, facts)| KnownFile { path: self.below(&output.path), facts }).collect();
        let pair = &self.pairs[matched.place];
        let sources = self.sources.lock().unwrap_or_else(PoisonError::into_inner).remove(&matched.place);
        let inputs = [&pair.left, &pair.right].into_iter().zip(sources.into_iter().flatten());
        let inputs = inputs.map(|(path, facts)| KnownFile::new(path, facts)).collect();
        let (settings, kind) = (Some(self.settings.clone()), Some(PairKind::of(&matched.left)));
        let searched = self.mode.own_ranges.then(|| ends(&matched.params));
        Ok(Entry { settings, inputs, outputs, kind, searched, ..Entry::empty(&item.name) })
    }

    /// Logs maps that are on the disk. The log itself may be synced a little later: without its lines the maps are computed
    /// again.
    fn vouch(&self, entry: Entry) -> Result<()> {
        let sync = {
            let mut synced = self.synced.lock().unwrap_or_else(PoisonError::into_inner);
            let due = synced.elapsed() >= SYNC_AFTER;
            if due {
                *synced = Instant::now();
            }
            due
        };
        self.done.append(&[entry], sync)
    }

    /// Closes the log and the journal at the end of a run.
    pub fn close(&self) -> Result<()> {
        if self.begun.get().is_some() {
            self.done.sync()?;
        }
        match self.journal.get() {
            Some(journal) if self.mode.suspects.is_none() => journal.close(),
            _ => Ok(()),
        }
    }
}

impl Work for Store {
    fn read(&self, place: usize, pair: &Pair, options: &InputArgs) -> Result<ImagePair, Refused> {
        let alone = if self.mode.suspects.is_some() { self.suspects[place] + 1 } else { 0 };
        let begun = Begun::new(&self.items[place].name, pair, alone);
        self.journal().and_then(|journal| journal.begin(begun)).map_err(Refused::All)?;
        let views = images::read_pair(&pair.left, &pair.right, options).map_err(Refused::Pair)?;
        self.sources.lock().unwrap_or_else(PoisonError::into_inner).insert(place, views.facts.clone());
        Ok(views)
    }

    fn write(&self, matched: &MatchedPair) -> Result<(), Refused> {
        // Not earlier, so that a run that cannot compute changes nothing.
        self.begin_once().map_err(|error| Refused::All(anyhow!("{error}")))?;
        let entry = self.write_maps(matched).map_err(Refused::of)?;
        self.vouch(entry).map_err(Refused::All)?;
        self.journal().and_then(|journal| journal.end(&self.items[matched.place].name, None)).map_err(Refused::All)
    }

    fn failed(&self, place: usize, error: &str) -> Result<()> {
        if !self.mode.video {
            self.failures.append(&[self.failure(place, error)], false)?;
        }
        self.journal()?.end(&self.items[place].name, Some(error))
    }
}
