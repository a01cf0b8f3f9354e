//! Trial: pairs that an earlier process may have died of are computed one by one in a separate process.

use super::pipeline::{self, FailedPair, Ran, Sequence, Setup, Work as _};
use super::store::{MOST_DEATHS, State, Store};
use crate::terminal::{message, name, one_line, warnings};
use anyhow::{Context as _, Result, anyhow, bail, ensure};
use gpu_stereo::Error;
use gpu_stereo::files::JsonPath;
use std::io::Read as _;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// The time between two polls of the other process.
const LOOK: Duration = Duration::from_millis(10);

/// Computes all pairs of a store: in parallel where possible, then alone where necessary.
pub fn run(store: &Store, setup: &Setup<'_>, stop: &'static AtomicBool) -> Ran {
    let start = Instant::now();
    let mut ran = match store.open() {
        Ok(()) => {
            pipeline::run(Sequence::Files(&store.pairs[..store.main + store.alone()]), &store.setup(setup), stop, store)
        }
        Err(error) => Ran { stopped: Some(error), ..Ran::default() },
    };
    let end = if store.mode.suspects.is_some() { as_suspect(store, &mut ran) } else { after(store, &mut ran, stop) };
    if let Err(error) = end {
        ran.stopped.get_or_insert(error);
    }
    ran.seconds = start.elapsed().as_secs_f64();
    ran
}

impl Store {
    /// How many of the suspects this process computes itself.
    fn alone(&self) -> usize {
        if self.mode.suspects.is_some() { self.suspects.len() } else { 0 }
    }

    fn setup<'a>(&'a self, setup: &Setup<'a>) -> Setup<'a> {
        let alone = self.mode.suspects.is_some();
        Setup { alone, quiet: setup.quiet || alone, kind: self.kind.as_ref(), ..*setup }
    }
}

/// In the process that computes suspects: a lost device is blamed on the pair.
fn as_suspect(store: &Store, ran: &mut Ran) -> Result<()> {
    let Some(error) = lost(ran).map(|error| one_line(&format!("{error:#}"))) else { return Ok(()) };
    let states = store.journal()?.states()?;
    let is_running = |place: &usize| {
        let state = states.get(&JsonPath::from(&store.items[*place].name));
        state.is_some_and(|(_, state)| *state == State::Running)
    };
    let Some(place) = (0..store.items.len()).find(is_running) else { return Ok(()) };
    fail(store, ran, place, &error, |store| store.failed(place, &error))?;
    ran.stopped = None;
    Ok(())
}

/// The error of a lost device, if there is one.
fn lost(ran: &Ran) -> Option<&anyhow::Error> {
    ran.stopped.as_ref().filter(|error| matches!(error.downcast_ref(), Some(Error::Lost(_) | Error::Refused(_))))
}

/// Reports, counts and records a pair that failed.
fn fail(
    store: &Store,
    ran: &mut Ran,
    place: usize,
    error: &str,
    note: impl FnOnce(&Store) -> Result<()>,
) -> Result<()> {
    let left = &store.pairs[place].left;
    message(&format!("failed: {}: {error}", name(left)));
    ran.failed.push(FailedPair { place, frame: left.into(), error: error.into() });
    note(store)
}

/// After the other pairs: the suspects, and those that are not computed again.
fn after(store: &Store, ran: &mut Ran, stop: &AtomicBool) -> Result<()> {
    if lost(ran).is_some() {
        // Any of the pairs in flight may be the cause.
        let states = store.journal()?.states()?.into_values();
        let running = states.filter(|(_, state)| *state == State::Running);
        store.journal()?.suspect(running.map(|(begun, _)| begun))?;
    }
    if ran.stopped.is_some() {
        return Ok(());
    }
    let first_passed = store.main + store.suspects.len();
    for (place, why) in (first_passed..).zip(&store.passed) {
        let why = format!("not tried again: {why}");
        fail(store, ran, place, &why, |_| Ok(()))?;
    }
    for (place, &deaths) in (store.main..).zip(&store.suspects) {
        if deaths >= MOST_DEATHS {
            let why = format!("{deaths} processes that computed it alone died; --retry tries it again");
            fail(store, ran, place, &why, |store| store.convict(place, &why))?;
        }
    }
    loop {
        if stop.load(Ordering::Relaxed) {
            bail!("interrupted");
        }
        let open = open(store)?;
        if open.is_empty() {
            break;
        }
        store.begin_once().map_err(|error| anyhow!("{error}"))?;
        let (status, told) = other_process(store, stop)?;
        let culprit = settle(store, ran, &open)?;
        match (status.code(), culprit) {
            _ if stop.load(Ordering::Relaxed) => bail!("interrupted"),
            (Some(2), _) => bail!("the process that computes pairs alone could not run: {told}"),
            (Some(0 | 1), None) => {}
            (_, Some(place)) => {
                let why = format!("it ended the process that computed it alone ({status}); --retry tries it again");
                fail(store, ran, place, &why, |store| store.convict(place, &why))?;
            }
            (_, None) => {}
        }
        ensure!(self::open(store)?.len() < open.len(), "the process that computes pairs alone ended early ({status})");
    }
    ran.failed.sort_by_key(|failure| failure.place);
    Ok(())
}

/// The places of suspects that are not finished.
fn open(store: &Store) -> Result<Vec<usize>> {
    let states = store.journal()?.states()?;
    let is_open = |place: &usize| {
        let state = states.get(&JsonPath::from(&store.items[*place].name));
        state.is_some_and(|(_, state)| !matches!(state, State::Ended(_)))
    };
    Ok((store.main..store.main + store.suspects.len()).filter(is_open).collect())
}

/// Counts what the other process finished of `open`; returns the pair that it was computing, if any.
fn settle(store: &Store, ran: &mut Ran, open: &[usize]) -> Result<Option<usize>> {
    let states = store.journal()?.states()?;
    let mut culprit = None;
    for &place in open {
        match states.get(&JsonPath::from(&store.items[place].name)).map(|(_, state)| state) {
            Some(State::Ended(None)) => ran.done += 1,
            Some(State::Ended(Some(error))) => {
                let frame = JsonPath::from(&store.pairs[place].left);
                ran.failed.push(FailedPair { place, frame, error: error.clone() });
            }
            Some(State::Running) => culprit = Some(place),
            _ => {}
        }
    }
    Ok(culprit)
}

/// Runs this command on the suspects alone. Returns its status and its last error.
fn other_process(store: &Store, stop: &AtomicBool) -> Result<(ExitStatus, String)> {
    let start = || -> std::io::Result<_> {
        let mut args = std::env::args_os().skip(1);
        let mut command = Command::new(std::env::current_exe()?);
        command.args(args.next()).arg("--suspects").arg(&store.journal().map_err(std::io::Error::other)?.path);
        command.args(args).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
    };
    let mut child = start().context("the process that computes pairs alone cannot be started")?;
    let (mut stdin, stderr) = (child.stdin.take(), child.stderr.take());
    let reader = thread::Builder::new().spawn(move || {
        let mut text = Vec::new();
        stderr.map(|mut stderr| stderr.read_to_end(&mut text));
        String::from_utf8_lossy(&text).into_owned()
    });
    let reader = reader.context("a thread cannot be started; raise the limit of threads (ulimit -u)")?;
    let status = loop {
        if let Some(status) = child.try_wait().context("the process that computes pairs alone cannot be waited for")? {
            break status;
        }
        if stop.load(Ordering::Relaxed) {
            stdin = None; // it ends when it sees this
        }
        thread::sleep(LOOK);
    };
    drop(stdin);
    let text = reader.join().map_err(|_| anyhow!("what the process that computes pairs alone said is lost"))?;
    let (errors, others): (Vec<_>, Vec<_>) = text.lines().partition(|line| line.starts_with("error: "));
    for line in others {
        match line.strip_prefix("note: ") {
            Some(note) => warnings::warn(note),
            None if line.starts_with("failed: ") => message(line),
            None => {}
        }
    }
    Ok((status, errors.last().and_then(|line| line.strip_prefix("error: ")).unwrap_or_default().to_owned()))
}

/// In the process that computes suspects: stops when stdin ends, since then the waiting process has ended.
pub fn stop_with_parent(stop: &'static AtomicBool) -> Result<()> {
    let watch = move || {
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        stop.store(true, Ordering::Relaxed);
    };
    thread::Builder::new()
        .spawn(watch)
        .map(drop)
        .context("a thread cannot be started; raise the limit of threads (ulimit -u)")
}
