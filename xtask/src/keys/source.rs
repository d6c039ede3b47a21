//! Types of the project's crates as their source has them: names, fields and documentation.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use syn::{Attribute, Fields, Generics, Item, UseTree};

/// Folders of sources, and the crates that they are.
const CRATES: [(&str, &str); 4] = [
    ("model/src", "sesc_model"),
    ("codegen/src", "sesc_codegen"),
    ("identify/src", "sesc_identify"),
    ("src", "sesc"),
];

/// A type that is read or written.
pub(super) struct Type {
    /// The file in which it stands, relative to the project's root.
    pub file: PathBuf,
    /// Crate and modules, outermost first.
    path: Vec<String>,
    pub name: String,
    pub kind: Kind,
    /// Names of its parameters for types.
    pub parameters: Vec<String>,
}

pub(super) enum Kind {
    Struct(Vec<Field>),
    /// Names as serde writes them, documentation, and whether they carry something.
    Enum(Vec<(String, String, bool)>),
    /// It says itself how it is written.
    Own,
}

pub(super) struct Field {
    /// Its key as serde writes it.
    pub key: String,
    pub meaning: String,
    pub of: syn::Type,
    pub flat: bool,
    /// It is left out where there is nothing.
    pub optional: bool,
}

/// All types, and what names mean in each file.
#[derive(Default)]
pub(super) struct Source {
    types: Vec<Type>,
    /// Paths that files import, by their last name.
    imports: BTreeMap<PathBuf, BTreeMap<String, Vec<String>>>,
}

impl Source {
    /// Read the sources of all crates below `root`.
    ///
    /// # Errors
    /// A file that cannot be read or is no Rust.
    pub fn read(root: &Path) -> Result<Source, String> {
        let mut source = Source::default();
        for (folder, name) in CRATES {
            source.folder(root, Path::new(folder), &[name.to_string()])?;
        }
        Ok(source)
    }

    /// The type of this name in `file`.
    pub fn at(&self, file: &str, name: &str) -> Result<&Type, String> {
        let own = |of: &&Type| of.file == Path::new(file) && of.name == name;
        let found = self.types.iter().find(own);
        found.ok_or_else(|| format!("no type `{name}` in {file}"))
    }

    /// What `name` means in a file: a type of the file, one that it imports, or one that its
    /// crate has once.
    pub fn resolve(&self, file: &Path, name: &str) -> Result<&Type, String> {
        let all = || self.types.iter().filter(|of| of.name == name);
        if let Some(own) = all().find(|of| of.file == file) {
            return Ok(own);
        }
        let imported = self.imports.get(file).and_then(|names| names.get(name));
        let home = self.types.iter().find(|of| of.file == file);
        let home = home.map_or(&[][..], |of| of.path.as_slice());
        let wanted = match imported {
            Some(path) => absolute(path, home),
            None => home.iter().take(1).cloned().collect(),
        };
        let mut found: Vec<&Type> = all()
            .filter(|of| of.path.first() == wanted.first())
            .collect();
        // Types that are exported from above stand below.
        let below = |of: &&Type| of.path.starts_with(&wanted);
        if found.len() > 1 {
            found.retain(below);
        }
        match found[..] {
            [one] => Ok(one),
            [] => Err(format!("{}: no type `{name}` is known", file.display())),
            _ => Err(format!("{}: several types `{name}`", file.display())),
        }
    }

    fn folder(&mut self, root: &Path, folder: &Path, path: &[String]) -> Result<(), String> {
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        let entries = std::fs::read_dir(root.join(folder)).map_err(failed)?;
        let mut names = Vec::new();
        for entry in entries {
            names.push(entry.map_err(failed)?.file_name().into_string());
        }
        let mut names: Vec<String> = names.into_iter().flatten().collect();
        names.sort();
        for name in names {
            let file = folder.join(&name);
            let mut own = path.to_vec();
            if root.join(&file).is_dir() {
                own.push(name);
                self.folder(root, &file, &own)?;
            } else if let Some(stem) = name.strip_suffix(".rs")
                && stem != "tests"
            {
                if !["mod", "lib", "main"].contains(&stem) {
                    own.push(stem.to_string());
                }
                self.file(root, file, &own)?;
            }
        }
        Ok(())
    }

    fn file(&mut self, root: &Path, file: PathBuf, path: &[String]) -> Result<(), String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
        let text = std::fs::read_to_string(root.join(&file)).map_err(|error| failed(&error))?;
        let parsed = syn::parse_file(&text).map_err(|error| failed(&error))?;
        let mut own_serialize = Vec::new();
        for item in &parsed.items {
            if let Item::Impl(of) = item
                && let Some((of_trait, _)) = &of.trait_
                && of_trait
                    .segments
                    .last()
                    .is_some_and(|last| last.ident == "Serialize")
                && let syn::Type::Path(of) = &*of.self_ty
                && let Some(last) = of.path.segments.last()
            {
                own_serialize.push(last.ident.to_string());
            }
        }
        for item in parsed.items {
            let (name, attributes, kind, generics) = match item {
                Item::Use(of) => {
                    let names = self.imports.entry(file.clone()).or_default();
                    imports(&of.tree, &mut Vec::new(), names);
                    continue;
                }
                Item::Struct(of) => {
                    let Fields::Named(fields) = of.fields else {
                        continue;
                    };
                    let fields = fields.named.iter().filter_map(field);
                    (
                        of.ident,
                        of.attrs,
                        Kind::Struct(fields.collect()),
                        of.generics,
                    )
                }
                Item::Enum(of) => {
                    let style = serde(&of.attrs, "rename_all").flatten();
                    let cases = of.variants.iter().map(|case| {
                        let name = cased(&case.ident.to_string(), style.as_deref());
                        (name, documentation(&case.attrs), !case.fields.is_empty())
                    });
                    let cases = Kind::Enum(cases.collect());
                    (of.ident, of.attrs, cases, of.generics)
                }
                _ => continue,
            };
            let name = name.to_string();
            let own = own_serialize.contains(&name);
            if own || derives_serde(&attributes) {
                self.types.push(Type {
                    file: file.clone(),
                    path: path.to_vec(),
                    name,
                    kind: if own { Kind::Own } else { kind },
                    parameters: parameters(&generics),
                });
            }
        }
        Ok(())
    }
}

/// A path that a file of `home` imports, from its crate on.
fn absolute(path: &[String], home: &[String]) -> Vec<String> {
    let modules = &path[..path.len() - 1];
    let mut out: Vec<String> = Vec::new();
    for name in modules {
        match name.as_str() {
            "crate" => out = home.iter().take(1).cloned().collect(),
            "self" => out = home.to_vec(),
            "super" => {
                if out.is_empty() {
                    out = home.to_vec();
                }
                out.pop();
            }
            name => {
                // A module of the file's own.
                if out.is_empty() && CRATES.iter().all(|(_, own)| *own != name) {
                    out = home.to_vec();
                }
                out.push(name.to_string());
            }
        }
    }
    out
}

fn imports(tree: &UseTree, path: &mut Vec<String>, names: &mut BTreeMap<String, Vec<String>>) {
    match tree {
        UseTree::Path(of) => {
            path.push(of.ident.to_string());
            imports(&of.tree, path, names);
            path.pop();
        }
        UseTree::Name(of) => {
            let full = path.iter().cloned().chain([of.ident.to_string()]);
            names.insert(of.ident.to_string(), full.collect());
        }
        UseTree::Rename(of) => {
            let full = path.iter().cloned().chain([of.ident.to_string()]);
            names.insert(of.rename.to_string(), full.collect());
        }
        UseTree::Group(of) => of.items.iter().for_each(|tree| imports(tree, path, names)),
        UseTree::Glob(_) => {}
    }
}

fn parameters(generics: &Generics) -> Vec<String> {
    generics
        .type_params()
        .map(|of| of.ident.to_string())
        .collect()
}

/// A field that serde writes.
fn field(field: &syn::Field) -> Option<Field> {
    if serde(&field.attrs, "skip").is_some() {
        return None;
    }
    let name = field.ident.as_ref()?.to_string();
    Some(Field {
        key: serde(&field.attrs, "rename").flatten().unwrap_or(name),
        meaning: documentation(&field.attrs),
        of: field.ty.clone(),
        flat: serde(&field.attrs, "flatten").is_some(),
        optional: serde(&field.attrs, "skip_serializing_if").is_some(),
    })
}

fn derives_serde(attributes: &[Attribute]) -> bool {
    let mut found = false;
    for attribute in attributes.iter().filter(|of| of.path().is_ident("derive")) {
        let _ = attribute.parse_nested_meta(|meta| {
            let last = meta.path.segments.last();
            found |= last.is_some_and(|of| of.ident == "Serialize" || of.ident == "Deserialize");
            Ok(())
        });
    }
    found
}

/// Whether `#[serde(…)]` has this word, and the text that it gives it, if any.
fn serde(attributes: &[Attribute], word: &str) -> Option<Option<String>> {
    let mut found = None;
    for attribute in attributes.iter().filter(|of| of.path().is_ident("serde")) {
        let _ = attribute.parse_nested_meta(|meta| {
            let text = match meta.input.peek(syn::Token![=]) {
                true => Some(meta.value()?.parse::<syn::LitStr>()?.value()),
                false => None,
            };
            if meta.path.is_ident(word) {
                found = Some(text);
            }
            Ok(())
        });
    }
    found
}

/// The first paragraph of what is said of an item.
fn documentation(attributes: &[Attribute]) -> String {
    let mut lines = Vec::new();
    for attribute in attributes.iter().filter(|of| of.path().is_ident("doc")) {
        if let syn::Meta::NameValue(of) = &attribute.meta
            && let syn::Expr::Lit(of) = &of.value
            && let syn::Lit::Str(text) = &of.lit
        {
            lines.push(text.value().trim().to_string());
        }
    }
    let first = lines.split(|line| line.is_empty()).next();
    first.unwrap_or_default().join(" ")
}

/// A name of Rust as serde writes it.
fn cased(name: &str, style: Option<&str>) -> String {
    match style {
        Some("lowercase") => name.to_lowercase(),
        Some("snake_case") => {
            let mut out = String::new();
            for c in name.chars() {
                if c.is_uppercase() && !out.is_empty() {
                    out.push('_');
                }
                out.extend(c.to_lowercase());
            }
            out
        }
        _ => name.to_string(),
    }
}
