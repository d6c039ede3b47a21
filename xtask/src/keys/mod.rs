//! Keys of files and of JSON, from the types that read and write them.
//!
//! A type's fields are its keys and their documentation is what they mean, as serde has them:
//! renamed, left out, flattened. The source is read and not the compiled type, which knows
//! nothing of its documentation.

mod source;

use std::path::Path;
use std::rc::Rc;

use sesc_identify::diagnose::Verdict;
use sesc_identify::health::KINDS;
use source::{Field, Kind, Source, Type};
use syn::{GenericArgument, PathArguments};

/// What objects are called in TOML.
pub const TABLE: &str = "table";

/// Types that say themselves how they are written, and those that they are written as.
const WRITTEN_AS: [(&str, &str); 1] = [("Factor", "Packed")];

/// What is said of a key that is left out where there is nothing.
const LEFT_OUT: &str = ", where there is one";
/// Between a key and those within it.
const INNER: &str = ".";

/// One key, with those that it stands in: `chain[].mass_kg`, `bound.*`.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// With `[]` behind a list of objects, and `*` for a name that differs from file to file.
    pub path: String,
    /// What its value is: a number, text, a list.
    pub value: String,
    /// What it means.
    pub meaning: String,
}

/// Where the type of a file or of an answer stands: its file, and its name there.
pub type Place = (&'static str, &'static str);

/// All sources.
pub struct Keys {
    source: Rc<Source>,
    /// What objects are called: `object` in JSON, `table` in TOML.
    object: &'static str,
}

impl Keys {
    /// Read the sources below `root`; an object of the format is called `object`.
    ///
    /// # Errors
    /// A file that cannot be read or is no Rust.
    pub fn read(root: &Path, object: &'static str) -> Result<Keys, String> {
        let source = Rc::new(Source::read(root)?);
        Ok(Keys { source, object })
    }

    /// The same sources for a format whose objects are called so.
    pub fn called(&self, object: &'static str) -> Keys {
        let source = Rc::clone(&self.source);
        Keys { source, object }
    }

    /// The keys of a type, outer ones before those in them, in the order of its fields.
    ///
    /// # Errors
    /// A type that is not found, a field without documentation.
    pub fn of(&self, (file, name): Place) -> Result<Vec<Key>, String> {
        let mut keys = Vec::new();
        self.fields(self.source.at(file, name)?, "", &mut keys)?;
        Ok(keys)
    }

    fn fields(&self, of: &Type, prefix: &str, keys: &mut Vec<Key>) -> Result<(), String> {
        let Kind::Struct(fields) = &of.kind else {
            return Err(format!("{} is no struct", of.name));
        };
        for field in fields {
            self.field(of, field, prefix, keys)
                .map_err(|reason| format!("{}.{}: {reason}", of.name, field.key))?;
        }
        Ok(())
    }

    fn field(
        &self,
        of: &Type,
        field: &Field,
        prefix: &str,
        keys: &mut Vec<Key>,
    ) -> Result<(), String> {
        let found = self.shape(of, &field.of)?;
        if field.flat {
            let inner = found.inner.ok_or("is flattened, and no struct")?;
            let first = keys.len();
            self.fields(inner, prefix, keys)?;
            if field.optional {
                // Those within others are there with them.
                let own = |key: &&mut Key| !key.path[prefix.len()..].contains(INNER);
                let own = keys[first..].iter_mut().filter(own);
                own.for_each(|key| key.value += LEFT_OUT);
            }
            return Ok(());
        }
        if field.meaning.is_empty() {
            return Err("has no documentation".to_string());
        }
        let path = format!("{prefix}{}{}", field.key, found.below);
        let mut value = found.value;
        // TOML has no `null`.
        let left_out = field.optional || (found.or_null && self.object == TABLE);
        if left_out {
            value += LEFT_OUT;
        } else if found.or_null {
            value += ", or `null`";
        }
        let deeper = format!("{path}{INNER}");
        keys.push(Key {
            path: path.trim_end_matches("[]").to_string(),
            value,
            meaning: plain(&field.meaning),
        });
        let Some(inner) = found.inner else {
            return Ok(());
        };
        match &inner.kind {
            Kind::Struct(_) => self.fields(inner, &deeper, keys),
            Kind::Enum(cases) => {
                for (name, meaning, _) in cases.iter().filter(|case| case.2) {
                    keys.push(Key {
                        path: format!("{deeper}{name}"),
                        value: "number".to_string(),
                        meaning: plain(meaning),
                    });
                }
                Ok(())
            }
            Kind::Own => Ok(()),
        }
    }

    /// What a type of a field of `home` is.
    fn shape<'s>(&'s self, home: &Type, of: &syn::Type) -> Result<Shape<'s>, String> {
        match of {
            syn::Type::Reference(of) => self.shape(home, &of.elem),
            syn::Type::Paren(of) => self.shape(home, &of.elem),
            syn::Type::Slice(of) => Ok(self.shape(home, &of.elem)?.listed(None)),
            syn::Type::Array(of) => {
                let count = match &of.len {
                    syn::Expr::Lit(syn::ExprLit {
                        lit: syn::Lit::Int(count),
                        ..
                    }) => Some(count.base10_digits().to_string()),
                    _ => None,
                };
                Ok(self.shape(home, &of.elem)?.listed(count))
            }
            syn::Type::Tuple(_) => Ok(Shape::leaf("list")),
            syn::Type::Path(of) => self.named(home, &of.path),
            _ => Err("is of a kind of type that has no keys".to_string()),
        }
    }

    fn named<'s>(&'s self, home: &Type, path: &syn::Path) -> Result<Shape<'s>, String> {
        let last = path.segments.last().ok_or("has a type without a name")?;
        let name = last.ident.to_string();
        let arguments: Vec<&syn::Type> = match &last.arguments {
            PathArguments::AngleBracketed(of) => of.args.iter().filter_map(of_type).collect(),
            _ => Vec::new(),
        };
        let first = || arguments.first().ok_or("has a type without arguments");
        Ok(match name.as_str() {
            "f64" | "f32" => Shape::leaf("number"),
            "usize" | "u64" | "u32" | "i64" | "i32" => Shape::leaf("whole number"),
            "bool" => Shape::leaf("`true` or `false`"),
            "str" | "String" => Shape::leaf("text"),
            "Option" => Shape {
                or_null: true,
                ..self.shape(home, first()?)?
            },
            "Box" | "Arc" => self.shape(home, first()?)?,
            "Vec" => self.shape(home, first()?)?.listed(None),
            "BTreeMap" => {
                let values = arguments.get(1).ok_or("has a map without values")?;
                let of = self.shape(home, values)?;
                Shape {
                    below: format!(".*{}", of.below),
                    ..of
                }
            }
            parameter if home.parameters.iter().any(|own| own == parameter) => {
                Shape::leaf("number")
            }
            name => {
                let found = self.source.resolve(&home.file, name)?;
                let as_other = WRITTEN_AS.iter().find(|(own, _)| *own == name);
                match (as_other, &found.kind) {
                    (Some((_, other)), _) => self.object(self.source.resolve(&found.file, other)?),
                    (None, Kind::Own) => Shape::leaf(&one_of(own_names(name)?)),
                    (None, Kind::Struct(_)) => self.object(found),
                    (None, Kind::Enum(cases)) => {
                        let plain = cases.iter().filter(|case| !case.2);
                        let names = plain.map(|case| case.0.clone()).collect();
                        let carries = cases.iter().any(|case| case.2);
                        let object = match carries {
                            true => format!(", or {}", article(self.object)),
                            false => String::new(),
                        };
                        Shape {
                            inner: Some(found),
                            ..Shape::leaf(&(one_of(names) + &object))
                        }
                    }
                }
            }
        })
    }

    fn object<'s>(&self, inner: &'s Type) -> Shape<'s> {
        Shape {
            inner: Some(inner),
            ..Shape::leaf(self.object)
        }
    }
}

/// What a value is.
struct Shape<'s> {
    value: String,
    /// What stands behind the key of its objects: `[]` of lists, `.*` of maps.
    below: String,
    or_null: bool,
    /// The type of its objects.
    inner: Option<&'s Type>,
}

impl Shape<'_> {
    fn leaf(value: &str) -> Self {
        Shape {
            value: value.to_string(),
            below: String::new(),
            or_null: false,
            inner: None,
        }
    }

    /// A list of them, `count` where it is always so long.
    fn listed(self, count: Option<String>) -> Self {
        let of = match self.value.as_str() {
            "`true` or `false`" => "truths".to_string(),
            "text" => "texts".to_string(),
            "list" => "lists".to_string(),
            several if several.starts_with("list ") => several.replacen("list", "lists", 1),
            one if one.starts_with('`') => format!("names: {one}"),
            one => format!("{one}s"),
        };
        let of = match self.or_null {
            true => format!("{of} or `null`"),
            false => of,
        };
        let below = match self.inner {
            Some(_) => "[]".to_string() + &self.below,
            None => self.below,
        };
        Shape {
            value: match count {
                Some(count) => format!("list of {count} {of}"),
                None => format!("list of {of}"),
            },
            below,
            or_null: false,
            inner: self.inner,
        }
    }
}

fn of_type(argument: &GenericArgument) -> Option<&syn::Type> {
    match argument {
        GenericArgument::Type(of) => Some(of),
        _ => None,
    }
}

/// Names that a type which says itself how it is written may have.
fn own_names(name: &str) -> Result<Vec<String>, String> {
    let names: Vec<&str> = match name {
        "Verdict" => Verdict::ALL.iter().map(|of| of.name()).collect(),
        "Kind" => KINDS.iter().map(|of| of.name()).collect(),
        // Words for people, and names of ways.
        "TargetKind" => Vec::new(),
        _ => return Err(format!("`{name}` says itself how it is written")),
    };
    Ok(names.into_iter().map(str::to_string).collect())
}

/// `a`, `b` or `c`
fn one_of(names: Vec<String>) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => "text".to_string(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}

fn article(object: &str) -> String {
    let first = if object.starts_with('o') { "an" } else { "a" };
    format!("{first} {object}")
}

/// Documentation as a page has it: without links into the code, and without the full stop of
/// the only sentence.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((name, after)) = after.split_once("`]") else {
            break;
        };
        rest = behind_place(after);
        // A remark that is nothing but a link says nothing here.
        if let (Some(before), Some(after)) = (before.strip_suffix(" ("), rest.strip_prefix(')')) {
            out += before;
            rest = after;
            continue;
        }
        let last = name.rsplit("::").next().unwrap_or(name);
        out += &format!("{before}`{}`", last.trim_end_matches("()"));
    }
    out += rest;
    let one = out.strip_suffix('.').filter(|one| !one.contains(". "));
    one.unwrap_or(&out).replace('|', "\\|")
}

/// What stands behind the place in parentheses that a link may name.
fn behind_place(text: &str) -> &str {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' if depth == 1 => return &text[at + 1..],
            ')' if depth > 1 => depth -= 1,
            _ if depth == 0 => return text,
            _ => {}
        }
    }
    text
}

#[cfg(test)]
mod tests;
