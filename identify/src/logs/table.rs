//! Logs that are in memory already: one slice per column.

use std::fmt;
use std::hash::Hasher as _;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use twox_hash::XxHash64;

use super::columns::Columns;
use super::source::{Raw, RowSource};
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

    fn hash(&self, hash: &mut XxHash64) {
        let mut text = |text: &str| {
            hash.write(text.as_bytes());
            hash.write(&[0]);
        };
        match self {
            Column::Texts(all) => all.as_ref().iter().for_each(|own| text(own)),
            Column::Unusable(_, what) => hash.write(what.as_bytes()),
            Column::Numbers(all) => {
                let all = all.as_ref().iter();
                all.for_each(|x| hash.write(&x.to_le_bytes()));
            }
            Column::Integers(all) => {
                let all = all.as_ref().iter();
                all.for_each(|x| hash.write(&x.to_le_bytes()));
            }
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
            return Err(Error::log(table.name.clone(), None, said));
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
        Error::log(self.table.name.clone(), None, said)
    }

    /// Rows of a column that has to hold numbers.
    fn numbers(&self, column: usize, rows: &Range<usize>) -> Result<Vec<f64>, Error> {
        match &self.table.columns[column] {
            Column::Numbers(own) => Ok(own.as_ref()[rows.clone()].to_vec()),
            Column::Integers(own) => {
                let own = own.as_ref()[rows.clone()].iter();
                Ok(own.map(|x| *x as f64).collect())
            }
            Column::Texts(_) => Err(self.fault(column, "no numbers")),
            Column::Unusable(_, what) => {
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
        let (width, start) = (columns.numbers.len(), raw.numbers.len());
        raw.numbers.resize(start + rows.len() * width, f64::NAN);
        for (k, &column) in columns.numbers.iter().enumerate() {
            let values = self.numbers(column, &rows)?;
            let places = raw.column(start + k, width);
            places.zip(values).for_each(|(to, x)| *to = x);
        }
        match columns.pose.map(|k| (k, &self.table.columns[k])) {
            None => {}
            // Whole numbers of any size.
            Some((_, Column::Integers(own))) => raw.pose.extend(&own.as_ref()[rows.clone()]),
            Some((k, _)) => {
                let values = self.numbers(k, &rows)?;
                raw.poses(&self.table.name, self.done as u64 + 1, values)?;
            }
        }
        match columns.support.map(|k| (k, &self.table.columns[k])) {
            None => {}
            Some((_, Column::Texts(own))) => {
                raw.support.extend_from_slice(&own.as_ref()[rows.clone()]);
            }
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

/// Values that somebody else owns, without a copy: a vector, an array of another language.
#[derive(Clone)]
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

impl<T> fmt::Debug for Shared<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} values", self.as_ref().len())
    }
}
