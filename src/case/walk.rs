//! Walking a parsed file with the schema in hand: each value is taken out as what it should be, or a mistake is noted.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use super::error::{CaseError, Mistake};
use super::place::Places;
use super::schema::{self, Key, MAX_MAGNITUDE, Need, Table};
use crate::intake::{CASE_MISTAKES, STUDY_ENTRIES};

/// Unknown keys of one table that may be misspelt known ones, at most.
const LOOKED_AT: usize = 100;

/// The mistakes found so far in one file.
pub(super) struct Log<'t> {
    places: Places<'t>,
    /// Lines (from 0) on which the text is no TOML: what stands there is not judged further.
    broken_lines: BTreeSet<usize>,
    mistakes: Vec<Mistake>,
    /// Beyond those that are kept.
    more: usize,
    /// Where the last one stands that is not kept.
    last: Range<usize>,
}

impl<'t> Log<'t> {
    pub(super) fn new(path: &str, text: &'t str) -> Log<'t> {
        let (broken_lines, mistakes) = (BTreeSet::new(), Vec::new());
        Log { places: Places::new(path, text), broken_lines, mistakes, more: 0, last: 0..0 }
    }

    fn keep(&mut self, span: Range<usize>, error: CaseError, also: Vec<(Range<usize>, String)>) {
        if self.is_full() {
            self.more += 1;
            self.last = span;
        } else {
            self.mistakes.push(Mistake { error, place: self.places.place(span), also });
        }
    }

    /// Whether further mistakes are only counted.
    pub(super) fn is_full(&self) -> bool {
        self.mistakes.len() as u64 >= CASE_MISTAKES
    }

    /// Notes a syntax error. One a line is enough: the parser stumbles on over the same spot.
    pub(super) fn add_syntax(&mut self, span: Range<usize>, error: CaseError) {
        if self.broken_lines.insert(self.places.line_of(span.start)) {
            self.keep(span, error, Vec::new());
        }
    }

    /// Marks the lines of a span as no TOML, without a mistake of their own.
    pub(super) fn mark_broken(&mut self, span: &Range<usize>) {
        self.broken_lines.extend(self.places.line_of(span.start)..=self.places.line_of(span.end));
    }

    pub(super) fn add(&mut self, span: Range<usize>, error: CaseError) {
        self.add_with(span, error, Vec::new());
    }

    pub(super) fn add_with(&mut self, span: Range<usize>, error: CaseError, also: Vec<(Range<usize>, String)>) {
        let (first, last) = (self.places.line_of(span.start), self.places.line_of(span.end));
        let unsure = !self.broken_lines.is_empty() && error.is_absence();
        if !unsure && self.broken_lines.range(first..=last).next().is_none() {
            self.keep(span, error, also);
        }
    }

    /// How many mistakes there are so far.
    pub(super) fn len(&self) -> usize {
        self.mistakes.len() + self.more
    }

    /// All of them, in the order of the text.
    pub(super) fn into_mistakes(mut self) -> Vec<Mistake> {
        self.mistakes.sort_by_key(|mistake| (mistake.span().start, mistake.span().end));
        if self.more > 0 {
            let place = self.places.place(self.last.clone());
            self.mistakes.push(Mistake { error: CaseError::More { more: self.more }, place, also: Vec::new() });
        }
        self.mistakes
    }
}

/// One table of the file, with what the schema says of it.
#[derive(Clone)]
pub(super) struct Node<'t> {
    table: &'t DeTable<'t>,
    pub(super) schema: &'static Table,
    /// Its header, or its text if it stands in a line.
    pub(super) span: Range<usize>,
}

impl<'t> Node<'t> {
    /// Notes every key that the schema does not know.
    pub(super) fn new(table: &'t DeTable<'t>, schema: &'static Table, span: Range<usize>, log: &mut Log) -> Node<'t> {
        for key in table.keys() {
            let said = key.get_ref().as_ref();
            match schema.key(said) {
                None if log.is_full() => log.add(
                    key.span(),
                    CaseError::UnknownKey {
                        table: String::new(),
                        said: String::new(),
                        accepted: Vec::new(),
                        nearest: None,
                    },
                ),
                None => log.add(key.span(), CaseError::unknown_key(schema, said)),
                Some(known) if known.need == Need::Later => {
                    log.add(key.span(), CaseError::NotYet { key: schema.full_name(said) });
                }
                Some(_) => {}
            }
        }
        Node { table, schema, span }
    }

    fn of_value(
        value: &'t Spanned<DeValue<'t>>,
        schema: &'static Table,
        key: &str,
        log: &mut Log,
    ) -> Option<Node<'t>> {
        match value.get_ref() {
            DeValue::Table(table) => Some(Node::new(table, schema, value.span(), log)),
            other => {
                log.add(value.span(), wrong_type(key.into(), other, "a table"));
                None
            }
        }
    }

    /// Where a key's value stands; the table itself if there is no such key.
    pub(super) fn span_of(&self, key: &str) -> Range<usize> {
        self.table.get(key).map_or(self.span.clone(), Spanned::span)
    }

    pub(super) fn has(&self, key: &Key) -> bool {
        self.table.contains_key(key.name)
    }

    /// Whether an unknown key of the table was probably meant to be this one.
    pub(super) fn misspells(&self, key: &Key) -> bool {
        let unknown =
            self.table.keys().map(|said| said.get_ref().as_ref()).filter(|said| self.schema.key(said).is_none());
        let mut meant =
            unknown.take(LOOKED_AT).filter_map(|said| super::spelling::nearest(said, self.schema.accepted()));
        meant.any(|name| name == key.name) && !self.has(key)
    }

    /// Tables below the named one: each of an array counts.
    pub(super) fn n_tables(&self, key: &Key) -> u64 {
        let Some(DeValue::Table(role)) = self.raw(key).map(Spanned::get_ref) else { return 0 };
        let count = |value: &Spanned<DeValue>| match value.get_ref() {
            DeValue::Array(items) => items.len() as u64,
            _ => 1,
        };
        role.values().map(count).sum()
    }

    fn name_of(&self, key: &Key) -> String {
        self.schema.full_name(key.name)
    }

    /// A key's value; its absence is noted if it is required.
    fn value(&self, key: &Key, log: &mut Log) -> Option<&'t Spanned<DeValue<'t>>> {
        let value = self.table.get(key.name);
        if value.is_none() && key.need == Need::Required && !self.misspells(key) {
            let unit = if key.unit.is_empty() { String::new() } else { format!(" ({})", key.unit) };
            let expected = format!("{}{unit}", key.value.expected());
            log.add(self.span.clone(), CaseError::MissingKey { table: self.schema.title(), key: key.name, expected });
        }
        value
    }

    pub(super) fn refuse_type(&self, key: &Key, value: &Spanned<DeValue>, expected: &'static str, log: &mut Log) {
        log.add(value.span(), wrong_type(self.name_of(key), value.get_ref(), expected));
    }

    pub(super) fn table(&self, key: &Key, schema: &'static Table, log: &mut Log) -> Option<Node<'t>> {
        let value = self.value(key, log)?;
        Node::of_value(value, schema, &self.name_of(key), log)
    }

    /// One table or an array of them.
    pub(super) fn tables(&self, key: &Key, schema: &'static Table, log: &mut Log) -> Vec<Node<'t>> {
        let name = self.name_of(key);
        match self.value(key, log).map(|value| (value, value.get_ref())) {
            None => Vec::new(),
            Some((_, DeValue::Array(items))) => {
                items.iter().filter_map(|item| Node::of_value(item, schema, &name, log)).collect()
            }
            Some((value, DeValue::Table(_))) => Node::of_value(value, schema, &name, log).into_iter().collect(),
            Some((value, _)) => {
                self.refuse_type(key, value, key.value.expected(), log);
                Vec::new()
            }
        }
    }

    pub(super) fn text(&self, key: &Key, log: &mut Log) -> Option<&'t str> {
        let value = self.value(key, log)?;
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.refuse_type(key, value, key.value.expected(), log);
        }
        text
    }

    /// true or false.
    pub(super) fn flag(&self, key: &Key, log: &mut Log) -> Option<bool> {
        let value = self.value(key, log)?;
        let flag = value.get_ref().as_bool();
        if flag.is_none() {
            self.refuse_type(key, value, key.value.expected(), log);
        }
        flag
    }

    /// A finite number of ordinary size.
    pub(super) fn number(&self, key: &Key, log: &mut Log) -> Option<f64> {
        let value = self.value(key, log)?;
        self.number_of(key, value, MAX_MAGNITUDE, log)
    }

    fn number_of(&self, key: &Key, value: &Spanned<DeValue>, most: f64, log: &mut Log) -> Option<f64> {
        let said = match value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) => Some(integer_as_f64(integer)),
            _ => None,
        };
        let Some(said) = said else {
            self.refuse_type(key, value, "a number", log);
            return None;
        };
        let key = self.name_of(key);
        if !said.is_finite() {
            log.add(value.span(), CaseError::NotFinite { key, said });
        } else if said.abs() > most {
            log.add(value.span(), CaseError::TooFar { key, said });
        } else {
            return Some(said);
        }
        None
    }

    /// So many finite numbers of ordinary size.
    pub(super) fn numbers<const N: usize>(&self, key: &Key, log: &mut Log) -> Option<[f64; N]> {
        let value = self.value(key, log)?;
        self.numbers_of(key, value, log)
    }

    pub(super) fn numbers_of<const N: usize>(
        &self,
        key: &Key,
        value: &Spanned<DeValue>,
        log: &mut Log,
    ) -> Option<[f64; N]> {
        let DeValue::Array(items) = value.get_ref() else {
            self.refuse_type(key, value, key.value.expected(), log);
            return None;
        };
        let numbers: Vec<_> = items.iter().map(|item| self.number_of(key, item, MAX_MAGNITUDE, log)).collect();
        let Ok(numbers) = <[Option<f64>; N]>::try_from(numbers) else {
            let key = self.name_of(key);
            log.add(value.span(), CaseError::Length { key, what: "numbers", said: items.len(), expected: N });
            return None;
        };
        numbers.iter().all(Option::is_some).then(|| numbers.map(Option::unwrap_or_default))
    }

    /// The table in the place of a number, if there is one.
    pub(super) fn texture(&self, key: &Key, log: &mut Log) -> Option<Node<'t>> {
        let (value, schema::Value::Field(schema)) = (self.raw(key)?, key.value) else { return None };
        match value.get_ref() {
            DeValue::Table(_) => Node::of_value(value, schema, &self.name_of(key), log),
            _ => None,
        }
    }

    /// A point or an edge.
    pub(super) fn vector(&self, key: &Key, log: &mut Log) -> Option<DVec3> {
        let value = self.value(key, log)?;
        self.vector_of(key, value, MAX_MAGNITUDE, log)
    }

    /// A direction: its length means nothing, so any finite one will do.
    pub(super) fn direction(&self, key: &Key, log: &mut Log) -> Option<DVec3> {
        let value = self.value(key, log)?;
        self.vector_of(key, value, f64::MAX, log)
    }

    fn vector_of(&self, key: &Key, value: &Spanned<DeValue>, most: f64, log: &mut Log) -> Option<DVec3> {
        let DeValue::Array(items) = value.get_ref() else {
            self.refuse_type(key, value, "an array of three numbers", log);
            return None;
        };
        let numbers: Vec<_> = items.iter().map(|item| self.number_of(key, item, most, log)).collect();
        match numbers[..] {
            [x, y, z] => Some(DVec3::new(x?, y?, z?)),
            _ => {
                let key = self.name_of(key);
                log.add(value.span(), CaseError::Length { key, what: "numbers", said: numbers.len(), expected: 3 });
                None
            }
        }
    }

    /// Points, at most `most`.
    pub(super) fn vectors(&self, key: &Key, most: u64, log: &mut Log) -> Option<Vec<DVec3>> {
        let value = self.value(key, log)?;
        let items = self.items(key, value, log)?;
        if items.len() as u64 > most {
            log.add(value.span(), CaseError::TooMany { what: "vertices", said: items.len() as u128, limit: most });
            return None;
        }
        let points: Vec<_> = items.iter().map(|item| self.vector_of(key, item, MAX_MAGNITUDE, log)).collect();
        points.into_iter().collect()
    }

    pub(super) fn items(
        &self,
        key: &Key,
        value: &'t Spanned<DeValue<'t>>,
        log: &mut Log,
    ) -> Option<&'t [Spanned<DeValue<'t>>]> {
        match value.get_ref() {
            DeValue::Array(items) => Some(items),
            _ => {
                self.refuse_type(key, value, key.value.expected(), log);
                None
            }
        }
    }
}

impl<'t> Node<'t> {
    /// An integer from `least` to `most`.
    pub(super) fn count(&self, key: &Key, least: u64, most: u64, log: &mut Log) -> Option<u64> {
        let value = self.value(key, log)?;
        self.count_of(key, value, least, most, log)
    }

    pub(super) fn count_of(
        &self,
        key: &Key,
        value: &Spanned<DeValue>,
        least: u64,
        most: u64,
        log: &mut Log,
    ) -> Option<u64> {
        let DeValue::Integer(integer) = value.get_ref() else {
            self.refuse_type(key, value, "an integer", log);
            return None;
        };
        let said = u64::from_str_radix(integer.as_str(), integer.radix()).ok();
        let said = said.filter(|said| (least..=most).contains(said));
        if said.is_none() {
            let said = integer.to_string().chars().take(40).collect();
            log.add(value.span(), CaseError::Count { key: self.name_of(key), said, least, most });
        }
        said
    }

    /// The items of an array, each read by itself, at least one; `None` after any mistake.
    pub(super) fn list<T>(
        &self,
        key: &Key,
        log: &mut Log,
        mut item: impl FnMut(&Node<'t>, &Spanned<DeValue<'t>>, &mut Log) -> Option<T>,
    ) -> Option<Vec<T>>
    where
        T: PartialEq + std::fmt::Display,
    {
        let value = self.value(key, log)?;
        let items = self.items(key, value, log)?;
        if items.is_empty() {
            log.add(value.span(), CaseError::Empty { key: self.name_of(key) });
            return None;
        }
        if items.len() as u64 > STUDY_ENTRIES {
            let (said, limit) = (items.len() as u128, STUDY_ENTRIES);
            log.add(value.span(), CaseError::TooMany { what: "entries", said, limit });
            return None;
        }
        let before = log.len();
        let mut list = Vec::new();
        for said in items {
            match item(self, said, log) {
                Some(item) if list.contains(&item) => {
                    log.add(said.span(), CaseError::Twice { key: self.name_of(key), said: item.to_string() });
                }
                Some(item) => list.push(item),
                None => {}
            }
        }
        (log.len() == before).then_some(list)
    }

    /// One of the known names.
    pub(super) fn name_among(
        &self,
        key: &Key,
        value: &Spanned<DeValue>,
        accepted: &[&'static str],
        log: &mut Log,
    ) -> Option<&'static str> {
        let Some(said) = value.get_ref().as_str() else {
            self.refuse_type(key, value, "a string", log);
            return None;
        };
        let known = accepted.iter().copied().find(|name| *name == said);
        if known.is_none() {
            let nearest = super::spelling::nearest(said, accepted.iter().copied());
            let said = said.chars().take(100).collect();
            let accepted = accepted.to_vec();
            log.add(value.span(), CaseError::UnknownName { key: self.name_of(key), said, accepted, nearest });
        }
        known
    }

    /// A key's value, untyped, if it is there.
    pub(super) fn raw(&self, key: &Key) -> Option<&'t Spanned<DeValue<'t>>> {
        self.table.get(key.name)
    }
}

fn integer_as_f64(integer: &DeInteger) -> f64 {
    match i128::from_str_radix(integer.as_str(), integer.radix()) {
        Ok(exact) => exact as f64,
        // More digits than 128 bits hold: far beyond what is accepted anyway.
        Err(_) if integer.as_str().starts_with('-') => -f64::MAX,
        Err(_) => f64::MAX,
    }
}

fn wrong_type(key: String, said: &DeValue, expected: &'static str) -> CaseError {
    let said = match said {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "an integer",
        DeValue::Float(_) => "a number with a fraction",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or a time",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    };
    CaseError::WrongType { key, said, expected }
}
