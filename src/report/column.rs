//! Tables: one definition of each column, from which its header, its fields and its description come.

use std::io::Write;

use super::ReportError;

/// One field of a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Field {
    Text(String),
    Count(u64),
    /// Must be finite.
    Number(f64),
    /// The same with 17 significant digits.
    Digits17(f64),
    /// A number that has no meaning here.
    Empty,
}

impl From<&str> for Field {
    fn from(text: &str) -> Field {
        Field::Text(text.to_owned())
    }
}
impl From<u64> for Field {
    fn from(count: u64) -> Field {
        Field::Count(count)
    }
}
impl From<usize> for Field {
    fn from(count: usize) -> Field {
        Field::Count(count as u64)
    }
}
impl From<f64> for Field {
    fn from(number: f64) -> Field {
        Field::Number(number)
    }
}
impl<T: Into<Field>> From<Option<T>> for Field {
    fn from(value: Option<T>) -> Field {
        value.map_or(Field::Empty, Into::into)
    }
}

impl Field {
    /// What stands in the file, or the number that may not stand in one.
    fn written(self) -> Result<String, f64> {
        match self {
            Field::Text(text) => Ok(text),
            Field::Count(count) => Ok(count.to_string()),
            Field::Empty => Ok(String::new()),
            Field::Number(x) | Field::Digits17(x) if !x.is_finite() => Err(x),
            // Adding zero turns −0.0 into 0.0: the sign of nothing is no observation.
            Field::Number(x) => Ok(format!("{:?}", x + 0.0)),
            Field::Digits17(x) => Ok(format!("{:.16e}", x + 0.0)),
        }
    }
}

/// One column of a table whose rows are made from `R`.
pub(super) struct Column<R> {
    pub name: &'static str,
    /// As in the name; empty for a pure number, a count or a word.
    pub unit: &'static str,
    pub meaning: &'static str,
    pub value: fn(&R) -> Field,
}

/// A table: a file, what one row is, and its columns in order.
pub(super) struct Table<R> {
    pub file: &'static str,
    /// What one row tells of.
    pub row: &'static str,
    pub columns: Vec<Column<R>>,
    /// Columns that stand after these where a user asks for them, for the description.
    pub more: &'static [MoreDescribed],
    /// The case that a row belongs to, for error messages.
    pub case: fn(&R) -> &str,
}

/// What is said of columns that a user may ask for: the pattern of their names, unit, meaning.
pub(super) struct MoreDescribed {
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// Columns that a user asked for by name, after a table's own.
pub(super) struct MoreColumns<R> {
    pub names: Vec<String>,
    /// As many as there are names, or fewer: the rest stays empty.
    pub values: fn(&R) -> Vec<Field>,
}

impl<R> Table<R> {
    /// Writes the header and all rows.
    pub fn write(&self, rows: impl IntoIterator<Item = R>, out: impl Write) -> Result<(), ReportError> {
        self.write_with(rows, &[], out)
    }

    /// The same with further columns.
    pub fn write_with(
        &self,
        rows: impl IntoIterator<Item = R>,
        more: &[MoreColumns<R>],
        out: impl Write,
    ) -> Result<(), ReportError> {
        let failed = |source: std::io::Error| ReportError::Table { table: self.file, source };
        let mut writer = csv::Writer::from_writer(out);
        let more_names = more.iter().flat_map(|more| &more.names).map(String::as_str);
        writer.write_record(self.columns.iter().map(|c| c.name).chain(more_names)).map_err(|e| failed(e.into()))?;
        let mut record = csv::StringRecord::new();
        for row in rows {
            record.clear();
            let written = |name: &str, field: Field| {
                field.written().map_err(|value| ReportError::NotFinite {
                    table: self.file,
                    column: name.to_owned(),
                    case: (self.case)(&row).to_owned(),
                    value,
                })
            };
            for column in &self.columns {
                record.push_field(&written(column.name, (column.value)(&row))?);
            }
            for more in more {
                let mut values = (more.values)(&row).into_iter();
                for name in &more.names {
                    record.push_field(&written(name, values.next().unwrap_or(Field::Empty))?);
                }
            }
            writer.write_record(&record).map_err(|e| failed(e.into()))?;
        }
        writer.flush().map_err(failed)
    }

    /// The columns as a Markdown section.
    pub fn described(&self) -> String {
        let mut text = format!("## `{}`\n\nOne row is {}.\n\n", self.file, self.row);
        text.push_str("| column | unit | meaning |\n|---|---|---|\n");
        let own = self.columns.iter().map(|c| (c.name, c.unit, c.meaning));
        for (name, unit, meaning) in own.chain(self.more.iter().map(|m| (m.name, m.unit, m.meaning))) {
            text.push_str(&format!("| `{name}` | {unit} | {meaning} |\n"));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_survive_the_round_trip() {
        for x in [0.1, 1.0 / 3.0, 5e-324, f64::MAX, -1e-5, 1e16, 123_456_789.0] {
            for field in [Field::Number(x), Field::Digits17(x)] {
                assert_eq!(
                    field.clone().written().unwrap().parse::<f64>().unwrap().to_bits(),
                    x.to_bits(),
                    "{field:?}"
                );
            }
        }
        assert_eq!(Field::Number(-0.0).written().unwrap(), "0.0");
        assert_eq!(Field::Digits17(0.25).written().unwrap(), "2.5000000000000000e-1");
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(Field::Number(x).written().is_err());
            assert!(Field::Digits17(x).written().is_err());
        }
    }
}
