//! Writing predictions: a table of the CoM and CoP of postures, in the formats of logs.

use std::path::{Path, PathBuf};

use super::row::{Row, Written};
use super::writer::Sink;
use crate::Error;

/// Names of the columns: m, support frame.
pub const PREDICTED: [&str; 6] = ["pose", "com_x", "com_y", "com_z", "cop_x", "cop_y"];

/// A table of predictions being written.
///
/// The end of the file's name tells the format: `.csv`, `.csv.gz` or `.parquet`. The table
/// appears whole or not at all.
pub struct PredictionWriter {
    path: PathBuf,
    sink: Sink,
    text: Vec<u8>,
}

impl PredictionWriter {
    /// Start a table; nothing is at `path` before [`finish`](Self::finish).
    ///
    /// # Errors
    /// Ends of names that stand for something else, folders that cannot be written to.
    pub fn create(path: &Path) -> Result<PredictionWriter, Error> {
        let header = PREDICTED.map(str::to_string);
        Ok(PredictionWriter {
            path: path.to_path_buf(),
            sink: Sink::create(path, &header)?,
            text: Vec::new(),
        })
    }

    /// Append a posture: its CoM and CoP, m.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn row(&mut self, pose: i64, com_m: &[f64; 3], cop_m: [f64; 2]) -> Result<(), Error> {
        let row = Row {
            pose,
            q: com_m,
            cop: cop_m,
            ..Row::default()
        };
        let columns = Written {
            cop: true,
            ..Written::default()
        };
        self.sink.row(&self.path, &row, columns, &mut self.text)
    }

    /// Complete the table and move it to its place.
    ///
    /// # Errors
    /// When it cannot be written to its end.
    pub fn finish(self) -> Result<(), Error> {
        if let Some(file) = self.sink.finish(&self.path)? {
            file.finish()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::{LogSource, column_names};

    /// Numbers come back to the last digit.
    #[test]
    fn tables_have_the_columns_that_are_promised() {
        let folder = tempfile::tempdir().unwrap();
        let mut names = vec!["a.csv", "a.csv.gz"];
        names.extend(cfg!(feature = "parquet").then_some("a.parquet"));
        for name in names {
            let path = folder.path().join(name);
            let mut writer = PredictionWriter::create(&path).unwrap();
            writer.row(7, &[0.1, -0.2, 0.3], [1e-17, 0.5]).unwrap();
            assert!(!path.exists());
            writer.finish().unwrap();
            assert_eq!(column_names(&LogSource::from(&path)).unwrap(), PREDICTED);
        }
        let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
        let expected =
            "pose,com_x,com_y,com_z,cop_x,cop_y\n7,0.1,-0.2,0.3,0.00000000000000001,0.5\n";
        assert_eq!(text, expected);
        let wrong = PredictionWriter::create(&folder.path().join("a.txt"));
        assert!(
            wrong
                .err()
                .unwrap()
                .to_string()
                .contains(".csv, .csv.gz or .parquet")
        );
    }
}
