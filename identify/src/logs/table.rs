//! Logs that are in memory already: one slice per column.

use std::hash::Hasher as _;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use twox_hash::XxHash64;

use super::columns::Columns;
use super::source::{Raw, RowSource};
use crate::Error;

/// A posture log as columns in memory, named as those of a log file.
///
/// A value that is missing is NaN.
#[derive(Debug)]
pub struct Table {
    /// What messages call the table.
    pub name: String,
    header: Vec<String>,
    columns: Vec<Values>,
    hash: OnceLock<u64>,
}

/// The values of a column.
#[derive(Debug)]
pub enum Values {
    /// Numbers; NaN where one is missing.
    Numbers(Vec<f64>),
    /// Whole numbers.
    Integers(Vec<i64>),
    /// Texts.
    Texts(Vec<Arc<str>>),
    /// So many rows of what no log has; the words say what.
    Unusable(usize, String),
}

impl Table {
    /// A table without columns; `name` stands for a file in messages.
    pub fn new(name: impl Into<String>) -> Table {
        Table {
            name: name.into(),
            header: Vec::new(),
            columns: Vec::new(),
            hash: OnceLock::new(),
        }
    }

    /// Add a column of numbers: joint positions (rad or m), `cop_x` (m), `t` (s)
    /// and the like.
    pub fn numbers(self, name: &str, values: impl Into<Vec<f64>>) -> Table {
        self.with(name, Values::Numbers(values.into()))
    }

    /// Add a column of whole numbers, as `pose` is.
    pub fn integers(self, name: &str, values: impl Into<Vec<i64>>) -> Table {
        self.with(name, Values::Integers(values.into()))
    }

    /// Add a column of texts, as `support` is.
    pub fn texts(self, name: &str, values: impl Into<Vec<Arc<str>>>) -> Table {
        self.with(name, Values::Texts(values.into()))
    }

    /// Add a column of `rows` values that are neither numbers nor texts. It is in nobody's way
    /// until it is used; then `what` says what it holds: `dates`, `lists`.
    pub fn unusable(self, name: &str, rows: usize, what: impl Into<String>) -> Table {
        self.with(name, Values::Unusable(rows, what.into()))
    }

    fn with(mut self, name: &str, column: Values) -> Table {
        self.header.push(name.trim().to_string());
        self.columns.push(column);
        self.hash.take();
        self
    }

    /// The columns of numbers and texts in their order, by name.
    pub fn columns(&self) -> impl Iterator<Item = (&str, &Values)> {
        let columns = self.header.iter().map(String::as_str).zip(&self.columns);
        columns.filter(|(_, values)| !matches!(values, Values::Unusable(..)))
    }

    /// XXH64 over names and values, column by column: the same columns have the
    /// same hash wherever they are.
    fn hash(&self) -> u64 {
        *self.hash.get_or_init(|| {
            let mut hash = XxHash64::with_seed(0);
            let text = |hash: &mut XxHash64, text: &str| {
                hash.write(text.as_bytes());
                hash.write(&[0]);
            };
            for (name, column) in self.header.iter().zip(&self.columns) {
                text(&mut hash, name);
                match column {
                    Values::Texts(all) => all.iter().for_each(|own| text(&mut hash, own)),
                    Values::Unusable(_, what) => hash.write(what.as_bytes()),
                    Values::Numbers(all) => all.iter().for_each(|x| hash.write(&x.to_le_bytes())),
                    Values::Integers(all) => all.iter().for_each(|x| hash.write(&x.to_le_bytes())),
                }
            }
            hash.finish()
        })
    }
}

impl Values {
    /// Rows.
    pub fn rows(&self) -> usize {
        match self {
            Values::Numbers(values) => values.len(),
            Values::Integers(values) => values.len(),
            Values::Texts(values) => values.len(),
            Values::Unusable(rows, _) => *rows,
        }
    }
}

/// A table being read.
pub(super) struct TableSource {
    table: Arc<Table>,
    rows: usize,
    done: usize,
}

impl TableSource {
    pub(super) fn open(table: &Arc<Table>) -> Result<TableSource, Error> {
        let rows = table.columns.first().map_or(0, Values::rows);
        let mut named = table.header.iter().zip(&table.columns);
        if let Some((name, column)) = named.find(|(_, column)| column.rows() != rows) {
            let said = format!(
                "column `{name}` has {} rows, `{}` has {rows}; a log has a value of each in every \
                 row",
                column.rows(),
                table.header[0]
            );
            return Err(Error::row(None, said));
        }
        Ok(TableSource {
            table: table.clone(),
            rows,
            done: 0,
        })
    }

    /// A column that has to hold something else.
    fn fault(&self, column: usize, what: &str) -> Error {
        let said = format!("column `{}` holds {what}", self.table.header[column]);
        Error::row(None, said)
    }

    /// Rows of a column that has to hold numbers.
    fn numbers(&self, column: usize, rows: &Range<usize>) -> Result<Vec<f64>, Error> {
        match &self.table.columns[column] {
            Values::Numbers(own) => Ok(own[rows.clone()].to_vec()),
            Values::Integers(own) => Ok(own[rows.clone()].iter().map(|x| *x as f64).collect()),
            Values::Texts(_) => Err(self.fault(column, "no numbers")),
            Values::Unusable(_, what) => {
                Err(self.fault(column, &format!("{what}; cast them to numbers")))
            }
        }
    }
}

impl RowSource for TableSource {
    fn header(&self) -> &[String] {
        &self.table.header
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        let rows = self.done..self.rows.min(self.done + count);
        for (own, to) in columns.numbers.iter().zip(&mut raw.numbers) {
            to.extend(self.numbers(own.column, &rows)?);
        }
        match columns.pose.map(|k| (k, &self.table.columns[k])) {
            None => {}
            // Whole numbers of any size.
            Some((_, Values::Integers(own))) => raw.pose.extend(&own[rows.clone()]),
            Some((k, _)) => {
                let values = self.numbers(k, &rows)?;
                raw.poses(self.done as u64 + 1, values)?;
            }
        }
        match columns.support.map(|k| (k, &self.table.columns[k])) {
            None => {}
            Some((_, Values::Texts(own))) => raw.support.extend_from_slice(&own[rows.clone()]),
            Some((k, _)) => return Err(self.fault(k, "no text")),
        }
        raw.line.extend(rows.clone().map(|row| row as u64 + 1));
        self.done = rows.end;
        Ok(())
    }

    fn skip(&mut self, _: &Columns, rows: u64) -> Result<(), Error> {
        let rows = usize::try_from(rows).unwrap_or(usize::MAX);
        self.done = self.done.saturating_add(rows).min(self.rows);
        Ok(())
    }

    fn progress(&self) -> (u64, Option<u64>) {
        (self.done as u64, Some(self.rows as u64))
    }

    fn hash(&self) -> u64 {
        self.table.hash()
    }
}
