//! Readings of another frame than the log says.
//!
//! ```text
//! p_link(q) ≈ y        or        (R CoM(q))_xy ≈ y,  R e_z ≠ ± e_z by right angles
//! ```

use nalgebra::Matrix3;

use super::criteria::{BETTER, FAR_M, FEET, FITS};
use super::statistics::gap;
use super::wirings::Wirings;
use super::{Finding, Kind, Look};
use crate::evaluate::Evaluator;
use crate::robot::Robot;
use sesc_model::tree::{like_sole, sole_parts};
use sesc_model::{Function, Model};

/// Another link, or other axes of this one, that the readings fit.
pub(super) fn wrong(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let here = gap(look.data, look.predicted.iter().copied());
    if here < FAR_M {
        return None;
    }
    let foot = other_foot(look);
    let frame = turned(look);
    let (turned, axes) = (frame.left, frame.flat);
    let tree = &look.model.tree;
    let support = &tree.links[tree.support].name;
    let better = |there: f64| wirings.left([0, 1]) < BETTER * there;
    match foot {
        Some(foot) if foot.left < FITS * here && foot.left <= turned => {
            let known = better(wirings.left_on(&foot.model));
            (!known).then(|| {
                let link = &foot.link;
                let sentence = format!(
                    "The readings are {:.0} mm off on `{support}` and {:.1} mm on `{link}`: the \
                     robot stood on `{link}`; give that support.",
                    1e3 * here,
                    1e3 * foot.left
                );
                let marks = [&*format!("on {link}"), &*format!("on {support}")];
                let picture = look.distances(&foot.cop, marks);
                Finding::new(Kind::OtherFoot, link, sentence).showing(picture)
            })
        }
        _ if turned < FITS * here => {
            let known = better(wirings.left(axes));
            (!known).then(|| {
                let (axis, down) = frame.up;
                let sentence = format!(
                    "The readings are {:.0} mm off in the frame of `{support}` and {:.1} mm where \
                     its {axis} axis points {}: its z axis is not the normal of the sole; \
                     give a sole link as support.",
                    1e3 * here,
                    1e3 * turned,
                    if down { "down" } else { "up" }
                );
                let marks = ["with another axis up", "in this frame"];
                let picture = look.distances(&frame.cop, marks);
                Finding::new(Kind::FrameTurned, support, sentence).showing(picture)
            })
        }
        _ => None,
    }
}

/// Another link that the readings may be of.
struct Foot {
    /// Gap to the readings, m.
    left: f64,
    link: String,
    model: Model,
    /// CoP by CAD on it, m.
    cop: Vec<f64>,
}

/// Another frame of the support that the readings may be in.
struct Frame {
    /// Gap to the readings, m.
    left: f64,
    /// Axes that lie in the sole.
    flat: [usize; 2],
    /// The axis of the support that points up, and whether it points down instead.
    up: (&'static str, bool),
    /// CoP by CAD in it, m.
    cop: Vec<f64>,
}

/// Another link that carries no joint, which the readings fit best.
fn other_foot(look: &Look) -> Option<Foot> {
    let tree = &look.model.tree;
    let support = &tree.links[tree.support].name;
    let leaves = leaf_links(look.robot)
        .into_iter()
        .map(|link| match tree.by_height {
            true => like_sole(support, &link),
            false => link,
        })
        .filter(|link| link != support);
    let on = |link: String| {
        let model = look.robot.model(&link, look.snapping, None).ok()?;
        let cop = Evaluator::new(&model, Function::Cop).run(&look.data.q, look.data.len());
        let left = gap(look.data, cop.iter().copied());
        Some(Foot {
            left,
            link,
            model,
            cop,
        })
    };
    let feet = leaves.take(FEET).filter_map(on);
    feet.min_by(|a, b| a.left.total_cmp(&b.left))
}

/// Links that carry no joint: feet, hands, the head.
fn leaf_links(robot: &Robot) -> Vec<String> {
    let description = &robot.description;
    let carries = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
    let links = description.links.iter().map(|link| link.name.clone());
    links.filter(|link| !carries(link)).collect()
}

/// The frame, turned by right angles, that the readings fit best.
fn turned(look: &Look) -> Frame {
    // The sole of a link is moved along the link's z: another axis points up from the link itself.
    let height = match sole_parts(look.model.support()) {
        Some(Ok((_, height))) if look.model.tree.by_height => height,
        _ => 0.0,
    };
    let frames = axes_with_another_up().into_iter().map(|(axes, flat)| {
        let row = |c: &[f64], k: usize| -> f64 {
            let at = [c[0], c[1], c[2] - height];
            (0..3).map(|m| axes[(k, m)] * at[m]).sum()
        };
        let up = (0..3).find(|m| axes[(2, *m)] != 0.0).unwrap_or(2);
        let up = (["x", "y", "z"][up], axes[(2, up)] < 0.0);
        let com = look.com.chunks_exact(3);
        let cop: Vec<f64> = com.flat_map(|c| [row(c, 0), row(c, 1)]).collect();
        let left = gap(look.data, cop.iter().copied());
        Frame {
            left,
            flat,
            up,
            cop,
        }
    });
    let nothing = Frame {
        left: f64::INFINITY,
        flat: [0, 1],
        up: ("z", false),
        cop: Vec::new(),
    };
    frames.fold(nothing, |best, own| match own.left < best.left {
        true => own,
        false => best,
    })
}

/// Rotations by right angles after which another axis than z is vertical, and the axes that
/// lie in the plane then.
fn axes_with_another_up() -> Vec<(Matrix3<f64>, [usize; 2])> {
    let mut found = Vec::new();
    for (x, y, z) in [(0, 2, 1), (1, 2, 0), (2, 0, 1), (2, 1, 0)] {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let mut axes = Matrix3::zeros();
            axes[(0, x)] = sign(0);
            axes[(1, y)] = sign(1);
            axes[(2, z)] = sign(2);
            if axes.determinant() > 0.0 {
                found.push((axes, [x, y]));
            }
        }
    }
    found
}
