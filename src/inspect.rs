//! What there is to know about a robot before any data: tree, chain, base
//! parameters, what no data can see, operation counts, rounding, snaps.

mod rank;

use std::collections::BTreeMap;

use serde::Serialize;
use sesc_identify::threads::each;
use sesc_model::base::{Column, Unobservable};
use sesc_model::bounds::Precision;
use sesc_model::program::Counts;
use sesc_model::tree::{Snap, on_many_feet};
use sesc_model::{Function, Given, Model};

pub use rank::{Rank, RankCheck, numeric_rank};

/// The JSON of `sesc inspect`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Inspection {
    /// Name of the robot.
    pub robot: String,
    /// Hash of the URDF.
    pub hash: String,
    /// The link on the ground.
    pub support: String,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Links.
    pub links: usize,
    /// Independent joints.
    pub dof: usize,
    /// Bodies of the chain, fixed joints folded.
    pub bodies: usize,
    /// Parameters of the full chain.
    pub full_params: usize,
    /// Base parameters.
    pub base_params: usize,
    /// Ranks of the regressors by structure.
    pub rank: Rank,
    /// The same ranks found numerically.
    pub numeric_rank: Rank,
    /// What numeric ranks say of these.
    pub rank_check: RankCheck,
    /// Independent joints, in the order of `q`.
    pub joints: Vec<String>,
    /// Bodies, outward from the support.
    pub chain: Vec<Body>,
    /// Base parameters, in the order of `r`.
    pub parameters: Vec<Parameter>,
    /// Directions that no flat CoP can see.
    pub unobservable: Vec<Unobservable>,
    /// Right angles that were made exact.
    pub snaps: Vec<Snap>,
    /// Oddities of the URDF and feet.
    pub notes: Vec<String>,
    /// Operations of each function.
    pub operations: BTreeMap<&'static str, Counts>,
    /// Proven rounding bounds, m; of each function.
    pub rounding_bound: BTreeMap<&'static str, Rounding>,
}

/// One body of the chain.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Body {
    /// Link that names the body.
    pub body: String,
    /// Joint that moves it; none for the body that stands.
    pub joint: Option<String>,
    /// Body across that joint.
    pub parent: Option<String>,
    /// What turns it against that body.
    pub rotation: String,
    /// B_i as a product of rotations.
    pub orientation: String,
    /// CAD value of r_i, m; in the body's link frame.
    pub r: [f64; 3],
    /// CAD value of s_i.
    pub s: Option<f64>,
    /// Mass of its links, kg.
    pub mass_kg: f64,
    /// Its links.
    pub links: Vec<String>,
}

/// One base parameter.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Parameter {
    /// Link and axis.
    pub name: String,
    /// Value from CAD, in `unit`.
    pub cad: f64,
    /// `m`; `1` for a mass fraction.
    pub unit: &'static str,
}

/// Proven rounding bounds of one function, m.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Rounding {
    /// In double precision, m.
    pub f64: f64,
    /// In single precision, m.
    pub f32: f64,
}

/// Gather everything.
pub fn inspect(model: &Model) -> Inspection {
    let (tree, chain, base) = (&model.tree, &model.chain, &model.base);
    let of_function = |function: Function| {
        let program = model.program(function, Given::Positions)?;
        let bound = |precision| model.rounding(&program, precision).worst;
        let rounding = Rounding {
            f64: bound(Precision::F64),
            f32: bound(Precision::F32),
        };
        Some((function.name(), program.counts(), rounding))
    };
    let functions = each(usize::MAX, Function::ALL, of_function);
    let mut operations = BTreeMap::new();
    let mut rounding_bound = BTreeMap::new();
    for (name, counts, rounding) in functions.into_iter().flatten() {
        operations.insert(name, counts);
        rounding_bound.insert(name, rounding);
    }
    let (numeric_rank, rank_check) = numeric_rank(model);
    Inspection {
        robot: tree.robot.clone(),
        hash: tree.hash.clone(),
        support: tree.links[tree.support].name.clone(),
        mass_kg: tree.mass,
        links: tree.links.len(),
        dof: model.dof(),
        bodies: chain.bodies.len(),
        full_params: chain.full_params,
        base_params: base.params.len(),
        rank: Rank {
            xyz: base.params.len(),
            cop: base.rank_cop,
        },
        numeric_rank,
        rank_check,
        joints: tree.dofs.iter().map(|dof| dof.joint.clone()).collect(),
        chain: bodies(model),
        parameters: base
            .params
            .iter()
            .map(|param| Parameter {
                name: param.name.clone(),
                cad: param.cad,
                unit: match param.column {
                    Column::Prismatic { .. } => "1",
                    Column::Axis { .. } => "m",
                },
            })
            .collect(),
        unobservable: base.unobservable.clone(),
        snaps: tree.snaps.clone(),
        notes: notes(model),
        operations,
        rounding_bound,
    }
}

/// What is odd about the URDF and its support, and what feet can be used for where they are many:
/// a sentence each.
pub fn notes(model: &Model) -> Vec<String> {
    let notes = model.tree.notes.iter().cloned();
    notes.chain(on_many_feet(&model.tree.feet)).collect()
}

fn bodies(model: &Model) -> Vec<Body> {
    let chain = &model.chain;
    let orientations = chain.orientation_products().into_iter();
    let body = |((i, body), orientation): ((usize, &sesc_model::chain::Body), String)| Body {
        body: body.name.clone(),
        joint: body.joint.clone(),
        parent: body.parent.map(|p| chain.bodies[p].name.clone()),
        rotation: chain.own_rotation(i),
        orientation,
        r: body.r(),
        s: body.s,
        mass_kg: body.mass,
        links: body
            .links
            .iter()
            .map(|&l| model.tree.links[l].name.clone())
            .collect(),
    };
    let all = chain.bodies.iter().enumerate().zip(orientations);
    all.map(body).collect()
}
