//! Which run a journal belongs to.

use std::collections::HashSet;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::case::{Case, Reach};
use crate::configuration::Sha256;
use crate::trial::{Settings, Shard, numeric_fingerprint};

/// All that the numbers of a run follow from, and how to begin it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    pub etendue_version: String,
    /// [`numeric_fingerprint`].
    pub machine: String,
    pub settings: Settings,
    /// What selected the cases on the command line; none: the shipped ones.
    pub selectors: Vec<String>,
    /// How far their paths were let reach.
    pub reach: Reach,
    /// Where that was said, as far as it can be told in letters.
    pub folder: String,
    pub cases: Vec<CaseIdentity>,
    /// `None`: all of it.
    pub shard: Option<Shard>,
}

/// A case by name and content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseIdentity {
    pub name: String,
    /// The first 64 bits of SHA-256, hexadecimal, over all of it that moves numbers or is shown.
    pub digest: String,
}

impl CaseIdentity {
    fn of(case: &Case) -> CaseIdentity {
        let mut digest = Sha256::new();
        // Floats are told by digits that give them back.
        let told = format!(
            "{}\n{}\n{:?}\n{:?}\n{}",
            case.configuration.digest(),
            case.title,
            case.study,
            case.light,
            case.selector
        );
        digest.update(told.as_bytes());
        let digest = digest.finalize()[..8].iter().map(|byte| format!("{byte:02x}")).collect();
        CaseIdentity { name: case.name.clone(), digest }
    }
}

impl Identity {
    /// Of a run that begins here and now.
    ///
    /// - `selectors`, `reach`: as they were given
    pub fn new(
        cases: &[Case],
        settings: &Settings,
        selectors: &[String],
        reach: Reach,
        shard: Option<Shard>,
    ) -> Identity {
        Identity {
            etendue_version: env!("CARGO_PKG_VERSION").to_owned(),
            machine: numeric_fingerprint(),
            settings: settings.clone(),
            selectors: selectors.to_vec(),
            reach,
            folder: std::env::current_dir().unwrap_or_default().to_string_lossy().into_owned(),
            cases: cases.iter().map(CaseIdentity::of).collect(),
            shard,
        }
    }

    /// What another has that makes it another run; `None` if it is the same, and perhaps another shard of it.
    pub fn difference(&self, other: &Identity) -> Option<String> {
        let differs = |what: &str, other: &str, own: &str| Some(format!("its {what} is {other}, not {own}"));
        if other.etendue_version != self.etendue_version {
            return differs("etendue", &other.etendue_version, &self.etendue_version);
        }
        let (own, others) = (&self.settings, &other.settings);
        if others.seed != own.seed {
            return differs("seed", &others.seed.to_string(), &own.seed.to_string());
        }
        if others != own {
            let said = |settings: &Settings| format!("`{}`", settings.options(None).trim());
            return Some(format!("its options are {}, not {}", said(others), said(own)));
        }
        if let Some(why) = self.difference_of_cases(other) {
            return Some(why);
        }
        if other.machine != self.machine {
            return Some(format!(
                "its machine gives other numbers (fingerprint {}, not {}): the same build on the same kind of processor would not",
                other.machine, self.machine
            ));
        }
        match (other.shard, self.shard) {
            (Some(theirs), Some(own)) if theirs.of != own.of => {
                differs("run cut", &format!("into {} shards", theirs.of), &format!("into {}", own.of))
            }
            (Some(shard), None) => Some(format!("it is shard {shard}, not a whole run")),
            (None, Some(_)) => Some("it is a whole run, not a shard".to_owned()),
            _ => None,
        }
    }

    fn difference_of_cases(&self, other: &Identity) -> Option<String> {
        if self.cases == other.cases {
            return None;
        }
        let names =
            |identity: &'_ Identity| -> Vec<String> { identity.cases.iter().map(|case| case.name.clone()).collect() };
        let (own, others) = (names(self), names(other));
        let among = |names: &[String]| names.iter().cloned().collect::<HashSet<_>>();
        let (among_own, among_others) = (among(&own), among(&others));
        if let Some(name) = others.iter().find(|name| !among_own.contains(*name)) {
            return Some(format!("it has the case {name}, which is none of this run's"));
        }
        if let Some(name) = own.iter().find(|name| !among_others.contains(*name)) {
            return Some(format!("it lacks the case {name}"));
        }
        if own != others {
            return Some("its cases are in another order".to_owned());
        }
        let changed = self.cases.iter().zip(&other.cases).find(|(own, theirs)| own.digest != theirs.digest);
        changed.map(|(case, _)| {
            format!(
                "its case {} is another than it is now: its file was changed, or is named in another way",
                case.name
            )
        })
    }

    /// The command that makes it: only what moves numbers.
    pub fn command(&self) -> String {
        let selectors: Vec<&str> = self.selectors.iter().map(String::as_str).collect();
        self.settings.command(&selectors, None) + self.reach.words()
    }

    /// The folder in which its cases were selected, where that still is one.
    pub fn place(&self) -> Option<&Path> {
        Some(Path::new(&self.folder)).filter(|folder| folder.is_dir())
    }
}
