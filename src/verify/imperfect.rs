//! The virtual robot of the reference with effects of a model, each by its name.
//!
//! The reference knows what each name does to a robot and shares no code with the effects of
//! the model: of those it is told name, place and values.

use sesc_model::Robot;
use sesc_model::effects::{Instance, Target};
use sesc_reference::{ErrorKind, Place, World};

use crate::Error;

/// `world` with an effect of `robot` in it; `values` in the order of its parameters.
///
/// # Errors
/// When the reference has no such effect, or refuses its size.
pub fn with_effect(
    world: World,
    robot: &Robot,
    instance: &Instance,
    values: &[f64],
) -> Result<World, Error> {
    let name = instance.effect.id().name();
    let known = place(robot, &instance.target).map(|place| world.named(name, place, values));
    match known {
        Some(Ok(world)) => Ok(world),
        Some(Err(refused)) if refused.kind() != ErrorKind::UnknownImperfection => {
            Err(refused.into())
        }
        None | Some(Err(_)) => Err(Error::Usage(format!(
            "the virtual robot has no effect `{name}` to compare with; verify the model without it"
        ))),
    }
}

/// A target as the reference names it.
fn place<'a>(robot: &'a Robot, target: &Target) -> Option<Place<'a>> {
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
    use sesc_model::effects::{
        Catalog, Effect, EffectContext, EffectId, Measured, Stage, instances,
    };
    use sesc_model::{Snapping, urdf};

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
