//! What a call costs: instructions counted in a trace of qemu, flash, stack, and what
//! the code needs of its surroundings.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::ops::Range;
use std::path::Path;
use std::process::Command;

use super::LIMIT;
use super::build::{Config, M3_F32, M3_FIXED, M4F_F32, M4F_F32_EXACT, TARGETS};
use super::postures::COUNTED;
use sesc_test_support::machine;

/// Functions of the estimator, in float alone.
const ESTIMATOR: [&str; 3] = ["estimator_add", "estimator_params", "estimator_solve"];

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

/// Reads the program counter of `Trace 0: 0x7f788c000100 [00800400/00000048/00000110/ff000201]
/// reset`: 0x48.
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
    let version = machine::printed(Command::new("qemu-system-arm").arg("--version"), "", LIMIT);
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
        let printed = machine::printed(&mut nm, "", LIMIT);
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

    /// Every function that is counted.
    fn called(self) -> Vec<String> {
        let of_floats = ESTIMATOR.iter().filter(|_| !self.fixed);
        let names = self.names().map(|(name, ..)| name);
        names
            .chain(of_floats.map(|name| name.to_string()))
            .collect()
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
        machine::printed(&mut qemu, "", LIMIT);
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
        for name in self.called() {
            let counts = of(&self.symbol(&name));
            assert_eq!(counts.len(), COUNTED, "{}: {name}", self.name);
            let largest = counts.iter().copied().max().unwrap();
            // An estimator skips what a row does not have.
            if self != M3_F32 && !ESTIMATOR.contains(&name.as_str()) {
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
                // What is not of the robot keeps everything in registers.
                frames.insert(title, own.map_or(0, |bytes| bytes.parse().unwrap()));
                let registers = ["__aeabi_ui2f", "memset"].contains(&title);
                let registers = registers || title.starts_with("__aeabi_f");
                assert!(own.is_some() || registers, "{line}");
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
    let printed = machine::printed(Command::new("arm-none-eabi-size").arg(file), "", LIMIT);
    let mut words = printed.lines().nth(1).unwrap().split_whitespace();
    std::array::from_fn(|_| words.next().unwrap().parse().unwrap())
}

fn print_table(title: &str, cell: &dyn Fn(Config, &str) -> u64) {
    println!(
        "\n{title:<30}{}",
        TARGETS.map(|c| format!("{:>15}", c.name)).concat()
    );
    for name in M4F_F32.called() {
        let cells = TARGETS.map(|config| match config.called().contains(&name) {
            true => format!("{:>15}", cell(config, &name)),
            false => format!("{:>15}", "-"),
        });
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

#[test]
fn no_double_and_no_library_beyond_float_arithmetic() {
    for config in TARGETS {
        let mut nm = Command::new("arm-none-eabi-nm");
        nm.args(["--undefined-only", "--format=just-symbols"]);
        nm.arg(config.built().join("robot.o"));
        let printed = machine::printed(&mut nm, "", LIMIT);
        let needed: Vec<&str> = printed.split_whitespace().collect();
        let single = [
            "__aeabi_fadd",
            "__aeabi_fsub",
            "__aeabi_frsub",
            "__aeabi_fmul",
            // The estimator's alone: quotients, and the number of postures.
            "__aeabi_fdiv",
            "__aeabi_ui2f",
        ];
        let compared = [
            "__aeabi_fcmpge",
            "__aeabi_fcmple",
            "__aeabi_fcmpgt",
            "__aeabi_fcmplt",
        ];
        // With an FPU what gcc makes of a loop that clears the estimator; in fixed point
        // nothing at all.
        let allowed = |name: &&str| match config {
            M3_F32 => single.contains(name) || compared.contains(name) || *name == "memset",
            _ => !config.fixed && *name == "memset",
        };
        let stray: Vec<&&str> = needed.iter().filter(|name| !allowed(name)).collect();
        assert!(stray.is_empty(), "{}: {stray:?}", config.name);
        assert_eq!(
            needed.is_empty(),
            config.fixed,
            "{}: {needed:?}",
            config.name
        );
    }
}
