//! Logs that are in memory already: one slice per column.

use std::fmt;
use std::hash::Hasher as _;
use std::sync::{Arc, OnceLock};

use twox_hash::XxHash64;

use super::columns::{Columns, SUPPORT};
use super::source::{Raw, RowSource, whole};
use crate::Error;

/// A posture log as columns in memory, named as those of a log file.
///
/// Whatever can be looked at as a slice is a column: a vector, or an array
/// that another language owns; nothing is copied. A value that is missing is NaN.
#[derive(Debug)]
pub struct Table {
    name: String,
    header: Vec<String>,
    columns: Vec<Column>,
    hash: OnceLock<u64>,
}

/// The values of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values<'a> {
    /// Numbers; NaN where one is missing.
    Numbers(&'a [f64]),
    /// Whole numbers.
    Integers(&'a [i64]),
    /// Texts.
    Texts(&'a [Arc<str>]),
}

#[derive(Debug)]
enum Column {
    Numbers(Shared<f64>),
    Integers(Shared<i64>),
    Texts(Shared<Arc<str>>),
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
    pub fn numbers(self, name: &str, values: impl AsRef<[f64]> + Send + Sync + 'static) -> Table {
        self.with(name, Column::Numbers(Shared::new(values)))
    }

    /// Add a column of whole numbers, as `pose` is.
    pub fn integers(self, name: &str, values: impl AsRef<[i64]> + Send + Sync + 'static) -> Table {
        self.with(name, Column::Integers(Shared::new(values)))
    }

    /// Add a column of texts, as `support` is.
    pub fn texts(
        self,
        name: &str,
        values: impl AsRef<[Arc<str>]> + Send + Sync + 'static,
    ) -> Table {
        self.with(name, Column::Texts(Shared::new(values)))
    }

    /// Add a column of `rows` values that are neither numbers nor texts. It is in nobody's way
    /// until it is used; then `what` says what it holds: `dates`, `lists`.
    pub fn unusable(self, name: &str, rows: usize, what: impl Into<String>) -> Table {
        self.with(name, Column::Unusable(rows, what.into()))
    }

    fn with(mut self, name: &str, column: Column) -> Table {
        self.header.push(name.trim().to_string());
        self.columns.push(column);
        self.hash = OnceLock::new();
        self
    }

    /// What messages call the table.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The columns of numbers and texts in their order, by name.
    pub fn columns(&self) -> impl Iterator<Item = (&str, Values<'_>)> {
        let names = self.header.iter().map(String::as_str);
        let columns = names.zip(self.columns.iter().map(Column::values));
        columns.filter_map(|(name, values)| Some((name, values?)))
    }

    /// XXH64 over names and values, column by column: the same columns have the
    /// same hash wherever they are.
    fn hash(&self) -> u64 {
        *self.hash.get_or_init(|| {
            let mut hash = XxHash64::with_seed(0);
            for (name, column) in self.header.iter().zip(&self.columns) {
                hash.write(name.as_bytes());
                hash.write(&[0]);
                column.hash(&mut hash);
            }
            hash.finish()
        })
    }
}

impl Column {
    fn values(&self) -> Option<Values<'_>> {
        Some(match self {
            Column::Numbers(values) => Values::Numbers(values.as_ref()),
            Column::Integers(values) => Values::Integers(values.as_ref()),
            Column::Texts(values) => Values::Texts(values.as_ref()),
            Column::Unusable(..) => return None,
        })
    }

    fn len(&self) -> usize {
        match self {
            Column::Numbers(values) => values.as_ref().len(),
            Column::Integers(values) => values.as_ref().len(),
            Column::Texts(values) => values.as_ref().len(),
            Column::Unusable(rows, _) => *rows,
        }
    }

    fn number(&self, row: usize) -> f64 {
        match self {
            Column::Numbers(values) => values.as_ref()[row],
            Column::Integers(values) => values.as_ref()[row] as f64,
            Column::Texts(_) | Column::Unusable(..) => f64::NAN,
        }
    }

    fn hash(&self, hash: &mut XxHash64) {
        match self {
            Column::Numbers(all) => all
                .as_ref()
                .iter()
                .for_each(|x| hash.write(&x.to_le_bytes())),
            Column::Integers(all) => all
                .as_ref()
                .iter()
                .for_each(|x| hash.write(&x.to_le_bytes())),
            Column::Texts(all) => all.as_ref().iter().for_each(|text| {
                hash.write(text.as_bytes());
                hash.write(&[0]);
            }),
            Column::Unusable(_, what) => hash.write(what.as_bytes()),
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
    pub fn open(table: &Arc<Table>) -> Result<TableSource, Error> {
        let rows = table.columns.first().map_or(0, Column::len);
        let mut named = table.header.iter().zip(&table.columns);
        if let Some((name, column)) = named.find(|(_, column)| column.len() != rows) {
            let said = format!(
                "column `{name}` has {} rows, `{}` has {rows}; a log has a value of each in every \
                 row",
                column.len(),
                table.header[0]
            );
            return Err(fault(table, said));
        }
        Ok(TableSource {
            table: table.clone(),
            rows,
            done: 0,
        })
    }

    /// Check that every wanted column holds what it should.
    fn check_types(&self, columns: &Columns) -> Result<(), Error> {
        let table = &self.table;
        let numbers = columns.numbers.iter().copied().chain(columns.pose);
        for k in numbers {
            let what = match &table.columns[k] {
                Column::Numbers(_) | Column::Integers(_) => continue,
                Column::Texts(_) => "no numbers".to_string(),
                Column::Unusable(_, what) => format!("{what}; cast them to numbers"),
            };
            let said = format!("column `{}` holds {what}", table.header[k]);
            return Err(fault(table, said));
        }
        match columns.support.map(|k| &table.columns[k]) {
            None | Some(Column::Texts(_)) => Ok(()),
            Some(_) => Err(fault(table, format!("column `{SUPPORT}` holds no text"))),
        }
    }
}

impl RowSource for TableSource {
    fn header(&self) -> &[String] {
        &self.table.header
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        if self.done == 0 {
            self.check_types(columns)?;
        }
        let table = &self.table;
        let rows = self.done..self.rows.min(self.done + count);
        let width = columns.numbers.len();
        let start = raw.numbers.len();
        raw.numbers.resize(start + rows.len() * width, f64::NAN);
        for (k, column) in columns.numbers.iter().enumerate() {
            for (to, row) in raw.column(start + k, width).zip(rows.clone()) {
                *to = table.columns[*column].number(row);
            }
        }
        for row in rows.clone() {
            match columns.pose.map(|k| &table.columns[k]) {
                Some(Column::Integers(poses)) => raw.pose.push(poses.as_ref()[row]),
                Some(poses) => {
                    let pose = whole(poses.number(row));
                    raw.pose.push(pose.map_err(|message| {
                        Error::log(table.name.clone(), Some(row as u64 + 1), message)
                    })?);
                }
                None => {}
            }
            if let Some(Column::Texts(links)) = columns.support.map(|k| &table.columns[k]) {
                raw.support.push(links.as_ref()[row].clone());
            }
            raw.line.push(row as u64 + 1);
        }
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

fn fault(table: &Table, message: String) -> Error {
    Error::log(table.name.clone(), None, message)
}

/// Values that somebody else owns, without a copy: a vector, an array of another language.
pub(super) struct Shared<T>(Arc<dyn AsRef<[T]> + Send + Sync>);

impl<T> Shared<T> {
    pub fn new(values: impl AsRef<[T]> + Send + Sync + 'static) -> Shared<T> {
        Shared(Arc::new(values))
    }
}

impl<T> AsRef<[T]> for Shared<T> {
    fn as_ref(&self) -> &[T] {
        (*self.0).as_ref()
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Shared<T> {
        Shared(self.0.clone())
    }
}

impl<T> fmt::Debug for Shared<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} values", self.as_ref().len())
    }
}
