//! The robot on top of a page: its pictures, what is marked on them, and the postures that a
//! script may show it in.

use minijinja::{Value, context};
use serde_json::{Value as Json, json};

use super::figures::robot::{Marks, Pictured};
use sesc_identify::diagnose::view::chosen;
use sesc_identify::skeleton::Skeleton;
use sesc_model::chain::Body;
use sesc_model::effects::about::{TargetKind, about};
use sesc_model::effects::{Catalog, Target};
use sesc_model::text::visible_lines;
use sesc_model::tree::Motion;

/// Bytes of the data of a page: with its script they stay below 150 kB.
const DATA_BYTES: usize = 128_000;
/// Postures without which a slider is none; of a robot so large that fewer fit, the page has
/// pictures alone.
const FEWEST: usize = 3;
/// Bytes of one that is left out, `null,`.
const NULL: usize = 5;
/// The rotation of what is not turned, row by row.
const UNTURNED: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
/// CoPs of a picture that stay apart.
const MOST: usize = 400;

/// A posture that the robot may be shown in.
#[derive(Debug, Clone, Default)]
pub struct Shown {
    /// Its number, as people call it.
    pub pose: i64,
    /// rad or m
    pub q: Vec<f64>,
    /// CoP that was read, m.
    pub measured: Option<[f64; 2]>,
    /// CoP before and after the correction, m.
    pub predicted: Option<[[f64; 2]; 2]>,
    /// CoP that is expected, m.
    pub planned: Option<[f64; 2]>,
    /// Its row, as people call it, where that is not its place among those of the slider.
    pub row: Option<String>,
    /// What else is said of it, a phrase each.
    pub said: Vec<String>,
    /// It is rather an outlier.
    pub outlier: bool,
}

/// What changes between before and after.
#[derive(Debug, Clone, Default)]
pub(super) struct Correction {
    /// Coefficients of χ² over the part of the correction, and how much noise leaves.
    pub chi2: Option<([f64; 3], f64)>,
    /// Name, value and unit of what was found.
    pub found: Vec<(String, f64, &'static str)>,
    /// What the models before and after are called.
    pub names: [&'static str; 2],
}

/// What is marked on a robot, and what is said of it.
#[derive(Default)]
pub(super) struct Marked {
    pub marks: Marks,
    pub said: Vec<String>,
}

impl Marked {
    /// Mark what an `effect` acts on, joints where it is none; whether the robot has it.
    pub(super) fn mark(&mut self, skeleton: &Skeleton, effect: &str, target: &str) -> bool {
        let effects = about(&Catalog::standard());
        let named = effects.iter().find(|known| known.name == effect);
        let of_link = named.is_some_and(|effect| effect.target == TargetKind::Link);
        let marks = &mut self.marks;
        let mut any = false;
        for target in target.split(',') {
            if target == Target::ALL_JOINTS {
                any |= !std::mem::replace(&mut marks.every_joint, true);
            } else if of_link && skeleton.body_of(target).is_some() {
                any = true;
                marks.links.push(target.to_string());
            } else if let Some(body) = skeleton.carried_by(target) {
                any = true;
                let named = (body, target.to_string());
                // Of two things said of a joint its name is written once.
                if !marks.joints.contains(&named) {
                    marks.joints.push(named);
                }
            }
        }
        any
    }

    /// Mark it and say `what` it is.
    pub(super) fn point(&mut self, skeleton: &Skeleton, effect: &str, target: &str, what: &str) {
        if self.mark(skeleton, effect, target) {
            self.say(target, what);
        }
    }

    /// Say what is the matter with a target that is marked.
    pub(super) fn say(&mut self, target: &str, what: &str) {
        self.said.push(match target {
            Target::ALL_JOINTS => format!("every joint ({what})"),
            target => format!("`{}` ({what})", target.replace(',', "`, `")),
        });
    }

    /// All that is said of it in a sentence, or that there is nothing.
    pub(super) fn sentence(&self, nothing: &str) -> String {
        match self.said.is_empty() {
            true => nothing.to_string(),
            false => format!("Orange: {}.", self.said.join("; ")),
        }
    }
}

/// The robot of a page.
pub(super) struct Card<'a> {
    pub skeleton: &'a Skeleton,
    /// Where there are none the robot stands still, with all joints at zero.
    pub postures: Vec<Shown>,
    /// Postures of other figures, which the slider leaves out: numbered after the others.
    pub apart: Vec<Shown>,
    /// The figure beside the robot.
    pub beside: Option<String>,
    /// In a sentence, what is marked.
    pub caption: String,
    pub marks: Marks,
    pub correction: Correction,
}

impl<'a> Card<'a> {
    /// The robot in one of `postures`, or with all joints at zero where there are none, with what
    /// is said of the marks on it.
    pub(super) fn standing(
        skeleton: &'a Skeleton,
        marked: Marked,
        nothing: &str,
        postures: Vec<Shown>,
    ) -> Card<'a> {
        let at = match postures.is_empty() {
            true => "all joints at zero",
            false => "the joints as they were read",
        };
        let said = marked.sentence(nothing);
        let caption =
            format!("{said} Quartered disc: centre of mass by CAD, with its plumb line; {at}.");
        let marks = marked.marks;
        Card {
            marks,
            ..Card::new(skeleton, postures, caption)
        }
    }

    /// The robot with nothing marked on it.
    pub(super) fn new(skeleton: &'a Skeleton, postures: Vec<Shown>, caption: String) -> Card<'a> {
        Card {
            skeleton,
            postures,
            apart: Vec::new(),
            beside: None,
            caption,
            marks: Marks::default(),
            correction: Correction::default(),
        }
    }

    /// What `robot.html` takes.
    pub(super) fn context(self) -> Value {
        let cop = self.postures.iter();
        let cop = cop.filter_map(|p| p.measured.or(p.planned));
        let cop: Vec<[f64; 2]> = cop.collect();
        let cop = chosen(cop.len(), MOST).into_iter().map(|k| cop[k]);
        let shown = most_upright(&self.postures);
        let each = || self.postures.iter().chain(&self.apart);
        let views = Pictured {
            skeleton: self.skeleton,
            postures: match each().next().is_none() {
                true => vec![&[]],
                false => each().map(|p| p.q.as_slice()).collect(),
            },
            shown,
            cop: cop.collect(),
            marks: self.marks,
        }
        .views();
        let mut data = json!({
            "bodies": bodies(self.skeleton),
            // Body and ends of each, m.
            "capsules": self.skeleton.capsules.iter()
                .map(|own| json!([own.body, all(&own.ends[0], 5), all(&own.ends[1], 5)]))
                .collect::<Vec<Json>>(),
            // Name of each independent one, and whether it is prismatic.
            "joints": self.skeleton.dofs.iter()
                .map(|dof| json!([dof.joint, u8::from(dof.prismatic)]))
                .collect::<Vec<Json>>(),
            "slider": self.postures.len(),
            "shown": shown,
            "names": self.correction.names,
            "chi2": self.correction.chi2.map(|(c, expected)| {
                [c[0], c[1], c[2], expected].map(|x| rounded(x, 2))
            }),
            "found": self.correction.found.iter()
                .map(|(name, value, unit)| json!([name, rounded(*value, 6), unit]))
                .collect::<Vec<Json>>(),
        });
        let left = DATA_BYTES.saturating_sub(data.to_string().len());
        let kept = within(each().map(posture).collect(), shown, left);
        let wanted = self.postures.len();
        let on_slider = kept[..wanted].iter();
        let on_slider = on_slider.filter(|posture| !posture.is_null()).count();
        let left_out = left_out(on_slider, wanted, self.skeleton.dofs.len());
        let left_out = left_out.map(|sentence| format!(" {sentence}"));
        match kept.is_empty() || is_large(on_slider, wanted) {
            true => data = json!({"postures": []}),
            false => data["postures"] = Json::from(kept),
        }
        context! {
            views => views.map(Value::from_safe_string).to_vec(),
            beside => self.beside.map(Value::from_safe_string),
            caption => self.caption + &left_out.unwrap_or_default(),
            data => Value::from_safe_string(inline_json(&data)),
        }
    }
}

/// Postures whose text is no longer than `most` bytes: every second, third, … of more, and the
/// one that is `shown`; the others are null, so that each keeps its number.
fn within(postures: Vec<Json>, shown: usize, most: usize) -> Vec<Json> {
    let lengths: Vec<usize> = postures.iter().map(|own| own.to_string().len()).collect();
    let kept = |k: usize, step: usize| k.is_multiple_of(step) || k == shown;
    let length = |step: usize| {
        let own = lengths.iter().enumerate();
        let own = own.map(|(k, length)| if kept(k, step) { length + 1 } else { NULL });
        own.sum::<usize>()
    };
    let steps = 1..=postures.len().max(1);
    let step = steps.clone().find(|step| length(*step) <= most);
    let step = step.unwrap_or(*steps.end());
    let own = postures.into_iter().enumerate();
    own.map(|(k, posture)| if kept(k, step) { posture } else { Json::Null })
        .collect()
}

/// Whether so few postures fit that the page does without moving the robot.
fn is_large(kept: usize, wanted: usize) -> bool {
    kept < wanted.min(FEWEST)
}

/// What is said where a page has not all postures of its robot.
fn left_out(kept: usize, wanted: usize, joints: usize) -> Option<String> {
    match is_large(kept, wanted) {
        true => Some(format!(
            "The robot stands still: what moves one of {joints} joints would make the page too \
             large."
        )),
        false if kept < wanted => Some(format!(
            "The slider and pointing at dots show {kept} of the {wanted} postures: all of them \
             would make the page too large."
        )),
        false => None,
    }
}

/// The posture whose joints are nearest to zero.
fn most_upright(postures: &[Shown]) -> usize {
    let size = |shown: &Shown| shown.q.iter().map(|q| q * q).sum::<f64>();
    let sizes = postures.iter().map(size).enumerate();
    let least = sizes.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map_or(0, |(k, _)| k)
}

/// Rounded to `digits` digits after the decimal point; null where it is no number.
fn rounded(value: f64, digits: i32) -> Json {
    let scale = 10_f64.powi(digits);
    // Adding zero takes the sign from a negative zero.
    json!((value * scale).round() / scale + 0.0)
}

fn all<'v>(values: impl IntoIterator<Item = &'v f64>, digits: i32) -> Vec<Json> {
    values.into_iter().map(|x| rounded(*x, digits)).collect()
}

/// Parent, kind (0 fixed, 1 revolute, 2 prismatic), rotation, anchor, axis, joint, factor, offset,
/// mass and CoM of each body; what lengths are is m. Left out are no parent, no rotation, a factor
/// of one, and the rest where it is zero.
fn bodies(skeleton: &Skeleton) -> Vec<Json> {
    let of = |(body, com): (&Body, &[f64; 3])| {
        let (kind, axis, by) = match body.motion {
            Motion::Fixed => (0, [0.0; 3], None),
            Motion::Revolute { axis, by } => (1, axis.into(), Some(by)),
            Motion::Prismatic { axis, by } => (2, axis.into(), Some(by)),
        };
        let by = by.map_or((0, 1.0, 0.0), |by| (by.dof, by.factor, by.offset));
        let numbers = |values: &[f64], digits: i32| json!(all(values, digits));
        let rotation: Vec<f64> = body.rotation().concat();
        let zero = || json!([0.0, 0.0, 0.0]);
        let fields = [
            ("parent", json!(body.parent), Json::Null),
            ("kind", json!(kind), json!(0)),
            ("rotation", numbers(&rotation, 9), numbers(&UNTURNED, 9)),
            ("anchor", numbers(&body.anchor(), 7), zero()),
            ("axis", numbers(&axis, 9), zero()),
            ("joint", json!(by.0), json!(0)),
            ("factor", json!(by.1), json!(1.0)),
            ("offset", json!(by.2), json!(0.0)),
            ("mass", rounded(body.mass, 7), json!(0.0)),
            ("com", numbers(com, 7), zero()),
        ];
        let said = fields
            .into_iter()
            .filter(|(_, value, usual)| value != usual);
        let said = said.map(|(name, value, _)| (name.to_string(), value));
        said.collect()
    };
    skeleton.bodies.iter().zip(&skeleton.coms).map(of).collect()
}

fn posture(shown: &Shown) -> Json {
    let place = |at: &[f64; 2]| json!(all(at, 6));
    let predicted = |both: &[[f64; 2]; 2]| json!(both.each_ref().map(place));
    let fields = [
        ("pose", Some(json!(shown.pose))),
        ("q", Some(json!(all(&shown.q, 4)))),
        ("measured", shown.measured.as_ref().map(place)),
        ("predicted", shown.predicted.as_ref().map(predicted)),
        ("outlier", shown.outlier.then(|| json!(1))),
        ("planned", shown.planned.as_ref().map(place)),
        ("row", shown.row.as_ref().map(|row| json!(row))),
        ("said", (!shown.said.is_empty()).then(|| json!(shown.said))),
    ];
    let known = fields.into_iter();
    let known = known.filter_map(|(name, value)| Some((name.to_string(), value?)));
    known.collect()
}

/// The same with what is hidden in names spelled out, since the script shows them.
fn spelled_out(value: &Json) -> Json {
    match value {
        Json::String(text) => json!(visible_lines(text)),
        Json::Array(values) => values.iter().map(spelled_out).collect(),
        Json::Object(fields) => {
            let field = |(name, value): (&String, &Json)| (name.clone(), spelled_out(value));
            fields.iter().map(field).collect()
        }
        other => other.clone(),
    }
}

/// JSON as the text of a script element: nothing in it ends the element or is markup.
fn inline_json(value: &Json) -> String {
    let escaped = |c: char| match c {
        '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => format!("\\u{:04x}", u32::from(c)),
        c => c.to_string(),
    };
    let text = spelled_out(value).to_string();
    text.chars().map(escaped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::says;

    /// A page of a long log or of many joints: what its script reads stays small, every posture
    /// keeps its number, and the one that is shown is there.
    #[test]
    fn data_of_many_postures_stay_small() {
        let of = |joints: usize, count: usize| -> Vec<Json> {
            let shown = |k: usize| Shown {
                pose: k as i64,
                q: (0..joints)
                    .map(|j| -0.123_45 - 1e-3 * (k + j) as f64)
                    .collect(),
                measured: Some([0.012_345, -0.012_345]),
                predicted: Some([[0.012_345, -0.012_345]; 2]),
                ..Shown::default()
            };
            (0..count).map(|k| posture(&shown(k))).collect()
        };
        for (joints, count) in [(20, 400), (20, 2000), (38, 400), (38, 5000), (400, 5000)] {
            let kept = within(of(joints, count), 1, DATA_BYTES);
            assert_eq!(kept.len(), count);
            assert_eq!((&kept[0]["pose"], &kept[1]["pose"]), (&json!(0), &json!(1)));
            let text = json!(kept).to_string();
            assert!(text.len() <= DATA_BYTES + 2, "{joints}: {}", text.len());
        }
        let few = of(20, 100);
        assert_eq!(within(few.clone(), 0, DATA_BYTES), few);
    }

    #[test]
    fn what_does_not_fit_on_a_page_is_said() {
        assert_eq!(left_out(100, 100, 20), None);
        assert_eq!(left_out(0, 0, 20), None);
        assert_eq!(left_out(2, 2, 20), None);
        let some = left_out(15, 60, 450).unwrap();
        says(&some, &["15 of the 60 postures"]);
        let none = left_out(1, 60, 2000).unwrap();
        says(&none, &["stands still", "2000 joints"]);
    }

    #[test]
    fn data_in_a_script_end_no_script() {
        let hostile = json!({"hip": ["</script><!--&", "a\u{202e}b\u{1b}\u{2028}\n"]});
        let text = inline_json(&hostile);
        assert!(!text.contains(['<', '>', '&', '\u{202e}', '\u{2028}']));
        assert_eq!(
            serde_json::from_str::<Json>(&text).unwrap(),
            json!({"hip": ["</script><!--&", "a\\u{202e}b\\u{1b}\\u{2028}\n"]})
        );
    }
}
