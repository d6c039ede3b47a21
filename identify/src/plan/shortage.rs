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
            "the CoP must stay within {} by {} standard deviations ({:.1} mm each on average){miss}",
            request.region.sentence(),
            request.sigmas,
            1e3 * counts.cop_std,
        );
        message![
            strict,
            ": give a larger ",
            Setting::CopBox,
            " or the ",
            Setting::Sole,
            ", a ",
            Setting::Prior,
            " that knows more, or ",
            Setting::Limits,
            " that suit the support"
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
