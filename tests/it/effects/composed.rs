//! Effects that are made of a site and a formula, against a virtual robot that is told the same
//! function in Rust: the tape, model files, generated C and Rust.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc::verify::verify;
use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_model::effects::Site;
use sesc_model::expr::Expr;
use sesc_model::{EffectRecord, Function, Given, Model, ModelFile, Quantity};
use sesc_reference::{GRAVITY, World};
use sesc_test_support::child::Child;
use sesc_test_support::command::{Folder, fresh, says};
use sesc_test_support::recording::{Recording, normal};

use super::correction::with as with_effects;
use super::robots::{Stand, run, urdf};
use crate::c99::bits::{bounded, has_the_bits_of_rust};
use crate::c99::bounds::largest;
use crate::c99::case::{Case, SCALARS, servos};
use crate::c99::compiled::{Compiled, SEPARATE, WARNINGS, parallel, printed};
use crate::c99::draw::draw;
use crate::c99::fixed::trapping;

/// What rounding and joints that come to rest leave, m.
const EXACT: f64 = 4e-12;
/// What differences of fourth order leave, m/rad.
const SLOPE: f64 = 2e-8;
const STEP: f64 = 1e-4;
const POSTURES: usize = 12;

/// The record of an effect.
pub(crate) fn record(
    name: &str,
    target: &str,
    (site, function): (Site, &str),
    values: &[(&str, f64)],
) -> EffectRecord {
    let quantity = |value: f64| Quantity { value, std: None };
    let parameters = values.iter();
    let parameters = parameters.map(|(name, value)| (name.to_string(), quantity(*value)));
    EffectRecord {
        effect: name.to_string(),
        target: target.to_string(),
        site: Some(site),
        function: Some(function.to_string()),
        parameters: parameters.collect(),
        ..EffectRecord::default()
    }
}

/// The model with these effects, through the text of its file.
fn with(model: &Model, cells: &[[f64; 2]], records: Vec<EffectRecord>) -> Model {
    let mut file = ModelFile::from_values(model, &model.cad_params(), None, "data");
    file.cells = cells.to_vec();
    file.effects = records;
    let text = file.to_toml().unwrap();
    let read = ModelFile::parse(&text, "model.toml").unwrap();
    assert_eq!(read.to_toml().unwrap(), text);
    model.clone().with_file(read).unwrap()
}

/// What an effect does to the virtual robot.
type Bend = Box<dyn Fn(World, &dyn Fn(&str) -> usize) -> World>;

/// How far a joint errs by angles (rad) and moments (N m): its own, and those of another joint.
type Error = fn([f64; 2], [f64; 2]) -> f64;

/// An effect of a joint.
fn of_joint(
    [joint, other]: [&'static str; 2],
    function: &str,
    values: &[(&str, f64)],
    error: Error,
) -> (EffectRecord, Bend) {
    let bend = move |world: World, at: &dyn Fn(&str) -> usize| {
        let places = [at(joint), at(other)];
        let error =
            move |q: &[f64], tau: &[f64]| error(places.map(|k| q[k]), places.map(|k| tau[k]));
        world.joint_function(joint, error).unwrap()
    };
    let record = record("own", joint, (Site::Joint, function), values);
    (record, Box::new(bend))
}

/// Effects of the OP2 with what they do to it, in other words.
fn cases() -> Vec<(EffectRecord, Bend)> {
    let (knee, ankle) = (["r_knee"; 2], ["r_ank_pitch"; 2]);
    let a: [(&str, f64); 1] = [("a", 0.02)];
    let mut held = of_joint(knee, "a * sin(6 * q)", &a, |[q, _], _| {
        0.02 * (6.0 * q.clamp(-0.1, 0.15)).sin()
    });
    held.0.range = BTreeMap::from([("q".to_string(), [-0.1, 0.15])]);
    let wave = of_joint(knee, "a * sin(6.0 * q)", &a, |[q, _], _| {
        0.02 * (6.0 * q).sin()
    });
    let follow = "k * q[\"r_hip_roll\"]";
    let follow = of_joint(
        ["r_knee", "r_hip_roll"],
        follow,
        &[("k", 0.07)],
        |[_, q], _| 0.07 * q,
    );
    let pull = [("stiffness", 0.2), ("start", 0.05)];
    let pull = of_joint(knee, "stiffness * max(q - start, 0)", &pull, |[q, _], _| {
        if q > 0.05 { 0.2 * (q - 0.05) } else { 0.0 }
    });
    let spring = of_joint(
        ankle,
        "k * tau * abs(tau)",
        &[("k", 0.01)],
        |_, [tau, _]| 0.01 * tau * tau.abs(),
    );
    let (cross, values) = (
        "c * tau[\"r_ank_pitch\"] + d * q * tau",
        [("c", 0.005), ("d", -0.01)],
    );
    let cross = of_joint(
        ["r_knee", "r_ank_pitch"],
        cross,
        &values,
        |[q, _], [own, tau]| 0.005 * tau - 0.01 * q * own,
    );
    let of = |target: &str, site: Site, function: &str, values: &[(&str, f64)]| {
        record("own", target, (site, function), values)
    };
    let load = EffectRecord {
        at: Some([0.01, -0.02, 0.03]),
        ..of("body_link", Site::Load, "m", &[("m", 0.3)])
    };
    let square = of(
        "y",
        Site::Sensor,
        "c * abs(x) - d * pow(y, 2)",
        &[("c", 0.01), ("d", 1.5)],
    );
    let product = of("x", Site::Sensor, "c * x * y", &[("c", 3.0)]);
    let settles = of("y", Site::Ground, "s * exp(-t)", &[("s", 0.02)]);
    let gives = of(
        "x",
        Site::Ground,
        "s * x + u * y * y",
        &[("s", 0.3), ("u", 2.0)],
    );
    let cell = of("fsr_2", Site::Cell, "z + t", &[("z", 0.5)]);
    type Hide = fn(World) -> World;
    let others: [(EffectRecord, Hide); 6] = [
        (product, |w| w.sensor_function(0, |[x, y]| 3.0 * x * y)),
        (square, |w| {
            w.sensor_function(1, |[x, y]| 0.01 * x.abs() - 1.5 * y * y)
        }),
        (settles, |w| w.ground_slope([0.0, 0.02]).unwrap()),
        (gives, |w| {
            w.ground_function(0, |[x, y]| 0.3 * x + 2.0 * y * y)
        }),
        (load, |w| {
            w.payload("body_link", 0.3, [0.01, -0.02, 0.03]).unwrap()
        }),
        (cell, |w| w.cell_offset(2, 0.5).unwrap()),
    ];
    let others = others.map(|(record, bend)| -> (EffectRecord, Bend) {
        (record, Box::new(move |world, _| bend(world)))
    });
    [wave, held, follow, pull, spring, cross]
        .into_iter()
        .chain(others)
        .collect()
}

/// ∂`of`/∂q by differences of fourth order, row-major.
pub(crate) fn slopes<const N: usize>(q: &[f64], of: impl Fn(&[f64]) -> [f64; N]) -> Vec<f64> {
    let mut slopes = vec![0.0; N * q.len()];
    for j in 0..q.len() {
        let at = |step: f64| {
            let mut q = q.to_vec();
            q[j] += step;
            of(&q)
        };
        let near = [at(STEP), at(-STEP)];
        let far = [at(2.0 * STEP), at(-2.0 * STEP)];
        for axis in 0..N {
            let [near, far] = [near, far].map(|pair| pair[0][axis] - pair[1][axis]);
            slopes[axis * q.len() + j] = (8.0 * near - far) / (12.0 * STEP);
        }
    }
    slopes
}

#[test]
fn functions_of_the_body_and_readings_are_those_of_the_bent_robot() {
    let stand = Stand::new("op2", "r_sole");
    let place = |name: &str| {
        let mut dofs = stand.model.tree.dofs.iter();
        dofs.position(|dof| dof.joint == name).unwrap()
    };
    for (record, bend) in cases() {
        let name = record.function.clone().unwrap();
        let site = record.site;
        let of_cells = site == Some(Site::Cell);
        let model = with(&stand.model, &stand.cells, vec![record]);
        let bare = match of_cells {
            true => stand.world().cells(&stand.cells).unwrap(),
            false => stand.world(),
        };
        let world = bend(bare, &place).after_rounds(model.rounds);
        let mass: f64 = world.robot().links().iter().map(|link| link.mass_kg).sum();
        use Function::{Com, ComJacobian, Cop, CopJacobian, GravityMoments};
        let of = [Com, ComJacobian, GravityMoments, Cop, CopJacobian];
        let [com, jacobian, moments, cop, cop_jacobian] = of.map(|f| Evaluator::new(&model, f));
        let mut moved: f64 = 0.0;
        let postures = match of_cells {
            true => stand.postures_inside(POSTURES),
            false => stand.postures(POSTURES, 0.35, 7),
        };
        for q in postures {
            let near = |found: Vec<f64>, truth: &[f64], allowed: f64, what: &str| {
                let off = largest(&found, truth);
                assert!(off <= allowed, "{name}: {what} {off:.1e}");
            };
            near(com.run(&q, 1), world.com(&q).as_slice(), EXACT, "com");
            near(cop.run(&q, 1), &world.cop(&q), EXACT, "cop");
            let by_q = slopes(&q, |q| world.com(q).into());
            near(jacobian.run(&q, 1), &by_q, SLOPE, "com_jacobian");
            let by_q = slopes(&q, |q| world.cop(q));
            near(cop_jacobian.run(&q, 1), &by_q, SLOPE, "cop_jacobian");
            // Moments are of the body, on level ground.
            if !of_cells && site != Some(Site::Ground) {
                let truth: Vec<f64> = world.joint_moments(&q);
                let truth: Vec<f64> = truth.iter().map(|m| m / (mass * GRAVITY)).collect();
                near(moments.run(&q, 1), &truth, EXACT, "gravity_moments");
            }
            moved = moved.max(largest(&world.cop(&q), &stand.world().cop(&q)));
        }
        // It would be no test if nothing happened.
        assert!(moved > 1e-5, "{name}: {moved}");
        // Rows hold what encoders have, and nothing of moments or masses.
        let q = &stand.postures(1, 0.35, 9)[0];
        let rows = Evaluator::new(&model, Function::Regressor).run(q, 1);
        let com = |row: &[f64]| row.iter().zip(model.cad_params()).map(|(a, b)| a * b).sum();
        let by_rows: Vec<f64> = rows.chunks(model.base.params.len()).map(com).collect();
        let kinematic = name.contains('q') && !name.contains("tau") && !name.contains('c');
        let truth = match kinematic {
            true => world.com(q),
            false => stand.world().com(q),
        };
        assert!(largest(&by_rows, truth.as_slice()) < EXACT, "{name}: rows");
    }
}

/// The correction undoes what the sensor adds, as of every effect.
#[test]
fn what_a_sensor_adds_is_taken_back() {
    let stand = Stand::new("op2", "r_sole");
    let values = [("c", 2.0), ("d", 1e-3)];
    let own = record("own", "x", (Site::Sensor, "c * x * y + d"), &values);
    let model = with(&stand.model, &stand.cells, vec![own]);
    let correct = model.program(Function::CorrectCop, Given::Positions);
    let correct = correct.unwrap();
    for [x, y] in [[0.01, 0.02], [-0.03, 0.01], [0.0, 0.0]] {
        let found = run(&correct, &[&[x + 2.0 * x * y + 1e-3, y]]);
        assert!(largest(&found, &[x, y]) < 1e-12, "{found:?}");
    }
}

/// `verify` tells the virtual robot the values of the function, another way than expressions.
#[test]
fn a_model_with_a_formula_is_verified() {
    let stand = Stand::new("op2", "r_sole");
    let robot = Robot::read(urdf("op2").as_ref()).unwrap();
    for (record, _) in cases() {
        let name = record.function.clone().unwrap();
        let mut model = with(&stand.model, &stand.cells, vec![record]);
        let found = verify(&robot, &model, 60, 5, &mut ()).unwrap();
        assert!(found.pass && found.samples > 0, "{name}: {found:#?}");
        let mut records = model.file.as_mut().unwrap().effects.iter_mut();
        let value = records.next().unwrap().parameters.values_mut().next();
        value.unwrap().value *= 1.5;
        let other = verify(&robot, &model, 60, 5, &mut ()).unwrap();
        // A payload's record alone does not change what the model weighs.
        assert!(!other.pass, "{name}: {other:#?}");
    }
}

/// Two links with a formula each; those that fixed point can have.
fn two_links() -> Vec<Case> {
    let own = |what: &str, records: Vec<EffectRecord>| {
        let bare = Case::robot("two_link", "foot");
        let cells = [[0.1, 0.06], [0.1, -0.06], [-0.1, -0.06], [-0.1, 0.06]];
        let model = with(&bare.model, &cells, records);
        let servos = servos(&model);
        Case::new(model, &format!("own_{what}"), servos)
    };
    let joint = |what: &str, target: &str, function: &str, values: &[(&str, f64)]| {
        own(
            what,
            vec![record("own", target, (Site::Joint, function), values)],
        )
    };
    let sensor = [
        record("own", "x", (Site::Sensor, "c * x * y"), &[("c", 0.3)]),
        record(
            "own",
            "y",
            (Site::Sensor, "c * min(x, 0.01)"),
            &[("c", 0.01)],
        ),
    ];
    let crosses = "k * tau[\"knee\"] - k * q * tau";
    let cable = [("k", 0.1), ("s", 0.2)];
    vec![
        joint("wave", "knee", "a * sin(6 * q + 0.5)", &[("a", 0.02)]),
        joint("follows", "knee", "k * q[\"ankle\"]", &[("k", 0.07)]),
        joint("hardens", "knee", "k * tau * abs(tau)", &[("k", 0.002)]),
        joint("crosses", "ankle", crosses, &[("k", 0.004)]),
        own("sensor", sensor.into()),
        joint("cable", "knee", "k * max(q - s, 0)", &cable),
        joint("hat", "knee", "k * max(1 - abs(q), 0)", &[("k", 0.05)]),
    ]
}

/// In floats compiled C has the bits of the tape, corners and all; every function stays within
/// what is proven for it.
#[test]
fn formulas_in_c_have_the_bits_of_the_tape_and_their_bounds() {
    let folder = fresh("c99/composed");
    let cases = two_links();
    let jobs = cases
        .iter()
        .flat_map(|case| SCALARS.map(|scalar| (case, scalar)))
        // A reading that depends on itself is taken back by Newton's method, which divides.
        .filter(|(case, scalar)| case.name != "own_sensor" || *scalar != Scalar::Fixed32);
    parallel(jobs.collect(), |(case, scalar)| {
        let entries = case.entries(scalar);
        let compiled = match scalar {
            Scalar::Fixed32 => trapping(&folder, case),
            _ => Compiled::plain(&folder, case, scalar, "cc", "-O2"),
        };
        let drawn = draw(case, 300, 5, &*compiled.hold());
        has_the_bits_of_rust(case, scalar, &compiled, &entries, &drawn);
        // With corners, jumps of slopes are part of bounds, and no measure of them.
        let corners = ["own_cable", "own_hat", "own_hardens", "own_sensor"];
        if !corners.contains(&case.name.as_str()) {
            bounded(case, scalar, &compiled, &entries);
        }
    });
}

#[test]
fn fixed_point_leaves_out_what_divides_roots_or_raises() {
    let bare = Case::robot("two_link", "foot").model;
    for function in ["k / (1 + q * q)", "k * sqrt(abs(q))", "k * exp(q)"] {
        let own = record("own", "knee", (Site::Joint, function), &[("k", 0.02)]);
        let model = with(&bare, &[], vec![own]);
        let options = Options::of(Scalar::Fixed32);
        let error = c::package(&Facts::of(&model), "own", &options).unwrap_err();
        assert!(error.to_string().contains("fixed32"), "{error}");
        for scalar in [Scalar::F64, Scalar::F32] {
            c::package(&Facts::of(&model), "own", &Options::of(scalar)).unwrap();
        }
    }
}

/// What functions depend on beside q is an array of `model_com` and `model_cop`, in both languages.
#[test]
fn a_context_is_the_last_argument_of_model_functions_alone() {
    let bare = Case::robot("two_link", "foot").model;
    let (warms, values) = (
        "a * column[\"temp\"] + b * approach",
        [("a", 1e-3), ("b", 0.01)],
    );
    let mut warm = record("own", "ankle", (Site::Joint, warms), &values);
    warm.columns = BTreeMap::from([("temp".to_string(), 25.0)]);
    let drift = record("own", "x", (Site::Sensor, "d * t"), &[("d", 1e-5)]);
    let model = with(&bare, &[], vec![warm, drift]);
    let facts = Facts::of(&model);
    // Beside nothing of the context: 25 degrees, t and approach of 0.
    let (q, at) = ([0.3, -0.4], [[20.0, 1.0, 100.0], [25.0, 0.0, 0.0]]);
    let truth = |[temp, approach, t]: [f64; 3]| {
        let off = [q[0] + 1e-3 * temp + 0.01 * approach, q[1]];
        let com = bare.evaluate(Function::Com, &off, &bare.cad_params());
        let cop = [com[0] + 1e-5 * t, com[1]];
        [com, cop.to_vec()].concat()
    };
    let expected: Vec<f64> = [truth(at[0]), truth(at[1]), truth(at[1])].concat();

    let package = c::package(&facts, "own", &Options::of(Scalar::F64)).unwrap();
    let declared = [
        "#define own_CONTEXT 3",
        "extern const char *const own_context_names[own_CONTEXT];",
        "void own_com(const own_real q[], const own_real r[], own_real com[3]);",
        "void own_model_com(const own_real q[], const own_real context[], own_real com[3]);",
        "void own_model_cop(const own_real q[], const own_real context[], own_real cop[2]);",
        "void own_model_com_jacobian(const own_real q[], own_real jac[3 * own_DOF]);",
        "column[\"temp\"] = 25.0, approach[\"ankle\"] = 0.0, t = 0.0 in every function but",
    ];
    says(&package.header, &declared);
    let folder = fresh("c99/context");
    fs::write(folder.join("own.h"), &package.header).unwrap();
    fs::write(folder.join("own.c"), &package.source).unwrap();
    let main = format!(
        "#include \"own.h\"\n#include <stdio.h>\nint main(void)\n{{\n    \
         const double q[] = {};\n    const double at[2][3] = {};\n    double x[15];\n    \
         own_model_com(q, at[0], x);\n    own_model_cop(q, at[0], &x[3]);\n    \
         own_model_com(q, at[1], &x[5]);\n    own_model_cop(q, at[1], &x[8]);\n    \
         own_com(q, own_cad_params, &x[10]);\n    own_cop(q, own_cad_params, &x[13]);\n    \
         for (int k = 0; k < 15; k++) {{ printf(\"%.17g\\n\", x[k]); }}\n    \
         return own_selftest();\n}}\n",
        in_braces(&q),
        in_braces(&at)
    );
    fs::write(folder.join("main.c"), main).unwrap();
    let program = folder.join("program");
    let mut cc = Command::new("cc");
    cc.args(WARNINGS).arg(SEPARATE).current_dir(&folder);
    printed(cc.args(["own.c", "main.c", "-o"]).arg(&program));
    let numbers = |text: &str| -> Vec<f64> {
        let lines = text.lines();
        lines.map(|line| line.parse().unwrap()).collect()
    };
    let by_c = numbers(&printed(&mut Command::new(&program)));
    assert!(largest(&by_c, &expected) < 1e-15, "{by_c:?} {expected:?}");

    let child = Child::new("context", "");
    let module = rust::module(&facts, "own").unwrap();
    child.write("src/own.rs", &module);
    let main = format!(
        "pub mod own;\nuse own::CAD_PARAMS as R;\nfn main() {{\n    let q = {q:?};\n    \
         let at: [[f64; own::CONTEXT]; 2] = {at:?};\n    for at in &at {{\n        \
         for x in own::model_com(&q, at) {{ println!(\"{{x:?}}\"); }}\n        \
         for x in own::model_cop(&q, at) {{ println!(\"{{x:?}}\"); }}\n    }}\n    \
         for x in own::com(&q, &R) {{ println!(\"{{x:?}}\"); }}\n    \
         for x in own::cop(&q, &R) {{ println!(\"{{x:?}}\"); }}\n}}\n"
    );
    child.write("src/main.rs", &main);
    let by_rust = child.cargo(&["run", "--release", "--quiet"]).unwrap();
    let by_rust = numbers(std::str::from_utf8(&by_rust).unwrap());
    assert_eq!(by_rust, by_c);
}

/// Numbers as C writes them.
fn in_braces(numbers: &impl std::fmt::Debug) -> String {
    format!("{numbers:?}").replace('[', "{").replace(']', "}")
}

/// Formulas in a model file say what is wrong with them; springs that do not come to rest are
/// refused, softer ones take more rounds.
#[test]
fn a_model_file_with_a_formula_is_read_or_refused_in_words() {
    let stand = Stand::new("op2", "r_sole");
    let own = |function: &str, k: f64| {
        let own = record("own", "r_ank_pitch", (Site::Joint, function), &[("k", k)]);
        let mut file =
            ModelFile::from_values(&stand.model, &stand.model.cad_params(), None, "data");
        file.effects = vec![own];
        stand.model.clone().with_file(file)
    };
    for (function, said) in [
        ("k * sin(6 * q", "function: column 8: it is opened"),
        ("k * x", "`x` is no variable of site joint"),
        ("k * q[\"nose\"]", "no joint that its function names"),
        ("k * start", "`start` is missing"),
    ] {
        let error = own(function, 0.01).unwrap_err().to_string();
        assert!(error.contains(said), "{function}: {error}");
    }
    assert_eq!(own("k * tau", 1e-3).unwrap().rounds, 4);
    let soft = own("k * tau", 0.08).unwrap();
    assert!((5..=8).contains(&soft.rounds), "{}", soft.rounds);
    // As of the spring that it is.
    let spring = stand.hidden("joint_compliance", "r_ank_pitch", &[12.5]);
    assert_eq!(with_effects(&stand, &[spring]).rounds, soft.rounds);
    let error = own("k * tau", 0.5).unwrap_err().to_string();
    assert!(error.contains("springs are too soft"), "{error}");
}

/// From end to end: a cable pulls at the knee of the virtual robot, a diagnosis that is told of
/// such a thing names it, and the generated C's centre of mass comes back to the robot's.
#[test]
fn an_effect_of_a_users_own_is_found_and_generated() {
    const OWN: &str = "[[effect]]\nname = \"cable_pull\"\nsite = \"joint\"\n\
        adds = \"stiffness * max(q - start, 0.0)\"\n\
        sentence = \"a cable that pulls at {target}\"\n\
        [effect.parameters]\nstiffness = { typical = 0.05 }\n\
        start = { typical = 0.2, unit = \"rad\", min = -0.5, max = 0.6 }\n";
    const RANGE: f64 = 0.6;
    let stand = Stand::new("op2", "r_sole");
    let dofs = &stand.model.tree.dofs;
    let knee = dofs.iter().position(|dof| dof.joint == "r_knee").unwrap();
    let pull = move |q: &[f64], _: &[f64]| -0.15 * (q[knee] - 0.1).max(0.0);
    let world = stand.world().joint_function("r_knee", pull).unwrap();
    let folder = Folder::with("op2");
    let random = &mut ChaCha8Rng::seed_from_u64(5);
    let q = stand.postures(120, RANGE, 3);
    let cop = q
        .iter()
        .map(|q| world.cop(q).map(|x| x + 5e-4 * normal(random)));
    let log = Recording {
        joints: dofs.iter().map(|dof| dof.joint.clone()).collect(),
        cop: cop.collect(),
        q,
        ..Recording::default()
    };
    folder.write("log.csv", log.csv(false));
    folder.write("own.toml", OWN);
    let line = "diagnose op2.urdf --no-snap --support r_sole --data log.csv --noise 0.0005 \
                --prior tight --effects own.toml --out model.toml";
    let found = folder.json(line);
    let step = &found["steps"][0];
    assert_eq!(found["steps"].as_array().unwrap().len(), 1, "{found:#}");
    assert_eq!(step["effect"], "cable_pull");
    assert_eq!(step["target"], "r_knee");
    let value = |name: &str| step["parameters"][name]["value"].as_f64().unwrap();
    assert!((value("stiffness") + 0.15).abs() < 0.02, "{step:#}");
    assert!((value("start") - 0.1).abs() < 0.1, "{step:#}");
    let function = "function = \"stiffness * max(q - start, 0.0)\"";
    let sentence = "sentence = \"a cable that pulls at {target}\"";
    says(
        folder.read("model.toml"),
        &["site = \"joint\"", function, sentence],
    );
    folder.stdout(
        "generate op2.urdf --no-snap --support r_sole --lang c --scalar f64 --name op2 --out . \
         --model model.toml",
    );
    let fresh = stand.postures(200, RANGE, 77);
    let main = format!(
        "#include \"op2.h\"\n#include <stdio.h>\nstatic const double q[][op2_DOF] = {};\n\
         int main(void)\n{{\n    for (int k = 0; k < {}; k++) {{\n        double com[3];\n        \
         op2_model_com(q[k], com);\n        \
         printf(\"%.17g\\n%.17g\\n%.17g\\n\", com[0], com[1], com[2]);\n    }}\n    return 0;\n}}\n",
        in_braces(&fresh),
        fresh.len()
    );
    folder.write("main.c", main);
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "op2.c", "main.c", "-lm", "-o", "program"]);
    printed(cc.current_dir(folder.path()));
    let com = printed(&mut Command::new(folder.join("program")));
    let com: Vec<f64> = com.lines().map(|line| line.parse().unwrap()).collect();
    let bare = stand.world();
    let (mut before, mut after) = (0.0, 0.0);
    for (q, com) in fresh.iter().zip(com.chunks(3)) {
        let truth = world.com(q);
        before += (bare.com(q) - truth).norm_squared();
        after += largest(com, truth.as_slice()).powi(2);
    }
    let left = (after / before).sqrt();
    println!("gap of the CoM: {:.1} %", 100.0 * left);
    assert!(left < 0.15, "{left}");
}

/// A model without such effects has no trace of them: no maximum, no context.
#[test]
fn models_without_formulas_generate_what_they_did() {
    let stand = Stand::new("op2", "r_sole");
    for function in Function::ALL {
        let program = stand.model.program(function, Given::Positions).unwrap();
        let mut nodes = program.nodes.iter();
        assert!(nodes.all(|node| !matches!(node.expr, Expr::Max(..))));
    }
    let package = c::package(&Facts::of(&stand.model), "op2", &Options::of(Scalar::F64)).unwrap();
    assert!(!package.header.to_lowercase().contains("context"));
}
