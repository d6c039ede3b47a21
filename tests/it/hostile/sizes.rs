//! Small files that claim to be large: refused within seconds, in memory that is bounded.
//!
//! Each of these took gigabytes, or never came to an end.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use sesc_test_support::command::{ROOT, folder, in_words, program, refused, stdout, write};
use sesc_test_support::contacts::{record, schema, text};
use sesc_test_support::trees::Urdf;

const FILES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/hostile/files");
/// Address space that a command may have, KiB: a shell's `ulimit -v`.
const MEMORY: &str = "1500000";
const SECONDS: u64 = 30;

/// A command in bounded memory, which must end in time.
fn bounded(arguments: &[&str]) -> Output {
    let begun = Instant::now();
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -v {MEMORY}; exec \"$0\" \"$@\"")]);
    let output = command.arg(program()).args(arguments).output().unwrap();
    let took = begun.elapsed();
    let is_in_time = took < Duration::from_secs(SECONDS);
    assert!(is_in_time, "{arguments:?}: {took:?}");
    output
}

fn fit(log: &Path) -> Output {
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    let line = "fit @ --support foot --data @";
    bounded(&in_words(line, &[&urdf, log.to_str().unwrap()]))
}

#[test]
#[cfg(unix)]
fn logs_that_claim_more_than_they_have_are_refused() {
    for (file, word) in [
        // A dictionary of 2³¹ − 1 entries in 8 bytes.
        ("dict.parquet", "dictionary of 8 bytes"),
        // Lists of 2³¹ − 1 flags that take no bytes.
        ("skip.parquet", "another kind than the format"),
        // 2³¹ − 1 rows in one run of a constant.
        ("rows.parquet", "rows in 441 bytes"),
        // A page of 50 rows in a group of 7.
        ("fewer.parquet", "more rows than its group"),
        // Fields of other kinds than the format's, which lead past lists of 2³¹ − 1 flags.
        ("kinds.parquet", "another kind than the format"),
        // A page whose header has a map of flags, beyond which a reader skips lists without end.
        ("map.parquet", "another kind than the format"),
        // A chunk of 256 MiB zeros: 67 million joints without names.
        ("names.mcap", "claims to unpack"),
    ] {
        let path = Path::new(FILES).join(file);
        assert!(fs::metadata(&path).unwrap().len() < 10_000);
        refused(&fit(&path), &[file, word]);
    }
}

/// Ten thousand groups of columns, each in the one before.
#[test]
#[cfg(unix)]
fn schemas_nested_without_end_are_refused() {
    let folder = folder();
    let mut footer = vec![0x15, 0x02, 0x19, 0xfc];
    let mut count = 10_000u32;
    while count >= 0x80 {
        footer.push(count as u8 | 0x80);
        count >>= 7;
    }
    footer.push(count as u8);
    for _ in 0..10_000 {
        footer.extend([0x48, 0x01, b'a', 0x15, 0x02, 0]);
    }
    footer.extend([0x16, 0, 0x19, 0x0c, 0]);
    let mut file = b"PAR1".to_vec();
    file.extend(&footer);
    file.extend((footer.len() as u32).to_le_bytes());
    file.extend(b"PAR1");
    let log = write(folder.path(), "deep.parquet", file);
    refused(&fit(Path::new(&log)), &["deep.parquet", "nested"]);
}

/// Names of types that are kept until the end, without end.
#[test]
#[cfg(unix)]
fn recordings_with_endless_names_are_refused() {
    let folder = folder();
    let long = [
        &b"\x89MCAP0\r\n"[..],
        &record(1, &[text(""), text("")].concat()),
    ]
    .concat();
    let one = [&long[..], &schema(1, &"a".repeat(1 << 20))].concat();
    let many = (0..60_000).flat_map(|id| schema(id, &"a".repeat(1000)));
    let many: Vec<u8> = long.iter().copied().chain(many).collect();
    for (file, word) in [(one, "name of 1048576 bytes"), (many, "more than 16 MiB")] {
        let log = write(folder.path(), "log.mcap", file);
        refused(&fit(Path::new(&log)), &["log.mcap", word]);
    }
}

/// A robot of `n` links in a row, each joint after the first a mimic of it if `tied`.
pub(super) fn chain(n: usize, tied: bool) -> String {
    let mut robot = Urdf::new("chain").raw("<link name='l0'/>");
    for k in 1..=n {
        let (parent, link) = (format!("l{}", k - 1), format!("l{k}"));
        let mimic = match tied && k > 1 {
            true => "<mimic joint='j1'/>",
            false => "",
        };
        let more = format!(
            "<origin xyz='0 0 0.05'/><axis xyz='{} {} 0'/><limit lower='-1' upper='1'/>{mimic}",
            k % 2,
            (k + 1) % 2
        );
        robot = robot.link(&link, 1.0, "0 0.01 0.02");
        robot = robot.joint(&format!("j{k}"), "revolute", [&parent, &link], &more);
    }
    robot.text()
}

/// What cannot be computed in bounded memory is said at once; robots larger than any that was built
/// take what they must, and no more.
#[test]
#[cfg(unix)]
fn robots_beyond_all_sizes_are_refused_at_once() {
    let folder = folder();
    let out = folder.path().join("out.csv").display().to_string();
    let run = |n: usize, tied: bool, command: &[&str]| {
        let urdf = write(folder.path(), "chain.urdf", chain(n, tied));
        let robot = [urdf.as_str(), "--support", "l0"];
        bounded(&[&command[..1], &robot, &command[1..]].concat())
    };
    for tied in [true, false] {
        for command in [
            &["inspect"][..],
            &["generate", "--out", &out],
            &["simulate", "--poses", "3", "--out", &out],
        ] {
            refused(&run(9_998, tied, command), &["9998 joints move"]);
        }
    }
    let output = run(1_001, true, &["inspect"]);
    refused(&output, &["1001 joints move", "follow others"]);
    for (joints, tied) in [(2_000, false), (200, true)] {
        stdout(&run(joints, tied, &["inspect"]));
    }
}
