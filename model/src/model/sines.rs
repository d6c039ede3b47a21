//! Functions of joint positions by way of their sines and cosines.
//!
//! ```text
//! f(q) = f_sc(sin q, cos q)
//! ```
//!
//! Where a robot has many joints, generated code computes all sines and cosines in a loop
//! and has the rest of each function once, for both ways to call it: half the text, and less
//! than half of the compiler's time (`docs/dev/performance.md`, "Before it runs"). Programs, and so
//! tape, bounds and counts, are of the same operations.

use std::collections::HashMap;

use crate::expr::{Argument, Expr, Id};
use crate::model::Model;
use crate::program::{Node, Program, rename};
use crate::robot::Robot;

/// Most joints of a robot whose functions write out sines and cosines one by one.
const MOST_WRITTEN_OUT: usize = 64;

impl Model {
    /// Whether functions of joint positions are those of sines and cosines, where these can
    /// be had.
    #[doc(hidden)]
    pub fn begins_with_sines(&self) -> bool {
        self.dof() > MOST_WRITTEN_OUT
    }
}

/// The program of a function of `sin q` and `cos q` as one of `q`.
pub(super) fn of_positions(program: Program, robot: &Robot) -> Program {
    let bodies = robot.chain.bodies.iter().zip(&robot.keys);
    let keys: HashMap<&str, &str> = bodies
        .filter_map(|(body, key)| Some((body.joint.as_deref()?, key.as_str())))
        .collect();
    let mut nodes: Vec<Node> = Vec::with_capacity(program.nodes.len());
    let mut to: Vec<Id> = Vec::with_capacity(program.nodes.len());
    // Where the position of a joint stands, once it is there.
    let mut positions: Vec<Option<Id>> = vec![None; robot.dof()];
    let mut starts = Vec::with_capacity(program.nodes.len() + 1);
    for node in program.nodes {
        starts.push(nodes.len());
        let mut push = |expr: Expr, name: Option<String>, uses: usize| {
            nodes.push(Node { expr, name, uses });
            Id(nodes.len() as u32 - 1)
        };
        let (argument, joint) = match node.expr {
            Expr::Input { argument, index } => (argument, index as usize),
            expr => {
                to.push(push(
                    rename(expr, |id| to[id.index()]),
                    node.name,
                    node.uses,
                ));
                continue;
            }
        };
        let turns = matches!(argument, Argument::Sines | Argument::Cosines)
            && !robot.tree.dofs[joint].prismatic;
        if !turns {
            // A prismatic joint passes its position where a revolute one passes its sine.
            let argument = match argument {
                Argument::Sines => Argument::Positions,
                other => other,
            };
            let index = joint as u32;
            to.push(push(Expr::Input { argument, index }, node.name, node.uses));
            continue;
        }
        let position = *positions[joint].get_or_insert_with(|| {
            let argument = Argument::Positions;
            let index = joint as u32;
            push(Expr::Input { argument, index }, None, 0)
        });
        let (expr, prefix) = match argument {
            Argument::Sines => (Expr::Sin(position), "sin"),
            _ => (Expr::Cos(position), "cos"),
        };
        let key = keys.get(robot.tree.dofs[joint].joint.as_str());
        let name = key.map(|key| format!("{prefix}_{key}"));
        to.push(push(expr, name, node.uses));
        nodes[position.index()].uses += 1;
    }
    starts.push(nodes.len());
    let at = |id: &Id| to[id.index()];
    let arrays = program.inputs.into_iter().filter_map(|mut array| {
        match array.argument {
            Argument::Sines => array.argument = Argument::Positions,
            Argument::Cosines => return None,
            _ => {}
        }
        Some(array)
    });
    let sections = program.sections.into_iter();
    let mut vectors = program.vectors;
    for vector in &mut vectors {
        vector.entries = vector.entries.iter().map(at).collect();
        vector.scale = vector.scale.as_ref().map(at);
    }
    let mut products = program.products;
    for product in &mut products {
        product.entry = at(&product.entry);
    }
    Program {
        inputs: arrays.collect(),
        shape: program.shape,
        nodes,
        outputs: program.outputs.iter().map(at).collect(),
        sections: sections.map(|(k, title)| (starts[k], title)).collect(),
        vectors,
        products,
        weights: program.weights.iter().map(at).collect(),
        least: program.least.iter().map(|(id, x)| (at(id), *x)).collect(),
    }
}
