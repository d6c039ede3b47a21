//! The public items of the published crates as text, so that a change of them shows in a diff.
//!
//!     cargo api            rewrite docs/api/
//!     cargo api --check    fail where a list is not that of the code
//!
//! What `#[doc(hidden)]` hides is not listed: it serves the project's own crates.
//! The text is that of one toolchain, which docs/api/rustc.txt names; of another nothing is
//! compared.

mod shown;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Crates that are published, by the names of their libraries.
const CRATES: [&str; 6] = [
    "sesc",
    "sesc_codegen",
    "sesc_identify",
    "sesc_model",
    "sesc_reference",
    "sesc_runtime",
];

/// Names the toolchain whose rustdoc wrote the lists.
const TOOLCHAIN: &str = "rustc.txt";

fn toolchain() -> Result<String, Box<dyn Error>> {
    Ok(String::from_utf8(
        Command::new("rustc").arg("-V").output()?.stdout,
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let check = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--check"] => true,
        _ => return Err("usage: cargo api [--check]".into()),
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2);
    let root = root.ok_or("this program stands in no repository")?;
    let folder = root.join("docs/api");
    let toolchain = toolchain()?;
    let made_with = fs::read_to_string(folder.join(TOOLCHAIN)).unwrap_or_default();
    if check && made_with != toolchain {
        println!(
            "not compared: the lists are of {}, this is {}",
            made_with.trim(),
            toolchain.trim()
        );
        return Ok(());
    }
    let mut lists = lists(root)?;
    if !check {
        lists.push((TOOLCHAIN.to_string(), toolchain));
        fs::create_dir_all(&folder)?;
        for (name, text) in &lists {
            fs::write(folder.join(name), text)?;
        }
        return Ok(());
    }
    let mut failed = false;
    for (name, text) in &lists {
        let before = fs::read_to_string(folder.join(name)).unwrap_or_default();
        let gone = before
            .lines()
            .filter(|line| !text.lines().any(|other| other == *line));
        let come = text
            .lines()
            .filter(|line| !before.lines().any(|other| other == *line));
        let gone: Vec<String> = gone.map(|line| format!("-{line}")).collect();
        let come: Vec<String> = come.map(|line| format!("+{line}")).collect();
        if before != *text {
            eprintln!("docs/api/{name}:\n{}", [gone, come].concat().join("\n"));
            failed = true;
        }
    }
    if failed {
        return Err("public items changed: cargo api, and a line in CHANGELOG.md".into());
    }
    Ok(())
}

/// File names and their texts. One run of rustdoc for the whole workspace, with the features
/// that its members ask of each other.
fn lists(root: &Path) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or("target".into());
    let docs = root.join(target).join("doc");
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command
        .current_dir(root)
        .args(["doc", "--quiet", "--no-deps", "--lib"]);
    for library in CRATES {
        let _ = fs::remove_file(docs.join(format!("{library}.json")));
    }
    let status = command
        .args(["--workspace", "--exclude", "sesc-python"])
        .env("RUSTDOC", root.join("xtask/api/rustdoc-json"))
        .env(
            "RUSTDOCFLAGS",
            "-Zunstable-options --output-format json --document-hidden-items \
             -Arustdoc::private-intra-doc-links",
        )
        .status()?;
    if !status.success() {
        return Err("rustdoc failed".into());
    }
    let list = |library: &&str| -> Result<(String, String), Box<dyn Error>> {
        let file = docs.join(format!("{library}.json"));
        let mut described = serde_json::from_slice(&fs::read(&file)?)?;
        shown::leave_hidden_out(&mut described);
        fs::write(&file, serde_json::to_vec(&described)?)?;
        let api = public_api::Builder::from_rustdoc_json(file)
            .omit_blanket_impls(true)
            .omit_auto_trait_impls(true)
            .build()?;
        let lines: Vec<String> = api.items().map(|item| format!("{item}\n")).collect();
        Ok((format!("{}.txt", library.replace('_', "-")), lines.concat()))
    };
    CRATES.iter().map(list).collect()
}
