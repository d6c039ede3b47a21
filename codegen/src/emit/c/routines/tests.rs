//! What a function with an effect is in fixed point: nothing.

use super::*;
use sesc_model::expr::{Argument, Graph, Id};
use sesc_model::program::{Array, Program, Shape};
use sesc_model::{Model, Snapping, urdf};

const LEG: &str = r#"<robot name="leg">
    <link name="foot"/>
    <link name="shin"><inertial><mass value="1"/><origin xyz="0 0 0.2"/></inertial></link>
    <joint name="ankle" type="revolute"><parent link="foot"/><child link="shin"/>
        <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"#;

/// Writes a function of the one joint of a robot, as an effect would rewrite it.
fn export(scalar: Scalar, build: impl Fn(&mut Graph, Id) -> Id) -> Result<(), Error> {
    let description = urdf::parse(LEG, "leg.urdf").unwrap();
    let model = Model::new(&description, "foot", Snapping::default()).unwrap();
    let mut g = Graph::default();
    let q = g.input(Argument::Positions, 0);
    let out = build(&mut g, q);
    let inputs = vec![Array::new(Argument::Positions, 1)];
    let program = Program::new(g, inputs, Shape::Vector(2), &[out, out]);
    let routine = Routine {
        function: Function::Cop,
        given: Given::Positions,
        baked: false,
        inputs: model.input_ranges(&program),
        program,
    };
    exported(&Facts::of(&model), scalar, &routine).map(|_| ())
}

#[test]
fn effects_that_fixed_point_cannot_hold_are_refused_by_name() {
    type Build = fn(&mut Graph, Id) -> Id;
    let builds: [Build; 2] = [
        |g, q| {
            let two = g.constant(2.0);
            let weight = g.add(q, two);
            g.div(q, weight)
        },
        |g, q| {
            let exponent = g.constant(1.5);
            let square = g.mul(q, q);
            g.pow(square, exponent)
        },
    ];
    for build in builds {
        let error = export(Scalar::Fixed32, build).unwrap_err();
        assert_eq!(
            error.to_string(),
            "fixed32: cop divides or raises to powers, which cannot be had in fixed \
             point; effects that divide or raise to powers (those of cells) need f32 or f64"
        );
        assert!(export(Scalar::F32, build).is_ok());
    }
}
