//! The choice of binary points: sizes from the analysis of ranges, then proof that all fits.

use super::analysis::ranges;
use super::fixed::{
    FEWEST_OF_ANGLES, Formats, MOST, Overflow, Quantity, Unfit, capacity, fitting, unit,
};
use super::{Arithmetic, Input, Precision};
use crate::expr::{Expr, Id};
use crate::program::Program;

impl Formats {
    /// Choose binary points for `program` on inputs in the given ranges.
    ///
    /// # Errors
    /// When a quantity may be 2^31 or more, an angle 2^15 rad or more, or when
    /// the program divides or raises to powers.
    pub fn choose(program: &Program, inputs: &[Vec<Input>]) -> Result<Formats, Unfit> {
        let fits = |expr| !matches!(expr, Expr::Div(..) | Expr::Pow(..));
        if !program.nodes.iter().all(|node| fits(node.expr)) {
            return Err(Unfit::Operation);
        }
        // Sizes with errors like f32's first; then what fits is proven.
        let like_floats = Arithmetic::Float {
            precision: Precision::F32,
            largest_angle: f64::INFINITY,
        };
        let rough = ranges(program, inputs, like_floats);
        let largest = |array: &[Input]| array.iter().map(Input::size).fold(0.0, f64::max);
        // A little room for the rounding of what is passed in.
        let array = |array: &Vec<Input>| fitting(largest(array) * (1.0 + unit(30)));
        let mut formats = Formats {
            nodes: Vec::with_capacity(program.nodes.len()),
            sizes: Vec::new(),
            arrays: inputs.iter().map(array).collect(),
            output: MOST,
        };
        formats.join_sines(program);
        for (array, inputs) in program.inputs.iter().zip(inputs) {
            if let Some(index) = inputs.iter().position(|x| fitting(x.size()) < 0) {
                let argument = array.argument;
                return Err(Unfit::Overflow(Overflow {
                    quantity: Quantity::Input { argument, index },
                    size: inputs[index].size(),
                    angle: false,
                }));
            }
        }
        for (id, node) in program.iter() {
            let bits = match node.expr {
                Expr::Const(x) => fitting(libm::fabs(x)),
                Expr::Add(..) | Expr::Sub(..) | Expr::Mul(..) | Expr::Max(..) => {
                    fitting(rough[id.index()].size()).min(formats.most(program, node.expr))
                }
                other => formats.most(program, other),
            };
            if bits < 0 {
                return Err(overflow(program, id, rough[id.index()].size()));
            }
            formats.nodes.push(bits);
        }
        for (_, node) in program.iter() {
            if let Expr::Sin(a) | Expr::Cos(a) = node.expr
                && formats.of(a) < FEWEST_OF_ANGLES
            {
                let size = rough[a.index()].size();
                let (quantity, angle) = (quantity(program, a), true);
                return Err(Unfit::Overflow(Overflow {
                    quantity,
                    size,
                    angle,
                }));
            }
        }
        // Ranges hold errors, and errors depend on the formats: prove that all fits.
        for _ in 0..=MOST {
            let ranges = ranges(program, inputs, Arithmetic::Fixed(&formats));
            let sizes: Vec<f64> = ranges.iter().map(|range| range.size()).collect();
            let size = |id: Id| sizes[id.index()];
            let tight = |id: &Id| size(*id) > capacity(formats.of(*id));
            let tight: Vec<Id> = program.iter().map(|(id, _)| id).filter(tight).collect();
            if tight.is_empty() {
                formats.output = formats.coarsest_output(program);
                formats.sizes = sizes;
                return Ok(formats);
            }
            for id in tight {
                if formats.of(id) <= 0 || !size(id).is_finite() {
                    return Err(overflow(program, id, size(id)));
                }
                formats.nodes[id.index()] -= 1;
                if let Expr::Input { argument, .. } = program.expr(id) {
                    let bits = &mut formats.arrays[program.slot(argument)];
                    *bits = (*bits).min(formats.nodes[id.index()]);
                }
            }
            formats.settle(program);
        }
        let id = program.outputs.first().copied().unwrap_or(Id(0));
        Err(overflow(program, id, f64::INFINITY))
    }
}

fn overflow(program: &Program, id: Id, size: f64) -> Unfit {
    Unfit::Overflow(Overflow {
        quantity: quantity(program, id),
        size,
        angle: false,
    })
}

/// What a message calls node `id`.
fn quantity(program: &Program, id: Id) -> Quantity {
    match (program.expr(id), &program.nodes[id.index()].name) {
        (Expr::Input { argument, index }, _) => Quantity::Input {
            argument,
            index: index as usize,
        },
        (_, Some(name)) => Quantity::Named(name.clone()),
        _ => {
            let before = |section: &&(usize, String)| section.0 <= id.index();
            match program.sections.iter().rev().find(before) {
                Some((_, title)) => Quantity::Step(title.clone()),
                None => Quantity::Intermediate,
            }
        }
    }
}
