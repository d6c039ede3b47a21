//! The pages in `docs/`: their links resolve, their commands run, their tables are whole.

mod formats;
mod keys;
mod readme;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use sesc_test_support::command::{ROOT, folder, program, says};

/// Every page that a reader meets.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(ROOT);
    let top = "README.md ARCHITECTURE.md CONTRIBUTING.md CHANGELOG.md".split(' ');
    let mut pages: Vec<PathBuf> = top.map(|name| root.join(name)).collect();
    for folder in ["docs", "docs/effects"] {
        let docs = fs::read_dir(root.join(folder)).unwrap();
        let docs = docs.map(|entry| entry.unwrap().path());
        pages.extend(docs.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    pages.sort();
    pages
}

fn read(page: &str) -> String {
    fs::read_to_string(Path::new(ROOT).join(page)).unwrap()
}

/// Targets of `[text](target)`, outside of code.
fn links(text: &str) -> Vec<String> {
    let mut code = false;
    let prose = text.lines().filter(|line| {
        code ^= line.starts_with("```");
        !code
    });
    let mut found = Vec::new();
    for line in prose {
        for (at, _) in line.match_indices("](") {
            let rest = &line[at + 2..];
            found.extend(rest.find(')').map(|end| rest[..end].to_string()));
        }
    }
    found
}

/// What links call the headings of a page: letters and digits in small, spaces as dashes.
fn anchors(text: &str) -> Vec<String> {
    let mut code = false;
    let headings = text.lines().filter(|line| {
        code ^= line.starts_with("```");
        !code && line.starts_with('#')
    });
    let name = |heading: &str| -> String {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = heading
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(name).collect()
}

#[test]
fn links_between_pages_resolve() {
    let mut seen = 0;
    let mut places = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            if link.starts_with("http") {
                continue;
            }
            let (file, place) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            assert!(target.exists(), "{}: {link}", page.display());
            seen += 1;
            if !place.is_empty() {
                let there = anchors(&fs::read_to_string(&target).unwrap());
                assert!(there.contains(&place.to_string()), "{link}: {there:?}");
                places += 1;
            }
        }
    }
    assert!(seen > 100 && places > 5, "{seen} {places}");
}

/// Every page of `docs/` is a chapter, and no chapter links out of the book.
#[test]
fn every_page_is_a_chapter_of_the_book() {
    let summary = read("docs/SUMMARY.md");
    let docs = Path::new(ROOT).join("docs");
    let chapters: Vec<PathBuf> = links(&summary).iter().map(|file| docs.join(file)).collect();
    for (k, chapter) in chapters.iter().enumerate() {
        assert!(!chapters[..k].contains(chapter), "{}", chapter.display());
        let text = fs::read_to_string(chapter).unwrap();
        assert!(text.starts_with("# "), "{}", chapter.display());
        for link in links(&text).iter().filter(|link| !link.starts_with("http")) {
            let file = link.split('#').next().unwrap();
            let folder = chapter.parent().unwrap().strip_prefix(&docs).unwrap();
            let mut depth = folder.components().count();
            for step in file.split('/') {
                match step {
                    ".." => depth = depth.checked_sub(1).expect("a link out of the book"),
                    _ => depth += 1,
                }
            }
        }
    }
    for page in pages() {
        let own = page.strip_prefix(&docs);
        if own.is_ok_and(|name| name != Path::new("SUMMARY.md")) {
            assert!(chapters.contains(&page), "{} is no chapter", page.display());
        }
    }
}

/// From an empty folder to a corrected controller: each block of output is what the commands
/// before it print.
#[test]
fn the_tutorial_runs() {
    let tutorial = read("docs/tutorial.md");
    let folder = folder();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let (mut printed, mut compared) = (String::new(), 0);
    for (kind, text) in fences(&tutorial) {
        match kind {
            "sh" => {
                for line in text.lines() {
                    printed += &run(folder.path(), line);
                }
            }
            "text" => {
                let said: String = printed.split_whitespace().collect::<Vec<_>>().join(" ");
                let mut rest = said.as_str();
                for expected in text.lines() {
                    let found = rest.split_once(expected);
                    rest = found.unwrap_or_else(|| panic!("{expected}\n{rest}")).1;
                    compared += 1;
                }
                printed.clear();
            }
            kind => panic!("the tutorial has a block of {kind}"),
        }
    }
    assert!(compared > 12, "{compared}");
    for written in "poses.csv fit.html report.html model.toml fw/op2.c".split(' ') {
        assert!(folder.path().join(written).exists(), "{written}");
    }
    the_program_in_c_runs(folder.path());
}

/// Fenced blocks in their order, each with its kind.
fn fences(text: &str) -> Vec<(&str, &str)> {
    let parts = text.split("```").skip(1).step_by(2);
    parts.map(|part| part.split_once('\n').unwrap()).collect()
}

/// README's lines are the tutorial's, and its C runs with what these generate.
fn the_program_in_c_runs(folder: &Path) {
    let (readme, tutorial) = (read("README.md"), read("docs/tutorial.md"));
    let shown = blocks(&readme, "console");
    let commands = shown[0].lines().filter_map(|line| line.strip_prefix("$ "));
    for command in commands {
        let command = command.split("  #").next().unwrap().trim();
        assert!(tutorial.contains(command), "{command}");
    }
    let said = shown[0].lines().find(|line| line.starts_with("Missing"));
    says(&tutorial, &[said.unwrap()]);
    let program = &blocks(&readme, "c")[0];
    assert_eq!(program, &blocks(&read("docs/firmware.md"), "c")[0]);
    fs::write(folder.join("main.c"), program).unwrap();
    let cc = "cc -std=c99 -Wall -Wextra -Werror -Ifw main.c fw/op2.c -o main";
    let printed = run(folder, &format!("{cc} && ./main"));
    assert!(printed.ends_with(" mm\n"), "{printed}");
    assert_eq!(printed.split(' ').count(), 4, "{printed}");
}

/// What stands between fences of this kind.
fn blocks(text: &str, kind: &str) -> Vec<String> {
    let fences = fences(text).into_iter().filter(|fence| fence.0 == kind);
    fences.map(|(_, block)| block.to_string()).collect()
}

/// A line of a shell in `folder`, where `sesc` is the one under test; what it printed.
fn run(folder: &Path, line: &str) -> String {
    let output = shell(folder, line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}\n{stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// The same of a line that may fail.
fn run_any(folder: &Path, line: &str) -> String {
    String::from_utf8(shell(folder, line).stdout).unwrap()
}

fn shell(folder: &Path, line: &str) -> Output {
    let path = std::env::var("PATH").unwrap();
    let path = format!("{}:{path}", program().parent().unwrap().display());
    let mut bash = Command::new("bash");
    bash.args(["-ec", line])
        .current_dir(folder)
        .env("PATH", path);
    bash.output().unwrap()
}

/// With the lines of the page, or the name of a sole, a robot stands on its sole: its CoM is 40 mm
/// higher, and nothing else is changed.
#[test]
fn lines_for_a_sole_frame_make_one() {
    let lines = blocks(&read("docs/limits.md"), "xml").concat();
    let folder = folder();
    let own = read("robots/two_link/two_link.urdf");
    let with_sole = own.replace("</robot>", &format!("{lines}</robot>"));
    fs::write(folder.path().join("foot.urdf"), own).unwrap();
    fs::write(folder.path().join("foot_sole.urdf"), with_sole).unwrap();
    let log = folder.path().join("log.csv");
    fs::write(log, "pose,ankle,knee\n0,0.1,-0.2\n").unwrap();
    let robots = [
        ("foot", "foot"),
        ("foot_sole", "foot_sole"),
        ("foot", "foot@40mm"),
        ("foot", "foot --sole-height 0.04"),
    ];
    let [foot, soles @ ..] = robots.map(|(urdf, link)| -> Vec<f64> {
        let line = format!("sesc predict {urdf}.urdf --support {link} --data log.csv | tail -1");
        let row = run(folder.path(), &line);
        let cells = row.trim().split(',');
        cells.map(|cell| cell.parse().unwrap()).collect()
    });
    assert_eq!(foot.len(), 6);
    for sole in &soles {
        for (k, (a, b)) in foot.iter().zip(sole).enumerate() {
            let higher = if k == 3 { 0.04 } else { 0.0 };
            assert!((b - a - higher).abs() < 1e-12, "{foot:?} {sole:?}");
        }
    }
}
