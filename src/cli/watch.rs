//! `etendue run --watch`: cases run anew as their files change.
//!
//! One thread listens: whenever something stirs in the folders of the cases, it waits until all is quiet, reads the cases, and
//! tells them if they are not what they were. What an event says of a file is never asked: editors save by writing over, by
//! renaming, by way of a copy. The other thread runs what is new; where it becomes old meanwhile, it is given up.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use super::commands::{coloured, fault, select, set_threads, take};
use super::conclude::conclude;
use super::exit;
use super::interrupt::Interrupt;
use super::options::{Reaching, Run};
use super::progress::Board;
use super::run::{Writing, measured, told};
use crate::case::{self, Case, Ink, Reach};
use crate::report;
use crate::trial::{CaseOutcome, RunOutcome};

/// Files are read when nothing has stirred for so long; an editor that saves stirs several times.
const QUIET: Duration = Duration::from_millis(100);
/// Where something stirs all the time, they are read after so many such pauses.
const PATIENCE: usize = 20;
/// How often a thread that waits looks up.
const GLANCE: Duration = Duration::from_millis(50);

/// The cases as they are, or what is wrong with them.
type Found = Result<Vec<Case>, String>;

pub(super) fn watch(options: &Run) -> Result<u8, u8> {
    let (selectors, reaching) = (&options.work.cases, &options.work.reaching);
    on_disk(selectors, reaching)?;
    let interrupt = Interrupt::heard()?;
    let _lock = take(&options.out)?;
    report::claim(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
    set_threads(options.work.threads)?;
    let (stir, stirred) = channel();
    let reach = reaching.reach();
    let mut folders = Folders::new(stir, reach)?;
    folders.watch(selectors)?;
    // Watched before they are read, so that no change is missed. A mistake in a file is waited out.
    let first = read(selectors, reach);
    let (version, ended) = (AtomicU64::new(0), AtomicBool::new(false));
    let (tell, news) = channel();
    thread::scope(|scope| {
        let (version, ended, last) = (&version, &ended, first.clone());
        let _ending = Ending(ended);
        let goes_on = || !ended.load(Ordering::Relaxed);
        scope.spawn(move || listen(selectors, folders, &stirred, last, version, &tell, &goes_on));
        let mut rounds = Rounds { options, interrupt: &interrupt, version, known: BTreeMap::new(), reported: None };
        rounds.go_on(first, &news)
    })
}

/// Says that it is over, also where that is by a panic.
struct Ending<'a>(&'a AtomicBool);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Refuses what cannot change.
fn on_disk(selectors: &[String], reaching: &Reaching) -> Result<(), u8> {
    let way = "--watch waits for files to change: give a case file or a folder (`etendue new NAME` writes one)";
    if selectors.is_empty() {
        return Err(fault(exit::USAGE, format!("the shipped cases are part of the program; {way}")));
    }
    if let Some(selector) = selectors.iter().find(|selector| !Path::new(selector).exists()) {
        // Says what is wrong with a name that is none.
        select(std::slice::from_ref(selector), reaching)?;
        return Err(fault(exit::USAGE, format!("`{selector}` is part of the program; {way}")));
    }
    Ok(())
}

fn read(selectors: &[String], reach: Reach) -> Found {
    // A file that is gone must not be looked for among the shipped cases.
    if let Some(gone) = selectors.iter().find(|selector| !Path::new(selector).exists()) {
        return Err(format!("{gone} is not there"));
    }
    let ink = if coloured() { Ink::Coloured } else { Ink::Plain };
    case::select_reaching(selectors, reach).map_err(|error| error.render(ink))
}

/// The folders that are watched.
struct Folders {
    watcher: RecommendedWatcher,
    watched: BTreeSet<PathBuf>,
    /// How far the paths in case files may reach.
    reach: Reach,
}

impl Folders {
    fn new(stir: Sender<()>, reach: Reach) -> Result<Folders, u8> {
        let watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
            // That a file was read, by ourselves for one, is no change; whatever is not known may be one.
            if !event.is_ok_and(|event| matches!(event.kind, EventKind::Access(_))) {
                let _ = stir.send(());
            }
        });
        let watcher = watcher.map_err(|error| fault(exit::OUTPUT, format!("files cannot be watched: {error}")))?;
        Ok(Folders { watcher, watched: BTreeSet::new(), reach })
    }

    /// Watches what the selectors lead to: of a file its folder (a file that is saved by renaming is another one), and the
    /// folders of the meshes and pictures that it names.
    fn watch(&mut self, selectors: &[String]) -> Result<(), u8> {
        for selector in selectors {
            let path = Path::new(selector);
            let at = |path: &Path| fault(exit::OUTPUT, format!("{} cannot be watched", path.display()));
            if path.is_dir() {
                self.add(path, RecursiveMode::Recursive).map_err(|()| at(path))?;
                continue;
            }
            let own = folder_of(path);
            self.add(&own, RecursiveMode::NonRecursive).map_err(|()| at(&own))?;
            // Behind a link, too; and folders that are not there yet are looked for again at the next change.
            let real = path.canonicalize().ok();
            for file in case::files_named(path, self.reach).into_iter().chain(real) {
                let _ = self.add(&folder_of(&file), RecursiveMode::NonRecursive);
            }
        }
        Ok(())
    }

    fn add(&mut self, folder: &Path, mode: RecursiveMode) -> Result<(), ()> {
        if !folder.is_dir() || self.watched.contains(folder) {
            return Ok(());
        }
        self.watcher.watch(folder, mode).map_err(|_| ())?;
        self.watched.insert(folder.to_owned());
        Ok(())
    }
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Tells what became of the cases, each time that they are not what they were.
///
/// - `version`: how often that was
fn listen(
    selectors: &[String],
    mut folders: Folders,
    stirred: &Receiver<()>,
    mut last: Found,
    version: &AtomicU64,
    tell: &Sender<Found>,
    goes_on: &dyn Fn() -> bool,
) {
    while goes_on() {
        match stirred.recv_timeout(GLANCE) {
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
            Ok(()) => {}
        }
        for _ in 0..PATIENCE {
            if !goes_on() || stirred.recv_timeout(QUIET).is_err() {
                break;
            }
            while stirred.try_recv().is_ok() {}
        }
        // Before they are read: what changes after that stirs again.
        let _ = folders.watch(selectors);
        let now = read(selectors, folders.reach);
        if now != last {
            last = now.clone();
            version.fetch_add(1, Ordering::Relaxed);
            if tell.send(now).is_err() {
                return;
            }
        }
    }
}

/// Runs what is new, and reports it beside what is known.
struct Rounds<'a> {
    options: &'a Run,
    interrupt: &'a Interrupt,
    version: &'a AtomicU64,
    /// By the names of the cases.
    known: BTreeMap<String, (Case, CaseOutcome)>,
    /// The cases of the last report, and what its verdicts came to.
    reported: Option<(Vec<String>, u8)>,
}

impl Rounds<'_> {
    fn go_on(&mut self, first: Found, news: &Receiver<Found>) -> Result<u8, u8> {
        let mut found = Some(first);
        let mut seen = 0;
        let mut code = exit::INTERRUPTED;
        loop {
            if let Some(found) = found.take() {
                code = match found {
                    Ok(cases) => self.round(&cases, seen)?,
                    Err(mistakes) => {
                        say!("{mistakes}");
                        exit::USAGE
                    }
                };
                if self.version.load(Ordering::Relaxed) == seen && !self.interrupt.asked() {
                    self.say("waiting for a change; Ctrl-C ends");
                }
            }
            if self.interrupt.asked() {
                return Ok(code);
            }
            match news.recv_timeout(GLANCE) {
                Ok(now) => {
                    seen += 1;
                    found = Some(now);
                }
                Err(RecvTimeoutError::Timeout) => {}
                // Whoever listened has ended, and has said why.
                Err(RecvTimeoutError::Disconnected) => return Ok(code),
            }
        }
    }

    /// One round; what its verdicts come to.
    ///
    /// - `seen`: the version of the cases
    fn round(&mut self, cases: &[Case], seen: u64) -> Result<u8, u8> {
        let options = self.options;
        let is_known = |case: &Case| self.known.get(&case.name).is_some_and(|(known, _)| known == case);
        let fresh: Vec<Case> = cases.iter().filter(|case| !is_known(case)).cloned().collect();
        let names: Vec<String> = cases.iter().map(|case| case.name.clone()).collect();
        if let Some((reported, code)) = &self.reported
            && fresh.is_empty()
            && *reported == names
        {
            self.say("all is as in the last report");
            return Ok(*code);
        }
        let settings = options.work.settings();
        if !fresh.is_empty() {
            let running: Vec<&str> = fresh.iter().map(|case| case.name.as_str()).collect();
            self.say(&format!("running {} of {}: {}", fresh.len(), cases.len(), running.join(", ")));
        }
        let stop = || self.interrupt.asked() || self.version.load(Ordering::Relaxed) != seen;
        let board = Board::new(fresh.len(), options.progress, options.quiet);
        let outcome = measured(&fresh, &settings, None, &board, &stop, None);
        board.finish();
        let outcome = outcome?;
        for done in &outcome.cases {
            if let Some(case) = fresh.iter().find(|case| case.name == done.name) {
                self.known.insert(case.name.clone(), (case.clone(), done.clone()));
            }
        }
        if !outcome.missing.is_empty() && !self.interrupt.asked() {
            // They are not what they were: the next round knows them.
            return Ok(exit::INTERRUPTED);
        }
        self.known.retain(|name, _| names.contains(name));
        let selectors: Vec<&str> = options.work.cases.iter().map(String::as_str).collect();
        let mut whole = RunOutcome::new(
            settings.seed,
            settings.command(&selectors, None) + options.work.reaching.reach().words(),
        );
        let of_now = |name: &String| self.known.get(name).filter(|_| !outcome.missing.contains(name));
        for name in &names {
            match of_now(name) {
                Some((_, outcome)) => whole.cases.push(outcome.clone()),
                None => whole.missing.push(name.clone()),
            }
        }
        report::claim(&options.out).map_err(|error| fault(exit::OUTPUT, error))?;
        if whole.cases.is_empty() {
            say!("{}", told(&whole, cases, options));
            return Ok(exit::INTERRUPTED);
        }
        let writing = Writing { out: &options.out, plots: !options.no_plots, watched: true };
        writing.write(&whole, cases, &settings, self.interrupt)?;
        let code = conclude(&whole, &options.out, &options.telling, None, options.quiet, options.allow_undecided)?;
        if !whole.missing.is_empty() {
            say!("{}", told(&whole, cases, options));
            return Ok(exit::INTERRUPTED);
        }
        self.reported = Some((names, code));
        Ok(code)
    }

    fn say(&self, words: &str) {
        if !self.options.quiet {
            say!("{words}");
        }
    }
}
