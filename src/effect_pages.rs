//! The page of one effect: what it is, and what it does on the OP2.
//!
//! What imitates an effect, and in which postures the two differ, is computed from its slopes
//! ([`sesc_identify::diagnose::footprint`]) in balanced postures of the embedded robot. The
//! command line prints the text, `cargo regen` writes it with its figures to `docs/effects/`.

mod pictures;

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::sync::Arc;

use sesc_identify::diagnose::footprint::{Feature, Footprint, Footprints, Quantity, Telling};
use sesc_identify::fit::prior::{Prior, PriorChoice};
use sesc_identify::logs::LogSource;
use sesc_identify::plan::Geometry;
use sesc_identify::plan::Scene;
use sesc_identify::plan::balance::Region;
use sesc_identify::plan::limits::Limits;
use sesc_identify::plan::sample;
use sesc_identify::robot::Robot;
use sesc_identify::simulate;
use sesc_model::effects::about::{EffectAbout, TargetKind, about};
use sesc_model::effects::{Catalog, Unit};
use sesc_model::{Model, Snapping};

use crate::report::figures;
use crate::{Error, OP2_URDF};

pub use pictures::Picture;

/// Postures that effects are compared in.
const POSTURES: usize = 400;
/// Joints lie within so much of zero, degrees.
const RANGE_DEG: f64 = 60.0;
/// |CoP| on each axis, m: as in the seed paper's stable postures.
const BOX_M: f64 = 0.023;
/// Noise of a posture's CoP, m: the mean of 100 readings of the seed paper's sensor.
const NOISE_M: f64 = 0.0005;
/// Cells of the OP2's foot, m, frame of its sole.
const CELLS: [[f64; 2]; 4] = [
    [0.041, 0.025],
    [0.041, -0.025],
    [-0.041, -0.025],
    [-0.041, 0.025],
];
const SEED: u64 = 1;
/// A motion lasts so many seconds, has so many rows each, and joints go so far, degrees.
const SECONDS: usize = 20;
const HERTZ: usize = 20;
const SWING_DEG: f64 = 20.0;
/// Targets in the table, and imitators of each.
const TARGETS: usize = 8;
const IMITATORS: usize = 3;
/// What sets telling postures apart: at most so many quantities, at least so clearly.
const FEATURES: usize = 3;
const CLEAR: f64 = 0.5;
/// More postures than anybody takes.
const COUNTLESS: f64 = 1e6;
/// An imitator that takes less is not mentioned.
const FAINT: f64 = 0.3;

/// The OP2 in the postures that all pages are about.
pub struct Bench {
    model: Arc<Model>,
    q: Vec<f64>,
    motion: LogSource,
}

/// Everything about one effect.
pub struct EffectPage {
    /// Name, parameters, and the page that its author wrote.
    pub about: EffectAbout,
    /// What it does at each joint, link or cell of the OP2.
    pub footprints: Vec<Footprint>,
    /// How the first of them differs from its first imitator.
    pub telling: Option<Telling>,
    /// They are of a robot that moves.
    pub is_moving: bool,
    joints: Vec<String>,
}

impl Bench {
    /// Draw the postures.
    ///
    /// # Errors
    /// Where the robot cannot be read.
    pub fn new() -> Result<Bench, Error> {
        let robot = Robot::parse(OP2_URDF, "op2.urdf")?;
        let model = Arc::new(robot.model("r_sole", Snapping::default(), None)?);
        let mut limits = Limits::of_urdf(&model.tree.dofs);
        let range = RANGE_DEG.to_radians();
        for (low, high) in &mut limits.ranges {
            (*low, *high) = (low.max(-range), high.min(range));
        }
        let region = Region::square(BOX_M, 0.0)?;
        let geometry = Geometry::read(&robot.description, None);
        let scene = Scene::new(&model, &geometry, &limits, &region, 0.005, None);
        let (q, _) = sample(&scene, SEED, POSTURES, 100 * POSTURES, |_| {
            ControlFlow::Continue(())
        });
        let mut motion = simulate::Request::new(Arc::clone(&model), SECONDS * HERTZ);
        motion.rate = Some(HERTZ as f64);
        motion.range = Some(SWING_DEG.to_radians());
        motion.seed = SEED;
        let motion = simulate::simulate(&motion, &mut ())?;
        Ok(Bench { model, q, motion })
    }

    /// The pages of these effects; of all where none is named.
    ///
    /// # Errors
    /// Where a prior is none, which ours is.
    pub fn pages(&self, wanted: Option<&str>) -> Result<Vec<EffectPage>, Error> {
        let prior = PriorChoice::from(Prior::OF_DIAGNOSES);
        let all = Footprints::new(&self.model, &self.q, &CELLS, NOISE_M, &prior)?;
        let moving = Footprints::moving(&self.model, &self.motion, NOISE_M, &prior)?;
        let effects = about(&Catalog::standard()).into_iter();
        let effects = effects.filter(|effect| wanted.is_none_or(|name| effect.name == name));
        Ok(effects
            .map(|about| self.page(about, &all, &moving))
            .collect())
    }

    /// In postures at rest, or in the motion where these do not show it.
    fn page(&self, about: EffectAbout, at_rest: &Footprints, moving: &Footprints) -> EffectPage {
        let mut footprints = at_rest.of(about.name);
        let is_moving = footprints.is_empty();
        let all = if is_moving { moving } else { at_rest };
        if is_moving {
            footprints = all.of(about.name);
        }
        let first = footprints.first();
        let telling = first.and_then(|first| {
            let by = first.imitators.first()?;
            all.telling(first, &by.label)
        });
        let dofs = self.model.tree.dofs.iter();
        EffectPage {
            joints: dofs.map(|dof| dof.joint.clone()).collect(),
            about,
            footprints,
            telling,
            is_moving,
        }
    }
}

impl EffectPage {
    /// The text, as Markdown that reads well as it stands.
    pub fn text(&self) -> String {
        let about = &self.about;
        let parameters: Vec<String> = about
            .parameters
            .iter()
            .map(|p| match p.unit {
                "1" => p.name.to_string(),
                unit => format!("{} ({unit})", p.name),
            })
            .collect();
        let parameters = match parameters.is_empty() {
            true => "none".to_string(),
            false => parameters.join(", "),
        };
        let mut out = format!(
            "{}\nActs on: {}. Parameters: {parameters}.\n\n",
            about.page,
            acts_on(about)
        );
        match self.footprints.first() {
            Some(first) => self.on_the_op2(first, &mut out),
            None => out.push_str("Postures at rest do not show it.\n"),
        }
        out
    }

    fn on_the_op2(&self, first: &Footprint, out: &mut String) {
        let where_ = match self.is_moving {
            false => format!(
                "in {POSTURES} balanced postures (joints within ±{RANGE_DEG:.0}°, CoP within \
                 ±{:.0} mm)",
                1e3 * BOX_M
            ),
            true => format!(
                "moving for {SECONDS} s (two sines of 0.05 to 0.25 Hz a joint, within \
                 ±{SWING_DEG:.0}°), read {HERTZ} times a second"
            ),
        };
        let _ = writeln!(out, "On the OP2, {where_}{}:\n", size(first));
        let several = self.footprints.len() > 1;
        let rows = self.footprints.iter().take(TARGETS);
        let rows = rows.map(|footprint| row(footprint, several));
        out.push_str(&aligned(
            [
                "at",
                "moves the CoP",
                "masses take: `tight`, `cad`",
                "imitated by",
            ],
            &rows.collect::<Vec<_>>(),
        ));
        let more = self.footprints.len().saturating_sub(TARGETS);
        if more > 0 {
            let _ = writeln!(out, "\n{more} more move it by less.");
        }
        let (Some(telling), Some(by)) = (&self.telling, first.imitators.first()) else {
            return;
        };
        if by.share < FAINT {
            let _ = writeln!(
                out,
                "\nNothing imitates {}:\n{}, the most alike, takes {} of what masses leave of it.\n{}",
                first.phrase,
                by.phrase,
                percent(by.share),
                told_apart(telling, self.rows())
            );
            return;
        }
        let _ = writeln!(
            out,
            "\nThe best imitator of {} is {}:\nit takes {} of what masses within `{}` leave.\n{}",
            first.phrase,
            by.phrase,
            percent(by.share),
            Prior::OF_DIAGNOSES,
            told_apart(telling, self.rows())
        );
        if telling.postures >= COUNTLESS {
            return;
        }
        let features = telling
            .features
            .iter()
            .filter(|f| (f.among - f.all).abs() > CLEAR * f.spread && f.spread > 0.0);
        let features: Vec<String> = features
            .take(FEATURES)
            .map(|feature| self.feature(feature))
            .collect();
        let _ = write!(
            out,
            "{} of the difference stands in a tenth of the {}",
            percent(telling.share_of_tenth),
            self.rows()
        );
        let _ = match features.is_empty() {
            true => writeln!(out, ", which nothing else sets apart."),
            false => writeln!(out, ":\n{}.", features.join(",\n")),
        };
    }

    /// What the readings are of, one each.
    fn rows(&self) -> &'static str {
        match self.is_moving {
            true => "rows",
            false => "postures",
        }
    }

    /// `the CoM is 176 mm high there, 201 ± 8 mm in all`
    fn feature(&self, feature: &Feature) -> String {
        let axis = |axis: usize| ["x", "y"][axis];
        let (what, angle) = match feature.what {
            Quantity::ComHeight => ("the height of the CoM".to_string(), false),
            Quantity::Cop(k) => (format!("CoP {}", axis(k)), false),
            Quantity::CopOut(k) => {
                let text = format!("the CoP's distance from the middle along {}", axis(k));
                (text, false)
            }
            Quantity::Joint(j) => (self.joints[j].clone(), true),
            Quantity::JointSpeed(j) => (format!("the speed of {}", self.joints[j]), true),
            _ => (String::new(), false),
        };
        let unit = if angle { 1_f64.to_degrees() } else { 1e3 };
        // Whole numbers, and no negative zero.
        let whole = |x: f64| (unit * x).round() + 0.0;
        let [among, all, spread] = [feature.among, feature.all, feature.spread].map(whole);
        let each = match feature.what {
            Quantity::JointSpeed(_) => "°/s",
            _ => "°",
        };
        match angle {
            true => format!("{what} is {among}{each} there, {all}{each} ± {spread}{each} in all"),
            false => format!("{what} is {among} mm there, {all} ± {spread} mm in all"),
        }
    }

    /// The page for a book, beside its figures.
    pub fn markdown(&self) -> String {
        let name = self.about.name;
        let mut out = format!("# {name}\n\n{}", self.text());
        if let (Some(first), Some(_)) = (self.footprints.first(), &self.telling) {
            let by = &first.imitators[0].phrase;
            let _ = write!(
                out,
                "\n![Arrows from the CoP to the CoP with {0}, seen from above]({name}.svg)\n\
                 ![Arrows from where {by} and masses put the CoP to the CoP with {0}]\
                 ({name}-left.svg)\n",
                first.phrase
            );
        }
        out
    }

    /// What it does to the CoP and what its best imitator leaves of that, as SVG.
    pub fn figures(&self) -> Option<[String; 2]> {
        let (first, telling) = (self.footprints.first()?, self.telling.as_ref()?);
        Some(figures::effect(first, telling, BOX_M))
    }
}

/// What an effect acts on, as its page and the list of all have it.
pub fn acts_on(about: &EffectAbout) -> String {
    match &about.target {
        TargetKind::Whole => "the robot".to_string(),
        target => target.to_string(),
    }
}

fn told_apart(telling: &Telling, rows: &str) -> String {
    let noise = format!(
        "read to {} mm, tell them apart (five standard deviations).",
        1e3 * NOISE_M
    );
    match telling.postures.ceil() {
        n if n < 10.0 => format!("Fewer than ten {rows} like these, {noise}"),
        n if n < COUNTLESS => format!("About {} {rows} like these, {noise}", round(n)),
        _ => format!("No number of {rows} like these tells them apart."),
    }
}

/// `, at an ordinary size: offset 1.1°`
fn size(footprint: &Footprint) -> String {
    let sizes = footprint.size.iter().map(|value| {
        let (factor, unit) = Unit::of(value.name).shown();
        let x = factor * value.value;
        let digits = (1.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
        let space = if unit == "°" || unit.is_empty() {
            ""
        } else {
            " "
        };
        let stem = Unit::stem(value.name);
        format!("{stem} {x:.digits$}{space}{unit}")
    });
    let sizes: Vec<String> = sizes.collect();
    match sizes.is_empty() {
        true => String::new(),
        false => format!(",\nat an ordinary size ({})", sizes.join(", ")),
    }
}

/// Two digits.
fn round(n: f64) -> f64 {
    let unit = 10_f64.powf((n.log10().floor() - 1.0).max(0.0));
    (n / unit).ceil() * unit
}

fn row(footprint: &Footprint, several: bool) -> [String; 4] {
    // The best of each kind.
    let mut kinds: Vec<&str> = Vec::new();
    let mut imitators = Vec::new();
    for other in footprint
        .imitators
        .iter()
        .filter(|other| other.share >= FAINT)
    {
        let kind = other.label.split(':').next().unwrap_or_default();
        if !kinds.contains(&kind) {
            kinds.push(kind);
            imitators.push(format!("{} {}", other.label, percent(other.share)));
        }
    }
    imitators.truncate(IMITATORS);
    let at = match footprint.label.split_once(':') {
        Some((_, target)) => target,
        // Ways without a name.
        None if several => &footprint.phrase,
        None => "the robot",
    };
    [
        at.to_string(),
        format!("{:.2} mm", 1e3 * footprint.moves_m),
        format!(
            "{}, {}",
            percent(footprint.taken_by_masses),
            percent(footprint.taken_by_free_masses)
        ),
        match imitators.is_empty() {
            true => "nothing".to_string(),
            false => imitators.join(", "),
        },
    ]
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        x if x < 99.0 => format!("{x:.0} %"),
        x if x < 99.9 => format!("{x:.1} %"),
        _ => "over 99.9 %".to_string(),
    }
}

/// A table of Markdown whose columns are aligned.
fn aligned(headers: [&str; 4], rows: &[[String; 4]]) -> String {
    let width = |k: usize| {
        let cells = rows.iter().map(|row| row[k].chars().count());
        cells.chain([headers[k].chars().count()]).max().unwrap_or(0)
    };
    let widths = [0, 1, 2, 3].map(width);
    let line = |cells: [&str; 4]| {
        let cells = cells.iter().zip(widths);
        let cells =
            cells.map(|(cell, w)| format!(" {cell}{} |", " ".repeat(w - cell.chars().count())));
        format!("|{}\n", cells.collect::<String>())
    };
    let rules = widths.map(|w| "-".repeat(w));
    let mut out = line(headers) + &line([0, 1, 2, 3].map(|k| rules[k].as_str()));
    rows.iter()
        .for_each(|row| out += &line([0, 1, 2, 3].map(|k| row[k].as_str())));
    out
}
