//! Small robots of any shape: from URDF to programs that are compared with the reference.

use std::fmt::Write as _;

use arbitrary::{Result, Unstructured};
use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::bounds::Precision;
use sesc_model::{Function, Given, Model, Snapping, urdf};
use sesc_reference::{Reference, Robot};

/// Joints at most.
const JOINTS: usize = 6;
/// Snapped right angles may move the CoM by this much of its reach.
const AGREES: f64 = 1e-11;

/// A robot as text, the link it stands on, and where its joints are between their limits.
#[derive(Debug)]
pub struct Drawn {
    pub text: String,
    pub support: String,
    pub shares: Vec<f64>,
}

/// A length, m, among them zeros and equal ones.
fn length(u: &mut Unstructured) -> Result<f64> {
    Ok(f64::from(u.int_in_range(-64_i8..=64)?) / 128.0)
}

fn vector(u: &mut Unstructured) -> Result<String> {
    Ok(format!("{} {} {}", length(u)?, length(u)?, length(u)?))
}

fn angle(u: &mut Unstructured) -> Result<f64> {
    use std::f64::consts::{FRAC_PI_2, PI};
    Ok(match u.int_in_range(0..=7_u8)? {
        0..=2 => 0.0,
        3 => FRAC_PI_2,
        4 => -FRAC_PI_2,
        5 => PI,
        _ => f64::from(u.int_in_range(-128_i16..=128)?) / 40.0,
    })
}

impl Drawn {
    pub fn of(u: &mut Unstructured) -> Result<Drawn> {
        let joints = u.int_in_range(1..=JOINTS)?;
        let mut text = String::from("<robot name=\"drawn\">\n");
        for k in 0..=joints {
            // One has mass for sure.
            let mass = match u.int_in_range(0..=9_u8)? {
                0 if k > 0 => 0.0,
                n => f64::from(n.max(1)) / 4.0,
            };
            let com = vector(u)?;
            let _ = writeln!(
                text,
                "<link name=\"l{k}\"><inertial><origin xyz=\"{com}\"/><mass value=\"{mass}\"/>\
                 <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
            );
        }
        for k in 1..=joints {
            let kind = *u.choose(&["revolute", "revolute", "continuous", "prismatic", "fixed"])?;
            let parent = u.int_in_range(0..=k - 1)?;
            let (xyz, rpy) = (
                vector(u)?,
                format!("{} {} {}", angle(u)?, angle(u)?, angle(u)?),
            );
            let axis = match u.int_in_range(0..=6_u8)? {
                0 => "1 0 0".to_string(),
                1 => "0 -1 0".to_string(),
                2..=4 => "0 0 1".to_string(),
                _ => format!("0.6 {} 0.8", length(u)?),
            };
            let _ = write!(
                text,
                "<joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{k}\"/>\
                 <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/>"
            );
            if ["revolute", "prismatic"].contains(&kind) {
                let _ = write!(text, "<limit lower=\"-1.25\" upper=\"1.5\"/>");
            }
            if kind != "fixed" && k > 1 && u.ratio(1_u8, 6_u8)? {
                let master = u.int_in_range(1..=k - 1)?;
                let factor = *u.choose(&[1.0, -1.0, 2.0, 0.5, -0.75])?;
                let _ = write!(
                    text,
                    "<mimic joint=\"j{master}\" multiplier=\"{factor}\" offset=\"0.25\"/>"
                );
            }
            text += "</joint>\n";
        }
        text += "</robot>\n";
        let support = format!("l{}", u.int_in_range(0..=joints)?);
        let shares = (0..JOINTS).map(|_| Ok(f64::from(u.arbitrary::<u8>()?) / 255.0));
        let shares = shares.collect::<Result<_>>()?;
        Ok(Drawn {
            text,
            support,
            shares,
        })
    }

    /// Its model; none where a mimic follows a joint that does not move, say.
    pub fn model(&self) -> Option<Model> {
        let description = urdf::parse(&self.text, "drawn.urdf").ok()?;
        Model::new(&description, &self.support, Snapping::Off).ok()
    }

    /// A posture inside the limits of `model`.
    pub fn posture(&self, model: &Model) -> Vec<f64> {
        let dofs = model.tree.dofs.iter().zip(&self.shares);
        dofs.map(|(dof, share)| dof.lower + share * (dof.upper - dof.lower))
            .collect()
    }
}

/// Every program, its bound and the code of it; the CoM against the reference.
pub fn pipeline(data: &[u8]) {
    let Ok(drawn) = Drawn::of(&mut Unstructured::new(data)) else {
        return;
    };
    let Some(model) = drawn.model() else {
        return;
    };
    let (q, r) = (drawn.posture(&model), model.cad_params());
    for function in Function::ALL {
        for given in [Given::Positions, Given::SinesCosines] {
            let Some(program) = model.program(function, given) else {
                continue;
            };
            let bound = model.rounding(&program, Precision::F64).worst;
            assert!(bound >= 0.0, "{function:?}: {bound}");
            if given == Given::Positions && function != Function::Zmp {
                assert!(
                    bound.is_finite(),
                    "{function:?} on {}\n{}",
                    drawn.support,
                    drawn.text
                );
            }
        }
    }
    let com = model.evaluate(Function::Com, &q, &r);
    let reference = Robot::from_urdf(&drawn.text).expect("what we read, the reference reads");
    let reference = Reference::new(&reference, &drawn.support).expect("it has the link");
    let expected: [f64; 3] = reference.com(&q).into();
    for (x, y) in com.iter().zip(expected) {
        let apart = (x - y).abs();
        assert!(
            apart <= AGREES * model.reach().max(1.0),
            "{com:?} {expected:?} at {q:?} on {}\n{}",
            drawn.support,
            drawn.text
        );
    }
    let facts = Facts::of(&model);
    rust::module(&facts, "drawn").expect("a module");
    for scalar in [Scalar::F64, Scalar::F32, Scalar::Fixed32] {
        let mut options = Options::of(scalar);
        options.lanes = (scalar != Scalar::Fixed32).then_some(8);
        let package = c::package(&facts, "drawn", &options);
        assert!(package.is_ok(), "{scalar:?}: {:?}", package.err());
    }
}
