//! Rows that are passed over without a look at them.

use super::{dofs, gzip, log};
use crate::logs::*;

const ROWS: usize = 30_000;
const FIRST: usize = 4096;
const BETWEEN: u64 = 10_000;

/// What the joint of a row says.
fn value(row: usize) -> f64 {
    1e-4 * row as f64
}

/// Numbers from 0 of the rows read before and behind a gap, and behind one beyond the end.
fn rows_of(source: &LogSource, first_line: u64) -> [Vec<usize>; 3] {
    let mut reader = PostureReader::open(source, &dofs(&["hip"]), &Options::default()).unwrap();
    let number = |block: Block| -> Vec<usize> {
        let pairs = block.q.iter().zip(&block.line);
        let of = |(q, line): (&f64, &u64)| {
            let row = (q * 1e4).round() as usize;
            assert_eq!(row as u64 + first_line, *line);
            row
        };
        pairs.map(of).collect()
    };
    let before = number(reader.block(FIRST).unwrap());
    assert!(reader.skip(BETWEEN, 100).unwrap());
    let behind = number(reader.block(500).unwrap());
    assert!(reader.skip(10 * BETWEEN, 100).unwrap());
    // Rows that the parser holds come out before the end.
    let mut last = Vec::new();
    loop {
        let rows = number(reader.block(500).unwrap());
        if rows.is_empty() {
            return [before, behind, last];
        }
        last.extend(rows);
    }
}

fn check(name: &str, source: &LogSource, first_line: u64) {
    let [before, behind, last] = rows_of(source, first_line);
    assert!(before.iter().copied().eq(0..FIRST), "{name}");
    assert!(behind.windows(2).all(|pair| pair[0] < pair[1]), "{name}");
    assert_eq!(behind.len(), 500, "{name}");
    let expected = FIRST + BETWEEN as usize;
    let gaps = behind.windows(2).filter(|pair| pair[1] > pair[0] + 1);
    assert!(gaps.count() <= 1, "{name}");
    let reached = behind[499];
    let off = reached.abs_diff(expected + 500);
    // Rows of CSV are passed over by their mean length.
    assert!(off < 600, "{name}: {reached}");
    assert!(last.len() < 1000, "{name}: {}", last.len());
}

#[test]
fn rows_between_are_passed_over() {
    let rows = (0..ROWS).map(|k| format!("{:.4},0.01,-0.02\n", value(k)));
    let text = format!("hip,cop_x,cop_y\n{}", rows.collect::<String>());
    for (name, bytes) in [
        ("log.csv", text.clone().into_bytes()),
        ("windows.csv", text.replace('\n', "\r\n").into_bytes()),
        ("log.csv.gz", gzip(text.as_bytes())),
    ] {
        let (_folder, path) = log(name, &bytes, "");
        check(name, &LogSource::from(&path), 2);
    }
    let table = Table::new("table")
        .numbers("hip", (0..ROWS).map(value).collect::<Vec<f64>>())
        .numbers("cop_x", vec![0.01; ROWS])
        .numbers("cop_y", vec![-0.02; ROWS]);
    check("table", &table.into(), 1);
}

#[cfg(feature = "parquet")]
#[test]
fn rows_of_parquet_are_passed_over() {
    let (folder, _) = log("log.csv", b"", "");
    let path = folder.path().join("log.parquet");
    let columns = Written {
        cop: true,
        ..Written::default()
    };
    let mut writer = PostureWriter::create(&path, &dofs(&["hip"]), columns).unwrap();
    for k in 0..ROWS {
        let row = Row {
            q: &[value(k)],
            cop: [0.01, -0.02],
            ..Row::default()
        };
        writer.row(&row).unwrap();
    }
    writer.finish(&Sidecar::default()).unwrap();
    check("log.parquet", &LogSource::from(&path), 1);
}
