//! Memory in proportion to the input: each format at two sizes, the larger four times the smaller.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use sesc_test_support::command::{ROOT, folder, in_words, op2, program, sesc, stdout, write};

/// What a command takes whatever it reads, bytes: the program itself, robot, threads.
const BASE: u64 = 120 << 20;

/// Largest memory of a command, bytes, as the system counts it while the command runs.
fn peak(arguments: &[&str]) -> u64 {
    let mut command = Command::new(program());
    command.args(arguments);
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

const GENERATE: &str = "generate @ --support foot --out @ --model @";

#[test]
fn toml_takes_memory_in_proportion_to_the_file() {
    let folder = folder();
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = ["--support", "foot", "--poses", "10", "--out", &log];
    stdout(&sesc(&[&["simulate", &urdf][..], &simulate].concat()));
    let out = folder.path().join("out").display().to_string();
    for (piece, count) in [("1,", 900_000), ("{},", 300_000), ("[0],", 400_000)] {
        let array = |n: usize| format!("x = [{}]", piece.repeat(n));
        let model = |text: &str| {
            let model = write(folder.path(), "model.toml", text);
            peak(&in_words(GENERATE, &[&urdf, &out, &model]))
        };
        in_proportion("model file", TOML, sizes(count / 4, array), model);
        let prior = |text: &str| {
            let prior = write(folder.path(), "prior.toml", text);
            let fit = "fit @ --support foot --data @ --prior @";
            peak(&in_words(fit, &[&urdf, &log, &prior]))
        };
        in_proportion("prior", TOML, sizes(count / 4, array), prior);
        let sidecar = |text: &str| {
            write(folder.path(), "log.csv.toml", text);
            let most = peak(&["fit", &urdf, "--support", "foot", "--data", &log]);
            fs::remove_file(folder.path().join("log.csv.toml")).unwrap();
            most
        };
        in_proportion("sidecar", TOML, sizes(50_000, array), sidecar);
    }
    // Beyond the marks of any file, and beyond its bytes: nothing is parsed.
    for text in ["1,".repeat(8 << 20), "#".repeat(40 << 20)] {
        let model = write(folder.path(), "model.toml", &text);
        let most = peak(&in_words(GENERATE, &[&urdf, &out, &model]));
        assert!(most <= BASE, "{} MB", most >> 20);
    }
}

#[test]
fn logs_take_memory_in_proportion_to_the_file() {
    let folder = folder();
    let robot = op2();
    let log = folder.path().join("true.csv").display().to_string();
    let simulate = ["--support", "r_sole", "--poses", "400", "--noise", "0.0005"];
    stdout(&sesc(
        &[&["simulate", &robot][..], &simulate, &["--out", &log]].concat(),
    ));
    let text = fs::read_to_string(log).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let fit = |text: &str| {
        let log = write(folder.path(), "log.csv", text);
        peak(&["fit", &robot, "--support", "r_sole", "--data", &log])
    };
    // Rows that come again are named, and read.
    let csv = |times: usize| format!("{header}\n{}", rows.repeat(times));
    in_proportion("CSV", 8, sizes(10, csv), fit);
    // Columns that no joint has.
    let wide = |count: usize| {
        let more: String = (0..count).map(|k| format!(",note_{k}")).collect();
        let zeros = ",0".repeat(count);
        let rows: String = rows
            .lines()
            .take(4)
            .map(|row| format!("{row}{zeros}\n"))
            .collect();
        format!("{header}{more}\n{rows}")
    };
    in_proportion("wide CSV", 100, sizes(2000, wide), fit);
}

#[test]
fn packed_logs_take_memory_in_proportion_to_the_file() {
    let folder = folder();
    let robot = op2();
    let fit = |what: &str, log: &str| {
        let size = fs::metadata(log).unwrap().len();
        let most = peak(&["fit", &robot, "--support", "r_sole", "--data", log]);
        bounded(what, 20, size, most);
    };
    let simulated = |name: &str, poses: usize| {
        let log = folder.path().join(name).display().to_string();
        let poses = poses.to_string();
        let noise = ["--noise", "0.0005", "--poses", &poses, "--out", &log];
        let simulate = ["simulate", &robot, "--support", "r_sole"];
        stdout(&sesc(&[&simulate[..], &noise].concat()));
        log
    };
    for poses in [5_000, 20_000] {
        fit("CSV by gzip", &simulated("log.csv.gz", poses));
        fit("Parquet", &simulated("log.parquet", poses));
    }
    for poses in [500, 2_000] {
        let log = simulated("log.csv", poses);
        let recording = folder.path().join("log.mcap").display().to_string();
        let diagnose = ["diagnose", &robot, "--support", "r_sole", "--data", &log];
        stdout(&sesc(&[&diagnose[..], &["--mcap", &recording]].concat()));
        fit("MCAP", &recording);
    }
    // Rows that come again are packed to next to nothing.
    let text = fs::read_to_string(simulated("log.csv", 400)).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    for times in [50, 200] {
        let log = folder.path().join("again.csv.gz");
        let mut packed = GzEncoder::new(fs::File::create(&log).unwrap(), Compression::fast());
        writeln!(packed, "{header}").unwrap();
        (0..times).for_each(|_| packed.write_all(rows.as_bytes()).unwrap());
        packed.finish().unwrap();
        fit("the same rows by gzip", &log.display().to_string());
    }
}

/// Readings that go with no posture are asked about under every exchange of two joints.
#[test]
fn broken_logs_of_many_joints_take_memory_in_proportion_to_the_file() {
    let folder = folder();
    let log_of = |joints: usize| {
        let text = super::sizes::chain(joints, false);
        let urdf = write(folder.path(), &format!("chain_{joints}.urdf"), text);
        let log = folder.path().join("log.csv").display().to_string();
        let simulate = ["simulate", &urdf, "--support", "l0", "--poses", "320"];
        let options = ["--range", "5", "--out", &log];
        stdout(&sesc(&[&simulate[..], &options].concat()));
        let text = fs::read_to_string(log).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        assert!(header.ends_with("cop_x,cop_y"), "{header}");
        // Each posture has the reading of the one before it.
        let parts = |row: &'_ str| {
            let mut cells = row.rsplitn(3, ',');
            let [y, x] = [cells.next().unwrap(), cells.next().unwrap()].map(str::to_string);
            (cells.next().unwrap().to_string(), x, y)
        };
        let rows: Vec<(String, String, String)> = rows.lines().map(parts).collect();
        let mut out = format!("{header}\n");
        for k in 0..rows.len() {
            let (_, x, y) = &rows[(k + rows.len() - 1) % rows.len()];
            out += &format!("{},{x},{y}\n", rows[k].0);
        }
        out
    };
    for joints in [60, 120] {
        let text = log_of(joints);
        let log = write(folder.path(), "broken.csv", &text);
        let urdf = folder.path().join(format!("chain_{joints}.urdf"));
        let urdf = urdf.display().to_string();
        let most = peak(&["fit", &urdf, "--support", "l0", "--data", &log]);
        bounded("broken log", 20, text.len() as u64, most);
    }
}

#[test]
fn urdfs_take_memory_in_proportion_to_the_file() {
    let folder = folder();
    let inspect = |text: &str| {
        let urdf = write(folder.path(), "r.urdf", text);
        peak(&["inspect", &urdf, "--support", "l0"])
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
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let log = at("log.csv");
    let bare = write(folder.path(), "bare.urdf", loaded(0, ""));
    let simulate = ["--poses", "60", "--noise", "0.0005", "--out", &log];
    let support = ["--support", "l0"];
    stdout(&sesc(
        &[&["simulate", &bare][..], &support, &simulate].concat(),
    ));
    let light = "<inertial><mass value='.001'/></inertial>";
    for (what, each) in [("without mass", ""), ("with mass", light)] {
        for options in [
            &["inspect"][..],
            &["generate", "--lang", "c", "--out", &at("c")],
            &["verify", "--samples", "5"],
            &in_words("plan --poses 6 --cop-box 0.05 --out @", &[&at("poses.csv")])[..],
            &["simulate", "--poses", "6", "--out", &at("new.csv")],
            &["predict", "--data", &log],
            &["fit", "--data", &log],
            &["fit", "--data", &log, "--prior", "free"],
            &["diagnose", "--data", &log],
            &["fleet", "--data", &log, "--out", &at("fleet.csv")],
        ] {
            let few = write(folder.path(), "r.urdf", loaded(8, each));
            stdout(&sesc(
                &[&options[..1], &[&few], &support, &options[1..]].concat(),
            ));
            let run = |text: &str| {
                let urdf = write(folder.path(), "r.urdf", text);
                peak(&[&options[..1], &[&urdf], &support, &options[1..]].concat())
            };
            let links = |n: usize| loaded(n, each);
            let what = format!("{} of fixed links {what}", options[0]);
            in_proportion(&what, 200, sizes(500, links), run);
        }
    }
}
