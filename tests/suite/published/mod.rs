//! The tables of obstructed form factors in `reports/tables/` are what this code makes, every row found in two ways.
//!
//! After a row is added, `UPDATE_TABLES=1 cargo test published` writes them anew.

mod geometry;
mod patches;
mod points;

use std::env;
use std::path::{Path, PathBuf};

/// Significant digits that are printed at most.
const MOST_DIGITS: usize = 15;
/// What both ways may be off a value as it is about to be printed, in units of its last digit.
const PRINTING: f64 = 0.75;
/// The same, from a printed value on any machine.
const CHECKING: f64 = 1.0;
const UPDATE: &str = "to write the tables anew: UPDATE_TABLES=1 cargo test published";

/// One number, found in two ways.
#[derive(Clone, Copy, Debug)]
pub struct Pair(pub [f64; 2]);

impl Pair {
    /// The value with as many digits as both ways have in common; the second word is how many.
    fn printed(&self) -> [String; 2] {
        if self.0 == [0.0, 0.0] {
            return ["0".to_owned(), "exact".to_owned()];
        }
        let printed = |digits: &usize| format!("{:.*e}", digits - 1, self.0[0]);
        let digits = (1..=MOST_DIGITS).rev().find(|digits| self.within(&printed(digits), PRINTING));
        let digits = digits.unwrap_or_else(|| panic!("not one digit in common: {self:?}"));
        [printed(&digits), digits.to_string()]
    }

    /// Whether both ways are within so many units of a printed value's last digit.
    fn within(&self, printed: &str, units: f64) -> bool {
        let value: f64 = printed.parse().unwrap_or(f64::NAN);
        let unit = match printed.split_once('e') {
            Some((mantissa, exponent)) => {
                let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
                let exponent: i32 = exponent.parse().unwrap_or(i32::MIN);
                format!("1e{}", exponent - decimals).parse().unwrap_or(f64::NAN)
            }
            None => 0.0,
        };
        self.0.iter().all(|found| (found - value).abs() <= units * unit)
    }
}

/// One row of a table.
pub struct Row {
    pub id: String,
    /// What a point sees; patches see each other in part.
    pub view: Option<String>,
    pub geometry: String,
    pub unobstructed: Pair,
    pub obstructed: Pair,
    /// What the two ways of `obstructed` are; see the README there.
    pub ways: String,
}

impl Row {
    fn words(&self) -> Vec<String> {
        let [whole, _] = self.unobstructed.printed();
        let [seen, digits] = self.obstructed.printed();
        let ends = [self.geometry.clone(), whole, seen, digits, self.ways.clone()];
        [self.id.clone()].into_iter().chain(self.view.clone()).chain(ends).collect()
    }
}

fn header(has_view: bool) -> Vec<&'static str> {
    let ends = ["geometry", "F_unobstructed", "F", "agree_digits", "ways"];
    ["id"].into_iter().chain(has_view.then_some("view")).chain(ends).collect()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/tables").join(name)
}

/// Compares a table with its rows as they are found now, or writes it.
///
/// - `least`: significant digits that each of its factors has
fn check(name: &str, rows: &[Row], least: usize) {
    let path = file(name);
    let has_view = rows[0].view.is_some();
    for row in rows {
        geometry::assert_exact_numbers(&row.geometry);
        let [seen, digits] = row.obstructed.printed();
        println!("{}: {seen} ({digits}) of {:?}, unobstructed {:?}", row.id, row.obstructed.0, row.unobstructed.0);
        let ([seen, _], [whole, _]) = (row.obstructed.0, row.unobstructed.0);
        let is_lit = row.view.as_deref() == Some("lit");
        assert!(if is_lit { seen == whole } else { seen < whole }, "{}: {seen} of {whole} is seen", row.id);
    }
    if env::var_os("UPDATE_TABLES").is_some() {
        let mut table = csv::WriterBuilder::new().from_path(&path).expect("the table can be written");
        table.write_record(header(has_view)).expect("a header");
        rows.iter().for_each(|row| table.write_record(row.words()).expect("a row"));
        table.flush().expect("the table can be written");
    }
    let mut table =
        csv::Reader::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}; {UPDATE}", path.display()));
    assert_eq!(table.headers().expect("a header"), &csv::StringRecord::from(header(has_view)), "{name}; {UPDATE}");
    let kept: Vec<csv::StringRecord> = table.records().map(|record| record.expect("a row")).collect();
    assert_eq!(kept.len(), rows.len(), "rows of {name}; {UPDATE}");
    let mut faults = Vec::new();
    for (kept, row) in kept.iter().zip(rows) {
        let made = row.words();
        // The digits in common may be one more or less elsewhere; what is printed may not be wrong.
        let [whole, seen, digits] = [3, 2, 1].map(|from_end| kept.len() - 1 - from_end).map(|at| &kept[at]);
        let numbers = made.len() - 4..made.len() - 1;
        let same_words = (0..made.len()).filter(|at| !numbers.contains(at)).all(|at| kept[at] == *made[at]);
        let has_digits = if digits == "exact" {
            seen == "0"
        } else {
            let printed = seen.split('e').next().map_or(0, |m| m.chars().filter(char::is_ascii_digit).count());
            digits.parse() == Ok(printed) && printed >= least
        };
        if !same_words
            || !has_digits
            || !row.unobstructed.within(whole, CHECKING)
            || !row.obstructed.within(seen, CHECKING)
        {
            faults.push(format!("kept {kept:?}\nmade {made:?}; {:?}, {:?}", row.unobstructed, row.obstructed));
        }
    }
    assert!(faults.is_empty(), "{name}, {} rows; {UPDATE}\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn points_are_as_published() {
    check("points.csv", &points::rows(), 13);
}

#[test]
fn patches_are_as_published() {
    check("patches.csv", &patches::rows(), 12);
}

#[test]
fn a_wrong_digit_is_seen() {
    let pair = Pair([0.182_355_903_668_595_8, 0.182_355_903_668_595_9]);
    let [printed, digits] = pair.printed();
    assert_eq!((printed.as_str(), digits.as_str()), ("1.82355903668596e-1", "15"));
    assert!(pair.within(&printed, CHECKING));
    for wrong in ["1.82355903668598e-1", "1.82355903668594e-1", "1.82355903668596e-2", "0", ""] {
        assert!(!pair.within(wrong, CHECKING), "{wrong}");
    }
    assert_eq!(Pair([0.25, 0.25 + 1e-9]).printed(), ["2.5000000e-1", "8"]);
    assert_eq!(Pair([0.0, 0.0]).printed(), ["0", "exact"]);
    assert!(Pair([0.0, 0.0]).within("0", CHECKING) && !Pair([0.0, 1e-300]).within("0", CHECKING));
}
