//! Corrected descriptions and physical fits, judged by the reference and by hand.

use std::path::Path;

use nalgebra::DVector;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_model::standard::PER_LINK;
use sesc_model::{Model, Snapping};

use super::corrected::{Corrected, correct};
use super::gather::Gathered;
use super::masses::{FLOOR, Limits};
use super::prior::Prior;
use super::{Identification, Settings, identify};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::Block;
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::simulate::Simulator;
use crate::tests::says;

fn robot(name: &str) -> Robot {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    Robot::read(&root.join(format!("robots/{name}/{name}.urdf"))).unwrap()
}

fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    Normal::new(0.0, 1.0).unwrap().sample(rng)
}

/// A robot as built: masses ± 10 %, CoMs ± 5 mm, drawn.
fn truth(model: &Model, rng: &mut ChaCha8Rng) -> DVector<f64> {
    let cad = model.standard_cad();
    let mut theta = cad.clone();
    for link in 0..theta.len() / PER_LINK {
        let heavier = 1.0 + 0.1 * gauss(rng);
        for k in 0..PER_LINK {
            theta[PER_LINK * link + k] *= heavier;
        }
        for k in 1..PER_LINK {
            theta[PER_LINK * link + k] += cad[PER_LINK * link] * 0.005 * gauss(rng);
        }
    }
    let total: f64 = theta.iter().step_by(PER_LINK).sum();
    theta / total
}

struct Case {
    robot: Robot,
    support: &'static str,
    gathered: Gathered,
    supports: Vec<String>,
}

impl Case {
    /// Readings on one support after the other, of one drawn robot.
    fn new(name: &str, supports: &[&'static str], noise: f64, postures: usize) -> Case {
        Case::of(robot(name), supports, noise, postures)
    }

    fn of(robot: Robot, supports: &[&'static str], noise: f64, postures: usize) -> Case {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let first = robot.model(supports[0], Snapping::Off, None).unwrap();
        let theta = truth(&first, &mut rng);
        let mut measurement = Measurement::new(&robot, supports[0], Snapping::Off).unwrap();
        let mut gathered = Gathered::new(first.base.params.len(), 10);
        for (index, support) in supports.iter().enumerate() {
            let model = robot.model(support, Snapping::Off, None).unwrap();
            let params = model.standard_map() * &theta;
            let range = Some(0.5);
            let q = Simulator::new(&model.tree.dofs, range, 3 + index as u64).batch(postures);
            let function = sesc_model::Function::Cop;
            let cop = Evaluator::with_params(&model, function, params.as_slice().to_vec());
            let reading = cop.run(&q, postures);
            let mut noisy = |x: f64| x + noise * gauss(&mut rng);
            let reading = reading.chunks(2).map(|cop| [noisy(cop[0]), noisy(cop[1])]);
            let block = Block {
                line: vec![1; postures],
                pose: (0..postures as i64).collect(),
                support: Some(vec![(*support).into(); postures]),
                reading: Some(reading.collect()),
                q,
                ..Block::default()
            };
            let pushed = gathered.push(&mut measurement, &block, "log.csv", None);
            pushed.unwrap();
        }
        Case {
            support: supports[0],
            supports: supports.iter().map(ToString::to_string).collect(),
            robot,
            gathered,
        }
    }

    fn model(&self) -> Model {
        self.robot.model(self.support, Snapping::Off, None).unwrap()
    }

    fn fit(&self, prior: &str, limits: Option<&Limits>) -> Identification {
        let model = self.model();
        let settings = Settings::new(Prior::named(prior, &model).unwrap());
        let limits = limits.cloned();
        let settings = Settings { limits, ..settings };
        identify(&model, &self.supports, &self.gathered, &settings)
    }

    /// Whether the CoM of a corrected link is inside its shape, but for `slack` (m).
    fn holds(&self, limits: &Limits, corrected: &Corrected, link: &str, slack: f64) -> bool {
        let mut changes = corrected.links.iter();
        let com = changes.find(|change| change.link == link).unwrap().com[1];
        let tree = self.model().robot.tree;
        let index = tree.links.iter().position(|own| own.name == link);
        limits.extent(index.unwrap()).unwrap().0.holds(com, slack)
    }

    fn correct(&self, found: &Identification, prior: &str) -> Result<Corrected, Error> {
        let model = self.model();
        let prior = Prior::named(prior, &model).unwrap();
        let params = values(found);
        let target = (params.as_slice(), found.masses.as_ref());
        correct(&self.robot, &model, Snapping::Off, target, &prior, None)
    }
}

fn values(found: &Identification) -> DVector<f64> {
    let values = found.parameters.iter().map(|p| p.value);
    DVector::from_iterator(found.parameters.len(), values)
}

/// The text with everything a correction may change made the same.
fn frozen(text: &str) -> String {
    let mut out = String::new();
    for (k, part) in text.split("<inertial>").enumerate() {
        let Some((inside, after)) = part.split_once("</inertial>").filter(|_| k > 0) else {
            out += part;
            continue;
        };
        let words = inside.split(' ');
        let same = |word: &str| match word.contains(|c: char| c.is_ascii_digit()) {
            true => "#".to_string(),
            false => word.to_string(),
        };
        out += &words.map(same).collect::<Vec<_>>().join(" ");
        out += after;
    }
    out
}

/// The corrected text has the identified parameters on every support, the
/// reference agrees with their prediction, and nothing else changed.
fn holds(case: &Case, found: &Identification, corrected: &Corrected) {
    let text = &corrected.text;
    let params = values(found);
    let again = Robot::parse(text, "corrected.urdf").unwrap();
    let model = case.model();
    for support in &case.supports {
        let other = case.robot.model(support, Snapping::Off, None).unwrap();
        let shift = other.params_from(&model);
        let params = &shift.matrix * &params + &shift.offset;
        let read = again.model(support, Snapping::Off, None).unwrap();
        let off = (DVector::from_vec(read.cad_params()) - &params).amax();
        assert!(off < 1e-12, "{support}: {off:e}");
        let reference = crate::robot::reference(&again, support);
        let function = sesc_model::Function::Com;
        let com = Evaluator::with_params(&other, function, params.as_slice().to_vec());
        let mut simulator = Simulator::new(&other.tree.dofs, None, 5);
        for q in (0..50).map(|_| simulator.posture()) {
            let predicted = com.run(&q, 1);
            for (axis, x) in reference.com(&q).iter().enumerate() {
                assert!((predicted[axis] - x).abs() < 1e-9, "{support} {axis}");
            }
        }
        assert!((read.tree.mass - model.tree.mass).abs() < 1e-12 * model.tree.mass);
    }
    assert_eq!(frozen(text), frozen(case.robot.text()));
    assert!(!corrected.links.is_empty());
}

#[test]
fn a_corrected_robot_has_the_identified_parameters() {
    for (name, supports) in [
        ("op2", ["r_sole", "l_sole"]),
        ("op2", ["l_sole", "r_sole"]),
        ("lift_base", ["base_link", "front_left_wheel"]),
        ("skew_humanoid", ["right_sole", "left_sole"]),
    ] {
        let case = Case::new(name, &supports, 5e-4, 100);
        let found = case.fit("cad", None);
        let corrected = case.correct(&found, "cad").unwrap();
        holds(&case, &found, &corrected);
        assert!(corrected.active_bounds.is_empty(), "{name}");
        let twice = case.robot.model(supports[0], Snapping::Off, None).unwrap();
        assert!((corrected.total_mass - twice.tree.mass).abs() < 1e-12);
    }
}

/// What data do not tell stays: parameters of CAD give back the file itself.
#[test]
fn without_a_change_nothing_is_written() {
    let case = Case::new("op2", &["r_sole"], 0.0, 60);
    let mut found = case.fit("cad", None);
    for parameter in &mut found.parameters {
        parameter.value = parameter.cad;
    }
    let corrected = case.correct(&found, "cad").unwrap();
    assert_eq!(corrected.text, case.robot.text());
    assert!(corrected.links.is_empty());
}

#[test]
fn negative_masses_are_refused_by_name_and_physical_ones_found() {
    let case = Case::new("op2", &["r_sole", "l_sole"], 0.02, 40);
    let found = case.fit("free", None);
    let refusal = case.correct(&found, "free").err().unwrap();
    let words = ["negative", "kg", "physical", "Nothing was written", "`"];
    says(refusal, &words);
    let limits = Limits::of(&case.robot).unwrap();
    let physical = case.fit("free", Some(&limits));
    let bounds = physical.active_bounds.as_ref().unwrap();
    assert!(!bounds.is_empty());
    let masses = physical.masses.as_ref().unwrap();
    let cad = case.model().standard_cad();
    for (share, cad) in masses.theta.iter().zip(&cad).step_by(PER_LINK) {
        assert!(*share >= FLOOR * cad - 1e-12);
    }
    let sum: f64 = masses.theta.iter().step_by(PER_LINK).sum();
    assert!((sum - 1.0).abs() < 1e-12);
    let corrected = case.correct(&physical, "free").unwrap();
    holds(&case, &physical, &corrected);
    for change in &corrected.links {
        let is_inside = case.holds(&limits, &corrected, &change.link, 1e-9);
        assert!(is_inside, "{change:?}");
    }
    // Bounds cost something where data alone would go further.
    assert!(physical.in_sample_rmse > found.in_sample_rmse);
    assert!(physical.held_out_rmse.is_finite());
}

#[test]
fn bounds_that_are_not_felt_change_nothing() {
    for prior in ["cad", "tight", "free"] {
        let case = Case::new("op2", &["r_sole", "l_sole"], 1e-6, 200);
        let plain = case.fit(prior, None);
        let limits = Limits::of(&case.robot).unwrap();
        let physical = case.fit(prior, Some(&limits));
        assert_eq!(physical.active_bounds.as_deref(), Some(&[][..]), "{prior}");
        assert_eq!(values(&plain), values(&physical), "{prior}");
        assert!((plain.held_out_rmse - physical.held_out_rmse).abs() < 1e-15);
        holds(&case, &physical, &case.correct(&physical, prior).unwrap());
    }
}

/// A trunk whose shape ends right beside CAD's CoM: the CoM stays inside.
#[test]
fn a_centre_of_mass_stays_inside_the_collision_geometry() {
    let text = robot("op2").text().replacen(
        "<link name=\"body_link\">",
        "<link name=\"body_link\">\n    <collision><origin xyz=\"-0.0196631 -0.00311589 -0.0394437\"/>\
         <geometry><box size=\"0.0002 0.0002 0.0002\"/></geometry></collision>",
        1,
    );
    let robot = Robot::parse(&text, "op2.urdf").unwrap();
    let limits = Limits::of(&robot).unwrap();
    let case = Case::of(robot, &["r_sole", "l_sole"], 1e-4, 300);
    let plain = case.fit("cad", None);
    let found = case.fit("cad", Some(&limits));
    let bounds = found.active_bounds.as_ref().unwrap();
    says(bounds.join("\n"), &["CoM of `body_link`"]);
    let corrected = case.correct(&found, "cad").unwrap();
    holds(&case, &found, &corrected);
    assert!(case.holds(&limits, &corrected, "body_link", 1e-12));
    let free = case.correct(&plain, "cad").unwrap();
    assert!(!case.holds(&limits, &free, "body_link", 1e-4));
}
