//! What the command line may change about a study.

use std::fmt::Write as _;

use crate::case::{Replicates, SmallestBias, Study};
use crate::sampling::Strategy;

/// How hard to look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Effort {
    /// Five times coarser than the case asks, and no more than 64 samples: a look, in seconds.
    Quick,
    /// As the case asks.
    #[default]
    Standard,
    /// Ten times finer than the case asks.
    Thorough,
}

/// Settings that override those of every case.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Overrides {
    pub strategies: Option<Vec<Strategy>>,
    /// Points on each source, per shading point and replicate: the N that are studied, each 1 or more.
    pub samples: Option<Vec<u64>>,
    /// Independent repeats of each estimate.
    pub replicates: Option<Replicates>,
    /// Relative: what a pass must have been able to see.
    pub smallest_bias: Option<SmallestBias>,
}

/// A run's settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Base of all random streams: the same seed gives the same numbers, for any number of threads.
    pub seed: u64,
    pub effort: Effort,
    /// What stands here stands instead of every case's own.
    pub overrides: Overrides,
}

impl Settings {
    /// The seed where none is given.
    pub const DEFAULT_SEED: u64 = 1;

    /// A case's study with everything applied.
    pub fn study(&self, of_case: &Study) -> Study {
        let mut study = of_case.clone();
        match self.effort {
            Effort::Standard => {}
            Effort::Quick => {
                study.smallest_bias.mean *= 5.0;
                study.smallest_bias.point *= 5.0;
                let few: Vec<u64> = study.samples.iter().copied().filter(|n| *n <= 64).collect();
                if !few.is_empty() {
                    study.samples = few;
                }
            }
            Effort::Thorough => {
                study.smallest_bias.mean *= 0.1;
                study.smallest_bias.point *= 0.1;
            }
        }
        let Overrides { strategies, samples, replicates, smallest_bias } = self.overrides.clone();
        study.strategies = strategies.unwrap_or(study.strategies);
        study.samples = samples.unwrap_or(study.samples);
        study.replicates = replicates.unwrap_or(study.replicates);
        study.smallest_bias = smallest_bias.unwrap_or(study.smallest_bias);
        study.samples.sort_unstable();
        study.samples.dedup();
        study
    }

    /// The command that gives the same numbers: only options that move them.
    ///
    /// - `cases`: selectors; `strategy`: one only, or all that the settings name
    pub fn command(&self, cases: &[&str], strategy: Option<Strategy>) -> String {
        let mut text = String::from("etendue run");
        for case in cases {
            let _ = write!(text, " {}", quoted(case));
        }
        text + &self.options(strategy)
    }

    /// Of such a command what follows after the cases.
    pub fn options(&self, strategy: Option<Strategy>) -> String {
        let mut text = String::new();
        match self.effort {
            Effort::Quick => text.push_str(" --quick"),
            Effort::Standard => {}
            Effort::Thorough => text.push_str(" --thorough"),
        }
        let listed = |items: Vec<String>| items.join(",");
        let strategies = strategy.map(|s| vec![s]).or_else(|| self.overrides.strategies.clone());
        if let Some(strategies) = strategies {
            let _ = write!(text, " --strategy {}", listed(strategies.iter().map(Strategy::to_string).collect()));
        }
        if let Some(samples) = &self.overrides.samples {
            let _ = write!(text, " --samples {}", listed(samples.iter().map(u64::to_string).collect()));
        }
        match self.overrides.replicates {
            Some(Replicates::Fixed(n)) => {
                let _ = write!(text, " --replicates {n}");
            }
            Some(Replicates::Auto) => text.push_str(" --replicates auto"),
            None => {}
        }
        if let Some(SmallestBias { mean, point }) = self.overrides.smallest_bias {
            let _ = write!(text, " --smallest-bias {mean},{point}");
        }
        let _ = write!(text, " --seed {}", self.seed);
        text
    }
}

/// A word that a shell takes as one.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_names_what_moves_numbers() {
        let mut settings = Settings { seed: 7, effort: Effort::Quick, overrides: Overrides::default() };
        assert_eq!(settings.command(&[], None), "etendue run --quick --seed 7");
        settings.effort = Effort::Standard;
        settings.overrides.samples = Some(vec![1, 4]);
        settings.overrides.smallest_bias = Some(SmallestBias { mean: 0.02, point: 0.2 });
        assert_eq!(
            settings.command(&["penumbra/eclipse", "it's here.toml"], Some(Strategy::Random)),
            r"etendue run penumbra/eclipse 'it'\''s here.toml' --strategy random --samples 1,4 --smallest-bias 0.02,0.2 --seed 7"
        );
    }

    #[test]
    fn overrides_win_over_effort_and_case() {
        let overrides = Overrides { samples: Some(vec![256, 2, 2]), ..Overrides::default() };
        let study = Settings { seed: 1, effort: Effort::Quick, overrides }.study(&Study::default());
        assert_eq!(study.samples, [2, 256]);
        assert_eq!(study.smallest_bias, SmallestBias { mean: 5e-2, point: 5e-1 });
    }
}
