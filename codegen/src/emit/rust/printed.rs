//! Tokens as the text of a file.
//!
//! `prettyplease` drops comments and breaks lines at 89 columns. Comments therefore travel
//! as markers, which are replaced afterwards, and what was broken for want of room is
//! joined where it fits into [`WIDTH`] columns.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::Error;
use crate::emit::header::printable;
use crate::error::Problem;

/// Longest line of code.
const WIDTH: usize = 100;

/// Texts that tokens cannot carry, by the number in their markers.
#[derive(Default)]
pub(super) struct Notes(Vec<Note>);

enum Note {
    /// A comment line of its own.
    Section(String),
    /// An array, one number a line, each with a comment.
    Numbers(Vec<(f64, String)>),
}

impl Notes {
    /// A statement that becomes the comment `title`.
    pub(super) fn section(&mut self, title: &str) -> TokenStream {
        let marker = self.push(Note::Section(printable(title)));
        quote! { #marker; }
    }

    /// An expression that becomes an array of these numbers, what each is beside it.
    pub(super) fn numbers<'a>(
        &mut self,
        numbers: impl Iterator<Item = (f64, &'a str)>,
    ) -> TokenStream {
        let numbers = numbers.map(|(x, name)| (x, printable(name))).collect();
        self.push(Note::Numbers(numbers))
    }

    fn push(&mut self, note: Note) -> TokenStream {
        let number = Literal::usize_unsuffixed(self.0.len());
        self.0.push(note);
        quote! { note!(#number) }
    }

    /// A line with a marker as the lines that it stands for.
    fn lines(&self, line: &str) -> Option<Vec<String>> {
        let (before, rest) = line.split_once("note!(")?;
        let (number, after) = rest.split_once(')')?;
        Some(match self.0.get(number.parse::<usize>().ok()?)? {
            Note::Section(title) => vec![format!("{before}// {title}")],
            Note::Numbers(numbers) => {
                let texts: Vec<String> = numbers.iter().map(|(x, _)| number_text(*x)).collect();
                let width = texts.iter().map(String::len).max().unwrap_or(0) + 1;
                let entry = |(text, (_, name)): (&String, &(f64, String))| {
                    format!("    {:<width$} // {name}", format!("{text},"))
                };
                let entries = texts.iter().zip(numbers).map(entry);
                let first = std::iter::once(format!("{before}["));
                first.chain(entries).chain([format!("]{after}")]).collect()
            }
        })
    }
}

/// A float that reads back to the same bits.
fn number_text(x: f64) -> String {
    match x.is_finite() {
        true => format!("{x:?}"),
        false if x > 0.0 => "f64::INFINITY".to_string(),
        false => "f64::NEG_INFINITY".to_string(),
    }
}

/// Items below a comment.
pub(super) fn file(items: TokenStream, about: &[String], notes: &Notes) -> Result<String, Error> {
    let file = syn::parse2(items).map_err(|error| Problem::Emitted {
        reason: error.to_string(),
    })?;
    let printed = prettyplease::unparse(&file);
    let mut text = String::with_capacity(printed.len() + 4096);
    for line in about {
        text.push_str(format!("// {line}").trim_end());
        text.push('\n');
    }
    text.push('\n');
    let printed: Vec<&str> = printed.lines().collect();
    let (mut k, mut previous) = (0, String::new());
    while k < printed.len() {
        let (line, next) = joined(&printed, k);
        if apart(&previous, &line) {
            text.push('\n');
        }
        for line in notes.lines(&line).unwrap_or_else(|| vec![line.clone()]) {
            text.push_str(&line);
            text.push('\n');
        }
        (k, previous) = (next, line);
    }
    Ok(text)
}

/// Whether an empty line belongs between these: the printer leaves no room between items.
fn apart(previous: &str, line: &str) -> bool {
    let attached = |line: &str| line.trim_start().starts_with("///") || line.starts_with("#[");
    let item = line.starts_with("pub ") || line.starts_with("impl") || attached(line);
    let method = line.starts_with("    #[inline");
    let names_crate = |line: &str| line.starts_with("use ");
    let macro_call = line.starts_with("sesc_runtime::");
    (item && !attached(previous))
        || (method && !previous.ends_with('{'))
        || (macro_call && names_crate(previous))
}

/// Line k, with the lines after it that belong to it if all fit into [`WIDTH`] columns, and
/// the number of the line after these.
fn joined(lines: &[&str], k: usize) -> (String, usize) {
    let mut text = lines[k].to_string();
    let mut open = brackets(lines[k]);
    let comment = |line: &str| line.trim_start().starts_with("//");
    let mut next = k + 1;
    while let Some(line) = lines.get(next) {
        let line = line.trim_start();
        if comment(&text) || (open <= 0 && !line.starts_with('.')) {
            break;
        }
        let closes = line.starts_with([')', ']']);
        if closes && text.ends_with(',') {
            text.pop();
        }
        if !closes && !line.starts_with('.') && !text.ends_with(['(', '[']) {
            text.push(' ');
        }
        text.push_str(line);
        open += brackets(line);
        next += 1;
        if comment(line) || text.chars().count() > WIDTH {
            return (lines[k].to_string(), k + 1);
        }
    }
    (text, next)
}

/// Brackets that a line opens, less those that it closes.
fn brackets(line: &str) -> isize {
    let weigh = |c| match c {
        '(' | '[' => 1,
        ')' | ']' => -1,
        _ => 0,
    };
    line.chars().map(weigh).sum()
}
