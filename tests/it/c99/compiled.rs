//! Generated C, compiled on this machine and run on postures.

use std::fmt::Write as _;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use sesc_codegen::emit::c::{Package, Scalar};
use sesc_test_support::command::scratch;
pub(crate) use sesc_test_support::command::{printed, tool};

use super::case::Case;
use super::draw::{Draw, Drawn, Hold};
use super::entry::Entry;

/// What every file must pass without a word.
pub(crate) const WARNINGS: [&str; 10] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wfloat-equal",
    "-Wshadow",
    "-Wvla",
    "-Werror",
];

/// Each product and each sum rounded by itself, as in Rust.
pub(crate) const SEPARATE: &str = "-ffp-contract=off";

/// The folder for the files of one test.
pub(crate) fn folder(name: &str) -> PathBuf {
    scratch(&format!("c99/{name}"))
}

pub(crate) fn write(folder: &Path, name: &str, package: &Package) -> PathBuf {
    fs::write(folder.join(format!("{name}.h")), &package.header).unwrap();
    let source = folder.join(format!("{name}.c"));
    fs::write(&source, &package.source).unwrap();
    source
}

/// The words of a function's row in the tables of a header.
pub(crate) fn row<'h>(header: &'h str, function: &str) -> Vec<&'h str> {
    let rows = header.lines().filter_map(|line| line.strip_prefix(" * "));
    let mut rows = rows.map(|line| line.split_whitespace().collect::<Vec<&str>>());
    let own = rows.find(|words| words.first() == Some(&function));
    let own = own.unwrap_or_else(|| panic!("the header has no row for {function}"));
    own[1..].to_vec()
}

/// Run `work` on every item, two at a time.
pub(crate) fn parallel<T: Send, R: Send>(items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let count = items.len();
    let queue = Mutex::new(items.into_iter().enumerate());
    let done = Mutex::new(Vec::with_capacity(count));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().unwrap().next();
                    let Some((k, item)) = next else { break };
                    // The others are tried all the same.
                    let result = catch_unwind(AssertUnwindSafe(|| work(item)));
                    done.lock().unwrap().push((k, result));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap();
    let failed = done.iter().filter(|(_, result)| result.is_err()).count();
    assert!(failed == 0, "{failed} of {count} failed, see above");
    done.sort_by_key(|(k, _)| *k);
    let done = done.into_iter();
    done.filter_map(|(_, result)| result.ok()).collect()
}

/// A program that reads postures and writes the results of chosen functions.
pub(crate) struct Compiled {
    folder: PathBuf,
    program: PathBuf,
    scalar: Scalar,
    /// Fraction bits by macro name, 0 in floats.
    header: String,
    name: String,
}

impl Compiled {
    /// Compile the functions of `case`.
    pub(crate) fn plain(
        folder: &Path,
        case: &Case,
        scalar: Scalar,
        compiler: &str,
        level: &str,
    ) -> Compiled {
        Compiled::build(folder, case, scalar, compiler, &[level], |source| source)
    }

    /// Compile the functions of `case`, as `change` leaves their source.
    pub(crate) fn build(
        folder: &Path,
        case: &Case,
        scalar: Scalar,
        compiler: &str,
        flags: &[&str],
        change: impl Fn(String) -> String,
    ) -> Compiled {
        let mut package = case.package(scalar);
        package.source = change(package.source);
        let folder = folder.join(format!("{}_{scalar:?}_{compiler}{}", case.name, flags[0]));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &package);
        let driver = driver(case, scalar);
        fs::write(folder.join("main.c"), &driver).unwrap();
        let program = folder.join("program");
        let mut command = Command::new(compiler);
        command.args(WARNINGS).arg(SEPARATE).args(flags);
        command.args([source, folder.join("main.c")]).arg("-o");
        printed(command.arg(&program));
        Compiled {
            folder,
            program,
            scalar,
            header: package.header,
            name: case.name.clone(),
        }
    }

    /// Fraction bits that the header tells of `quantity`; 0 in floats.
    pub(crate) fn bits(&self, quantity: &str) -> i32 {
        let start = format!("#define {}_{quantity}_FRACTION_BITS ", self.name);
        let mut lines = self.header.lines();
        let line = lines.find_map(|line| line.strip_prefix(&start));
        line.map_or(0, |bits| bits.parse().unwrap())
    }

    /// The proven bound that the header's table gives; infinite where it says what was seen.
    pub(crate) fn bound(&self, entry: &Entry) -> f64 {
        match row(&self.header, &entry.name)[5] {
            "none;" | "none" => f64::INFINITY,
            bound => bound.parse().unwrap(),
        }
    }

    /// Rounding of a position or velocity to what the scalar holds.
    pub(crate) fn hold(&self) -> Box<Hold> {
        let [q, qd, sc] = ["Q", "QD", "SC"].map(|quantity| self.bits(quantity));
        let has_sines = self.header.contains("_SC_FRACTION_BITS");
        match self.scalar {
            Scalar::F64 => Box::new(|x, _, _| x),
            Scalar::F32 => Box::new(|x, _, up| {
                let y = x as f32;
                f64::from(match up {
                    true if f64::from(y) < x => y.next_up(),
                    false if f64::from(y) > x => y.next_down(),
                    _ => y,
                })
            }),
            Scalar::Fixed32 => Box::new(move |x, drawn, up| {
                let bits = match drawn {
                    Drawn::Velocity => qd,
                    Drawn::Stroke if has_sines => q.min(sc),
                    Drawn::Stroke | Drawn::Angle => q,
                };
                let unit = (-f64::from(bits)).exp2();
                match up {
                    true => (x / unit).ceil() * unit,
                    false => (x / unit).floor() * unit,
                }
            }),
            other => panic!("{other:?} is not measured"),
        }
    }

    /// Results of each entry, in metres, row by row.
    pub(crate) fn run(&self, case: &Case, entries: &[Entry], drawn: &Draw) -> Vec<Vec<f64>> {
        let (dof, params) = (case.model.dof(), case.model.base.params.len());
        let dofs = case.model.tree.dofs.iter();
        let prismatic: Vec<bool> = dofs.map(|dof| dof.prismatic).collect();
        let mut bytes = Vec::new();
        let [q_bits, qd_bits, r_bits, sc_bits] =
            ["Q", "QD", "R", "SC"].map(|quantity| self.bits(quantity));
        for (k, q) in drawn.q.chunks(dof).enumerate() {
            let mut put = |x: f64, bits: i32| match self.scalar {
                Scalar::F64 => bytes.extend(x.to_le_bytes()),
                Scalar::F32 => bytes.extend((x as f32).to_le_bytes()),
                Scalar::Fixed32 => {
                    let whole = (x * f64::from(bits).exp2()).round_ties_even();
                    assert!(whole.abs() < 2_f64.powi(31), "{x} does not fit");
                    bytes.extend((whole as i32).to_le_bytes());
                }
                other => panic!("{other:?} is not measured"),
            };
            let pairs = q.iter().map(|x| sesc_runtime::trig::sin_cos(*x));
            let pairs: Vec<(f64, f64)> = pairs.collect();
            q.iter().for_each(|x| put(*x, q_bits));
            for (j, (sin, _)) in pairs.iter().enumerate() {
                put(if prismatic[j] { q[j] } else { *sin }, sc_bits);
            }
            for (j, (_, cos)) in pairs.iter().enumerate() {
                put(if prismatic[j] { 0.0 } else { *cos }, sc_bits);
            }
            let own = k * dof..(k + 1) * dof;
            // Fixed point has no function of slow motion and of accelerations.
            for (array, bits) in [(&drawn.qd, qd_bits), (&drawn.slow, 0), (&drawn.qdd, 0)] {
                array[own.clone()].iter().for_each(|x| put(*x, bits));
            }
            let r = &drawn.r[k * params..(k + 1) * params];
            r.iter().for_each(|x| put(*x, r_bits));
            let ticks = drawn.ticks[own].iter();
            ticks.for_each(|t| bytes.extend(t.to_le_bytes()));
        }
        let input = self.folder.join("input");
        fs::write(&input, bytes).unwrap();
        let mut command = Command::new(&self.program);
        command.arg(&input);
        let all = case.entries(self.scalar);
        for entry in entries {
            let at = all.iter().position(|e| e.name == entry.name).unwrap();
            command.arg(at.to_string());
        }
        let output = tool(&mut command).unwrap_or_else(|message| panic!("{message}"));
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); entries.len()];
        let size = if self.scalar == Scalar::F64 { 8 } else { 4 };
        let mut values = output.chunks(size);
        for _ in 0..drawn.q.len() / dof {
            for (entry, column) in entries.iter().zip(&mut columns) {
                let bits = self.bits(&entry.function.name().to_uppercase());
                for bytes in values.by_ref().take(entry.width) {
                    column.push(match self.scalar {
                        Scalar::F64 => f64::from_le_bytes(bytes.try_into().unwrap()),
                        Scalar::F32 => f32::from_le_bytes(bytes.try_into().unwrap()).into(),
                        Scalar::Fixed32 => {
                            let whole = i32::from_le_bytes(bytes.try_into().unwrap());
                            f64::from(whole) * (-f64::from(bits)).exp2()
                        }
                        other => panic!("{other:?} is not measured"),
                    });
                }
            }
        }
        assert!(
            values.next().is_none(),
            "{}: more than asked for",
            self.name
        );
        columns
    }
}

/// `main.c`: postures from a file, results of the functions by number to stdout.
fn driver(case: &Case, scalar: Scalar) -> String {
    let name = &case.name;
    let entries = case.entries(scalar);
    let widest = entries.iter().map(|entry| entry.width).max().unwrap_or(1);
    let mut cases = String::new();
    for (k, entry) in entries.iter().enumerate() {
        let call = format!("{name}_{}({}, out)", entry.name, entry.arguments());
        let _ = writeln!(cases, "    case {k}: {call}; return {}u;", entry.width);
    }
    format!(
        r#"#include "{name}.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static {name}_real q[{name}_DOF], sines[{name}_DOF], cosines[{name}_DOF];
static {name}_real qd[{name}_DOF], slow[{name}_DOF], qdd[{name}_DOF], r[{name}_BASE_PARAMS], out[{widest}];
static int32_t ticks[{name}_DOF];

static size_t call(int function)
{{
    switch (function) {{
{cases}    default: return 0u;
    }}
}}

int main(int count, char **arguments)
{{
    FILE *input;
    if ({name}_selftest() != 0) {{
        fprintf(stderr, "selftest failed: %d\n", {name}_selftest());
        return 2;
    }}
    input = (count > 1) ? fopen(arguments[1], "rb") : NULL;
    if (input == NULL) {{
        return 3;
    }}
    while (fread(q, sizeof q, 1u, input) == 1u) {{
        int k;
        if (fread(sines, sizeof sines, 1u, input) != 1u
            || fread(cosines, sizeof cosines, 1u, input) != 1u
            || fread(qd, sizeof qd, 1u, input) != 1u
            || fread(slow, sizeof slow, 1u, input) != 1u
            || fread(qdd, sizeof qdd, 1u, input) != 1u
            || fread(r, sizeof r, 1u, input) != 1u
            || fread(ticks, sizeof ticks, 1u, input) != 1u) {{
            return 4;
        }}
        for (k = 2; k < count; k += 1) {{
            const size_t width = call(atoi(arguments[k]));
            if (fwrite(out, sizeof out[0], width, stdout) != width) {{
                return 5;
            }}
        }}
    }}
    (void)fclose(input);
    return 0;
}}
"#
    )
}
