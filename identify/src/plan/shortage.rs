//! Why there are not enough candidates, with the numbers and what would help.

use super::candidates::Counts;
use super::request::Request;
use super::scene::Scene;
use crate::{Message, Setting, message};

/// What became of the draws, and which demand to relax.
pub(super) fn sentence(scene: &Scene, request: &Request, counts: &Counts) -> Message {
    let tree = &scene.model.tree;
    let Counts {
        drawn,
        balanced,
        clear,
        collision_free,
        ..
    } = counts;
    let support = &tree.links[tree.support].name;
    let numbers = format!(
        "of {drawn} postures drawn, {balanced} balance on `{support}`, {clear} of them keep clear of \
         the ground, {collision_free} of these of themselves; {} are wanted",
        request.poses
    );
    let remedy = if *balanced < request.poses.max(drawn / 1000) {
        let miss = match counts.nearest_miss {
            Some(miss) if miss.is_finite() && *balanced == 0 => {
                format!(", the best one misses by {:.1} mm", 1e3 * miss)
            }
            _ => String::new(),
        };
        let strict = format!(
            "the CoP must stay within {}, by {} standard deviations ({:.1} mm each on average){miss}",
            request.region.sentence(),
            request.sigmas,
            1e3 * counts.cop_std,
        );
        let enough = wide_enough(request, counts).map_or_else(String::new, |half| {
            format!(" ({half} lets a tenth of them balance, where the foot is so large)")
        });
        message![
            strict,
            ": give a larger ",
            Setting::CopBox,
            enough,
            " or the ",
            Setting::Sole,
            ", a ",
            Setting::Prior,
            " that knows more, or ",
            Setting::Limits,
            " that suit the support",
            request.robot.feet_note()
        ]
    } else if *clear < request.poses.max(balanced / 1000) {
        let worst = (0..counts.low.len())
            .max_by_key(|&link| counts.low[link])
            .unwrap_or(0);
        let low = format!(
            "asked is {}; most often `{}` is too low: give a smaller ",
            scene.clearance.sentence(),
            tree.links[worst].name
        );
        message![
            low,
            Setting::Clearance,
            ", narrower ",
            Setting::Limits,
            ", or a support whose z = 0 is its sole"
        ]
    } else if *collision_free < *clear {
        message!["give narrower ", Setting::Limits, ", or ask for fewer"]
    } else {
        message![
            "ask for fewer ",
            Setting::Poses,
            ", or allow more with ",
            Setting::Candidates
        ]
    };
    remedy.after(&format!("{numbers}\n  "))
}

/// Half the side of a square that lets a tenth of the draws balance, whole cm in m; none where
/// some balance, or where both feet carry.
fn wide_enough(request: &Request, counts: &Counts) -> Option<f64> {
    let mut misses = counts.misses.clone();
    misses.retain(|miss| miss.is_finite());
    if counts.balanced > 0 || misses.is_empty() {
        return None;
    }
    misses.sort_by(f64::total_cmp);
    let miss = misses[misses.len() / 10];
    let ends = request.region.bounds();
    let half = ends.iter().flat_map(|(low, high)| [low.abs(), high.abs()]);
    let half = half.fold(0.0, f64::max) + miss;
    Some((1e2 * half).ceil() / 1e2)
}
