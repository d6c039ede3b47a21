//! The nearest spelling of a name that does not exist.

use super::report::shown;

/// Names longer than this are not compared.
const LONGEST: usize = 64;

/// Comparing every wrong name with every right one takes time; after this many
/// the rest go without a suggestion.
pub(super) const SUGGESTIONS: usize = 20;

/// `; did you mean `elbow`?`, or none when no name is close. Among equals
/// the one wins that starts like `owner`, whose reference it is.
pub(super) fn suggest<'a>(
    wrong: &str,
    owner: &str,
    names: impl Iterator<Item = &'a str>,
) -> Option<String> {
    nearest(wrong, owner, names).map(|name| format!("; did you mean {}?", shown(name)))
}

fn nearest<'a>(wrong: &str, owner: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let letters: Vec<char> = folded(wrong);
    if letters.is_empty() || letters.len() > LONGEST {
        return None;
    }
    // Few letters may differ, or everything would be close.
    let most = match letters.len() {
        0..=2 => 0,
        length => (length / 4).clamp(1, 3),
    };
    names
        .filter_map(|name| {
            let candidate = folded(name);
            let length = candidate.len();
            let misspelt = length <= LONGEST && length.abs_diff(letters.len()) <= most;
            let distance = match misspelt.then(|| distance(&letters, &candidate)) {
                Some(distance) if distance <= most => distance,
                // A forgotten prefix: `index` for `left_index`.
                _ if letters.len() >= 3 && candidate.ends_with(&letters) => most + 1,
                _ => return None,
            };
            Some((distance, std::cmp::Reverse(common(name, owner)), name))
        })
        .min_by_key(|(distance, common, _)| (*distance, *common))
        .map(|(_, _, name)| name)
}

/// Letter case and the kind of separator are free.
fn folded(name: &str) -> Vec<char> {
    let letters = name.trim().chars().take(LONGEST + 1);
    let fold = |c: char| match c {
        '-' | '.' | ' ' | '/' => '_',
        _ => c.to_lowercase().next().unwrap_or(c),
    };
    letters.map(fold).collect()
}

/// How many letters two names start with together.
fn common(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count()
}

/// Letters to insert, delete, replace or swap with their neighbour (optimal
/// string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut next = vec![i + 1];
        for (j, to) in b.iter().enumerate() {
            let replaced = row[j] + usize::from(from != to);
            let mut least = replaced.min(row[j + 1] + 1).min(next[j] + 1);
            if i > 0 && j > 0 && *from == b[j - 1] && a[i - 1] == *to {
                least = least.min(before[j - 1] + 1);
            }
            next.push(least);
        }
        before = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_spellings_are_found_and_distant_ones_are_not() {
        let names = ["base_link", "l_elbow", "r_elbow", "x"];
        let near = |wrong| nearest(wrong, "", names.into_iter());
        assert_eq!(near("base-link"), Some("base_link"));
        assert_eq!(near("Base_Lnik"), Some("base_link"));
        assert_eq!(near("r_elbo"), Some("r_elbow"));
        assert_eq!(near("l_eblow"), Some("l_elbow"));
        assert_eq!(near("L.Elbow"), Some("l_elbow"));
        assert_eq!(near("camera"), None);
        assert_eq!(near(""), None);
        assert_eq!(near("y"), None);
    }

    #[test]
    fn a_forgotten_prefix_is_taken_from_the_owner() {
        let names = ["left_index", "right_index", "right_tip"];
        let near = |owner| nearest("index", owner, names.into_iter());
        assert_eq!(near("right_tip"), Some("right_index"));
        assert_eq!(near("left_tip"), Some("left_index"));
    }
}
