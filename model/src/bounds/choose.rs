//! The choice of binary points: sizes from the analysis of ranges, then proof that all fits.

use super::analysis::Analysis;
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
        let mut analysis = Analysis::new(program, inputs, like_floats);
        analysis.run();
        let largest = |array: &[Input]| {
            let size = |x: &Input| libm::fabs(x.lower).max(libm::fabs(x.upper));
            array.iter().map(size).fold(0.0, f64::max)
        };
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
            let size = |x: &Input| libm::fabs(x.lower).max(libm::fabs(x.upper));
            if let Some(k) = inputs.iter().position(|x| fitting(size(x)) < 0) {
                let overflow = Overflow {
                    quantity: Quantity::Input {
                        argument: array.argument,
                        index: k,
                    },
                    size: size(&inputs[k]),
                    angle: false,
                };
                return Err(overflow.into());
            }
        }
        for (id, node) in program.iter() {
            let bits = match node.expr {
                Expr::Const(x) => fitting(libm::fabs(x)),
                Expr::Input { argument, .. } => formats.arrays[program.slot(argument)],
                Expr::Sin(_) | Expr::Cos(_) | Expr::Clamp(_) => MOST,
                Expr::Neg(a) => formats.of(a),
                // A product or sum may not have more bits than what it is made of.
                Expr::Mul(a, b) => {
                    fitting(analysis.range(id).size()).min(formats.of(a) + formats.of(b))
                }
                // Constants take the format of the sum, which must hold them too.
                Expr::Add(a, b) | Expr::Sub(a, b) | Expr::Max(a, b) => {
                    let least = formats.of(a).min(formats.of(b));
                    fitting(analysis.range(id).size()).min(least)
                }
                Expr::Div(..) | Expr::Pow(..) => {
                    unreachable!("programs with these were refused")
                }
            };
            if bits < 0 {
                return Err(overflow(program, id, analysis.range(id).size()).into());
            }
            formats.nodes.push(bits);
        }
        formats.check_angles(program, &analysis)?;
        // Ranges hold errors, and errors depend on the formats: prove that all fits.
        for _ in 0..=MOST {
            let mut analysis = Analysis::new(program, inputs, Arithmetic::Fixed(&formats));
            analysis.run();
            let ids = || program.iter().map(|(id, _)| id);
            let sizes: Vec<f64> = ids().map(|id| analysis.range(id).size()).collect();
            let size = |id: Id| sizes[id.index()];
            let tight = |id: &Id| size(*id) > capacity(formats.of(*id));
            let tight: Vec<Id> = ids().filter(tight).collect();
            if tight.is_empty() {
                formats.output = formats.coarsest_output(program);
                formats.sizes = sizes;
                return Ok(formats);
            }
            for id in tight {
                if formats.of(id) <= 0 || !size(id).is_finite() {
                    return Err(overflow(program, id, size(id)).into());
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
        Err(overflow(program, id, f64::INFINITY).into())
    }

    fn check_angles(&self, program: &Program, analysis: &Analysis) -> Result<(), Overflow> {
        for (_, node) in program.iter() {
            if let Expr::Sin(a) | Expr::Cos(a) = node.expr
                && self.of(a) < FEWEST_OF_ANGLES
            {
                return Err(Overflow {
                    angle: true,
                    ..overflow(program, a, analysis.range(a).size())
                });
            }
        }
        Ok(())
    }
}

fn overflow(program: &Program, id: Id, size: f64) -> Overflow {
    let quantity = match (program.expr(id), &program.nodes[id.index()].name) {
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
    };
    Overflow {
        quantity,
        size,
        angle: false,
    }
}
