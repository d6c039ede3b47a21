//! The robot of a model file with effects, as the virtual robot of the reference has it:
//! it bends itself and shares no code with the effects of the model.
//!
//! Every function is compared with the robot that has the effects acting on it: those of
//! the body for CoM, Jacobian and moments; wiring, offsets and scales for regressor rows;
//! all that one posture shows for the CoP. The model takes four rounds of the springs' fixed
//! point `φ' = φ + C τ(φ')`, and so does the virtual robot here; how far from rest both are
//! is measured, and is less than
//!
//! ```text
//! reach · s⁵        s = Σ weight · reach / stiffness, over at most three joints
//! ```
//!
//! Beside dead bands the virtual robot settles until it rests, and so much is allowed for.

use sesc_model::effects::{Catalog, Composed, EffectContext, Instance, Site, Stage, Target};
use sesc_model::formula::Variable;
use sesc_model::{Function, Model};
use sesc_reference::{ErrorKind, GRAVITY, Place, Reference, World};

use super::motion::{JointMotion, Truth};
use crate::Error;
use sesc_identify::robot::Robot;

/// Joints of the virtual robot that come to rest within 1e-13 rad, relative to its reach.
pub(super) const AT_REST: f64 = 4e-12;
/// Derivatives by central differences of fourth order, relative to its reach.
pub(super) const DIFFERENCES: f64 = 2e-9;
/// The step of those, rad or m.
const STEP: f64 = 1e-4;
/// What those leave in the ZMP, relative to the square of its reach.
const ACCELERATIONS: f64 = 1e-7;
/// What rounds of bending leave out of the CoM of a model that is read, m.
const MOST_LEFT_OUT_M: f64 = 1e-3;
/// Between the postures that joint accelerations are taken from, s.
const INTERVAL_S: f64 = 0.02;

/// What the functions of a model with effects must give.
pub(super) struct Bent {
    body: World,
    encoders: World,
    cop: World,
    /// Without effects of the sensor, and the corners of the cells, where a cell has one:
    /// no other CoP has a reading.
    on_cells: Option<(World, Vec<[f64; 2]>)>,
    /// Without dead bands, and half of their width by joint, rad.
    loose: (World, Vec<f64>),
    /// The robot with its loads, as joints stand.
    moving: Reference,
    /// Weight, N.
    weight: f64,
    /// The body at rest, where the others take as many rounds as the model.
    at_rest: Option<World>,
    /// What four rounds leave out at most, m.
    most_left_out: f64,
}

impl Bent {
    /// The robot with the effects of `model`; none where it has none.
    ///
    /// # Errors
    /// When the reference cannot read the URDF, or refuses an effect's size.
    pub(super) fn new(robot: &Robot, model: &Model) -> Result<Option<Bent>, Error> {
        if model.effects.is_empty() {
            return Ok(None);
        }
        let read = super::read(robot, model)?;
        let support = &model.tree.links[model.tree.support].name;
        let records = Record::all(model);
        let has = |is: &dyn Fn(&Record) -> bool| records.iter().any(is);
        let in_rounds = has(&|r| r.yields()) && !has(&|r| r.is_dead_band());
        let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
        let of_cells = has(&|r| r.instance.effect.stage() == Stage::Cells);
        let world = |acts: &dyn Fn(&Record) -> bool, cells: &[[f64; 2]]| {
            let mut world = World::new(&read, support)?;
            if !cells.is_empty() {
                world = world.cells(cells)?;
            }
            let mut acting = records.iter().filter(|record| acts(record));
            acting.try_fold(world, |world, record| {
                with_effect(world, model, record.instance, &record.values)
            })
        };
        let rounded = |world: World| match in_rounds {
            true => world.after_rounds(model.rounds),
            false => world,
        };
        let of_body = |r: &Record| r.instance.effect.changes_body(&r.instance.target);
        let of_sensor = |r: &Record| r.instance.effect.is_sensor_effect(&r.instance.target);
        let body = world(&of_body, &[])?;
        let mass: f64 = body.robot().links().iter().map(|link| link.mass_kg).sum();
        let weight = mass * GRAVITY;
        Ok(Some(Bent {
            encoders: world(
                &|r| r.instance.effect.changes_regressor(&r.instance.target),
                &[],
            )?,
            cop: rounded(world(&|_| true, if of_cells { cells } else { &[] })?),
            on_cells: match of_cells {
                true => Some((rounded(world(&|r| !of_sensor(r), &[])?), cells.to_vec())),
                false => None,
            },
            loose: (
                world(&|r| of_body(r) && !r.is_dead_band(), &[])?,
                by_joint(model, &records, |r| {
                    r.is_dead_band().then(|| 0.5 * r.values[0])
                }),
            ),
            most_left_out: left_out(model, &records, weight),
            weight,
            at_rest: in_rounds.then(|| body.clone()),
            moving: Reference::new(body.robot(), support)?,
            body: rounded(body),
        }))
    }

    /// Whether gravity says at which end of its band every loose joint rests, wherever in
    /// their bands the others are: in between it depends on how it got there. And whether
    /// cells with effects carry the robot.
    pub(super) fn is_decided(&self, q: &[f64]) -> bool {
        let between = |(world, cells): &(World, Vec<[f64; 2]>)| {
            let cop = world.cop(q);
            (0..2).all(|axis| {
                let all = cells.iter().map(|cell| cell[axis]);
                let low = all.clone().fold(f64::INFINITY, f64::min);
                (low..=all.fold(f64::NEG_INFINITY, f64::max)).contains(&cop[axis])
            })
        };
        if !self.on_cells.as_ref().is_none_or(between) {
            return false;
        }
        let (world, half) = &self.loose;
        let moments = world.joint_moments(q);
        let mut swing = vec![0.0; q.len()];
        for i in (0..q.len()).filter(|&i| half[i] > 0.0) {
            let mut moved = q.to_vec();
            moved[i] += half[i];
            let with = world.joint_moments(&moved);
            for (swing, (with, moment)) in swing.iter_mut().zip(with.iter().zip(&moments)) {
                *swing += 1.5 * (with - moment).abs();
            }
        }
        (0..q.len()).all(|j| half[j] == 0.0 || moments[j].abs() > swing[j])
    }

    /// What springs may still move in comparisons, m.
    pub(super) fn allowed_for_springs(&self) -> f64 {
        match self.at_rest {
            Some(_) => 0.0,
            None => self.most_left_out,
        }
    }

    /// How far the CoM of a posture is from where it rests, m, and how far it may be.
    pub(super) fn left_out(&self, q: &[f64]) -> (f64, f64) {
        let measured = self.at_rest.as_ref();
        let measured = measured.map(|at_rest| (at_rest.com(q) - self.body.com(q)).norm());
        (measured.unwrap_or(self.most_left_out), self.most_left_out)
    }

    /// What it says of one posture.
    pub(super) fn truth(&self, q: &[f64], joints: &JointMotion, differentiate: bool) -> Truth {
        let mut truth = Truth {
            com: self.body.com(q).into(),
            rows: self.encoders.com(q).into(),
            cop: self.cop.cop(q),
            ..Truth::default()
        };
        if differentiate {
            truth.zmp = self.zmp(q, joints);
            truth.com_jacobian = jacobian(q, |q| self.body.com(q).into());
            truth.cop_jacobian = jacobian(q, |q| self.cop.cop(q));
            // Moments of gravity over the weight, m.
            let moments = self.body.joint_moments(q).into_iter();
            truth.moments = moments.map(|moment| moment / self.weight).collect();
        }
        truth
    }

    /// The ZMP as encoders move: of where the joints are then, by differences of sixth order.
    /// None where a dead band changes sides on the way.
    fn zmp(&self, q: &[f64], joints: &JointMotion) -> Option<[f64; 2]> {
        let path = |k: i32| {
            let t = f64::from(k) * INTERVAL_S;
            let moved = q.iter().zip(joints.rates.iter().zip(&joints.accelerations));
            let at: Vec<f64> = moved.map(|(q, (v, a))| q + t * (v + 0.5 * t * a)).collect();
            self.is_decided(&at).then(|| self.body.true_posture(&at))
        };
        let path: Vec<Vec<f64>> = (-3..=3).map(path).collect::<Option<_>>()?;
        let by = |weights: [f64; 7], scale: f64| -> Vec<f64> {
            let of = |j: usize| path.iter().zip(weights).map(|(q, w)| w * q[j]).sum::<f64>();
            (0..q.len()).map(|j| of(j) / scale).collect()
        };
        let rates = by([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0], 60.0 * INTERVAL_S);
        let gains = by(
            [2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0],
            180.0 * INTERVAL_S * INTERVAL_S,
        );
        Some(self.moving.zmp(&path[3], &rates, &gains).into())
    }
}

/// ∂`of`/∂q, row-major.
fn jacobian<const N: usize>(q: &[f64], of: impl Fn(&[f64]) -> [f64; N]) -> Vec<f64> {
    let mut jacobian = vec![0.0; N * q.len()];
    for j in 0..q.len() {
        let at = |step: f64| {
            let mut moved = q.to_vec();
            moved[j] += step;
            of(&moved)
        };
        let [ahead, back] = [at(STEP), at(-STEP)];
        let [far_ahead, far_back] = [at(2.0 * STEP), at(-2.0 * STEP)];
        for axis in 0..N {
            let near = 8.0 * (ahead[axis] - back[axis]);
            let far = far_ahead[axis] - far_back[axis];
            jacobian[axis * q.len() + j] = (near - far) / (12.0 * STEP);
        }
    }
    jacobian
}

/// An effect of a model file with its values in the order of its parameters.
struct Record<'m> {
    values: Vec<f64>,
    instance: &'m Instance,
}

impl Record<'_> {
    /// Those that one posture shows.
    fn all(model: &Model) -> Vec<Record<'_>> {
        let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
        let context = EffectContext::new(model, cells, false, Catalog::standard());
        let records = model.file.iter().flat_map(|file| &file.effects);
        let pairs = records.zip(model.effects.iter().map(|(instance, _)| instance));
        let pairs = pairs.filter(|(_, instance)| instance.effect.is_static());
        pairs
            .map(|(record, instance)| {
                let parameters = instance.effect.parameters(&context, &instance.target);
                let value = |name: &str| record.parameters.get(name).map_or(0.0, |x| x.value);
                let values = parameters.iter().map(|p| value(p.name)).collect();
                Record { values, instance }
            })
            .collect()
    }

    fn is_spring(&self) -> bool {
        self.instance.effect.is_spring()
    }

    /// Whether its joint follows moments, in rounds.
    fn yields(&self) -> bool {
        self.instance.effect.stage() == Stage::Bends && !self.is_dead_band()
    }

    fn is_dead_band(&self) -> bool {
        self.instance.effect.dead_band().is_some()
    }
}

/// What effects add up to at each joint.
fn by_joint(model: &Model, records: &[Record], of: fn(&Record) -> Option<f64>) -> Vec<f64> {
    let mut sums = vec![0.0; model.dof()];
    for record in records {
        for j in record.instance.target.revolute(model) {
            sums[j] += of(record).unwrap_or(0.0);
        }
    }
    sums
}

/// What four rounds of the springs' fixed point leave out, m.
fn left_out(model: &Model, records: &[Record], weight: f64) -> f64 {
    let compliance = |r: &Record| r.is_spring().then(|| 1.0 / r.values[0]);
    let compliance = by_joint(model, records, compliance).into_iter();
    let most = compliance.clone().fold(0.0, f64::max);
    let softness = weight * model.reach() * compliance.sum::<f64>().min(3.0 * most);
    let springs = model.reach() * softness.powi(model.rounds as i32 + 1);
    // Functions of moments: what a model file may leave out.
    let of_functions = |r: &Record| r.yields() && !r.is_spring();
    match records.iter().any(of_functions) {
        true => springs + MOST_LEFT_OUT_M,
        false => springs,
    }
}

/// How far beyond rounding the model may be from the virtual robot, in the unit of
/// `function`: joints at rest, differences, and what the springs leave out.
pub(super) fn beyond_rounding(model: &Model, function: Function, left_out: f64) -> f64 {
    let reach = model.reach().max(1.0);
    match function {
        Function::Com => AT_REST * reach + left_out,
        Function::Cop => (AT_REST * reach + left_out) * magnified(model),
        Function::GravityMoments => AT_REST * reach + 5.0 * left_out,
        // What is left of a deflection changes with each of its five factors.
        Function::ComJacobian | Function::ComVelocity => DIFFERENCES * reach + 10.0 * left_out,
        Function::CopJacobian => (DIFFERENCES * reach + 10.0 * left_out) * magnified(model),
        // Joints at rest within 1e-13 rad, over the square of the interval, on the ground.
        Function::Zmp => ACCELERATIONS * reach * reach + 100.0 * left_out,
        Function::Regressor | Function::RegressorCop | Function::RegressorFull => AT_REST * reach,
        Function::CorrectCop => 0.0,
    }
}

/// How many times further a reading moves than its CoP; 1 without effects of the sensor.
pub(super) fn magnified(model: &Model) -> f64 {
    let at = |x: f64, y: f64| model.reading_of([x, y]);
    let (here, step) = (at(0.0, 0.0), 1e-3);
    let moved = |there: [f64; 2]| (there[0] - here[0]).hypot(there[1] - here[1]) / step;
    moved(at(step, 0.0)).max(moved(at(0.0, step)))
}

// The virtual robot of the reference with effects of a model, each by its name.
//
// The reference knows what each name does to a robot and shares no code with the effects of
// the model: of those it is told name, place and values.

/// `world` with an effect of `robot` in it; `values` in the order of its parameters.
///
/// # Errors
/// When the reference has no such effect, or refuses its size.
pub fn with_effect(
    world: World,
    robot: &sesc_model::Robot,
    instance: &Instance,
    values: &[f64],
) -> Result<World, Error> {
    if let Some(composed) = instance.effect.composed()
        && let Some(bent) = with_function(&world, robot, composed, instance, values)
    {
        return Ok(bent?);
    }
    let name = instance.effect.id().name();
    let known = place(robot, &instance.target).map(|place| world.named(name, place, values));
    let unknown =
        |refused: &sesc_reference::Error| refused.kind() == ErrorKind::UnknownImperfection;
    match known {
        Some(known) if !known.as_ref().is_err_and(unknown) => Ok(known?),
        _ => Err(Error::Usage(format!(
            "the virtual robot has no effect `{name}` to compare with; verify the model without it"
        ))),
    }
}

/// The same of an effect that is made of a site and a function: the virtual robot is told the
/// function's values. None where it has no such site.
fn with_function(
    world: &World,
    robot: &sesc_model::Robot,
    composed: &'static Composed,
    instance: &Instance,
    values: &[f64],
) -> Option<Result<World, sesc_reference::Error>> {
    let (world, values) = (world.clone(), values.to_vec());
    let usual = |variable: &Variable| composed.about(variable).1;
    let constant = composed.value(&values, &usual);
    let of_parameters = values.clone();
    let of_reading = move |reading: [f64; 2]| {
        composed.value(&of_parameters, &|variable| match variable {
            Variable::Reading(axis) => reading[*axis],
            other => usual(other),
        })
    };
    let axis = usize::from(instance.target == Target::Way("y"));
    let (definition, target) = (composed.definition(), &instance.target);
    Some(match (definition.site, target) {
        (Site::Joint, &Target::Joint(own)) => {
            let names = robot.tree.dofs.iter().map(|dof| dof.joint.clone());
            let names: Vec<String> = names.collect();
            let joint = names[own].clone();
            let place = move |name: &Option<String>| match name {
                Some(name) => names.iter().position(|known| known == name).unwrap_or(0),
                None => own,
            };
            world.joint_function(&joint, move |q, moments| {
                composed.value(&values, &|variable| match variable {
                    Variable::Position(name) => q[place(name)],
                    Variable::Moment(name) => moments[place(name)],
                    other => usual(other),
                })
            })
        }
        (Site::Sensor, _) => Ok(world.sensor_function(axis, of_reading)),
        (Site::Ground, _) if composed.reads_cop() => Ok(world.ground_function(axis, of_reading)),
        (Site::Ground, _) => Ok(world.ground_error(axis, constant)),
        (Site::Load, Target::Link(link)) => {
            let link = &robot.tree.links[*link];
            world.payload(&link.name, constant, definition.at.unwrap_or(link.com()))
        }
        (Site::Cell, Target::Cell(cell)) if !composed.reads_cop() => {
            world.cell_offset(cell + 1, constant)
        }
        _ => return None,
    })
}

/// A target as the reference names it.
fn place<'a>(robot: &'a sesc_model::Robot, target: &Target) -> Option<Place<'a>> {
    let joint = |j: usize| robot.tree.dofs[j].joint.as_str();
    Some(match *target {
        Target::Whole => Place::Whole,
        Target::Joint(j) => Place::Joint(joint(j)),
        Target::AllJoints => Place::AllJoints,
        Target::Joints(a, b) => Place::Joints(joint(a), joint(b)),
        Target::Link(link) => Place::Link(&robot.tree.links[link].name),
        Target::Cell(k) => Place::Cell(k + 1),
        Target::Way(way) => Place::Way(way),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sesc_model::effects::{Effect, EffectId, Measured, instances};
    use sesc_model::{Robot, Snapping, urdf};

    /// A foot and two links on joints of both kinds.
    const URDF: &str = "<robot name='r'><link name='foot'/>\
        <link name='shank'><inertial><mass value='1'/></inertial></link>\
        <link name='thigh'><inertial><mass value='1'/></inertial></link>\
        <link name='trunk'><inertial><mass value='1'/></inertial></link>\
        <joint name='ankle' type='revolute'><parent link='foot'/><child link='shank'/>\
        <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
        <joint name='knee' type='revolute'><parent link='shank'/><child link='thigh'/>\
        <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
        <joint name='lift' type='prismatic'><parent link='thigh'/><child link='trunk'/>\
        <axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/></joint></robot>";
    const CELLS: [[f64; 2]; 4] = [[0.1, 0.05], [0.1, -0.05], [-0.1, -0.05], [-0.1, 0.05]];

    fn stand() -> (Robot, World) {
        let read = urdf::parse(URDF, "r.urdf").unwrap();
        let robot = Robot::new(&read, "foot", Snapping::default()).unwrap();
        let read = sesc_reference::Robot::from_urdf(URDF).unwrap();
        let world = World::new(&read, "foot").unwrap().cells(&CELLS).unwrap();
        (robot, world)
    }

    #[test]
    fn the_virtual_robot_knows_every_effect_at_every_target() {
        let (robot, world) = stand();
        let context = EffectContext::new(&robot, &CELLS, true, Catalog::standard());
        for instance in instances(&context) {
            let parameters = instance.effect.parameters(&context, &instance.target);
            let values = vec![0.01; parameters.len()];
            let bent = with_effect(world.clone(), &robot, &instance, &values);
            assert!(bent.is_ok(), "{instance:?}: {}", bent.unwrap_err());
        }
    }

    /// An effect that nobody has taught the reference.
    struct Outside;

    impl Effect for Outside {
        fn id(&self) -> EffectId {
            EffectId::new("outside")
        }
        fn stage(&self) -> Stage {
            Stage::Joints
        }
        fn targets(&self, context: &EffectContext) -> Vec<Target> {
            context.joints()
        }
        fn phrase(&self, _: &Target, name: &str) -> String {
            format!("something of {name}")
        }
        fn rewrite(&self, _: &Target, _: &mut Measured, _: &[sesc_model::expr::Id]) {}
    }

    #[test]
    fn an_effect_that_the_reference_does_not_know_is_refused_by_name() {
        let (robot, world) = stand();
        let outside = Instance {
            effect: &Outside,
            target: Target::Joint(0),
        };
        let refused = with_effect(world, &robot, &outside, &[]).unwrap_err();
        let expected = "the virtual robot has no effect `outside` to compare with; verify the \
                        model without it";
        assert_eq!(refused.to_string(), expected);
    }
}
