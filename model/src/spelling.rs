//! The nearest spelling of a name that does not exist.

use strsim::osa_distance;

/// Names longer than this are not compared.
const LONGEST: usize = 64;

/// The nearest of `names` to the name `wrong`; letter case and the kind of separator are free,
/// and a forgotten prefix is found. Among equals the one wins that starts like `owner`, whose
/// reference it is, and then the first.
///
/// ```
/// use sesc_model::spelling::nearest;
///
/// let joints = ["l_knee", "r_knee"];
/// assert_eq!(nearest("R-Kne", "", joints), Some("r_knee"));
/// assert_eq!(nearest("camera", "", joints), None);
/// ```
pub fn nearest<'a>(
    wrong: &str,
    owner: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let (wrong, letters) = folded(wrong);
    if letters == 0 || letters > LONGEST {
        return None;
    }
    // Few letters may differ, or everything would be close.
    let most = match letters {
        0..=2 => 0,
        length => (length / 4).clamp(1, 3),
    };
    names
        .into_iter()
        .filter_map(|name| {
            let (candidate, length) = folded(name);
            let misspelt = length <= LONGEST && length.abs_diff(letters) <= most;
            let distance = match misspelt.then(|| osa_distance(&wrong, &candidate)) {
                Some(distance) if distance <= most => distance,
                // A forgotten prefix: `index` for `left_index`.
                _ if letters >= 3 && candidate.ends_with(&wrong) => most + 1,
                _ => return None,
            };
            Some((distance, std::cmp::Reverse(common(name, owner)), name))
        })
        .min_by_key(|(distance, common, _)| (*distance, *common))
        .map(|(_, _, name)| name)
}

/// A name without letter case and kinds of separators, and its length in letters.
fn folded(name: &str) -> (String, usize) {
    let letters = name.trim().chars().take(LONGEST + 1);
    let fold = |c: char| match c {
        '-' | '.' | ' ' | '/' => '_',
        _ => c.to_lowercase().next().unwrap_or(c),
    };
    let folded: String = letters.map(fold).collect();
    let length = folded.chars().count();
    (folded, length)
}

/// How many letters two names start with together.
fn common(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_spellings_are_found_and_distant_ones_are_not() {
        let names = ["base_link", "l_elbow", "r_elbow", "x"];
        let near = |wrong| nearest(wrong, "", names);
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
        let near = |owner| nearest("index", owner, names);
        assert_eq!(near("right_tip"), Some("right_index"));
        assert_eq!(near("left_tip"), Some("left_index"));
    }
}
