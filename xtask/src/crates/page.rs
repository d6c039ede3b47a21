//! The page of docs/ that lists crates with licences and why each is there.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use clap::Args;

use super::Failure;
use super::tree::{Crates, Id, crates};
use super::why::WHY;

/// The page, from the root of the repository.
const PAGE: &str = "docs/dependencies.md";

/// Workspaces of their own.
const APART: [&str; 2] = ["fuzz", "xtask/api"];

/// What `cargo xtask dependencies` is asked.
#[derive(Args)]
pub struct Dependencies {
    /// Fail where the page is not what would be written
    #[arg(long)]
    check: bool,
}

impl Dependencies {
    /// Write the page, or compare it.
    ///
    /// # Errors
    /// A crate without a reason, a reason without a crate, or with `--check` a page of before.
    pub fn run(&self, root: &Path) -> Result<(), Failure> {
        let text = page(root)?;
        let path = root.join(PAGE);
        if !self.check {
            fs::write(&path, text)?;
        } else if fs::read_to_string(&path)? != text {
            return Err(
                format!("{PAGE} is not that of Cargo.lock: cargo xtask dependencies").into(),
            );
        }
        Ok(())
    }
}

/// Who names each crate in a manifest: ours by theirs, without ours.
fn named(all: &Crates) -> BTreeMap<&Id, BTreeSet<&str>> {
    let mut named: BTreeMap<&Id, BTreeSet<&str>> = BTreeMap::new();
    for ((name, _), one) in all.iter().filter(|(_, one)| one.ours) {
        for need in one.needs.iter().filter(|need| !all[*need].ours) {
            named.entry(need).or_default().insert(name);
        }
    }
    named
}

fn page(root: &Path) -> Result<String, Failure> {
    let sesc = ["-p", "sesc", "--features", "zstd", "--target", "all"];
    let shipped = crates(root, &[&sesc[..], &["-e", "normal,build"]].concat())?;
    let workspace = ["--workspace", "--all-features", "--target", "all"];
    let mut all = crates(root, &workspace)?;
    for folder in APART {
        all = with_those_of(all, crates(&root.join(folder), &["--target", "all"])?);
    }
    let named = named(&all);
    let direct: BTreeSet<&str> = named.keys().map(|(name, _)| name.as_str()).collect();
    let reasons: BTreeMap<&str, &str> = WHY.iter().copied().collect();
    for name in &direct {
        if !reasons.contains_key(name) {
            return Err(format!("xtask/src/crates/why.rs: what is {name} there for?").into());
        }
    }
    if let Some((name, _)) = reasons.iter().find(|(name, _)| !direct.contains(*name)) {
        return Err(format!("xtask/src/crates/why.rs: no manifest names {name}").into());
    }

    let mut text = String::from(
        "# Crates and licences\n\n\
         What `sesc` is built from, under which licences, and what each crate is there for. `cargo \
         xtask dependencies` writes this page from `Cargo.lock`; `.ci/run` compares it. `deny.toml` \
         allows permissive licences alone and names the reason for each crate that comes in two \
         versions. Where a crate offers several licences, a permissive one is taken.\n\n\
         `sesc-runtime`, which a controller ships, needs none of them.\n\n\
         ## Crates that a manifest names\n\n\
         | crate | licence | named by | what it is there for |\n|---|---|---|---|\n",
    );
    for (id, by) in &named {
        let by: Vec<&str> = by.iter().copied().collect();
        text += &format!(
            "| {} | {} | {} | {} |\n",
            id.0,
            all[*id].licence,
            by.join(", "),
            reasons[id.0.as_str()]
        );
    }
    let shipped: Vec<&Id> = shipped
        .iter()
        .filter(|(_, one)| !one.ours)
        .map(|(id, _)| id)
        .collect();
    text += &format!(
        "\n## What the command line is built from\n\n\
         {} crates on all systems together, with every feature that a user can ask for (`zstd` \
         among them), macros and what builds C included.\n\n",
        shipped.len()
    );
    text += &table(&all, &shipped)?;
    let rest = all
        .iter()
        .filter(|(id, one)| !one.ours && !shipped.contains(id));
    let rest: Vec<&Id> = rest.map(|(id, _)| id).collect();
    text += &format!(
        "\n## What tests, benches, fuzz targets and the Python package add\n\n{} crates.\n\n",
        rest.len()
    );
    text += &table(&all, &rest)?;
    Ok(text)
}

/// The workspace, and what only another one has.
fn with_those_of(mut all: Crates, other: Crates) -> Crates {
    let new = other.into_iter().filter(|(id, _)| !all.contains_key(id));
    let new: Crates = new.collect();
    all.extend(new);
    all
}

fn table(all: &Crates, of: &[&Id]) -> Result<String, Failure> {
    let mut text =
        String::from("| crate | version | licence | asked for by |\n|---|---|---|---|\n");
    for id in of {
        let one = all
            .get(*id)
            .ok_or_else(|| format!("{} is in no tree", id.0))?;
        let by = all.iter().filter(|(_, other)| other.needs.contains(*id));
        let by: BTreeSet<&str> = by.map(|((name, _), _)| name.as_str()).collect();
        let by: Vec<&str> = by.into_iter().collect();
        text += &format!(
            "| {} | {} | {} | {} |\n",
            id.0,
            id.1,
            one.licence,
            by.join(", ")
        );
    }
    Ok(text)
}
