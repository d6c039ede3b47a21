//! Which public items of a file have no example.

/// Items without an example in `text`: functions, types, traits and constants, and the functions
/// and constants that a trait offers.
pub fn bare(text: &str) -> Vec<String> {
    const KINDS: [&str; 7] = [
        "fn ",
        "const fn ",
        "struct ",
        "enum ",
        "trait ",
        "const ",
        "type ",
    ];
    let mut found = Vec::new();
    // The documentation and attributes of the item to come.
    let (mut documented, mut hidden) = (false, false);
    let mut in_trait = false;
    for line in text.lines().take_while(|line| *line != "mod tests {") {
        let code = line.trim_start();
        if code.starts_with("///") || code.starts_with("#[") {
            documented |= code.starts_with("/// ```");
            hidden |= code == "#[doc(hidden)]";
            continue;
        }
        let offered = in_trait && line.strip_prefix("    ").is_some_and(|line| line == code);
        let of_trait = ["fn ", "const "].iter().any(|kind| code.starts_with(kind));
        let public = code.strip_prefix("pub ");
        let public = public.is_some_and(|item| KINDS.iter().any(|kind| item.starts_with(kind)));
        if (public || offered && of_trait) && !documented && !hidden {
            found.push(code.to_string());
        }
        in_trait = line.starts_with("pub trait ") || in_trait && line != "}";
        if !code.starts_with("//") {
            (documented, hidden) = (false, false);
        }
    }
    found
}

#[test]
fn an_item_without_an_example_is_found() {
    let text = "/// Sums.\npub fn a() {}\n/// ```\n/// ```\npub fn b() {}\n#[doc(hidden)]\n\
                pub fn c() {}\npub const D: usize = 1;\npub type E = f64;\n/// ```\n/// ```\n\
                pub trait F {\n    /// 0.\n    const G: f64;\n    fn h() {\n        fn i() {}\n    }\n\
                }\nfn j() {}\n";
    let expected = [
        "pub fn a() {}",
        "pub const D: usize = 1;",
        "pub type E = f64;",
        "const G: f64;",
        "fn h() {",
    ];
    assert_eq!(bare(text), expected);
}
