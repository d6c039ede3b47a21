//! Memory in proportion to the input: each format at two sizes, the larger four times the smaller.
#![cfg(target_os = "linux")]

use std::f64::consts::TAU;
use std::fs;
use std::io::Write as _;
use std::process::{ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use flate2::Compression;
use flate2::write::GzEncoder;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_test_support::command::{Folder, rows};
use sesc_test_support::contacts::{recording, soles};
use sesc_test_support::feet::Noise;
use sesc_test_support::stage::{Platform, Stage};
use sesc_test_support::trees::Urdf;

/// What a command takes whatever it reads, bytes: the program itself, robot, threads.
const BASE: u64 = 120 << 20;

/// Largest memory of a command, bytes, as the system counts it while the command runs.
fn peak(folder: &Folder, line: &str) -> u64 {
    ended(folder, line).0
}

/// The same with how the command ended.
fn ended(folder: &Folder, line: &str) -> (u64, ExitStatus) {
    let mut command = folder.command(line);
    let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = quiet.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    let end = loop {
        if let Some(end) = child.try_wait().unwrap() {
            break end;
        }
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
        most = most.max(kib.unwrap_or(0_u64) << 10);
        thread::sleep(Duration::from_millis(2));
    };
    (most, end)
}

/// A command's memory stays below [`BASE`] and `per_byte` times the input, at both sizes.
fn in_proportion(what: &str, per_byte: u64, inputs: [String; 2], run: impl Fn(&str) -> u64) {
    for input in inputs {
        bounded(what, per_byte, input.len() as u64, run(&input));
    }
}

/// Memory of `most` bytes is below [`BASE`] and `each` times the bytes or pieces of the input.
fn bounded(what: &str, each: u64, size: u64, most: u64) {
    println!("{what}: input of {size}, {} MB", most >> 20);
    let room = BASE + each * size;
    assert!(
        most <= room,
        "{what}: input of {size}, {most} bytes of memory, {room} allowed"
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
    let stage = Stage::new(Platform::Op2);
    let noise = Noise {
        cop_m: 5e-4,
        encoder_rad: 5e-4,
        flat_rad: 1.4e-3,
    };
    for poses in [100, 400] {
        let random = &mut ChaCha8Rng::seed_from_u64(1);
        let world = stage.world();
        let recorded = recording(&stage, &world, poses, noise, &soles(), random);
        fs::write(folder.join("log.mcap"), recorded).unwrap();
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
        // Each posture has the reading of the one before it.
        let mut broken = folder.sheet("log.csv");
        for name in ["cop_x", "cop_y"] {
            let mut column = broken.numbers(&[name]).concat();
            column.rotate_right(1);
            (0..320).for_each(|k| broken.set(name, Some(k), &column[k].to_string()));
        }
        let text = broken.to_string();
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
fn loaded<'a>(n: usize, each: impl Fn(usize) -> &'a str) -> String {
    let mut robot = Urdf::new("r").link("l0", 1.0, "0 0 .1");
    for k in 1..5 {
        let (parent, link) = (format!("l{}", k - 1), format!("l{k}"));
        let axis = format!("{} {} 0", k % 2, 1 - k % 2);
        robot = robot.link(&link, 1.0, "0 0 .1");
        robot = robot.revolute(&format!("j{k}"), [&parent, &link], "0 0 .2", &axis, 0.3);
    }
    for k in 0..n {
        let (parent, link) = (format!("l{}", 1 + k % 4), format!("x{k}"));
        robot = robot.raw(&format!("<link name='{link}'>{}</link>", each(k)));
        robot = robot.joint(&format!("f{k}"), "fixed", [&parent, &link], "");
    }
    robot.text()
}

/// Commands, each with the axes of input that it has: `m`echanics of the URDF, a `l`og, a model
/// file's `e`ffects.
const COMMANDS: &str = "inspect r.urdf | m
    generate r.urdf --lang c --out c | m
    generate r.urdf --lang rust --out rust | m
    generate r.urdf --lang c --model model.toml --out c | e
    verify r.urdf --samples 5 | m
    verify r.urdf --samples 5 --model model.toml | e
    plan r.urdf --poses 6 --candidates 60 --cop-box 1 --out poses.csv | m
    simulate r.urdf --poses 6 --out new.csv | m
    predict r.urdf --data log.csv | ml
    predict r.urdf --data log.csv --model model.toml | e
    fit r.urdf --data log.csv | ml
    diagnose r.urdf --data log.csv | ml
    compare log.csv later.csv --urdf r.urdf | ml
    fleet r.urdf --data log.csv --out fleet.csv | ml";

/// An axis along which an input grows: its name, its kind as in [`COMMANDS`], two sizes, and the
/// memory that one piece takes at most, bytes; of `joints`, that each of their pairs takes.
type Axis = (&'static str, char, [usize; 2], u64);

const AXES: [Axis; 8] = [
    ("fixed links", 'm', [500, 2000], 40_000),
    ("joints", 'm', [10, 40], 120_000),
    ("mimic joints", 'm', [20, 80], 1_000_000),
    ("collision shapes", 'm', [500, 2000], 40_000),
    ("rows", 'l', [2000, 8000], 4000),
    ("columns", 'l', [2000, 8000], 4000),
    ("cells", 'l', [100, 400], 20_000),
    ("effects", 'e', [10, 40], 500_000),
];

/// Logs whose CoP is that of `n` cells on a circle: f = 1 + 2 p·c/r².
fn with_cells(folder: &Folder, n: usize) {
    const RADIUS: f64 = 0.05;
    let places = (0..n).map(|k| (TAU * k as f64 / n as f64).sin_cos());
    let places: Vec<[f64; 2]> = places.map(|(s, c)| [RADIUS * c, RADIUS * s]).collect();
    for log in ["log.csv", "later.csv"] {
        let mut sheet = folder.sheet(log);
        let cop = sheet.cop();
        sheet.keep(|name| !name.starts_with("cop_"));
        for (cell, p) in places.iter().enumerate() {
            let force = |y: [f64; 2]| 1.0 + 2.0 * (y[0] * p[0] + y[1] * p[1]) / (RADIUS * RADIUS);
            sheet.add(&format!("fsr_{}", cell + 1), |k| force(cop[k]).to_string());
        }
        folder.write(log, sheet.to_string());
        let sidecar = format!("support = \"l0\"\ncells = {places:?}\n");
        folder.write(&format!("{log}.toml"), sidecar);
    }
}

/// A robot `r.urdf`, logs and a model file that are of size `n` along an axis.
fn made(folder: &Folder, axis: &str, n: usize) {
    let light = "<inertial><mass value='.001'/></inertial>";
    let shape = "<collision><geometry><box size='.01 .01 .01'/></geometry></collision>";
    let robot = match axis {
        "fixed links" => loaded(n, |k| ["", light][k % 2]),
        "collision shapes" => loaded(n, |_| shape),
        "joints" | "effects" => super::sizes::chain(n, false),
        "mimic joints" => super::sizes::chain(n, true),
        _ => loaded(0, |_| ""),
    };
    folder.write("r.urdf", robot);
    let few = 2 * n.min(40) + 40;
    let poses = if axis == "rows" { n } else { few };
    for (seed, log) in [(1, "log.csv"), (2, "later.csv")] {
        let options = format!("--range 5 --poses {poses} --seed {seed} --out {log}");
        folder.stdout(&format!("simulate r.urdf --support l0 {options}"));
    }
    match axis {
        "columns" => {
            for log in ["log.csv", "later.csv"] {
                let mut sheet = folder.sheet(log);
                (0..n).for_each(|k| sheet.add(&format!("note_{k}"), |_| "0".to_string()));
                folder.write(log, sheet.to_string());
            }
        }
        "cells" => with_cells(folder, n),
        "effects" => {
            folder.stdout("fit r.urdf --data log.csv --out model.toml");
            let effect = |k| {
                format!(
                    "[[effects]]\neffect = \"joint_offset\"\ntarget = \"j{k}\"\n\
                     [effects.parameters.offset_rad]\nvalue = 0.001\n\n"
                )
            };
            let effects: String = (1..=n).map(effect).collect();
            let mut text = folder.read("model.toml");
            text.insert_str(text.find("[information]").unwrap(), &effects);
            folder.write("model.toml", text);
        }
        _ => {}
    }
}

/// The table of `SECURITY.md` at smaller sizes.
#[test]
fn every_command_takes_bounded_memory_along_every_axis() {
    for (axis, kind, sizes, each) in AXES {
        for n in sizes {
            let folder = Folder::empty();
            made(&folder, axis, n);
            let pieces = if axis == "joints" { n * n } else { n } as u64;
            for command in rows(COMMANDS).iter().filter(|row| row[1].contains(kind)) {
                let (most, end) = ended(&folder, &format!("{} --support l0", command[0]));
                let what = format!("{}: {n} {axis}", command[0]);
                assert!(matches!(end.code(), Some(0 | 1)), "{what}: {end}");
                bounded(&what, each, pieces, most);
            }
        }
    }
}
