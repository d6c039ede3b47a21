//! Generated C as text.

/// C `source` without the functions whose names hold one of `words`.
pub fn without(source: &str, words: &[&str]) -> String {
    let mut kept = String::new();
    let mut inside = false;
    for line in source.lines() {
        let starts = line.starts_with("void ") && words.iter().any(|word| line.contains(word));
        inside |= starts;
        if !inside {
            kept.push_str(line);
            kept.push('\n');
        }
        inside &= line != "}";
    }
    kept
}
