//! 32-bit fixed point: nothing overflows, whatever the robot; no division, no
//! float.

use std::fs;
use std::path::Path;

use sesc_codegen::emit::c::{self, Options, Scalar, Servos};
use sesc_codegen::facts::Facts;
use sesc_model::{Function, Snapping};

use super::bounds::check;
use super::case::{Case, ROOT};
use super::compiled::{Compiled, folder, parallel};
use super::draw::draw;
use crate::COMPILERS;
use sesc_test_support::command::says;
use sesc_test_support::trees::Urdf;

/// An overflowing sum, a shift of too many bits or an index beyond an array traps.
const TRAPS: [&str; 3] = [
    "-O0",
    "-fsanitize=signed-integer-overflow,shift,bounds",
    "-fsanitize-undefined-trap-on-error",
];

/// Every conversion to 32 bits traps where the value does not fit.
fn checked(case: &Case, source: String) -> String {
    let cast = format!("({}_real)((wide", case.name);
    assert!(source.contains(&cast), "{}: narrow() narrows", case.name);
    // Sums that wrap for inputs out of range overflow, and trap, inside the ranges.
    let mut source = source;
    for sign in ["+", "-"] {
        let wraps = format!("(int32_t)((uint32_t)(a) {sign} (uint32_t)(b))");
        source = source.replace(&wraps, &format!("(a) {sign} (b)"));
    }
    assert!(!source.contains("(uint32_t)(a)"));
    // The phase of an angle is a turn's remainder: meant to wrap.
    let kept = "(int32_t)beside";
    let source = source.replace(kept, "@@").replace("(int32_t)(", "checked(");
    let source = source.replace("@@", kept).replace(&cast, "checked((wide");
    let include = "#include <stdint.h>\n";
    let trap = "\nstatic int32_t checked(int64_t wide)\n{\n    \
                if ((wide > INT32_MAX) || (wide < -INT32_MAX)) {\n        __builtin_trap();\n    }\n    \
                return (int32_t)wide;\n}\n";
    source.replacen(include, &format!("{include}{trap}"), 1)
}

/// `case` in fixed point, stopped by what overflows.
pub(crate) fn trapping(folder: &Path, case: &Case) -> Compiled {
    let (change, compiler) = (
        |source| checked(case, source),
        COMPILERS[COMPILERS.len() - 1],
    );
    Compiled::build(folder, case, Scalar::Fixed32, compiler, &TRAPS, change)
}

/// A chain of joints of alternating axes, links `length` long, limits ±`limit`.
struct Chain {
    name: &'static str,
    joints: usize,
    length: f64,
    kind: fn(usize) -> &'static str,
    lower: f64,
    upper: f64,
    mimic: Option<(f64, f64)>,
}

impl Chain {
    fn text(&self) -> String {
        let Chain {
            length,
            lower,
            upper,
            ..
        } = self;
        let link = |robot: Urdf, k: usize| {
            let (a, b) = (length * (0.3 + 0.05 * (k % 7) as f64), length * 0.11);
            robot.link(
                &format!("l{k}"),
                (1 + k % 3) as f64,
                &format!("{a} {b} {a}"),
            )
        };
        let mut robot = link(Urdf::new(self.name), 0);
        for k in 0..self.joints {
            let axis = ["1 0 0", "0 1 0", "0 0 1", "0.6 0 0.8", "0.3 -0.7 0.2"][k % 5];
            let mimic = match self.mimic {
                Some((factor, offset)) if k % 2 == 1 => format!(
                    "<mimic joint='j{}' multiplier='{factor}' offset='{offset}'/>",
                    k - 1
                ),
                _ => String::new(),
            };
            let turn = 0.1 * (k % 9) as f64;
            let more = format!(
                "<origin xyz='{length} 0 {length}' rpy='0.2 0 {turn}'/><axis xyz='{axis}'/>\
                 <limit lower='{lower}' upper='{upper}'/>{mimic}"
            );
            let links = [format!("l{k}"), format!("l{}", k + 1)];
            let links = [links[0].as_str(), &links[1]];
            robot = link(robot, k + 1).joint(&format!("j{k}"), (self.kind)(k), links, &more);
        }
        robot.text()
    }
}

const REVOLUTE: fn(usize) -> &'static str = |_| "revolute";
const PRISMATIC: fn(usize) -> &'static str = |_| "prismatic";
const MIXED: fn(usize) -> &'static str = |k| if k % 3 == 1 { "prismatic" } else { "revolute" };

/// Robots at the ends of what 32 bits hold, and beyond.
fn extremes() -> Vec<Chain> {
    let usual = Chain {
        name: "usual",
        joints: 6,
        length: 0.2,
        kind: REVOLUTE,
        lower: -2.0,
        upper: 2.0,
        mimic: None,
    };
    macro_rules! chain {
        ($name:literal, $($field:ident: $value:expr),*) => {
            Chain { name: $name, $($field: $value,)* ..usual }
        };
    }
    vec![
        chain!("kilometres", length: 1e3),
        chain!("megametres", length: 1e6),
        chain!("micrometres", length: 1e-6),
        chain!("nanometres", length: 1e-9),
        chain!("massed_at_axes", length: 0.0),
        chain!("long_strokes", kind: MIXED, lower: -900.0, upper: 999.0),
        chain!("longer_strokes", kind: PRISMATIC, lower: -999.0, upper: 999.0, mimic: Some((2e3, 1e5))),
        chain!("endless_strokes", kind: PRISMATIC, lower: -999.0, upper: 999.0, mimic: Some((1e7, 0.0))),
        chain!("short_strokes", kind: MIXED, lower: -1e-5, upper: 1e-5),
        chain!("far_prismatic", kind: PRISMATIC, lower: 900.0, upper: 900.1),
        chain!("many_turns", lower: -999.0, upper: 999.0),
        chain!("more_turns", lower: -999.0, upper: 999.0, mimic: Some((30.0, 0.0))),
        chain!("too_many_turns", lower: -999.0, upper: 999.0, mimic: Some((40.0, 0.0))),
        chain!("geared_down", mimic: Some((0.3, 0.0))),
        chain!("geared_back", mimic: Some((-2.0, 1.0))),
        chain!("geared_up", mimic: Some((5.0, -3.0))),
        chain!("geared_far", mimic: Some((500.0, 20.0))),
        chain!("geared_prismatic", kind: PRISMATIC, mimic: Some((5.0, 100.0))),
        // The offset is larger than the angle and than the sum.
        chain!("offset_beyond", lower: -1.9, upper: -1.5, mimic: Some((1.0, 3.4))),
        chain!("offset_far_beyond", lower: -63.9, upper: -63.5, mimic: Some((1.0, 64.5))),
        chain!("prismatic_offset", kind: PRISMATIC, lower: -7.9, upper: -7.5, mimic: Some((1.0, 8.3))),
        chain!("narrow_limits", lower: 1.0, upper: 1.0001),
        chain!("hundred_joints", joints: 100),
    ]
}

/// Bounded or refused: never wrong.
#[test]
fn robots_at_the_ends_of_what_32_bits_hold() {
    let folder = folder("extremes");
    let mut chains = extremes();
    // One compiler has more joints below.
    chains.retain(|chain| COMPILERS.len() > 1 || chain.joints < 100);
    let outcomes = parallel(chains, |chain| {
        let text = chain.text();
        let mut case = Case::of_text(&text, "l0", chain.name);
        // Strokes of 1e-9 to 1e4 m a tick: about 1e5 ticks from end to end.
        for setting in case.servos.joints.values_mut() {
            if setting.metres_per_tick.is_some() {
                setting.metres_per_tick = Some((chain.upper - chain.lower) / 1e5);
                setting.zero = Some(0);
                setting.sign = Some(1);
            }
        }
        for scalar in [Scalar::F64, Scalar::F32] {
            in_floats(&folder, &case, scalar);
        }
        let mut options = Options::of(Scalar::Fixed32);
        options.servos = Some(case.servos.clone());
        match c::package(&Facts::of(&case.model), &case.name, &options) {
            Err(error) => {
                let message = error.to_string();
                says(
                    &message,
                    &["fixed32", "may reach", "the robot reaches", "f32"],
                );
                (chain.name, Err(message))
            }
            Ok(_) => {
                let compiled = trapping(&folder, &case);
                let entries = case.entries(Scalar::Fixed32);
                let drawn = draw(&case, 240, 37, &*compiled.hold());
                let rows = check(&case, &compiled, &entries, &drawn);
                let com = rows.into_iter().find(|(name, ..)| name == "com").unwrap();
                (chain.name, Ok((com.1, com.2)))
            }
        }
    });
    for (name, outcome) in &outcomes {
        println!("{name:<18} {outcome:?}");
    }
    let refused = outcomes.iter().filter(|(_, outcome)| outcome.is_err());
    let refused: Vec<&str> = refused.map(|(name, _)| *name).collect();
    assert_eq!(refused, ["endless_strokes", "too_many_turns"]);
}

/// The self-test agrees and the bounds hold, or no bound is claimed.
fn in_floats(folder: &Path, case: &Case, scalar: Scalar) {
    let mut options = Options::of(scalar);
    options.servos = Some(case.servos.clone());
    match c::package(&Facts::of(&case.model), &case.name, &options) {
        Err(error) => assert!(error.to_string().contains("1024 rad"), "{error}"),
        Ok(_) => {
            let compiled = Compiled::plain(folder, case, scalar, COMPILERS[0], "-O0");
            let entries = case.entries(Scalar::Fixed32);
            let drawn = draw(case, 60, 53, &*compiled.hold());
            // In f64 the tape is the yardstick of f32 alone; here the self-test runs.
            match scalar {
                Scalar::F64 => drop(compiled.run(case, &entries, &drawn)),
                _ => drop(check(case, &compiled, &entries, &drawn)),
            }
        }
    }
}

/// Hundreds of joints in one chain: the CoM alone, in all its variants. gcc takes minutes for five
/// hundred, clang seconds.
#[test]
fn a_chain_of_hundreds_of_joints_stays_inside() {
    let folder = folder("long");
    let chain = Chain {
        name: "long",
        joints: if COMPILERS.len() == 1 { 150 } else { 500 },
        length: 0.01,
        kind: REVOLUTE,
        lower: -1.0,
        upper: 1.0,
        mimic: None,
    };
    let case = Case::of_text(&chain.text(), "l0", chain.name);
    use Function::{Com, ComVelocity, Cop, GravityMoments};
    let case = Case {
        functions: vec![Com, ComVelocity, Cop, GravityMoments],
        ..case
    };
    let compiled = trapping(&folder, &case);
    let entries = case.entries(Scalar::Fixed32);
    let drawn = draw(&case, 60, 41, &*compiled.hold());
    println!("{:?}", check(&case, &compiled, &entries, &drawn));
}

/// A sensor that is broken gives any number: no rule of C is broken by it, in any function.
#[test]
fn any_position_velocity_and_tick_is_defined_in_fixed_point() {
    let folder = folder("any_input");
    let robots = [
        ("op2", "r_sole"),
        ("lift_base", "hand"),
        ("skew_humanoid", "left_sole"),
    ];
    parallel(robots.to_vec(), |(robot, support)| {
        let case = Case::robot(robot, support);
        let compiler = COMPILERS[COMPILERS.len() - 1];
        let compiled = Compiled::build(&folder, &case, Scalar::Fixed32, compiler, &TRAPS, |s| s);
        let entries = case.entries(Scalar::Fixed32);
        let mut drawn = draw(&case, 200, 47, &*compiled.hold());
        let most = [-i32::MAX, i32::MAX, 1 - i32::MAX];
        let others = [-1, 1 << 30, 987_654_321, -123_456_789];
        let mut ends = most.into_iter().chain(others).cycle();
        let [q_bits, qd_bits, sc_bits] = ["Q", "QD", "SC"].map(|quantity| compiled.bits(quantity));
        let dof = case.model.dof();
        for k in 0..drawn.q.len() {
            // In the first seven postures some joints alone, then all of them.
            let any = k / dof == k % 7 || k >= 7 * dof;
            let [q, qd, tick] = [(); 3].map(|()| ends.next().unwrap());
            if any {
                // A stroke stands among the sines, too.
                let stroke = case.model.tree.dofs[k % dof].prismatic;
                let bits = if stroke { q_bits.max(sc_bits) } else { q_bits };
                drawn.q[k] = f64::from(q) * (-f64::from(bits)).exp2();
                drawn.qd[k] = f64::from(qd) * (-f64::from(qd_bits)).exp2();
                drawn.ticks[k] = tick;
            }
        }
        compiled.run(&case, &entries, &drawn);
    });
}

/// C without its comments.
pub(crate) fn without_comments(source: &str) -> String {
    let mut code = String::new();
    let mut rest = source;
    while let Some((before, after)) = rest.split_once("/*") {
        code.push_str(before);
        rest = after.split_once("*/").expect("a comment ends").1;
    }
    code + rest
}

/// The command line's servo file, read as the library reads it.
#[test]
fn servo_settings_come_from_a_file_as_from_code() {
    let folder = folder("servos");
    let file = folder.join("servos.toml");
    let text = "[default]\nzero = 512\nresolution = 1024\n[joints.r_knee]\nzero = -3\nsign = -1\n";
    fs::write(&file, text).unwrap();
    let path = Path::new(ROOT).join("robots/op2/op2.urdf");
    let robot = sesc_identify::robot::Robot::read(&path).unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut case = Case::new(model, "op2", Servos::read(&file).unwrap());
    let from_file = case.package(Scalar::Fixed32);
    // The same, joint by joint.
    let default = case.servos.default.clone();
    for dof in &case.model.tree.dofs {
        let setting = case.servos.joints.entry(dof.joint.clone()).or_default();
        setting.zero = setting.zero.or(default.zero);
        setting.resolution = default.resolution;
    }
    case.servos.default = Default::default();
    assert_eq!(from_file, case.package(Scalar::Fixed32));
    let compiled = trapping(&folder, &case);
    let mut entries = case.entries(Scalar::Fixed32);
    entries.retain(|entry| entry.given.is_none());
    let drawn = draw(&case, 200, 43, &*compiled.hold());
    check(&case, &compiled, &entries, &drawn);
}
