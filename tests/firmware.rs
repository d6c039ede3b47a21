//! The generated C on the processors that it is for: built by `tests/firmware/`
//! for Cortex-M3 and Cortex-M4F, run in qemu, compared with this machine and with
//! f64, and counted.
//!
//! `cargo test --test firmware -- --nocapture costs` prints what a call costs.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::Duration;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_generated::op2_r_sole as op2;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const LIMIT: Duration = Duration::from_secs(300);

const FUNCTIONS: [&str; 7] = [
    "com",
    "com_jacobian",
    "gravity_moments",
    "regressor",
    "regressor_cop",
    "regressor_full",
    "cop",
];

// -- how it is built and run

/// Processor, arithmetic and rounding: a CONFIG of the Makefile.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Config {
    name: &'static str,
    /// Of qemu; none is this machine.
    board: Option<&'static str>,
    fixed: bool,
}

const M3_FIXED: Config = Config {
    name: "m3-fixed",
    board: Some("mps2-an385"),
    fixed: true,
};
const M3_F32: Config = Config {
    name: "m3-f32",
    board: Some("mps2-an385"),
    fixed: false,
};
/// Multiplications and additions fused where the compiler likes.
const M4F_F32: Config = Config {
    name: "m4f-f32",
    board: Some("mps2-an386"),
    fixed: false,
};
/// Every operation rounded by itself.
const M4F_F32_EXACT: Config = Config {
    name: "m4f-f32-exact",
    ..M4F_F32
};
const HOST_FIXED: Config = Config {
    name: "host-fixed",
    board: None,
    fixed: true,
};
const HOST_F32: Config = Config {
    name: "host-f32",
    board: None,
    fixed: false,
};
const TARGETS: [Config; 4] = [M3_FIXED, M3_F32, M4F_F32, M4F_F32_EXACT];

impl Config {
    fn prefix(self) -> &'static str {
        match self.fixed {
            true => "op2_r_sole_fixed_",
            false => "op2_r_sole_",
        }
    }

    fn header(self) -> String {
        let name = self.prefix().trim_end_matches('_');
        fs::read_to_string(format!("{ROOT}/generated/c/{name}.h")).unwrap()
    }

    /// Runs the Makefile.
    fn make(self, out: &Path, arguments: &[&str]) {
        let mut make = Command::new("make");
        make.args(["--silent", "--directory", "tests/firmware"])
            .arg(format!("CONFIG={}", self.name))
            .arg(format!("OUT={}", out.display()))
            .args(arguments)
            .current_dir(ROOT);
        // The jobserver of an outer make is not for us.
        make.env_remove("MAKEFLAGS").env_remove("MAKELEVEL");
        sesc_test_support::machine::printed(&mut make, "", LIMIT);
    }

    /// The folder with everything built, once in a run.
    fn built(self) -> PathBuf {
        static BUILT: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
        // Another test's failure to build is that test's.
        let mut built = BUILT
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let out = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("firmware")
            .join(self.name);
        if !built.contains(self.name) {
            sesc_test_support::machine::need_tools();
            let _ = fs::remove_dir_all(&out);
            fs::create_dir_all(&out).unwrap();
            fs::write(out.join("postures.h"), self.postures_h()).unwrap();
            self.make(&out, &["all"]);
            built.insert(self.name);
        }
        out
    }

    /// How `program` is run.
    fn command(self, program: &str) -> Command {
        let program = self.built().join(format!("{program}.elf"));
        let Some(board) = self.board else {
            return Command::new(program);
        };
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args(["-machine", board, "-nographic"])
            .args(["-monitor", "none", "-serial", "null"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(program);
        qemu
    }
}

// -- what is passed in

const DOF: usize = op2::DOF;
const POSTURES: usize = 16;
/// Postures that instructions are counted on.
const COUNTED: usize = 3;

struct Posture {
    ticks: [i32; DOF],
    q: [f64; DOF],
}

/// Both ends of the joint limits, ±2.618 rad, and random postures between.
fn postures() -> Vec<Posture> {
    const LIMIT_RAD: f64 = 2.617;
    const LIMIT_TICKS: i32 = 1706;
    let mut rng = ChaCha8Rng::seed_from_u64(1906);
    let at = |sign: i32| Posture {
        ticks: [2048 + sign * LIMIT_TICKS; DOF],
        q: [f64::from(sign) * LIMIT_RAD; DOF],
    };
    let mut postures = vec![at(1), at(-1)];
    postures.resize_with(POSTURES, || Posture {
        ticks: std::array::from_fn(|_| 2048 + rng.random_range(-LIMIT_TICKS..=LIMIT_TICKS)),
        q: std::array::from_fn(|_| rng.random_range(-LIMIT_RAD..=LIMIT_RAD)),
    });
    postures
}

impl Config {
    /// `x` as an integer, or as f32 holds it.
    fn passed(self, x: f64, point: &str) -> f64 {
        match self.fixed {
            true => (x * self.unit(point)).round(),
            false => f64::from(x as f32),
        }
    }

    /// What a passed value means.
    fn meant(self, x: f64, point: &str) -> f64 {
        match self.fixed {
            true => self.passed(x, point) / self.unit(point),
            false => self.passed(x, point),
        }
    }

    /// 2^bits of a quantity's binary point.
    fn unit(self, point: &str) -> f64 {
        let header = self.header();
        let define = format!("#define {}{point}_FRACTION_BITS ", self.prefix());
        let line = header.lines().find_map(|line| line.strip_prefix(&define));
        let bits: i32 = line
            .expect("the header tells binary points")
            .parse()
            .unwrap();
        2f64.powi(bits)
    }

    fn postures_h(self) -> String {
        let mut text = format!(
            "#include <stdint.h>\n\n#include \"robot.h\"\n\n#define POSTURES {POSTURES}u\n\
             #define POSTURES_COUNTED {COUNTED}u\n"
        );
        let mut array = |kind: &str, name: &str, value: &dyn Fn(&Posture, usize) -> String| {
            let _ = writeln!(
                text,
                "\nstatic const {kind} {name}[POSTURES][ROBOT(DOF)] = {{"
            );
            for posture in postures() {
                let row: Vec<String> = (0..DOF).map(|k| value(&posture, k)).collect();
                let _ = writeln!(text, "    {{{}}},", row.join(", "));
            }
            text += "};\n";
        };
        let literal = |x: f64| match self.fixed {
            true => format!("{x}"),
            false => format!("{:?}f", x as f32),
        };
        let (q, sc) = ("Q", "SC");
        array("int32_t", "ticks", &|p, k| p.ticks[k].to_string());
        array("ROBOT(real)", "q", &|p, k| literal(self.passed(p.q[k], q)));
        array("ROBOT(real)", "sin_q", &|p, k| {
            literal(self.passed(p.q[k].sin(), sc))
        });
        array("ROBOT(real)", "cos_q", &|p, k| {
            literal(self.passed(p.q[k].cos(), sc))
        });
        text
    }
}

// -- what must come out

/// A function in f64.
fn in_f64(function: &str, q: &[f64; DOF], r: &[f64; op2::BASE_PARAMS]) -> Vec<f64> {
    match function {
        "com" => op2::com(q, r).to_vec(),
        "com_jacobian" => op2::com_jacobian(q, r).concat(),
        "gravity_moments" => op2::gravity_moments(q, r).to_vec(),
        "regressor" => op2::regressor(q).concat(),
        "regressor_cop" => op2::regressor_cop(q).concat(),
        "regressor_full" => op2::regressor_full(q).concat(),
        "cop" => op2::cop(q, r).to_vec(),
        other => panic!("{other} is no function"),
    }
}

/// Every name that is called: `com_jacobian`, `com_jacobian_sc`, `com_jacobian_ticks`, …
fn names() -> impl Iterator<Item = (String, &'static str, &'static str)> {
    let kinds = ["", "_sc", "_ticks"];
    kinds
        .into_iter()
        .flat_map(|kind| FUNCTIONS.map(|function| (format!("{function}{kind}"), function, kind)))
}

impl Config {
    /// The proven bound that the header states.
    fn bound(self, name: &str) -> f64 {
        let header = self.header();
        let line = header.lines().find_map(|line| {
            let mut words = line.strip_prefix(" * ")?.split_whitespace();
            (words.next()? == name).then(|| words.last())?
        });
        line.expect("the header has a table of bounds")
            .parse()
            .unwrap()
    }

    /// What `agree` prints: of each line, the function and the bits it returned.
    fn results(self) -> Vec<(String, Vec<u32>)> {
        let printed = sesc_test_support::machine::printed(&mut self.command("agree"), "", LIMIT);
        let line = |line: &str| {
            let mut words = line.split_whitespace();
            let name = words.next().unwrap().to_string();
            (
                name,
                words.map(|x| u32::from_str_radix(x, 16).unwrap()).collect(),
            )
        };
        printed.lines().map(line).collect()
    }

    fn value(self, bits: u32, unit: f64) -> f64 {
        match self.fixed {
            true => f64::from(bits as i32) / unit,
            false => f64::from(f32::from_bits(bits)),
        }
    }

    /// Results within the proven bound of f64; returns the worst share of the bound.
    fn check(self, results: &[(String, Vec<u32>)]) -> f64 {
        assert_eq!(
            results[0],
            ("selftest".to_string(), vec![0]),
            "{}",
            self.name
        );
        assert_eq!(
            results.len(),
            1 + POSTURES * names().count(),
            "{}",
            self.name
        );
        let r = op2::CAD_PARAMS.map(|x| self.meant(x, "R"));
        let mut results = results[1..].iter();
        let mut worst: f64 = 0.0;
        for posture in postures() {
            for (name, function, kind) in names() {
                let q = match kind {
                    "" => posture.q.map(|q| self.meant(q, "Q")),
                    "_sc" => posture.q,
                    _ => posture
                        .ticks
                        .map(|t| f64::from(t - 2048) * std::f64::consts::TAU / 4096.0),
                };
                let (printed, got) = results.next().unwrap();
                assert_eq!(*printed, name);
                let expected = in_f64(function, &q, &r);
                assert_eq!(got.len(), expected.len(), "{name}");
                let unit = if self.fixed {
                    self.unit(&function.to_uppercase())
                } else {
                    1.0
                };
                let bound = self.bound(&name);
                for (k, (got, expected)) in got.iter().zip(expected).enumerate() {
                    let error = (self.value(*got, unit) - expected).abs();
                    assert!(
                        error <= bound,
                        "{}: {name}[{k}] is off by {error:e}, proven {bound:e}",
                        self.name
                    );
                    worst = worst.max(error / bound);
                }
            }
        }
        worst
    }
}

#[test]
fn results_are_those_of_f64_and_of_this_machine() {
    let fixed = HOST_FIXED.results();
    let float = HOST_F32.results();
    for config in TARGETS {
        let results = config.results();
        let worst = config.check(&results);
        println!(
            "{}: at most {:.0} % of the proven bound",
            config.name,
            100.0 * worst
        );
        let host = if config.fixed { &fixed } else { &float };
        if config == M4F_F32 {
            // Fused operations round less often: near, and not the same everywhere.
            assert_ne!(&results, host, "the compiler fuses");
        } else {
            for (got, expected) in results.iter().zip(host) {
                assert_eq!(got, expected, "{}: to the last bit", config.name);
            }
        }
    }
}

// -- what it costs

/// Most instructions of `com_ticks`, by configuration.
const GOALS: [(Config, u64); 3] = [(M3_FIXED, 1500), (M4F_F32, 900), (M4F_F32_EXACT, 900)];

/// Instructions of each call that `measure` makes, by address of what is called.
///
/// One line of the trace is one instruction; what lies between leaving `measure`
/// and coming back to it is one call. A line that begins with "Stopped" takes the
/// line before it back.
fn calls(trace: impl BufRead, measure: &Range<u32>) -> Vec<(u32, u64)> {
    let mut calls = Vec::new();
    let mut open: Option<(u32, u64)> = None;
    let mut begun = false;
    for line in trace.split(b'\n') {
        let line = line.unwrap();
        if line.starts_with(b"Stopped execution") {
            open = open.map(|(entry, count)| (entry, count - 1));
            continue;
        }
        let Some(pc) = program_counter(&line) else {
            continue;
        };
        if measure.contains(&pc) {
            begun = true;
            // A call that was stopped before its first instruction is not over.
            calls.extend(open.take().filter(|(_, count)| *count > 0));
        } else if begun {
            let (entry, count) = open.filter(|(_, count)| *count > 0).unwrap_or((pc, 0));
            open = Some((entry, count + 1));
        }
    }
    calls
}

/// Of `Trace 0: 0x7f788c000100 [00800400/00000048/00000110/ff000201] reset`: 0x48.
fn program_counter(line: &[u8]) -> Option<u32> {
    let line = std::str::from_utf8(line).ok()?.strip_prefix("Trace")?;
    let field = line.split('[').nth(1)?.split('/').nth(1)?;
    u32::from_str_radix(field.trim_start_matches('0'), 16).ok()
}

#[test]
fn calls_are_told_apart_in_a_trace() {
    let line =
        |pc: u32| format!("Trace 0: 0x7f788c000100 [00800400/{pc:08x}/00000110/ff000201] f\n");
    let stopped = |pc: u32| format!("Stopped execution of TB chain before 0x7f [{pc:08x}] f\n");
    let trace = [
        line(0x10),
        line(0x100),
        line(0x40),
        line(0x44),
        stopped(0x44),
        line(0x44),
        line(0x102),
        line(0x60),
        stopped(0x60),
        line(0x60),
        line(0x104),
        line(0x70),
    ];
    let found = calls(trace.concat().as_bytes(), &(0x100..0x110));
    assert_eq!(found, [(0x40, 2), (0x60, 1)]);
}

/// The option that makes every instruction a block of its own.
fn one_by_one() -> &'static [&'static str] {
    let version = sesc_test_support::machine::printed(
        Command::new("qemu-system-arm").arg("--version"),
        "",
        LIMIT,
    );
    let number = version.split_whitespace().nth(3).unwrap_or_default();
    let mut parts = number
        .split('.')
        .map(|part| part.parse::<u32>().unwrap_or(0));
    let version = (parts.next().unwrap_or(0), parts.next().unwrap_or(0));
    match version < (8, 1) {
        true => &["-singlestep"],
        false => &["-accel", "tcg,one-insn-per-tb=on"],
    }
}

impl Config {
    /// Symbols of an object: address and size.
    fn symbols(self, file: &str) -> BTreeMap<String, Range<u32>> {
        let mut nm = Command::new("arm-none-eabi-nm");
        nm.arg("--print-size").arg(self.built().join(file));
        let printed = sesc_test_support::machine::printed(&mut nm, "", LIMIT);
        let symbol = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [address, size, _, name] = words[..] else {
                return None;
            };
            // The lowest bit says Thumb.
            let address = u32::from_str_radix(address, 16).ok()? & !1;
            let size = u32::from_str_radix(size, 16).ok()?;
            Some((name.to_string(), address..address + size))
        };
        printed.lines().filter_map(symbol).collect()
    }

    /// The symbol of a function.
    fn symbol(self, name: &str) -> String {
        format!("{}{name}", self.prefix())
    }

    /// Executed instructions of every call in `counts`, in the order of the calls.
    fn trace(self) -> Vec<(String, u64)> {
        let symbols = self.symbols("counts.elf");
        let trace = self.built().join("trace");
        let mut qemu = self.command("counts");
        qemu.args(one_by_one())
            .args(["-d", "exec,nochain", "-D"])
            .arg(&trace);
        sesc_test_support::machine::printed(&mut qemu, "", LIMIT);
        let calls = calls(
            BufReader::new(File::open(&trace).unwrap()),
            &symbols["measure"],
        );
        fs::remove_file(&trace).unwrap();
        let name = |entry: u32| {
            let found = symbols.iter().find(|(_, range)| range.start == entry);
            found
                .expect("a call enters a function at its beginning")
                .0
                .clone()
        };
        calls
            .into_iter()
            .map(|(entry, count)| (name(entry), count))
            .collect()
    }

    /// Instructions per call: the most over the counted postures.
    fn instructions(self) -> BTreeMap<String, u64> {
        let calls = self.trace();
        let of = |symbol: &str| -> Vec<u64> {
            let counts = calls.iter().filter(|(name, _)| name == symbol);
            counts.map(|(_, count)| *count).collect()
        };
        // The yardstick: loops, skipped instructions, a lone return.
        assert_eq!(of("known_return"), [1], "{}", self.name);
        assert_eq!(of("known_loop"), [3 + 2 * 1000], "{}", self.name);
        assert_eq!(of("known_skip"), [5], "{}", self.name);
        let mut most = BTreeMap::new();
        for (name, ..) in names() {
            let counts = of(&self.symbol(&name));
            assert_eq!(counts.len(), COUNTED, "{}: {name}", self.name);
            let largest = counts.iter().copied().max().unwrap();
            if self != M3_F32 {
                // Floating point in software takes its time from the numbers.
                assert_eq!(
                    counts, [largest; COUNTED],
                    "{}: {name}, whatever the posture",
                    self.name
                );
            }
            most.insert(name, largest);
        }
        most
    }

    /// Bytes of flash that a function takes with everything it calls.
    fn flash(self, name: &str) -> u64 {
        let out = self.built();
        let program = out.join(format!("only/{}.elf", self.symbol(name)));
        self.make(&out, &[&program.display().to_string()]);
        sizes(&program)[0]
    }

    /// Bytes of stack at the deepest, by the compiler's own account.
    fn stack(self, name: &str) -> u64 {
        let graph = fs::read_to_string(self.built().join("robot.ci")).unwrap();
        let mut frames: BTreeMap<&str, u64> = BTreeMap::new();
        let mut callees: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for line in graph.lines() {
            let field = |key: &str| {
                line.split_once(key)
                    .and_then(|(_, rest)| rest.split('"').next())
            };
            if let (Some(from), Some(to)) = (field("sourcename: \""), field("targetname: \"")) {
                callees.entry(from).or_default().push(to);
            } else if let (Some(title), Some(label)) = (field("title: \""), field("label: \"")) {
                let own = label
                    .rsplit("\\n")
                    .find_map(|part| part.strip_suffix(" bytes (static)"));
                // libgcc's arithmetic, which keeps everything in registers.
                frames.insert(title, own.map_or(0, |bytes| bytes.parse().unwrap()));
                assert!(own.is_some() || title.starts_with("__aeabi_f"), "{line}");
            }
        }
        fn deepest<'g>(
            function: &'g str,
            frames: &BTreeMap<&'g str, u64>,
            callees: &BTreeMap<&'g str, Vec<&'g str>>,
        ) -> u64 {
            let below = callees.get(function).into_iter().flatten();
            frames[function]
                + below
                    .map(|f| deepest(f, frames, callees))
                    .max()
                    .unwrap_or(0)
        }
        deepest(&self.symbol(name), &frames, &callees)
    }
}

/// Bytes of code and constants, of initialised and of zeroed variables.
fn sizes(file: &Path) -> [u64; 3] {
    let printed = sesc_test_support::machine::printed(
        Command::new("arm-none-eabi-size").arg(file),
        "",
        LIMIT,
    );
    let mut words = printed.lines().nth(1).unwrap().split_whitespace();
    std::array::from_fn(|_| words.next().unwrap().parse().unwrap())
}

fn print_table(title: &str, cell: &dyn Fn(Config, &str) -> u64) {
    println!(
        "\n{title:<30}{}",
        TARGETS.map(|c| format!("{:>15}", c.name)).concat()
    );
    for (name, ..) in names() {
        let cells = TARGETS.map(|config| format!("{:>15}", cell(config, &name)));
        println!("{name:<30}{}", cells.concat());
    }
}

#[test]
fn costs_are_counted_and_keep_their_goals() {
    let counted: Vec<BTreeMap<String, u64>> = TARGETS.iter().map(|c| c.instructions()).collect();
    let instructions = |config: Config, name: &str| {
        let k = TARGETS.iter().position(|c| *c == config).unwrap();
        counted[k][name]
    };
    print_table("instructions a call", &instructions);
    print_table("flash, bytes, alone", &|config, name| config.flash(name));
    print_table("stack, bytes", &|config, name| config.stack(name));
    println!("\nwhole library: flash, static RAM, bytes");
    for config in TARGETS {
        let [text, data, bss] = sizes(&config.built().join("robot.o"));
        println!("{:<15}{text:>8}{:>8}", config.name, data + bss);
        assert_eq!(data + bss, 0, "{}: no variables", config.name);
    }
    assert_eq!(M3_FIXED.instructions(), counted[0], "counts repeat");
    for (config, goal) in GOALS {
        let count = instructions(config, "com_ticks");
        assert!(
            count <= goal,
            "{}: com_ticks takes {count} instructions, goal {goal}",
            config.name
        );
    }
}

// -- what it must not touch

#[test]
fn no_double_and_no_library_beyond_float_arithmetic() {
    for config in TARGETS {
        let mut nm = Command::new("arm-none-eabi-nm");
        nm.args(["--undefined-only", "--format=just-symbols"]);
        nm.arg(config.built().join("robot.o"));
        let printed = sesc_test_support::machine::printed(&mut nm, "", LIMIT);
        let needed: Vec<&str> = printed.split_whitespace().collect();
        let single = [
            "__aeabi_fadd",
            "__aeabi_fsub",
            "__aeabi_frsub",
            "__aeabi_fmul",
        ];
        let compared = [
            "__aeabi_fcmpge",
            "__aeabi_fcmple",
            "__aeabi_fcmpgt",
            "__aeabi_fcmplt",
        ];
        // With an FPU, and in fixed point, nothing at all.
        let allowed =
            |name: &&str| config == M3_F32 && (single.contains(name) || compared.contains(name));
        let stray: Vec<&&str> = needed.iter().filter(|name| !allowed(name)).collect();
        assert!(stray.is_empty(), "{}: {stray:?}", config.name);
        assert_eq!(
            needed.is_empty(),
            config != M3_F32,
            "{}: {needed:?}",
            config.name
        );
    }
}

#[test]
fn clang_has_nothing_to_warn_of() {
    for config in [HOST_FIXED, HOST_F32] {
        let postures = config.built();
        let out = postures.join("clang");
        config.make(
            &out,
            &[
                "CC=clang",
                &format!("POSTURES={}", postures.display()),
                "all",
            ],
        );
    }
    // The target's own part, with the headers of the target's library.
    let mut where_is = Command::new("arm-none-eabi-gcc");
    where_is.args(["-E", "-x", "c", "-"]);
    let text = sesc_test_support::machine::printed(&mut where_is, "#include <stdlib.h>\n", LIMIT);
    let include = text
        .lines()
        .filter_map(|line| line.split('"').nth(1)?.strip_suffix("/stdlib.h"))
        .next()
        .expect("newlib has a stdlib.h");
    for cpu in ["cortex-m3", "cortex-m4"] {
        let mut clang = Command::new("clang");
        clang
            .args(["--target=arm-none-eabi", "-mthumb", &format!("-mcpu={cpu}")])
            .args(
                "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion".split(' '),
            )
            .args(["-Wfloat-equal", "-Wshadow", "-Werror", "-isystem", include])
            .args(["-c", "-o", "/dev/null"])
            .arg(format!("{ROOT}/tests/firmware/startup.c"));
        sesc_test_support::machine::printed(&mut clang, "", LIMIT);
    }
}

#[test]
#[should_panic(expected = "did not end within 100ms and was stopped")]
fn a_program_that_hangs_is_stopped() {
    sesc_test_support::machine::run(
        Command::new("sleep").arg("60"),
        "",
        Duration::from_millis(100),
    );
}

// -- the example

/// CoM, CoP and margin in mm of every line that the example prints.
fn read_example(printed: &str) -> Vec<[f64; 6]> {
    let line = |line: &str| {
        let numbers: Vec<f64> = line
            .split_whitespace()
            .filter_map(|x| x.parse().ok())
            .collect();
        numbers.try_into().expect("six numbers a line")
    };
    printed.lines().map(line).collect()
}

#[test]
fn the_example_reads_ticks_and_tells_the_margin() {
    let input = fs::read_to_string(format!("{ROOT}/tests/firmware/postures.txt")).unwrap();
    for config in [M3_FIXED, M3_F32, M4F_F32, HOST_FIXED, HOST_F32] {
        let printed =
            sesc_test_support::machine::printed(&mut config.command("main"), &input, LIMIT);
        let rows = read_example(&printed);
        assert_eq!(
            rows.len(),
            input.lines().count(),
            "{}: {printed}",
            config.name
        );
        for (row, line) in rows.iter().zip(input.lines()) {
            let ticks: Vec<f64> = line
                .split_whitespace()
                .map(|t| t.parse().unwrap())
                .collect();
            let q = std::array::from_fn(|k| (ticks[k] - 2048.0) * std::f64::consts::TAU / 4096.0);
            let [x, y, z] = op2::com(&q, &op2::CAD_PARAMS).map(|m| 1000.0 * m);
            // The outline of the sole, without the example's way to it.
            let margin = (53.0 - x).min(x + 52.0).min(33.0 - y).min(y + 33.0);
            for (got, expected) in row.iter().zip([x, y, z, x, y, margin]) {
                assert!(
                    (got - expected).abs() < 0.003,
                    "{}: {got} {expected}",
                    config.name
                );
            }
        }
        // All zero: what Pinocchio and MuJoCo say; and it falls over, being on one foot.
        for (got, expected) in rows[0]
            .iter()
            .zip([-4.057, 46.476, 228.231, -4.057, 46.476, -13.476])
        {
            assert!((got - expected).abs() < 0.002, "{}: {printed}", config.name);
        }
        assert!(rows[2][5] > 30.0, "leaning over the foot: {printed}");

        let short = sesc_test_support::machine::run(&mut config.command("main"), "1 2 3\n", LIMIT);
        assert_eq!(short.status.code(), Some(2), "{}", config.name);
        let message = String::from_utf8_lossy(&short.stderr);
        assert!(
            message.contains("line 1: give 20 ticks, head_pan to r_el"),
            "{message}"
        );
    }
}
