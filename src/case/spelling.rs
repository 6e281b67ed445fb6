//! The known name that somebody may have meant.

/// The candidate nearest to what was said, if it is near enough to be a slip: at most a third of its letters off.
/// Of equally near ones, the first.
pub(crate) fn nearest<'c>(said: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let said = said.to_lowercase();
    candidates
        .into_iter()
        .map(|candidate| (distance(&said, &candidate.to_lowercase()), candidate))
        .filter(|(slips, candidate)| *slips <= (said.chars().count().max(candidate.chars().count())).div_ceil(3))
        .min_by_key(|(slips, _)| *slips)
        .map(|(_, candidate)| candidate)
}

/// The fewest slips (a letter added, left out, changed, or swapped with its neighbour) from one word to the other.
///
/// Optimal string alignment; words longer than 100 letters count as wholly different, to keep the work bounded.
pub(super) fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len() > 100 || b.len() > 100 {
        return a.len().max(b.len());
    }
    // Row i holds the distances of a's first i letters to each beginning of b; three rows are alive at once.
    let mut before_last: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let changed = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = changed.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_counted() {
        assert_eq!(distance("radius", "radius"), 0);
        assert_eq!(distance("raduis", "radius"), 1, "a swap is one slip");
        assert_eq!(distance("radus", "radius"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
    }

    #[test]
    fn only_a_near_name_is_offered() {
        let keys = ["center", "normal", "radius", "exitance"];
        assert_eq!(nearest("raduis", keys), Some("radius"));
        assert_eq!(nearest("Centre", keys), Some("center"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest("x", keys), None);
    }
}
