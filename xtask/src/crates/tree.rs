//! What `cargo tree` prints, as crates and who asks for them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use super::Failure;

/// Name and version.
pub type Id = (String, String);

/// A crate of a tree.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Crate {
    /// The licence that the crate states, an expression of SPDX.
    pub licence: String,
    /// It is a member of this repository.
    pub ours: bool,
    /// Crates that it asks for.
    pub needs: BTreeSet<Id>,
}

/// Crates by name and version.
pub type Crates = BTreeMap<Id, Crate>;

/// What `cargo tree` says with these arguments.
///
/// # Errors
/// cargo fails, or prints what is no tree.
pub fn crates(root: &Path, arguments: &[&str]) -> Result<Crates, Failure> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root).args(["tree", "--locked"]);
    command.args(["--prefix", "depth", "--format", "|{p}|{l}|"]);
    let output = command.args(arguments).output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    read(&String::from_utf8(output.stdout)?)
}

/// Lines `DEPTH|NAME vVERSION (PATH)|LICENCE|`, depth first; `(*)` stands for what was printed.
fn read(text: &str) -> Result<Crates, Failure> {
    let mut crates = Crates::new();
    let mut above: Vec<Id> = Vec::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        let mut parts = line.split('|');
        let (Some(depth), Some(package), Some(licence)) =
            (parts.next(), parts.next(), parts.next())
        else {
            return Err(format!("not a line of a tree: {line}").into());
        };
        let depth: usize = depth.parse()?;
        let mut words = package.split(' ');
        let (Some(name), Some(version)) = (words.next(), words.next()) else {
            return Err(format!("not a crate: {package}").into());
        };
        let id = (
            name.to_string(),
            version.trim_start_matches('v').to_string(),
        );
        above.truncate(depth);
        if let Some(parent) = above.last() {
            let parent = crates.get_mut(parent).ok_or("a tree without its root")?;
            parent.needs.insert(id.clone());
        }
        let entry = crates.entry(id.clone()).or_default();
        // Older crates write a slash for OR.
        entry.licence = licence.replace('/', " OR ");
        entry.ours = package.contains("(/") || package.contains(":\\");
        above.push(id);
    }
    Ok(crates)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_is_read_with_who_asks_for_whom() {
        let text = "0|sesc v0.1.0 (/somewhere)|MIT OR Apache-2.0|\n\
                    1|clap v4.6.7|MIT/Apache-2.0|\n\
                    2|strsim v0.11.1|MIT|\n\
                    1|serde_derive v1.0.2 (proc-macro)|MIT|\n\
                    1|clap v4.6.7|MIT/Apache-2.0| (*)\n\n\
                    0|other v0.1.0 (/elsewhere)|MIT|\n";
        let crates = read(text).unwrap();
        let id = |name: &str, version: &str| (name.to_string(), version.to_string());
        let needs = |name, version| -> Vec<String> {
            let needs = &crates[&id(name, version)].needs;
            needs.iter().map(|(name, _)| name.clone()).collect()
        };
        assert_eq!(crates.len(), 5);
        assert_eq!(needs("sesc", "0.1.0"), ["clap", "serde_derive"]);
        assert_eq!(needs("clap", "4.6.7"), ["strsim"]);
        assert!(needs("other", "0.1.0").is_empty());
        assert_eq!(crates[&id("clap", "4.6.7")].licence, "MIT OR Apache-2.0");
        assert!(crates[&id("sesc", "0.1.0")].ours && !crates[&id("strsim", "0.11.1")].ours);
        assert!(!crates[&id("serde_derive", "1.0.2")].ours);
    }
}
