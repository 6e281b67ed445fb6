//! Who keeps what units of work came to, and whose they are.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::desk::{Portion, Stage};

/// A unit of a run: the smallest part whose result is kept by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Unit {
    /// The case, counted from 0 in the order of the run.
    pub case: u32,
    pub portion: Portion,
}

/// What came of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// A pure function of the unit and of the run's settings.
    pub bytes: Vec<u8>,
    /// That it took. Differs from time to time.
    pub seconds: f64,
}

/// What to do about a unit that nobody has kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// It is made now, and kept.
    Make,
    /// It is somebody else's share.
    Leave,
    /// It should have been there: the run ends.
    GiveUp,
}

/// Who keeps the results of units. Asked from many threads at a time.
pub trait Keeper: Sync {
    /// What a unit came to, if it is here.
    fn found(&self, unit: &Unit) -> Option<Kept>;

    fn absent(&self, unit: &Unit) -> Absent;

    /// Takes what came of a unit. `Break`: it cannot be kept, and without that the run is in vain.
    fn keep(&self, unit: &Unit, kept: Kept) -> ControlFlow<()>;

    /// Whether anything of a stage of a case is to be made here, or to be had.
    fn wants(&self, _case: u32, _stage: Stage) -> bool {
        true
    }

    /// Whether units are made here, rather than all had.
    fn makes(&self) -> bool {
        true
    }

    /// Whether some units may be somebody else's, so that nothing is judged.
    fn shares(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::mem::discriminant;
    use std::sync::Mutex;

    use super::*;
    use crate::case::{Case, shipped};
    use crate::sampling::Strategy;
    use crate::trial::{Effort, Overrides, Progress, Settings, run_kept};

    /// Keeps units in memory, and makes those that it has not.
    #[derive(Default)]
    struct Memory {
        units: Mutex<BTreeMap<Unit, Kept>>,
        /// In this run.
        made: Mutex<Vec<Unit>>,
    }

    impl Keeper for Memory {
        fn found(&self, unit: &Unit) -> Option<Kept> {
            self.units.lock().unwrap().get(unit).cloned()
        }
        fn absent(&self, _: &Unit) -> Absent {
            Absent::Make
        }
        fn keep(&self, unit: &Unit, kept: Kept) -> ControlFlow<()> {
            self.units.lock().unwrap().insert(*unit, kept);
            self.made.lock().unwrap().push(*unit);
            ControlFlow::Continue(())
        }
    }

    /// Results of all units; all techniques have a prediction of their own.
    fn run(cases: &[Case], keeper: &Memory) -> BTreeMap<Unit, Vec<u8>> {
        let overrides = Overrides { strategies: Some(Strategy::ALL.to_vec()), ..Overrides::default() };
        let settings = Settings { seed: 1, effort: Effort::Quick, overrides };
        keeper.made.lock().unwrap().clear();
        run_kept(cases, &settings, keeper, &|_: Progress| ControlFlow::Continue(())).unwrap();
        keeper.units.lock().unwrap().iter().map(|(unit, kept)| (*unit, kept.bytes.clone())).collect()
    }

    /// Results under units that they do not belong to, as no fault of a disk would leave them: their checksums are right. They are
    /// made anew, rather than taken for what they are not, but for those whose shape is the same.
    #[test]
    fn results_of_another_shape_are_not_taken() {
        let names =
            ["penumbra/half-plane", "caustic/paraboloid", "caustic/glass-ball", "interreflection/coaxial-disks"];
        let cases: Vec<Case> = names
            .map(|name| shipped().find(|case| case.name() == name).expect("it is shipped").read().unwrap())
            .into_iter()
            .collect();
        let keeper = Memory::default();
        let made = run(&cases, &keeper);
        assert_eq!(keeper.made.lock().unwrap().len(), made.len());
        assert!(run(&cases, &keeper) == made, "what is kept is taken");
        assert_eq!(*keeper.made.lock().unwrap(), [], "and nothing is made again");
        let mut forged = 0;
        for (unit, kept) in keeper.units.lock().unwrap().iter_mut() {
            let stage = unit.portion.stage;
            let mut alike =
                made.iter().filter(|(other, _)| discriminant(&other.portion.stage) == discriminant(&stage));
            // Light of another budget, all else of another case.
            let is_other = |other: &Unit| match stage {
                Stage::Light { .. } => other.portion.stage != stage,
                _ => other.case != unit.case,
            };
            let other = alike.find(|(other, bytes)| is_other(other) && **bytes != kept.bytes);
            if let Some((_, bytes)) = other {
                kept.bytes.clone_from(bytes);
                forged += 1;
            }
        }
        assert!(forged > made.len() / 2, "{forged} of {}", made.len());
        let again = run(&cases, &keeper);
        let taken = made.iter().filter(|(unit, bytes)| again[unit] != **bytes).map(|(unit, _)| unit.portion.stage);
        let taken: Vec<Stage> = taken.filter(|stage| !matches!(stage, Stage::Survey | Stage::Compared)).collect();
        assert!(taken.is_empty(), "{taken:?}");
        assert_eq!(again.len(), made.len());
    }
}
