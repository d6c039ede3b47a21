//! Logs that are in memory: tables and bytes are read as files are.

use std::sync::Arc;

use super::{dofs, log, read_file};
use crate::logs::*;

fn whole(log: &LogSource) -> Result<(Block, Summary), crate::Error> {
    let mut reader = PostureReader::open(log, &dofs(&["hip", "knee"]), &Options::default())?;
    let block = reader.block(1_000_000)?;
    let summary = reader.summary().expect("the log was read to its end");
    Ok((block, summary))
}

fn table() -> Table {
    let links: Vec<Arc<str>> = vec!["sole".into(), "".into(), "sole".into()];
    Table::new("run")
        .integers("pose", vec![3, 3, 7])
        .texts("support", links)
        .numbers(" knee", vec![90.0, 45.0, 0.0])
        .numbers("hip", [0.0, -9.0, 18.0])
        .numbers("fsr_1", vec![3.0, 1.0, 2.0])
        .numbers("fsr_2", vec![1.0, 1.0, 2.0])
        .numbers("fsr_3", vec![1.0, 2.0, 2.0])
}

const CSV: &str = "pose,support,knee,hip,fsr_1,fsr_2,fsr_3\n\
                   3,sole,90,0,3,1,1\n3,,45,-9,1,1,2\n7,sole,0,18,2,2,2\n";
const SIDECAR: &str = "support = 'trunk'\nangles = 'deg'\nreadings_per_pose = 4\n\
                       cells = [[0.01, 0.02], [0.01, -0.02], [-0.01, 0.0]]";

/// Units, cells, supports and means are handled alike, wherever the rows are.
#[test]
fn tables_and_bytes_read_as_files_do() {
    let (_folder, path) = log("log.csv", CSV.as_bytes(), SIDECAR);
    let (mut expected, _) = read_file(&path, &dofs(&["hip", "knee"]), &Options::default()).unwrap();
    let (sidecar, _) = LogSource::from(&path).sidecar().unwrap();
    let bytes = LogSource::bytes("log.csv", CSV).with_sidecar(sidecar.clone());
    let (block, summary) = whole(&bytes).unwrap();
    assert_eq!(block, expected);
    assert_eq!(summary, whole(&LogSource::from(&path)).unwrap().1);

    let (block, summary) = whole(&LogSource::from(table()).with_sidecar(sidecar)).unwrap();
    // Rows of a file count from its header.
    expected.line = vec![1, 2, 3];
    assert_eq!(block, expected);
    assert_eq!((summary.rows, summary.postures), (3, 2));
}

/// Equal columns have equal hashes, and any other value another.
#[test]
fn a_table_is_known_by_its_columns() {
    let sidecar = Sidecar {
        cells: Some(vec![[0.01, 0.02], [0.01, -0.02], [-0.01, 0.0]]),
        angles: Some(Angles::Deg),
        ..Sidecar::default()
    };
    let hash = |table: Table| {
        let log = LogSource::from(table).with_sidecar(sidecar.clone());
        whole(&log).unwrap().1.hash
    };
    assert_eq!(hash(table()), hash(table()));
    assert_ne!(hash(table()), hash(table().numbers("t", vec![0.0; 3])));
}

#[test]
fn faulty_tables_are_refused_by_column() {
    let run = || Table::new("run");
    let hip = || run().numbers("hip", vec![0.0]);
    let both = || hip().numbers("knee", vec![0.0]);
    let two = run().numbers("hip", vec![0.0; 2]);
    let three = two.numbers("knee", vec![0.0; 3]);
    let text = hip().texts("knee", vec![Arc::from("x")]);
    let dates = run().unusable("note", 1, "lists").numbers("hip", vec![0.0]);
    let dates = dates.unusable("knee", 1, "dates");
    let support = both().numbers("support", vec![0.0]);
    let odd = hip().numbers("knee", vec![f64::NAN]);
    for (table, words) in [
        (three, ": column `knee` has 3 rows, `hip` has 2"),
        (text, ": column `knee` holds no numbers"),
        (dates, ": column `knee` holds dates; cast them to numbers"),
        (support, ": column `support` holds no text"),
        (odd, ":1: 1 of 1 rows have no value of a column"),
        (hip(), ":1: no column for joint `knee`"),
        (run(), ":1: no column for joint"),
        (
            both().numbers("pose", vec![0.5]),
            ":1: column `pose`: 0.5 is no whole number",
        ),
    ] {
        let message = whole(&LogSource::from(table)).unwrap_err().to_string();
        assert!(message.starts_with(&format!("run{words}")), "{message}");
    }
    let upwards = Sidecar {
        gravity: Some([0.0, 0.0, 9.8]),
        ..Sidecar::default()
    };
    let log = LogSource::from(table()).with_sidecar(upwards);
    let message = whole(&log).unwrap_err().to_string();
    assert!(message.starts_with("run: sidecar: gravity"), "{message}");
}
