//! Logs that are refused, and how.

use super::{dofs, gzip, log, read_file, refused};
use crate::logs::Options;
use crate::tests::says;

#[test]
fn faults_name_row_column_and_remedy() {
    for (text, words) in [
        ("", &["log.csv", "empty", "header"][..]),
        ("hip,knee\n", &["log.csv", "no postures"]),
        (" , \n0,0\n", &[":1", "no header"]),
        ("hip,nee\n0,0\n", &[":1", "`knee`", "mean `nee` for `knee`"]),
        (
            "hip,knee\n0,0\n0,x\n",
            &[":3", "`knee`", "`x` is no number"],
        ),
        ("hip,knee\n0,\n", &[":2", "`knee`", "no value"]),
        ("hip;knee\n0;0,5\n", &[":2", "`knee`", "decimal comma"]),
        ("hip,knee\n0,inf\n", &[":2", "`knee`", "not finite"]),
        (
            "hip,knee\n0,2048\n",
            &[":2", "`knee`", "ticks of an encoder"],
        ),
        (
            "hip,knee\n0,45\n",
            &[":2", "`knee`", "give `angles`", "sidecar"],
        ),
        ("hip,knee\n0,0\n0\n", &[":3", "1 fields", "2"]),
        ("hip,knee\n0,0,0\n", &[":2", "3 fields"]),
        (
            "hip,knee,pose\n0,0,1.5\n",
            &[":2", "`pose`", "whole number"],
        ),
        ("hip,knee,t\n0,0,inf\n", &[":2", "`t`", "not finite"]),
        (
            "hip,knee,cop_x,cop_y,cop_x_std,cop_y_std\n0,0,0,0,0.1,0\n",
            &[":2", "`cop_y_std`", "positive"],
        ),
        (
            "hip,knee,cop_x,cop_y\n0,0,12.5,-3.5\n",
            &[":2", "`cop_x`", "millimetres"],
        ),
        (
            "hip,knee,gravity_x,gravity_y,gravity_z\n0,0,0,0,9.8\n",
            &[":2", "negative"],
        ),
        (
            "hip,knee,fsr_1,fsr_2\n0,0,1,1\n",
            &["log.csv", "cells = ", "sidecar"],
        ),
    ] {
        refused(text, "", words);
    }
    let log = "hip,knee,support\n0,0,soel\n";
    let words = [":2", "no link `soel`", "mean `sole`"];
    refused(log, "support = 'sole'", &words);
    let words = ["sidecar", "`soles`", "`sole`"];
    refused("hip,knee\n0,0\n", "support = 'soles'", &words);
    refused("hip,knee\n0,0\n", "cells = 3", &["log.csv.toml", "cells"]);
}

/// Numbers are made side by side; the first fault is told, whatever it is.
#[test]
fn the_first_fault_of_many_rows_is_told() {
    // Rows up to the one with too few fields become numbers in four parts.
    let row = |k: usize| format!("{k},0,0.{k:04},0.01,0.02,0,0,-9.8\n");
    let odd = [
        (1100, "1100.5,0,0,0,0,0,0,-9.8\n", "`pose`"),
        (2500, "2500,0,x,0,0,0,0,-9.8\n", "`knee`"),
        (3900, "3900,y,0,0,0,0,0,-9.8\n", "`hip`"),
        (4000, "4000,0,0,0\n", "4 fields"),
    ];
    for first in 0..odd.len() {
        let rows = (0..4200).map(|k| match odd[first..].iter().find(|odd| odd.0 == k) {
            Some((_, text, _)) => text.to_string(),
            None => row(k),
        });
        let header = "pose,hip,knee,cop_x,cop_y,gravity_x,gravity_y,gravity_z\n".to_string();
        let (at, _, word) = odd[first];
        let text = header + &rows.collect::<String>();
        refused(&text, "", &[&format!(":{}", at + 2), word]);
    }
}

/// What is said of a file with one joint.
fn said(name: &str, bytes: &[u8]) -> String {
    let (_folder, path) = log(name, bytes, "");
    let read = read_file(&path, &dofs(&["hip"]), &Options::default());
    read.unwrap_err().to_string()
}

/// Bytes of no table, files that are cut off anywhere, and text under the name of another format,
/// which is read as CSV and is odd where its columns are wrong.
#[test]
fn what_is_no_log_is_told_by_its_bytes() {
    let text = b"this is\nno log\n";
    let broken = [&b"\x1f\x8b"[..], &[0xff; 9]].concat();
    let mut cases: Vec<(&str, &[u8], &[&str])> = vec![
        ("log.csv", b"\xff\xfeh\0i\0p\0", &["UTF-16"]),
        ("log.csv", b"PK\x03\x04...", &["save the sheet as CSV"]),
        ("log.csv", b"\x7fELF\x02\x01\x01\0\0\0", &["not text"]),
        ("log.csv", b"hip,\xe9\n0,0\n", &["UTF-8"]),
        ("log.csv", b"\x1f\x8b\x08", &["cut off"]),
        ("log.csv", &broken, &["gzip"]),
        ("log.parquet", text, &["not a Parquet file but text"]),
        ("log.MCAP", text, &["not an MCAP recording but text"]),
    ];
    let packed = gzip(b"hip\n0.5\n");
    cases.push(("log.csv.gz", &packed[..packed.len() - 6], &["cut off"]));
    if cfg!(feature = "parquet") {
        let words = &["log.parquet", "cut off", "copy it again"];
        cases.push(("log.parquet", b"PAR1\x15\x04\x15", words));
    }
    if cfg!(feature = "mcap") {
        for bytes in [
            &b"\x89MCAP0\r\n"[..],
            b"\x89MCAP0\r\n\x01\x40\0\0\0\0\0\0\0abc",
            b"\x89MCAP",
        ] {
            cases.push(("log.mcap", bytes, &["log.mcap", "cut off", "mcap recover"]));
        }
    }
    for (name, bytes, words) in cases {
        says(said(name, bytes), words);
    }
    assert!(!said("log.csv", text).contains("but text"));
}

/// Bytes of no format under the names of some, and text under a name that is not its own.
#[test]
fn damaged_files_are_told_by_their_names() {
    let noise: Vec<u8> = (0..200u32).map(|k| (k * k * 37 + 129) as u8).collect();
    for (name, format) in [
        ("log.parquet", "a Parquet file"),
        ("log.mcap", "an MCAP recording"),
        ("log.csv.gz", "packed with gzip"),
    ] {
        for bytes in [&noise, &noise[..3], b"\x7fELF\x02\x01\0\0\0\0"] {
            let remedy = "copy it again, or rename it";
            says(said(name, bytes), &[name, format, remedy]);
        }
        assert!(said(name, b"").contains("empty; copy it again"));
        let (_folder, path) = log(name, b"hip\n0.5\n", "");
        assert!(read_file(&path, &dofs(&["hip"]), &Options::default()).is_ok());
    }
}

#[test]
fn absurd_sizes_end_in_words() {
    let wide = "x,".repeat(100_000) + "hip\n";
    let long = format!("hip\n{}\n", "1".repeat(9 << 20));
    let quote = format!("hip\n\"{}\n", "1\n".repeat(5 << 20));
    let many: String = (0..30_000).map(|k| format!("c{k},")).collect::<String>() + "hip\n0\n";
    for (text, word) in [
        (wide, "appears twice|columns"),
        (long, "a row of more than"),
        (quote, "a row of more than"),
        (many, "30001 columns"),
    ] {
        let message = said("log.csv", text.as_bytes());
        assert!(word.split('|').any(|w| message.contains(w)), "{message}");
        assert!(message.len() < 500, "{}", message.len());
    }
}
