//! The pages in `docs/`: their links resolve, their commands run, their tables are whole.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_test_support::command::{ROOT, folder, program};

/// Every page that a reader meets.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(ROOT);
    let top = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
    ];
    let mut pages: Vec<PathBuf> = top.iter().map(|name| root.join(name)).collect();
    let docs = fs::read_dir(root.join("docs")).unwrap();
    let docs = docs.map(|entry| entry.unwrap().path());
    pages.extend(docs.filter(|path| path.extension().is_some_and(|end| end == "md")));
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

#[test]
fn links_between_pages_resolve() {
    let mut seen = 0;
    for page in pages() {
        for link in links(&fs::read_to_string(&page).unwrap()) {
            if link.starts_with("http") || link.starts_with('#') {
                continue;
            }
            let (file, _) = link.split_once('#').unwrap_or((&link, ""));
            let target = page.parent().unwrap().join(file);
            assert!(target.exists(), "{}: {link}", page.display());
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
}

/// Columns are those that the commands name in their help.
#[test]
fn formats_name_every_column_and_key() {
    let formats = read("docs/formats.md");
    let columns = sesc_identify::logs::columns_text();
    // Further lines of a meaning stand below its first.
    let starts = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    for line in columns.lines().skip(1).filter(starts) {
        let names = line
            .split("  ")
            .find(|part| !part.trim().is_empty())
            .unwrap();
        for name in names.split(',').map(str::trim) {
            let name = match name {
                "JOINT" => "a joint's name".to_string(),
                "fsr_k" => "`fsr_1`".to_string(),
                "fsr_k_std" => "`fsr_1_std`".to_string(),
                name => format!("`{name}`"),
            };
            assert!(formats.contains(&name), "{name}");
        }
    }
}

/// The blocks of TOML are what the readers take.
#[test]
fn files_of_the_formats_page_are_read() {
    let formats = read("docs/formats.md");
    let blocks = blocks(&formats, "toml");
    assert_eq!(blocks.len(), 4);
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::copy(format!("{ROOT}/robots/op2/op2.urdf"), at("op2.urdf")).unwrap();
    let run = |line: &str| run(folder.path(), line);
    run("sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.001 --out run.csv");
    // The log has its CoP already, and is of no experiment.
    let unused = ["cells", "experiment", "topic", "readings_per_pose"];
    let sidecar = blocks[0]
        .lines()
        .filter(|line| !unused.iter().any(|key| line.starts_with(key)));
    fs::write(at("run.csv.toml"), sidecar.collect::<Vec<_>>().join("\n")).unwrap();
    fs::write(at("prior.toml"), &blocks[1]).unwrap();
    fs::write(at("servos.toml"), &blocks[2]).unwrap();
    let warned = run("sesc fit op2.urdf --data run.csv --prior prior.toml 2>&1 >/dev/null");
    assert_eq!(warned, "");
    run("sesc diagnose op2.urdf --data run.csv --servos servos.toml");

    fs::write(at("sesc.toml"), &blocks[3]).unwrap();
    fs::write(
        at("limits.csv"),
        "joint,lower_deg,upper_deg\nhead_pan,-5,5\n",
    )
    .unwrap();
    let planned = run("sesc plan op2.urdf --poses 3 --candidates 100 --out poses.csv 2>&1");
    assert!(
        planned.contains("--support=r_sole --prior=tight --noise=0.0005"),
        "{planned}"
    );
}

/// From an empty folder with a URDF to a corrected controller.
#[test]
fn the_tutorial_runs() {
    let tutorial = read("docs/tutorial.md");
    let folder = folder();
    fs::copy(
        format!("{ROOT}/robots/op2/op2.urdf"),
        folder.path().join("op2.urdf"),
    )
    .unwrap();
    let mut printed = String::new();
    let commands = blocks(&tutorial, "sh");
    assert!(commands.len() > 6);
    for line in commands.iter().flat_map(|block| block.lines()) {
        printed += &run(folder.path(), line);
    }
    let printed: String = printed.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in blocks(&tutorial, "text")
        .iter()
        .flat_map(|block| block.lines())
    {
        assert!(printed.contains(expected), "{expected}\n{printed}");
    }
    for written in [
        "poses.csv",
        "fit.html",
        "report.html",
        "model.toml",
        "fw/op2.c",
    ] {
        assert!(folder.path().join(written).exists(), "{written}");
    }
}

/// What stands between fences of this kind.
fn blocks(text: &str, kind: &str) -> Vec<String> {
    let fence = format!("```{kind}\n");
    let parts = text.split(&fence).skip(1);
    parts
        .map(|part| part.split("```").next().unwrap().to_string())
        .collect()
}

/// A line of a shell in `folder`, where `sesc` is the one under test; what it printed.
fn run(folder: &Path, line: &str) -> String {
    let path = std::env::var("PATH").unwrap();
    let path = format!("{}:{path}", program().parent().unwrap().display());
    let mut bash = Command::new("bash");
    bash.args(["-ec", line])
        .current_dir(folder)
        .env("PATH", path);
    let output = bash.output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}\n{stderr}");
    String::from_utf8(output.stdout).unwrap()
}
