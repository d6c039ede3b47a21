//! Logs as people write them, and as they should not be.

mod faults;
mod memory;
mod mutations;
mod skips;

use std::fs;
use std::path::{Path, PathBuf};

use sesc_model::tree::Dof;
use twox_hash::XxHash64;

use super::*;
use crate::tests::says;
use crate::{Error, Message};

/// Revolute joints within ±3 rad.
pub(in crate::logs) fn dofs(names: &[&str]) -> Vec<Dof> {
    let dof = |name: &&str| Dof {
        joint: name.to_string(),
        prismatic: false,
        continuous: false,
        lower: -3.0,
        upper: 3.0,
        speed: 1.0,
    };
    names.iter().map(dof).collect()
}

/// A log in a folder of its own, with a sidecar unless it is empty.
pub(in crate::logs) fn log(
    name: &str,
    bytes: &[u8],
    sidecar: &str,
) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    if !sidecar.is_empty() {
        fs::write(Sidecar::path(&path), sidecar).unwrap();
    }
    (folder, path)
}

/// The whole log in one block, and its warnings.
pub(in crate::logs) fn read_file(
    path: &Path,
    dofs: &[Dof],
    options: &Options,
) -> Result<(Block, Vec<Message>), Error> {
    let mut reader = PostureReader::open(path, dofs, options)?;
    let block = reader.block(1_000_000)?;
    assert_eq!(reader.summary().unwrap().rows, block.len() as u64);
    Ok((block, reader.warnings))
}

fn read(text: &str, sidecar: &str, options: &Options) -> Result<(Block, Vec<Message>), Error> {
    let (_folder, path) = log("log.csv", text.as_bytes(), sidecar);
    read_file(&path, &dofs(&["hip", "knee"]), options)
}

#[track_caller]
pub(in crate::logs) fn refused(text: &str, sidecar: &str, words: &[&str]) {
    let options = Options {
        readings: Readings::Optional,
        links: vec!["sole".into(), "trunk".into()],
        ..Options::default()
    };
    says(read(text, sidecar, &options).unwrap_err(), words);
}

pub(in crate::logs) fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write as _;
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// As pyarrow writes a table with a batch of no rows, one without any, and an encrypted one.
#[cfg(feature = "parquet")]
#[test]
fn groups_of_no_rows_are_passed_over() {
    let joints = dofs(&["ankle", "roll", "waist", "shoulder"]);
    let read = |bytes: &[u8]| {
        let (_folder, path) = log("log.parquet", bytes, "");
        read_file(&path, &joints, &Options::default())
    };
    let (block, _) = read(include_bytes!("files/group_of_no_rows.parquet")).unwrap();
    assert_eq!((block.len(), block.reading.unwrap().len()), (40, 40));
    let empty = read(include_bytes!("files/empty.parquet"));
    says(empty.unwrap_err(), &["no postures below the header"]);
    let encrypted: [&[u8]; 2] = [include_bytes!("files/encrypted.parquet"), b"PARE....PARE"];
    for bytes in encrypted {
        says(read(bytes).unwrap_err(), &["encrypted; decrypt it first"]);
    }
}

#[test]
fn every_spelling_of_a_table_reads_the_same() {
    let plain = "pose,knee,hip,cop_x,cop_y\n3,0.5,-1,0.01,0.02\n3,0.5,-1,0.02,0.03\n";
    let (expected, warnings) = read(plain, "", &Options::default()).unwrap();
    assert_eq!(expected.q, [-1.0, 0.5, -1.0, 0.5]);
    assert_eq!(expected.pose, [3, 3]);
    assert_eq!(expected.line, [2, 3]);
    assert_eq!(expected.reading, Some(vec![[0.01, 0.02], [0.02, 0.03]]));
    assert!(warnings.is_empty(), "{warnings:?}");
    for text in [
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        plain.replace(',', ";"),
        plain.replace(',', "\t"),
        plain.replace(',', " , ").replace('\n', "  \n"),
        plain.replace("hip", "\"hip\""),
        format!("\u{feff}\"pose\"{}", &plain[4..]),
        plain.trim_end().to_string(),
        format!("{plain}\n\n  \n"),
        plain.replace("3,", "3.0,"),
    ] {
        let (block, _) = read(&text, "", &Options::default()).unwrap();
        assert_eq!(block, expected, "{text:?}");
    }
    let (_folder, path) = log("log.csv.gz", &gzip(plain.as_bytes()), "");
    let (block, _) = read_file(&path, &dofs(&["hip", "knee"]), &Options::default()).unwrap();
    assert_eq!(block, expected);
}

#[test]
fn lines_count_as_an_editor_counts_them() {
    let text = "hip,knee,note\n\n0,0,a\n  \n0,0,\"two\nlines\"\n0,0,b\n\n0,0,c";
    for text in [text.to_string(), text.replace('\n', "\r\n")] {
        let (block, _) = read(&text, "", &Options::default()).unwrap();
        assert_eq!(block.line, [3, 5, 7, 9], "{text:?}");
    }
}

#[test]
fn blocks_of_any_size_hold_the_same_rows() {
    // The first two rows are one posture.
    let row = |k: i32| format!("{},0.1,{},0.01,0\n", k.max(1), f64::from(k) * 1e-4);
    let rows = (0..10_000).map(row).collect::<String>();
    let text = format!("pose,hip,knee,cop_x,cop_y\n{rows}");
    let (_folder, path) = log("log.csv", text.as_bytes(), "");
    let joints = dofs(&["hip", "knee"]);
    let (whole, _) = read_file(&path, &joints, &Options::default()).unwrap();
    for count in [1, 999, 4096, 5000, 10_000] {
        let mut reader = PostureReader::open(&path, &joints, &Options::default()).unwrap();
        assert_eq!(reader.summary(), None);
        let (mut q, mut poses) = (Vec::new(), Vec::new());
        loop {
            let block = reader.block(count).unwrap();
            if block.is_empty() {
                break;
            }
            assert!(block.len() == count || q.len() / 2 + block.len() == 10_000);
            q.extend(block.q);
            poses.extend(block.pose);
        }
        assert!(q == whole.q && poses == whole.pose, "{count}");
        let summary = reader.summary().unwrap();
        assert_eq!((summary.rows, summary.postures), (10_000, 9_999));
        let hash = XxHash64::oneshot(0, text.as_bytes());
        assert_eq!(summary.hash, format!("{hash:016x}"));
        let (done, total) = reader.progress();
        assert_eq!(Some(done), total);
    }
}

/// Four cells on the corners of a 2 × 4 cm sole; closed forms by hand.
#[test]
fn cells_give_the_cop_and_its_deviation() {
    let sidecar = "readings_per_pose = 4\n\
                   cells = [[0.01, 0.02], [0.01, -0.02], [-0.01, -0.02], [-0.01, 0.02]]";
    let text = "hip,knee,fsr_1,fsr_2,fsr_3,fsr_4,fsr_1_std,fsr_2_std,fsr_3_std,fsr_4_std\n\
                0,0,3,3,1,1,0.8,0.8,0.8,0.8\n";
    let (block, _) = read(text, sidecar, &Options::default()).unwrap();
    let [x, y] = block.reading.unwrap()[0];
    assert!((x - 0.005).abs() < 1e-15 && y.abs() < 1e-15);
    // A row alone in its pose is the mean of 4 readings: half the deviation.
    let cells = block.cells.unwrap();
    assert_eq!(cells.force, [3.0, 3.0, 1.0, 1.0]);
    assert_eq!(cells.std, Some(vec![0.4; 4]));
    let [x, y] = block.std.unwrap()[0];
    let lever: f64 = 2.0 * 0.005f64.powi(2) + 2.0 * 0.015f64.powi(2);
    assert!((x - 0.4 / 8.0 * lever.sqrt()).abs() < 1e-15, "{x}");
    assert!((y - 0.4 / 8.0 * 0.04).abs() < 1e-15, "{y}");
    let nothing = text.replace("3,3,1,1", "3,-3,1,-1");
    let words = [":2", "`fsr_1` … `fsr_4`", "0 N in total"];
    refused(&nothing, sidecar, &words);
    let three = sidecar.replace(", [-0.01, 0.02]]", "]");
    refused(text, &three, &["4 columns", "3 places"]);
}

#[test]
fn deviations_are_those_of_rows() {
    let text = |rows: &str| format!("hip,knee,pose,cop_x,cop_y,cop_x_std,cop_y_std\n{rows}");
    let std = |rows: &str| {
        let sidecar = "readings_per_pose = 4";
        let (block, _) = read(&text(rows), sidecar, &Options::default()).unwrap();
        block.std.unwrap()[0][0]
    };
    // Means of four, and four readings that were all written down.
    assert_eq!(std("0,0,0,0,0,0.01,0.01\n0,0,1,0,0,0.01,0.01\n"), 0.005);
    let all = "0,0,0,0,0,0.01,0.01\n".repeat(4) + &"0,0,1,0,0,0.01,0.01\n".repeat(4);
    assert_eq!(std(&all), 0.01);
    // A column without a value is none.
    let (block, warnings) = read(&text("0,0,0,0,0,,\n"), "", &Options::default()).unwrap();
    assert_eq!(block.std, None);
    says(&warnings[0], &["not used: `cop_x_std`, `cop_y_std`"]);
}

#[test]
fn rows_go_before_the_sidecar() {
    let sidecar = "support = 'sole'\ngravity = [0.0, 0.0, -1.0]\nangles = 'deg'";
    let text = "hip,knee,support\n90,0,\n0,0,trunk\n";
    let (block, _) = read(text, sidecar, &Options::default()).unwrap();
    let support = block.support.unwrap();
    assert_eq!([&*support[0], &*support[1]], ["sole", "trunk"]);
    assert_eq!(block.gravity, Some(vec![[0.0, 0.0, -1.0]; 2]));
    assert_eq!(block.q[0], std::f64::consts::FRAC_PI_2);
    let options = Options {
        angles: Some(Angles::Rad),
        ..Options::default()
    };
    let text = "hip,knee,gravity_x,gravity_y,gravity_z\n1,0,0.5,0,-9\n";
    let (block, _) = read(text, sidecar, &options).unwrap();
    assert_eq!(block.gravity, Some(vec![[0.5, 0.0, -9.0]]));
    assert_eq!(block.q[0], 1.0);
}

#[test]
fn readings_are_required_or_ignored_on_demand() {
    let with = |readings| Options {
        readings,
        ..Options::default()
    };
    let text = "hip,knee,cop_x,cop_y\n0,0,NaN,word\n";
    let (block, warnings) = read(text, "", &with(Readings::Ignored)).unwrap();
    assert_eq!(block.reading, None);
    assert!(warnings.is_empty(), "{warnings:?}");
    let error = read("hip,knee\n0,0\n", "", &with(Readings::Required)).unwrap_err();
    says(error, &["cop_x"]);
    let (_, warnings) = read("hip,knee,note\n0,0,a\n", "", &with(Readings::Optional)).unwrap();
    says(&warnings[0], &["`note`"]);
}

/// What the writer writes the reader reads, bit by bit, in every format.
#[test]
fn written_logs_are_read_back() {
    let joints = dofs(&["hip", "a, \"b\""]);
    let columns = Written {
        t: true,
        support: true,
        cop: true,
        cop_std: true,
    };
    let folder = tempfile::tempdir().unwrap();
    let names = ["log.csv", "packed.csv.gz", "log2.parquet"];
    for name in &names[..if cfg!(feature = "parquet") { 3 } else { 2 }] {
        let path = folder.path().join(name);
        let mut writer = PostureWriter::create(&path, &joints, columns).unwrap();
        for k in 0..5 {
            let x = f64::from(k) / 3.0;
            let row = Row {
                pose: i64::from(k) - 2,
                t: x,
                support: ["sole", "left; \"sole\""][k as usize % 2],
                q: &[x, -x],
                cop: [x / 7.0, 0.1],
                cop_std: [0.01, 0.03],
            };
            writer.row(&row).unwrap();
        }
        let sidecar = Sidecar {
            readings_per_pose: Some(4),
            ..Sidecar::default()
        };
        writer.finish(&sidecar).unwrap();
        let (block, warnings) = read_file(&path, &joints, &Options::default()).unwrap();
        let (sidecar, _) = Sidecar::of(&path).unwrap();
        let mut reader = PostureReader::open(&path, &joints, &Options::default()).unwrap();
        while !reader.block(2).unwrap().is_empty() {}
        let hash = XxHash64::oneshot(0, &fs::read(&path).unwrap());
        assert_eq!(reader.summary().unwrap().hash, format!("{hash:016x}"));
        let form = LogSource::bytes(*name, fs::read(&path).unwrap()).with_sidecar(sidecar.clone());
        for time in ["once", "again"] {
            let mut reader = PostureReader::open(&form, &joints, &Options::default()).unwrap();
            let read = reader.block(100).unwrap();
            assert_eq!(read, block, "{name}, {form:?}, {time}");
        }
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(block.pose, [-2, -1, 0, 1, 2]);
        assert_eq!(block.t.as_ref().unwrap()[1], 1.0 / 3.0);
        assert_eq!(block.q[2..4], [1.0 / 3.0, -1.0 / 3.0]);
        assert_eq!(&*block.support.as_ref().unwrap()[1], "left; \"sole\"");
        assert_eq!(block.reading.as_ref().unwrap()[1], [1.0 / 21.0, 0.1]);
        assert_eq!(block.std.as_ref().unwrap()[1], [0.005, 0.015]);
    }
}
