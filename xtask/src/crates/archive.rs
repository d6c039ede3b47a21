//! What a binary archive says of the crates in its program: licences, and a bill of materials.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;
use serde_json::{Value, json};

use super::Failure;
use super::tree::{Crates, Id, crates};

/// What `cargo xtask bill` is asked.
#[derive(Args)]
pub struct Bill {
    /// What the program is built for
    #[arg(long)]
    target: String,
    /// Folder that the files are written to
    #[arg(long)]
    out: PathBuf,
}

impl Bill {
    /// Write `LICENCES.txt` and `sesc.cdx.json` of the command line.
    ///
    /// # Errors
    /// cargo fails, or a crate has neither a licence text nor one that is known without.
    pub fn run(&self, root: &Path) -> Result<(), Failure> {
        let of = ["-p", "sesc", "--target", &self.target];
        let linked = crates(root, &[&of[..], &["-e", "normal,no-proc-macro"]].concat())?;
        fs::create_dir_all(&self.out)?;
        fs::write(self.out.join("LICENCES.txt"), licences(root, &linked)?)?;
        let bill = bill(&linked, &checksums(root)?, &self.target)?;
        let bill = serde_json::to_string_pretty(&bill)? + "\n";
        fs::write(self.out.join("sesc.cdx.json"), bill)?;
        Ok(())
    }
}

/// SHA-256 of what the registry holds, from `Cargo.lock`.
fn checksums(root: &Path) -> Result<BTreeMap<Id, String>, Failure> {
    let lock: toml::Table = fs::read_to_string(root.join("Cargo.lock"))?.parse()?;
    let packages = lock["package"]
        .as_array()
        .ok_or("Cargo.lock without packages")?;
    let text = |package: &toml::Value, key: &str| Some(package.get(key)?.as_str()?.to_string());
    let sums = packages.iter().filter_map(|package| {
        let id = (text(package, "name")?, text(package, "version")?);
        Some((id, text(package, "checksum")?))
    });
    Ok(sums.collect())
}

/// CycloneDX 1.5: every crate in the program, the sum of its source, and what asks for it. It
/// holds neither date nor serial number: two builds of one source have the same bill.
fn bill(crates: &Crates, checksums: &BTreeMap<Id, String>, target: &str) -> Result<Value, Failure> {
    let url = |(name, version): &Id| format!("pkg:cargo/{name}@{version}");
    let component = |id: &Id, kind: &str| {
        let mut component = json!({
            "type": kind,
            "bom-ref": url(id),
            "name": id.0,
            "version": id.1,
            "scope": "required",
            "licenses": [{ "expression": crates[id].licence }],
            "purl": url(id),
        });
        if let Some(sum) = checksums.get(id) {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": sum }]);
        }
        component
    };
    let program = crates.keys().find(|(name, _)| name == "sesc");
    let program = program.ok_or("the tree has no sesc")?;
    let others = crates.keys().filter(|id| *id != program);
    let components: Vec<Value> = others.map(|id| component(id, "library")).collect();
    let needs = crates.iter().map(|(id, one)| {
        let needs: Vec<String> = one.needs.iter().map(url).collect();
        json!({ "ref": url(id), "dependsOn": needs })
    });
    let needs: Vec<Value> = needs.collect();
    Ok(json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": component(program, "application"),
            "properties": [{ "name": "cargo:target", "value": target }],
        },
        "components": components,
        "dependencies": needs,
    }))
}

/// Folders of the sources of crates.
fn sources(root: &Path) -> Result<BTreeMap<Id, PathBuf>, Failure> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.current_dir(root);
    let output = command
        .args(["metadata", "--locked", "--format-version", "1"])
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    let metadata: Value = serde_json::from_slice(&output.stdout)?;
    let packages = metadata["packages"]
        .as_array()
        .ok_or("metadata without packages")?;
    let sources = packages.iter().filter_map(|package| {
        let text = |key: &str| package[key].as_str().map(str::to_string);
        let folder = Path::new(package["manifest_path"].as_str()?).parent()?;
        Some(((text("name")?, text("version")?), folder.to_path_buf()))
    });
    Ok(sources.collect())
}

/// Files of a source that state a licence or a notice.
fn statements(folder: &Path) -> Result<Vec<String>, Failure> {
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        let states = [
            "license",
            "licence",
            "copying",
            "unlicense",
            "notice",
            "copyright",
        ];
        if path.is_file() && states.iter().any(|begin| name.starts_with(begin)) {
            files.push(path);
        }
    }
    files.sort();
    let read = |path: &PathBuf| -> Result<String, Failure> {
        let text = fs::read(path)?;
        Ok(String::from_utf8_lossy(&text)
            .replace("\r\n", "\n")
            .trim_matches('\n')
            .to_string())
    };
    files.iter().map(read).collect()
}

/// Texts, each once, with the crates that come under it.
fn licences(root: &Path, crates: &Crates) -> Result<String, Failure> {
    let sources = sources(root)?;
    let apache = fs::read_to_string(root.join("LICENSE-APACHE"))?;
    let apache = apache.trim_matches('\n').to_string();
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut list = String::new();
    for (id, one) in crates {
        let name = format!("{} {}", id.0, id.1);
        list += &format!("{name}: {}\n", one.licence);
        let folder = sources
            .get(id)
            .ok_or_else(|| format!("no source of {name}"))?;
        let mut found = statements(folder)?;
        if found.is_empty() && one.licence.contains("Apache-2.0") {
            // The text of this licence names no holder of rights.
            found.push(apache.clone());
        }
        if found.is_empty() {
            return Err(format!("{name} has no licence text").into());
        }
        for text in found {
            texts.entry(text).or_default().insert(name.clone());
        }
    }
    let mit = fs::read_to_string(root.join("LICENSE-MIT"))?;
    let under = |holder: &str| -> Result<String, Failure> {
        let own = mit.lines().find(|line| line.starts_with("Copyright"));
        let own = own.ok_or("LICENSE-MIT names no holder")?;
        Ok(mit.replace(own, holder).trim_matches('\n').to_string())
    };
    let library = "the standard library of Rust";
    texts.entry(apache).or_default().insert(library.to_string());
    texts
        .entry(under("Copyright (c) The Rust Project Contributors")?)
        .or_default()
        .insert(library.to_string());
    texts
        .entry(under("Copyright © 2005-2020 Rich Felker, et al.")?)
        .or_default()
        .insert("musl".to_string());
    list += &format!("{library}: MIT OR Apache-2.0\nmusl: MIT\n");

    let rule = "=".repeat(78);
    let mut text = format!("What the program sesc is made of, and its licences.\n\n{list}");
    for (licence, of) in &texts {
        let of: Vec<&str> = of.iter().map(String::as_str).collect();
        text += &format!("\n{rule}\n{}\n{rule}\n\n{licence}\n", of.join(", "));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crates::tree::Crate;

    fn two() -> Crates {
        let id = |name: &str| (name.to_string(), "1.0.0".to_string());
        let mut program = Crate {
            licence: "MIT".to_string(),
            ours: true,
            ..Crate::default()
        };
        program.needs.insert(id("libm"));
        let library = Crate {
            licence: "MIT OR Apache-2.0".to_string(),
            ..Crate::default()
        };
        Crates::from([(id("sesc"), program), (id("libm"), library)])
    }

    #[test]
    fn the_bill_names_each_crate_with_the_sum_of_its_source() {
        let sums = [(("libm".to_string(), "1.0.0".to_string()), "ab".repeat(32))];
        let bill = bill(&two(), &BTreeMap::from(sums), "x86_64-unknown-linux-musl").unwrap();
        assert_eq!(
            bill["metadata"]["component"]["purl"],
            "pkg:cargo/sesc@1.0.0"
        );
        let components = bill["components"].as_array().unwrap();
        assert_eq!(components.len(), 1);
        assert_eq!(
            components[0]["licenses"][0]["expression"],
            "MIT OR Apache-2.0"
        );
        assert_eq!(components[0]["hashes"][0]["content"], "ab".repeat(32));
        let of_program = bill["dependencies"].as_array().unwrap();
        let of_program = of_program
            .iter()
            .find(|one| one["ref"] == "pkg:cargo/sesc@1.0.0");
        assert_eq!(
            of_program.unwrap()["dependsOn"],
            json!(["pkg:cargo/libm@1.0.0"])
        );
    }

    #[test]
    fn a_source_without_a_licence_text_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("README.md"), "MIT, of course").unwrap();
        assert!(statements(folder.path()).unwrap().is_empty());
        fs::write(
            folder.path().join("LICENSE-MIT"),
            "Permission\r\nis granted\n",
        )
        .unwrap();
        assert_eq!(
            statements(folder.path()).unwrap(),
            ["Permission\nis granted"]
        );
    }
}
