//! Text that an XML reader takes: what robot tools write beside strict XML is left out.

/// Without comments, instructions, declarations and namespaces: a prefix is a part of the name.
pub(crate) fn mend(text: &str) -> String {
    let hidden = [("<!--", "-->"), ("<?", "?>"), ("<![", "]]>"), ("<!", ">")];
    let mut rest = text.trim_start_matches('\u{feff}').trim_end_matches('\0');
    let mut out = String::with_capacity(rest.len());
    while let Some(start) = rest.find('<') {
        out.push_str(&rest[..start]);
        rest = &rest[start..];
        if let Some((open, close)) = hidden.iter().find(|(open, _)| rest.starts_with(open)) {
            let end = rest[open.len()..].find(close);
            rest = end.map_or("", |at| &rest[open.len() + at + close.len()..]);
            continue;
        }
        let mut quote = None;
        let end = rest.char_indices().find(|&(at, c)| {
            let masked = c == ':' || rest[at..].starts_with("xmlns");
            out.push(if quote.is_none() && masked { '_' } else { c });
            let ends = quote.is_none() && c == '>';
            match quote {
                None => quote = Some(c).filter(|c| matches!(c, '"' | '\'')),
                Some(_) => quote = quote.filter(|open| *open != c),
            }
            ends
        });
        rest = end.map_or("", |(at, _)| &rest[at + 1..]);
    }
    out + rest
}
