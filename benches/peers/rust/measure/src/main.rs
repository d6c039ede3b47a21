//! Ours and the peers on the same postures, in turns: called by `benches/peers/run`.

mod fits;
mod functions;
mod our_fit;
mod ours;
mod peers;
mod table;
mod turns;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use functions::{FUNCTIONS, MODES, Range};
use peers::Peers;
use table::Table;

const USAGE: &str = "usage: measure FOLDER PYTHON [--quick] [--rounds N] [--fit-postures N] \
                     [--only functions|fit]";

struct Settings {
    folder: PathBuf,
    python: PathBuf,
    rounds: usize,
    slot: Duration,
    fit_postures: usize,
    fit_rounds: usize,
    functions: bool,
    fit: bool,
}

fn settings(mut arguments: impl Iterator<Item = String>) -> Result<Settings, String> {
    let mut path = || arguments.next().map(PathBuf::from).ok_or(USAGE);
    let mut settings = Settings {
        folder: path()?,
        python: path()?,
        rounds: 51,
        slot: Duration::from_millis(4),
        fit_postures: 1_000_000,
        fit_rounds: 20,
        functions: true,
        fit: true,
    };
    let mut rounds = None;
    while let Some(word) = arguments.next() {
        let mut value = || {
            arguments
                .next()
                .ok_or(format!("{word} wants a value\n{USAGE}"))
        };
        let number = |text: String| match text.parse() {
            Ok(n) if n > 0 => Ok(n),
            _ => Err(format!("`{text}` is no count\n{USAGE}")),
        };
        match word.as_str() {
            "--quick" => {
                settings.rounds = 20;
                settings.slot = Duration::from_millis(1);
                settings.fit_postures = 50_000;
                settings.fit_rounds = 5;
            }
            "--rounds" => rounds = Some(number(value()?)?),
            "--fit-postures" => settings.fit_postures = number(value()?)?,
            "--only" => match value()?.as_str() {
                "functions" => settings.fit = false,
                "fit" => settings.functions = false,
                other => return Err(format!("--only {other}?\n{USAGE}")),
            },
            _ => return Err(format!("what is {word}?\n{USAGE}")),
        }
    }
    if let Some(rounds) = rounds {
        (settings.rounds, settings.fit_rounds) = (rounds, rounds);
    }
    Ok(settings)
}

fn run(settings: &Settings) -> Result<(), String> {
    let peers = Peers::open(&settings.folder)?;
    let limits = settings.folder.join("limits.txt");
    let limits = std::fs::read_to_string(&limits)
        .map_err(|error| format!("{}: {error}", limits.display()))?;
    let mut table = Table::default();
    if settings.functions {
        for range in [
            Range::new("±150°", &peers, None)?,
            Range::new("real limits", &peers, Some(&limits))?,
        ] {
            for (mode, asked) in MODES {
                eprintln!("{}: {asked}", range.name);
                for (function, name) in FUNCTIONS {
                    let found = functions::measure(
                        &peers,
                        &range,
                        function,
                        mode,
                        settings.rounds,
                        settings.slot,
                    )?;
                    table.functions(range.name, asked, name, functions::POSTURES, &found);
                }
            }
        }
    }
    if settings.fit {
        let (count, rounds) = (settings.fit_postures, settings.fit_rounds);
        eprintln!("fit of {count} postures, {rounds} rounds");
        let found = fits::measure(&peers, &settings.folder, &settings.python, count, rounds)?;
        table.fit(count, &found);
    }
    print!("{}", table.markdown());
    let path = settings.folder.join("results.tsv");
    std::fs::write(&path, table.tsv()).map_err(|error| format!("{}: {error}", path.display()))
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let done = match &words[..] {
        [word, folder, urdf] if word == "--write-c" => ours::write_c(folder, urdf),
        _ => settings(words.into_iter()).and_then(|settings| run(&settings)),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("measure: {error}");
            ExitCode::FAILURE
        }
    }
}
