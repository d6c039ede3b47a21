//! Memory in proportion to the input: each format at two sizes, the larger four times the smaller.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write as _;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use sesc_test_support::command::Folder;

/// What a command takes whatever it reads, bytes: the program itself, robot, threads.
const BASE: u64 = 120 << 20;

/// Largest memory of a command, bytes, as the system counts it while the command runs.
fn peak(folder: &Folder, line: &str) -> u64 {
    let mut command = folder.command(line);
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = quiet.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
        most = most.max(kib.unwrap_or(0_u64) << 10);
        thread::sleep(Duration::from_millis(2));
    }
    most
}

/// A command's memory stays below [`BASE`] and `per_byte` times the input, at both sizes.
fn in_proportion(what: &str, per_byte: u64, inputs: [String; 2], run: impl Fn(&str) -> u64) {
    for input in inputs {
        bounded(what, per_byte, input.len() as u64, run(&input));
    }
}

/// Memory of `most` bytes is below [`BASE`] and `per_byte` times the input.
fn bounded(what: &str, per_byte: u64, size: u64, most: u64) {
    println!("{what}: {size} bytes, {} MB", most >> 20);
    assert!(
        most <= BASE + per_byte * size,
        "{what}: {size} bytes of input, {} MB of memory",
        most >> 20
    );
}

/// Two inputs, of so many pieces and four times as many.
fn sizes(count: usize, of: impl Fn(usize) -> String) -> [String; 2] {
    [of(count), of(4 * count)]
}

/// TOML takes most of what is read: a list of four bytes becomes 500 of memory.
const TOML: u64 = 150;

const MODEL: &str = "generate two_link.urdf --support foot --out out --model model.toml";

#[test]
fn toml_takes_memory_in_proportion_to_the_file() {
    let folder = Folder::with("two_link");
    folder.stdout("simulate two_link.urdf --support foot --poses 10 --out log.csv");
    let fit = "fit two_link.urdf --support foot --data log.csv";
    for (piece, count) in [("1,", 900_000), ("{},", 300_000), ("[0],", 400_000)] {
        let array = |n: usize| format!("x = [{}]", piece.repeat(n));
        for (what, file, count, line) in [
            ("model file", "model.toml", count / 4, MODEL),
            (
                "prior",
                "prior.toml",
                count / 4,
                &format!("{fit} --prior prior.toml"),
            ),
            ("sidecar", "log.csv.toml", 50_000, fit),
        ] {
            in_proportion(what, TOML, sizes(count, array), |text| {
                folder.write(file, text);
                let most = peak(&folder, line);
                fs::remove_file(folder.join(file)).unwrap();
                most
            });
        }
    }
    // Beyond the marks of any file, and beyond its bytes: nothing is parsed.
    for text in ["1,".repeat(8 << 20), "#".repeat(40 << 20)] {
        folder.write("model.toml", &text);
        let most = peak(&folder, MODEL);
        assert!(most <= BASE, "{} MB", most >> 20);
    }
}

#[test]
fn logs_take_memory_in_proportion_to_the_file() {
    let folder = Folder::with_log("--poses 400 --noise 0.0005");
    let text = folder.read("log.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    fs::remove_file(folder.join("log.csv.toml")).unwrap();
    let fit = |text: &str| {
        folder.write("log.csv", text);
        peak(&folder, "fit op2.urdf --support r_sole --data log.csv")
    };
    // Rows that come again are named, and read.
    let csv = |times: usize| format!("{header}\n{}", rows.repeat(times));
    in_proportion("CSV", 8, sizes(10, csv), fit);
    // Columns that no joint has.
    let wide = |count: usize| {
        let more: String = (0..count).map(|k| format!(",note_{k}")).collect();
        let zeros = ",0".repeat(count);
        let rows = rows.lines().take(4).map(|row| format!("{row}{zeros}\n"));
        format!("{header}{more}\n{}", rows.collect::<String>())
    };
    in_proportion("wide CSV", 100, sizes(2000, wide), fit);
}

#[test]
fn packed_logs_take_memory_in_proportion_to_the_file() {
    let folder = Folder::with("op2");
    let fit = |what: &str, log: &str| {
        let size = fs::metadata(folder.join(log)).unwrap().len();
        let line = format!("fit op2.urdf --support r_sole --data {log}");
        bounded(what, 20, size, peak(&folder, &line));
    };
    let simulated = |name: &str, poses: usize| {
        folder.simulate(&format!("--noise 0.0005 --poses {poses} --out {name}"));
    };
    for poses in [5_000, 20_000] {
        for (what, log) in [("CSV by gzip", "log.csv.gz"), ("Parquet", "log.parquet")] {
            simulated(log, poses);
            fit(what, log);
        }
    }
    for poses in [500, 2_000] {
        simulated("log.csv", poses);
        folder.stdout("diagnose op2.urdf --support r_sole --data log.csv --mcap log.mcap");
        fit("MCAP", "log.mcap");
    }
    // Rows that come again are packed to next to nothing.
    simulated("log.csv", 400);
    let text = folder.read("log.csv");
    let (header, rows) = text.split_once('\n').unwrap();
    for times in [50, 200] {
        let again = fs::File::create(folder.join("again.csv.gz")).unwrap();
        let mut packed = GzEncoder::new(again, Compression::fast());
        writeln!(packed, "{header}").unwrap();
        (0..times).for_each(|_| packed.write_all(rows.as_bytes()).unwrap());
        packed.finish().unwrap();
        fit("the same rows by gzip", "again.csv.gz");
    }
}

/// Readings that go with no posture are asked about under every exchange of two joints.
#[test]
fn broken_logs_of_many_joints_take_memory_in_proportion_to_the_file() {
    let folder = Folder::empty();
    for joints in [60, 120] {
        folder.write("r.urdf", super::sizes::chain(joints, false));
        folder.stdout("simulate r.urdf --support l0 --poses 320 --range 5 --out log.csv");
        let text = folder.read("log.csv");
        let (header, rows) = text.split_once('\n').unwrap();
        assert!(header.ends_with("cop_x,cop_y"), "{header}");
        // Each posture has the reading of the one before it.
        let rows: Vec<Vec<&str>> = rows
            .lines()
            .map(|row| row.rsplitn(3, ',').collect())
            .collect();
        let before = rows.iter().cycle().skip(rows.len() - 1);
        let broken = rows.iter().zip(before);
        let broken =
            broken.map(|(own, before)| format!("{},{},{}\n", own[2], before[1], before[0]));
        let text = format!("{header}\n{}", broken.collect::<String>());
        folder.write("broken.csv", &text);
        let most = peak(&folder, "fit r.urdf --support l0 --data broken.csv");
        bounded("broken log", 20, text.len() as u64, most);
    }
}

#[test]
fn urdfs_take_memory_in_proportion_to_the_file() {
    let folder = Folder::empty();
    let inspect = |text: &str| {
        folder.write("r.urdf", text);
        peak(&folder, "inspect r.urdf --support l0")
    };
    // Links that do not move.
    let fixed = |n: usize| super::sizes::chain(n, false).replace("revolute", "fixed");
    in_proportion("URDF of fixed links", 200, sizes(500, fixed), inspect);
    let comments = |n: usize| super::sizes::chain(3, false) + &"<!-- - -->\n".repeat(n);
    in_proportion("URDF of comments", 100, sizes(50_000, comments), inspect);
}

/// A robot of four joints that carries `n` links that do not move, each with what `each` says.
fn loaded(n: usize, each: &str) -> String {
    let mass = "<inertial><origin xyz='0 0 .1'/><mass value='1'/></inertial>";
    let mut text = format!("<robot name='r'><link name='l0'>{mass}</link>");
    for k in 1..5 {
        text += &format!(
            "<link name='l{k}'>{mass}</link><joint name='j{k}' type='revolute'>\
             <parent link='l{}'/><child link='l{k}'/><origin xyz='0 0 .2'/><axis xyz='{} {} 0'/>\
             <limit lower='-.3' upper='.3'/></joint>",
            k - 1,
            k % 2,
            1 - k % 2
        );
    }
    for k in 0..n {
        text += &format!(
            "<link name='x{k}'>{each}</link><joint name='f{k}' type='fixed'><parent link='l{}'/>\
             <child link='x{k}'/></joint>",
            1 + k % 4
        );
    }
    text + "</robot>"
}

/// Links that do not move, with and without mass, under every command that takes a URDF.
#[test]
fn fixed_links_take_memory_in_proportion_to_the_file_in_every_command() {
    let folder = Folder::empty();
    folder.write("r.urdf", loaded(0, ""));
    folder.stdout("simulate r.urdf --support l0 --poses 60 --noise 0.0005 --out log.csv");
    let light = "<inertial><mass value='.001'/></inertial>";
    for (what, each) in [("without mass", ""), ("with mass", light)] {
        for command in [
            "inspect",
            "generate --lang c --out c",
            "verify --samples 5",
            "plan --poses 6 --cop-box 0.05 --out poses.csv",
            "simulate --poses 6 --out new.csv",
            "predict --data log.csv",
            "fit --data log.csv",
            "fit --data log.csv --prior free",
            "diagnose --data log.csv",
            "fleet --data log.csv --out fleet.csv",
        ] {
            let line = format!("{command} --support l0 r.urdf");
            folder.write("r.urdf", loaded(8, each));
            folder.stdout(&line);
            let what = format!("{command} of fixed links {what}");
            let links = |n: usize| loaded(n, each);
            in_proportion(&what, 200, sizes(500, links), |text| {
                folder.write("r.urdf", text);
                peak(&folder, &line)
            });
        }
    }
}
