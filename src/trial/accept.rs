//! Deviations that a study lists as known and accepted.

use super::outcome::JudgedProperty;
use crate::case::Accepted;
use crate::sampling::Strategy;
use crate::statistics::Verdict;

/// Turns failures that are accepted into passes that say so; and marks those that are listed and no longer seen.
///
/// - `strategy`: `None` for a guest, of whom only what is accepted of everybody is
pub(super) fn accept(verdicts: &mut [JudgedProperty], strategy: Option<Strategy>, accepted: &[Accepted]) {
    for judged in verdicts {
        let own = |item: &&Accepted| {
            item.property == judged.property && (item.strategy.is_none() || item.strategy == strategy)
        };
        let Some(item) = accepted.iter().filter(own).max_by(|a, b| a.size.total_cmp(&b.size)) else { continue };
        let largest = judged.effect_low.abs().max(judged.effect_high.abs());
        let percent = 100.0 * item.size;
        match judged.verdict {
            Verdict::Fail if largest <= item.size => {
                judged.verdict = Verdict::Pass;
                judged.note = Some(format!("within {percent} %, accepted: {}. {}", item.reason, judged.words));
            }
            Verdict::Fail => {
                judged.words += &format!("; {percent} % is accepted ({}), and this is more", item.reason);
            }
            Verdict::Pass => {
                judged.note =
                    Some(format!("the accepted deviation of {percent} % is no longer seen: {}", item.reason));
            }
            Verdict::Undecided => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(verdict: Verdict, effect: f64) -> JudgedProperty {
        JudgedProperty {
            property: "bias",
            verdict,
            evidence: 7.0,
            threshold: 6.0,
            effect,
            effect_low: effect - 0.001,
            effect_high: effect + 0.001,
            smallest_bias_mean: None,
            smallest_bias_point: None,
            words: "biased".to_owned(),
            note: None,
            reproduce: String::new(),
        }
    }

    #[test]
    fn what_is_accepted_passes_and_says_so() {
        let item = |strategy| Accepted { property: "bias", strategy, size: 0.03, reason: "f32".to_owned() };
        let list = [item(Some(Strategy::Random))];
        let after = |verdict, effect, strategy| {
            let mut verdicts = [judged(verdict, effect)];
            accept(&mut verdicts, Some(strategy), &list);
            let [judged] = verdicts;
            (judged.verdict, judged.note)
        };
        let (verdict, note) = after(Verdict::Fail, -0.02, Strategy::Random);
        assert!(verdict == Verdict::Pass && note.is_some_and(|note| note.contains("f32") && note.contains("biased")));
        assert_eq!(after(Verdict::Fail, 0.0295, Strategy::Random).0, Verdict::Fail);
        assert_eq!(after(Verdict::Fail, -0.02, Strategy::Stratified), (Verdict::Fail, None));
        assert!(after(Verdict::Pass, 0.0, Strategy::Random).1.is_some_and(|note| note.contains("no longer")));
        assert_eq!(after(Verdict::Undecided, 0.0, Strategy::Random), (Verdict::Undecided, None));
    }
}
