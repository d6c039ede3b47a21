//! Robots for the tests, their postures, and programs run on tape.

use std::path::Path;

use sesc_identify::evaluate::PORTABLE;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::effects::{self, Catalog, EffectContext, Instance, PostureContext};
use sesc_model::program::Program;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Model, Snapping};
use sesc_reference::World;

use super::hidden::Hidden;
use sesc_test_support::command::ROOT;

/// A robot on its support, and its bent twin's blueprint.
pub(crate) struct Stand {
    pub name: &'static str,
    pub model: Model,
    described: sesc_reference::Robot,
    pub cells: Vec<[f64; 2]>,
}

/// With skewed axes and mimics; with prismatic joints; and the one of the paper.
pub(crate) const ROBOTS: [(&str, &str); 3] = [
    ("op2", "r_sole"),
    ("skew_humanoid", "left_sole"),
    ("lift_base", "base_link"),
];

pub(crate) fn urdf(robot: &str) -> String {
    format!("{ROOT}/robots/{robot}/{robot}.urdf")
}

impl Stand {
    pub(crate) fn new(name: &'static str, support: &str) -> Stand {
        let robot = Robot::read(Path::new(&urdf(name))).unwrap();
        // The reference takes decimals literally.
        let model = robot.model(support, Snapping::Off, None).unwrap();
        let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
        let at_rest = World::new(&described, support).unwrap();
        let [x, y] = at_rest.cop(&vec![0.0; model.dof()]);
        // Around the CoP of the posture of zeros; postures off them are not used.
        let (a, b) = (0.4 * model.cad_height(), 0.3 * model.cad_height());
        let cells = [[a, b], [a, -b], [-a, -b], [-a, b]].map(|[dx, dy]| [x + dx, y + dy]);
        Stand {
            name,
            model,
            described,
            cells: cells.to_vec(),
        }
    }

    pub(crate) fn all() -> Vec<Stand> {
        ROBOTS
            .map(|(robot, support)| Stand::new(robot, support))
            .into()
    }

    pub(crate) fn context(&self) -> EffectContext<'_> {
        EffectContext::new(&self.model, &self.cells, true, Catalog::standard())
    }

    /// An effect by its name and that of its target.
    pub(crate) fn hidden(&self, effect: &str, target: &str, values: &[f64]) -> Hidden {
        Hidden::named(&self.context(), effect, target, values)
    }

    /// The robot as its URDF says.
    pub(crate) fn world(&self) -> World {
        let tree = &self.model.tree;
        World::new(&self.described, &tree.links[tree.support].name).unwrap()
    }

    /// Random postures, joints within ±`range` rad.
    pub(crate) fn postures(&self, count: usize, range: f64, seed: u64) -> Vec<Vec<f64>> {
        let mut simulator = Simulator::new(&self.model.tree.dofs, Some(range), seed);
        (0..count).map(|_| simulator.posture()).collect()
    }

    /// Random postures in which the foot stands on all cells.
    pub(crate) fn postures_inside(&self, count: usize) -> Vec<Vec<f64>> {
        let mut simulator = Simulator::new(&self.model.tree.dofs, Some(0.35), 41);
        let world = self.world();
        let postures = std::iter::repeat_with(|| simulator.posture());
        let inside = postures.filter(|q| self.is_inside(world.cop(q)));
        inside.take(count).collect()
    }

    /// Whether a CoP lies between the cells.
    pub(crate) fn is_inside(&self, cop: [f64; 2]) -> bool {
        (0..2).all(|axis| {
            let all = self.cells.iter().map(|cell| cell[axis]);
            let low = all.clone().fold(f64::INFINITY, f64::min);
            let high = all.fold(f64::NEG_INFINITY, f64::max);
            (low..=high).contains(&cop[axis])
        })
    }

    /// The reading and its slopes in each unknown, rows x and y.
    pub(crate) fn reading(&self, instances: &[Instance], params: &[f64]) -> Program {
        effects::reading(&self.context(), instances, params)
    }

    pub(crate) fn posture_context(&self) -> PostureContext {
        PostureContext::of(&self.model)
    }
}

/// What `program` makes of one posture, unknowns and posture context.
pub(crate) fn run(program: &Program, arrays: &[&[f64]]) -> Vec<f64> {
    let tape = Tape::new(program);
    let mut out = vec![0.0; tape.outputs()];
    let arguments: Vec<Values> = arrays.iter().map(|x| Values::Shared(x)).collect();
    tape.run(&arguments, 1, &mut out, PORTABLE);
    out
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
