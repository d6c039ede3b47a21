//! A new effect is one file and one line in a catalog: these come from outside.

use sesc_model::effects::{
    Carry, Catalog, Effect, EffectContext, EffectId, Experiment, Measured, Parameter, Stage,
    Target, UrdfEdit,
};
use sesc_model::expr::Id;
use sesc_model::urdf::Shift;

use super::{Bench, SKEW, request, says, table};
use crate::diagnose::hypothesis::{Term, carried, effect_terms};
use crate::diagnose::problem::{Block, Problem};
use crate::diagnose::{Report, diagnose};
use crate::fit::prior::Prior;
use crate::observations::postures::Postures;

/// `φ_j = q_j + k (1 − cos 3 q_j)`: an eccentric gear wheel.
struct Eccentric;

impl Effect for Eccentric {
    fn id(&self) -> EffectId {
        EffectId::new("joint_eccentric")
    }

    fn stage(&self) -> Stage {
        Stage::Joints
    }

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        context.joints()
    }

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[Parameter::new("throw_rad", 0.02)];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("an eccentric gear wheel in {name}")
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let Target::Joint(joint) = *target else {
            return;
        };
        let three = at.constant(3.0);
        let angle = at.mul(three, at.joints[joint]);
        let cos = at.g().cos(angle);
        let one = at.constant(1.0);
        let rise = at.sub(one, cos);
        let moved = at.mul(unknowns[0], rise);
        at.shift_joint(joint, moved);
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        vec![(unknowns[0].abs() - 0.2).max(0.0) / 0.01]
    }

    fn load_share(&self, unknowns: &[f64], _: f64) -> f64 {
        2.0 * unknowns[0]
    }

    fn in_experiment(&self, experiment: Experiment, _: &Target) -> Carry {
        match experiment {
            Experiment::Turned => Carry::Scaled(vec![-1.0]),
            Experiment::Untouched => Carry::Gone,
            _ => Carry::Same,
        }
    }

    fn urdf_edit(&self, target: &str, value: &dyn Fn(&str) -> f64) -> Option<UrdfEdit> {
        Some(UrdfEdit::Joint(Shift {
            joint: target.to_string(),
            by: value("throw_rad"),
        }))
    }
}

/// The same kind of thing with a dead band in it.
struct Loose;

impl Effect for Loose {
    fn id(&self) -> EffectId {
        EffectId::new("joint_loose")
    }

    fn stage(&self) -> Stage {
        Stage::Bends
    }

    fn targets(&self, _: &EffectContext) -> Vec<Target> {
        vec![Target::AllJoints]
    }

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[Parameter::new("width_rad", 0.02)];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("something loose in {name}")
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        for joint in target.revolute(at.robot()) {
            at.slack(joint, unknowns[0]);
        }
    }

    fn dead_band(&self) -> Option<f64> {
        Some(0.015)
    }
}

fn effects() -> Catalog {
    Catalog::standard().with(&Eccentric).with(&Loose)
}

const THROW: f64 = 0.06;

/// The report on the skewed robot whose knee has an eccentric gear wheel.
fn report(effects: Catalog) -> Report {
    let bench = Bench::skew();
    let q = bench.postures(80, 3);
    let knee = bench.joint("knee");
    let mut bent = q.clone();
    for at in (knee..q.len()).step_by(2) {
        bent[at] += THROW * (1.0 - (3.0 * q[at]).cos());
    }
    let mut request = request(table(&q, &bench.log(&bench.world(), &bent, 5)));
    request.effects = effects;
    diagnose(&request, &mut ()).unwrap()
}

#[test]
fn an_effect_from_outside_is_found_said_and_written() {
    let found = report(effects());
    let said = &found.diagnosis;
    // A curve of the same joint's angle may do as well.
    let places = said.indistinguishable.iter().flatten();
    assert!(
        places.into_iter().all(|label| label.ends_with(":knee")),
        "{}",
        said.sentence
    );
    let step = &said.steps[0];
    assert_eq!((step.effect, &*step.target), ("joint_eccentric", "knee"));
    let throw = &step.parameters["throw_rad"];
    assert!((throw.value - THROW).abs() < 4.0 * throw.std, "{throw:?}");
    says(&said.sentence, &["an eccentric gear wheel in knee"]);
    let record = &found.model_file.effects[0];
    assert_eq!(record.effect, "joint_eccentric");
    // The URDF holds what the effect says that it can hold.
    let corrected = found.corrected_urdf.unwrap();
    assert!(corrected.left_out.is_empty(), "{:?}", corrected.left_out);
    assert_ne!(corrected.text, SKEW);
    // Without it in the catalog it is a form without that name.
    let without = report(Catalog::standard()).diagnosis;
    let step = &without.steps[0];
    assert_eq!((&*step.site, &*step.target), ("joint", "knee"));
    let [form, named] = [without.last.rmse, said.last.rmse];
    assert!(form < 1.02 * named, "{form} {named}");
}

#[test]
fn its_bounds_load_dead_band_and_experiments_are_those_it_states() {
    let bench = Bench::skew();
    let data = bench.log(&bench.world(), &bench.postures(30, 3), 5);
    let prior = Prior::named("tight", &bench.model).unwrap();
    let of = |data: Postures, effects: &Catalog| {
        let block = Block::new(&bench.model, data, None, effects);
        Problem::new(vec![block], &prior)
    };
    let plain = of(data.clone(), &Catalog::standard());
    let problem = of(data, &effects());
    let of = |name: &str, target: &str| {
        let mut terms = effect_terms(&problem.first().context).into_iter();
        let wanted =
            |t: &Term| t.name() == name && t.target_name(&problem.first().context) == target;
        terms.find(wanted).unwrap()
    };
    let eccentric = [of("joint_eccentric", "knee")];
    // The penalty counts its unknown, and two kinds more to choose from.
    let offset = [of("joint_offset", "knee")];
    let own = problem.penalty(&eccentric);
    assert!((own - problem.penalty(&offset)).abs() < 1e-12);
    assert!(own > plain.penalty(&offset));
    // A fit stays near its bound, and says that it was touched.
    let violation = eccentric[0].bound_violation(&problem.first().context, &[0.21]);
    assert!((violation[0] - 1.0).abs() < 1e-9);
    let fit = problem.fit_from(&eccentric, vec![0.05]);
    assert!(fit.unknowns[0].abs() < 0.2);
    let effect = eccentric[0].effect().unwrap().effect;
    assert_eq!(effect.load_share(&[0.25], 1.0), 0.5);
    // Experiments scale it, or leave it out.
    let context = &problem.first().context;
    let within = |experiment| carried(Some(experiment), (context, context), (&eccentric, &[0.1]));
    assert_eq!(within(Experiment::Turned).columns, [(0, -1.0)]);
    assert!(within(Experiment::Untouched).terms.is_empty());
    // Only the loose one has sides to choose.
    let loose = [of("joint_loose", "all")];
    assert!(problem.first().slack_joints(&eccentric).is_empty());
    assert_eq!(problem.first().slack_joints(&loose), [(0, 0), (1, 0)]);
    assert!(problem.fit(&loose, None).blocks[0].sides.is_some());
}
