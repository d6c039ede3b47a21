//! What a text declares for others, item by item: functions, fields, variants, methods,
//! implementations and what is passed on.

/// A public declaration, on one line and without its body.
#[derive(Debug)]
pub struct Signature {
    /// Attributes before it.
    pub attributes: String,
    /// The type that it is or belongs to, or the function.
    pub owner: String,
    /// Whether it, or what it belongs to, is `#[doc(hidden)]` or behind the feature `nalgebra`.
    pub hidden: bool,
    /// The declaration.
    pub text: String,
}

impl Signature {
    /// Whether a name of `foreign` stands in it, or a path into one of `libraries`.
    pub fn names_one_of(&self, foreign: &[String], libraries: &[String]) -> bool {
        let mut rest = self.text.as_str();
        while let Some(start) = rest.find(is_of_name) {
            rest = &rest[start..];
            let end = rest.find(|c| !is_of_name(c)).unwrap_or(rest.len());
            let (name, after) = rest.split_at(end);
            let is = |names: &[String]| names.iter().any(|other| other == name);
            if is(foreign) || is(libraries) && after.starts_with("::") {
                return true;
            }
            rest = after;
        }
        false
    }
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether attributes ask for matrices.
pub fn is_gate(attributes: &str) -> bool {
    attributes.contains("feature = \"nalgebra\"") && !attributes.contains("not(")
}

/// Whether attributes take something out of the documentation.
pub fn is_hidden(attributes: &str) -> bool {
    attributes.contains("doc(hidden)")
}

/// Names that a text takes from `libraries`.
pub fn imported(text: &str, libraries: &[String]) -> Vec<String> {
    let uses = parts(&plain(text), false).into_iter();
    let paths = uses.filter_map(|part| {
        let path = part.head.strip_prefix("use ")?.to_string();
        let first = path.split("::").next()?.to_string();
        libraries.contains(&first).then_some(path)
    });
    let names = paths.flat_map(|path| {
        let names = path.split(|c: char| !is_of_name(c)).map(str::to_string);
        // The library itself is looked for as the beginning of a path.
        names
            .skip(1)
            .filter(|name| !name.is_empty())
            .collect::<Vec<_>>()
    });
    names.collect()
}

/// Every public declaration of a text.
pub fn signatures(text: &str) -> Vec<Signature> {
    let mut found = Vec::new();
    for part in parts(&plain(text), false) {
        if !part.attributes.contains("cfg(test)") {
            declared(&part, &mut found);
        }
    }
    found
}

fn declared(part: &Part, found: &mut Vec<Signature>) {
    let hidden = is_hidden(&part.attributes) || is_gate(&part.attributes);
    let owner = owner(&part.head);
    let mut add = |attributes: &str, text: String| {
        found.push(Signature {
            attributes: attributes.to_string(),
            owner: owner.clone(),
            hidden: hidden || is_hidden(attributes) || is_gate(attributes),
            text,
        });
    };
    let item = part.head.strip_prefix("pub ");
    let of = |kind: &str| item.is_some_and(|item| item.starts_with(kind));
    let is_impl = part.head.starts_with("impl");
    if item.is_none() && !is_impl {
        return;
    }
    if of("mod ") {
        return;
    }
    let value = match of("const ") || of("static ") {
        true => part.head.split(" = ").next().unwrap_or_default(),
        false => &part.head,
    };
    add(&part.attributes, without_private(value));
    let inherent = is_impl && !part.head.contains(" for ");
    let is_public = |inner: &Part| match () {
        () if of("enum ") || of("trait ") => true,
        () => (of("struct ") || inherent) && inner.head.starts_with("pub "),
    };
    let with_commas = of("enum ") || of("struct ");
    for inner in parts(&part.body, with_commas)
        .iter()
        .filter(|p| is_public(p))
    {
        let body = match with_commas {
            true => format!("{} {}", inner.head, inner.body),
            false => inner.head.clone(),
        };
        add(
            &inner.attributes,
            body.split_whitespace().collect::<Vec<_>>().join(" "),
        );
    }
}

/// The type or function that a declaration is about.
fn owner(head: &str) -> String {
    let after = match head.strip_prefix("impl") {
        Some(rest) => {
            let rest = match rest.strip_prefix('<') {
                Some(_) => &rest[closing(rest)..],
                None => rest,
            };
            rest.rsplit_once(" for ").map_or(rest, |(_, of)| of)
        }
        None => {
            let kinds = [
                "fn ", "struct ", "enum ", "trait ", "const ", "static ", "type ",
            ];
            let found = kinds.iter().find_map(|kind| head.split_once(kind));
            found.map_or(head, |(_, rest)| rest)
        }
    };
    let path = after.trim_start();
    let end = path.find(|c: char| !is_of_name(c) && c != ':');
    let path = &path[..end.unwrap_or(path.len())];
    let path = path.trim_end_matches(':');
    path.rsplit("::").next().unwrap_or_default().to_string()
}

/// Where the angle bracket that `text` begins with is closed.
fn closing(text: &str) -> usize {
    let mut depth = 0;
    let close = text.char_indices().find(|&(at, c)| {
        depth += match c {
            '<' => 1,
            '>' if !text[..at].ends_with('-') => -1,
            _ => 0,
        };
        depth == 0
    });
    close.map_or(text.len(), |(at, _)| at + 1)
}

/// A declaration without those fields of a tuple that others cannot name.
fn without_private(head: &str) -> String {
    let Some((name, fields)) = head
        .strip_prefix("pub struct ")
        .and_then(|rest| rest.split_once('('))
    else {
        return head.to_string();
    };
    let fields = parts(
        fields.rsplit_once(')').map_or(fields, |(inside, _)| inside),
        true,
    );
    let public = fields.iter().filter(|field| field.head.starts_with("pub "));
    let public: Vec<&str> = public.map(|field| field.head.as_str()).collect();
    format!("pub struct {name}({})", public.join(", "))
}

/// A piece of a text between two of the same depth.
struct Part {
    attributes: String,
    /// On one line.
    head: String,
    /// Between braces.
    body: String,
}

/// Items of a text; with `commas`, fields or variants.
fn parts(text: &str, commas: bool) -> Vec<Part> {
    let (mut found, mut rest) = (Vec::new(), text);
    let mut attributes = String::new();
    loop {
        rest = rest.trim_start();
        if rest.is_empty() {
            return found;
        }
        if rest.starts_with('#') {
            let open = rest.find('[').unwrap_or(0);
            let end = open + matching(&rest[open..]);
            attributes += &rest[..end];
            rest = &rest[end..];
            continue;
        }
        let (mut at, mut depth) = (0, 0_i32);
        let passes_on = rest.starts_with("use ") || rest.starts_with("pub use ");
        let end = loop {
            let Some(c) = rest[at..].chars().next() else {
                break None;
            };
            match c {
                '(' | '[' => depth += 1,
                ')' | ']' => depth -= 1,
                ';' if depth == 0 => break Some(c),
                '{' if depth == 0 && !passes_on => break Some(c),
                // In the angle brackets of a type commas separate no fields.
                '<' if commas => depth += 1,
                '>' if commas && !rest[..at].ends_with(['-', '=']) => depth -= 1,
                ',' if depth == 0 && commas => break Some(c),
                _ => {}
            }
            at += c.len_utf8();
        };
        let head = rest[..at].split_whitespace().collect::<Vec<_>>().join(" ");
        let mut body = "";
        rest = match end {
            Some('{') => {
                let end = at + matching(&rest[at..]);
                body = &rest[at + 1..(end - 1).max(at + 1)];
                &rest[end..]
            }
            Some(_) => &rest[at + 1..],
            None => "",
        };
        if !head.is_empty() || !body.is_empty() {
            found.push(Part {
                attributes: std::mem::take(&mut attributes),
                head,
                body: body.to_string(),
            });
        }
    }
}

/// Behind the bracket that closes the one that `text` begins with.
fn matching(text: &str) -> usize {
    let mut depth = 0;
    let close = text.char_indices().find(|&(_, c)| {
        depth += match c {
            '(' | '[' | '{' => 1,
            ')' | ']' | '}' => -1,
            _ => 0,
        };
        depth == 0
    });
    close.map_or(text.len(), |(at, _)| at + 1)
}

/// A text without comments, and without what brackets and separators its texts hold.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let raw = rest.strip_prefix('r').map(|r| r.trim_start_matches('#'));
        let begins_word = !out.ends_with(is_of_name);
        let (kept, length) = if rest.starts_with("//") {
            ("", rest.find('\n').unwrap_or(rest.len()))
        } else if begins_word && raw.is_some_and(|r| r.starts_with('"')) {
            let hashes = rest.len() - 1 - raw.unwrap_or_default().len();
            let end = format!("\"{}", "#".repeat(hashes));
            let inside = hashes + 2;
            let found = rest[inside..].find(&end);
            (
                "\"\"",
                found.map_or(rest.len(), |at| inside + at + end.len()),
            )
        } else if c == '"' {
            let end = text_end(rest);
            let inside = rest[..end].replace(['{', '}', '(', ')', '[', ']', ';', ','], " ");
            out += &inside;
            ("", end)
        } else if let Some(length) = character(rest) {
            ("' '", length)
        } else {
            (&rest[..c.len_utf8()], c.len_utf8())
        };
        out += kept;
        rest = &rest[length..];
    }
    out
}

/// Behind the quote that ends the text that `rest` begins with.
fn text_end(rest: &str) -> usize {
    let mut escaped = false;
    let close = rest.char_indices().skip(1).find(|&(_, c)| {
        let ends = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        ends
    });
    close.map_or(rest.len(), |(at, _)| at + 1)
}

/// The length of the character literal that `rest` begins with; a lifetime is none.
fn character(rest: &str) -> Option<usize> {
    let inside = rest.strip_prefix('\'')?;
    match inside.strip_prefix('\\') {
        Some(escaped) => {
            let first = escaped.chars().next()?.len_utf8();
            Some(2 + first + escaped[first..].find('\'')? + 1)
        }
        None => {
            let first = inside.chars().next()?.len_utf8();
            inside[first..].starts_with('\'').then_some(first + 2)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foreign(text: &str) -> Vec<String> {
        let libraries = ["nalgebra", "roxmltree"].map(str::to_string);
        let names = imported(text, &libraries);
        let found = signatures(text).into_iter();
        found
            .filter(|item| !item.hidden && item.names_one_of(&names, &libraries))
            .map(|item| item.owner)
            .collect()
    }

    #[test]
    fn a_type_behind_the_first_comma_of_a_call_is_seen() {
        let text = "use nalgebra::{DMatrix, Vector2};
            impl Feet { pub fn step(
                &self,
                q: &mut [f64],
                miss: Vector2<f64>,
            ) -> f64 { 0.0 } }";
        assert_eq!(foreign(text), ["Feet"]);
        let answer = "use nalgebra::DVector;\npub fn rows(a: f64,\n b: f64) -> DVector<f64> {}";
        assert_eq!(foreign(answer), ["rows"]);
    }

    #[test]
    fn types_in_variants_fields_and_implementations_are_seen() {
        let variant = "use nalgebra::Vector3;
            pub enum Twist { Sparse(f64), Reflection { u: Vector3<f64>, k: f64 } }";
        assert_eq!(foreign(variant), ["Twist"]);
        let tuple = "pub enum Error { #[error(\"not {0}, {{\")] Xml(#[from] roxmltree::Error) }";
        assert_eq!(foreign(tuple), ["Error"]);
        let field = "use nalgebra::Point3;\npub struct Link { pub a: f64, pub com: Point3<f64> }";
        assert_eq!(foreign(field), ["Link"]);
        let from = "impl From<roxmltree::Error> for Error { fn from() {} }";
        assert_eq!(foreign(from), ["Error"]);
    }

    #[test]
    fn what_others_cannot_name_or_the_documentation_hides_is_not() {
        let text = "use nalgebra::DMatrix;
            pub struct Axis(pub(crate) DMatrix<f64>, pub f64);
            pub struct Frame { pub(crate) axes: DMatrix<f64>, own: DMatrix<f64> }
            impl Frame { fn own(&self) -> DMatrix<f64> { \"}\"; '}' } }
            #[doc(hidden)] pub fn rows() -> DMatrix<f64> {}
            impl Rows { #[cfg(feature = \"nalgebra\")] pub fn all(&self) -> DMatrix<f64> {} }
            pub(crate) enum Inner { All(DMatrix<f64>) }
            pub fn body() -> f64 { let x: DMatrix<f64> = r#\"\"{\"#; }
            pub fn lifetime<'a>(x: &'a str) -> &'a str { x }";
        assert_eq!(foreign(text), [""; 0]);
    }

    #[test]
    fn what_is_passed_on_is_declared() {
        let text = "pub use a::{\n    Frame, Twist,\n};\n#[doc(hidden)]\npub use b::Rows;";
        let found = signatures(text);
        assert_eq!(found[0].text, "pub use a::{ Frame, Twist, }");
        assert!(!found[0].hidden && found[1].hidden);
    }
}
