//! What effects need to know of the robot and the log.

use super::{Catalog, Effect};
use crate::inertia::GRAVITY;
use crate::measurement::{ROUNDS, foot};
use crate::robot::Robot;

/// Lever arms reach this far beyond what is known of a link, as a part of the
/// robot's own reach.
const ROOM: f64 = 0.25;

/// The joint, link or foot cell that an effect acts on.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Target {
    /// The whole robot, or its sensor.
    Whole,
    /// Index among the independent joints.
    Joint(usize),
    /// All revolute joints alike.
    AllJoints,
    /// Two joints.
    Joints(usize, usize),
    /// Index among [`crate::tree::Tree::links`].
    Link(usize),
    /// Foot cell, from 0.
    Cell(usize),
    /// One of a few ways, by name.
    Way(&'static str),
}

impl Target {
    /// Name of [`Target::AllJoints`] in reports and model files.
    pub const ALL_JOINTS: &str = "all";

    /// The revolute joints that it means.
    pub fn revolute(&self, robot: &Robot) -> Vec<usize> {
        let dofs = &robot.tree.dofs;
        match *self {
            Target::Joint(joint) => vec![joint],
            Target::AllJoints => (0..dofs.len()).filter(|&j| !dofs[j].prismatic).collect(),
            _ => Vec::new(),
        }
    }
}

/// The robot, what its log offers, and the effects that may act on them.
#[derive(Debug, Clone)]
pub struct EffectContext<'m> {
    /// The robot on its support link.
    pub robot: &'m Robot,
    /// Positions of the foot cells, m, support frame.
    pub cells: Vec<[f64; 2]>,
    /// Whether the log has times.
    pub times: bool,
    /// Whether readings are compared with the ZMP, so that loads are accelerated with their
    /// links.
    pub moving: bool,
    /// Whether effects are fitted to a log, and that has times: further columns are no inputs of
    /// fits.
    pub(super) fitted: Option<bool>,
    /// Rounds in which joints give way.
    pub rounds: usize,
    /// The effects that are known.
    pub catalog: Catalog,
    /// A link of each body, the heaviest: loads on others of the same body
    /// cannot be told from loads on it.
    links: Vec<usize>,
    reach: f64,
}

impl<'m> EffectContext<'m> {
    /// The robot with the foot cells (m, support frame) and times of a log, and
    /// the effects that may act on it.
    pub fn new(
        robot: &'m Robot,
        cells: &[[f64; 2]],
        times: bool,
        catalog: Catalog,
    ) -> EffectContext<'m> {
        let tree = &robot.tree;
        let heaviest = |body: &crate::chain::Body| {
            let mut links = body.links.clone();
            links.sort_by(|&a, &b| tree.links[b].mass.total_cmp(&tree.links[a].mass));
            links.first().copied()
        };
        EffectContext {
            robot,
            cells: cells.to_vec(),
            times,
            moving: false,
            fitted: None,
            rounds: ROUNDS,
            catalog,
            links: robot.chain.bodies.iter().filter_map(heaviest).collect(),
            reach: robot.reach(),
        }
    }

    /// The same where effects are fitted to a log, which may have times.
    pub fn fitted(mut self, timed: bool) -> EffectContext<'m> {
        self.fitted = Some(timed);
        self
    }

    /// A link of each body.
    pub fn links(&self) -> Vec<Target> {
        self.links.iter().map(|&link| Target::Link(link)).collect()
    }

    /// Every independent joint.
    pub fn joints(&self) -> Vec<Target> {
        (0..self.robot.dof()).map(Target::Joint).collect()
    }

    /// All revolute joints alike, and each of them.
    pub fn all_and_each_revolute(&self) -> Vec<Target> {
        let each = self.revolute().into_iter().map(Target::Joint);
        [Target::AllJoints].into_iter().chain(each).collect()
    }

    /// Every independent revolute joint.
    pub fn revolute(&self) -> Vec<usize> {
        Target::AllJoints.revolute(self.robot)
    }

    /// Every cell whose place is known.
    pub fn cell_targets(&self) -> Vec<Target> {
        match foot::rectangle(&self.cells).is_some() {
            true => (0..self.cells.len()).map(Target::Cell).collect(),
            false => Vec::new(),
        }
    }

    /// The first for a revolute joint, the second for a prismatic one.
    pub fn by_kind<T>(&self, target: &Target, revolute: T, prismatic: T) -> T {
        match target {
            Target::Joint(j) if self.robot.tree.dofs[*j].prismatic => prismatic,
            _ => revolute,
        }
    }

    /// Height of the CoM in the posture of zeros, at least a tenth of the reach, m.
    pub fn height(&self) -> f64 {
        self.robot.cad_height().max(0.1 * self.reach)
    }

    /// Mass of the robot, kg.
    pub fn mass(&self) -> f64 {
        self.robot.tree.mass
    }

    /// Its weight, N.
    pub fn weight(&self) -> f64 {
        self.mass() * GRAVITY
    }

    /// Mass of the body that `link` is part of, kg: what can be missing from it.
    pub fn mass_of(&self, link: usize) -> f64 {
        match &self.robot.chain.places[link] {
            Some(place) => self.robot.chain.bodies[place.body].mass,
            None => 0.0,
        }
    }

    /// How far from the link's origin a load can sit, m.
    pub fn lever_of(&self, link: usize) -> f64 {
        let links = &self.robot.tree.links;
        links[link].com.norm() + ROOM * self.reach
    }

    /// The target of `effect` that is called `name`; any link of a body will do.
    pub fn target_named(&self, effect: &dyn Effect, name: &str) -> Option<Target> {
        let targets = effect.targets(self);
        let known = targets.iter().find(|target| self.name_of(target) == name);
        let known = known.cloned().or_else(|| {
            // A swap has two names, in either order.
            let (a, b) = name.split_once(',')?;
            let reversed = format!("{},{}", b.trim(), a.trim());
            let found = targets
                .iter()
                .find(|target| self.name_of(target) == reversed);
            found.cloned()
        });
        let of_links = targets.iter().any(|t| matches!(t, Target::Link(_)));
        known.or_else(|| {
            let mut links = self.robot.tree.links.iter();
            let link = links.position(|link| of_links && link.name == name)?;
            self.robot.chain.places[link].as_ref()?;
            Some(Target::Link(link))
        })
    }

    /// Name of a target in sentences: `l_knee`, `every joint`.
    pub fn spoken_name(&self, target: &Target) -> String {
        match target {
            Target::AllJoints => "every joint".to_string(),
            target => self.name_of(target),
        }
    }

    /// Name of a target in reports and model files.
    pub fn name_of(&self, target: &Target) -> String {
        let joint = |j: &usize| self.robot.tree.dofs[*j].joint.clone();
        match target {
            Target::Whole => "-".to_string(),
            Target::Joint(j) => joint(j),
            Target::AllJoints => Target::ALL_JOINTS.to_string(),
            Target::Joints(a, b) => format!("{},{}", joint(a), joint(b)),
            Target::Link(link) => self.robot.tree.links[*link].name.clone(),
            Target::Cell(k) => format!("fsr_{}", k + 1),
            Target::Way(way) => (*way).to_string(),
        }
    }
}
