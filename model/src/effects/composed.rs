//! Effects that are made of a site and a function.
//!
//! ```text
//! site += f(variables; parameters)        φ_j, p_x, tilt_x, f_k, or the mass of a link
//! ```
//!
//! The function is a [`Formula`]. Outside of the range that a log had of a variable the function
//! keeps the value that it has at the range's end.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::remedy::digits;
use super::{
    Effect, EffectContext, EffectId, Measured, Parameter, Reason, Stage, Target, Unit, cells,
};
use crate::expr::Id;
use crate::formula::{Formula, Variable};
use crate::robot::Robot;

/// Where an effect adds something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Site {
    /// The position of a joint, rad or m.
    Joint,
    /// The reading along an axis, m.
    Sensor,
    /// The slope of the ground along an axis, rad.
    Ground,
    /// A mass on a link, kg.
    Load,
    /// The load of a foot cell, N.
    Cell,
}

impl Site {
    /// All of them.
    pub const ALL: [Site; 5] = [
        Site::Joint,
        Site::Sensor,
        Site::Ground,
        Site::Load,
        Site::Cell,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Site::Joint => "joint",
            Site::Sensor => "sensor",
            Site::Ground => "ground",
            Site::Load => "load",
            Site::Cell => "cell",
        }
    }

    /// What is added there, and in which unit.
    pub fn adds(self) -> &'static str {
        match self {
            Site::Joint => "position, rad or m",
            Site::Sensor => "reading along x or y, m",
            Site::Ground => "slope along x or y, rad",
            Site::Load => "mass at the link's CoM or `at`, kg",
            Site::Cell => "load of a cell, N",
        }
    }

    /// The variables of its functions, as text.
    pub fn variables(self) -> &'static str {
        match self {
            Site::Joint => {
                "q, tau, approach, q[\"joint\"], tau[\"joint\"], approach[\"joint\"], t, \
                 column[\"name\"]"
            }
            Site::Sensor | Site::Cell | Site::Ground => {
                "x, y, approach[\"joint\"], t, column[\"name\"]"
            }
            Site::Load => "approach[\"joint\"], t, column[\"name\"]",
        }
    }

    fn takes(self, variable: &Variable) -> bool {
        match variable {
            Variable::Time | Variable::Column(_) | Variable::Approach(Some(_)) => true,
            // What errs with a joint is the joint, and the reading follows.
            Variable::Approach(None) | Variable::Moment(_) | Variable::Position(_) => {
                self == Site::Joint
            }
            Variable::Reading(_) => matches!(self, Site::Sensor | Site::Cell | Site::Ground),
        }
    }
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Symbol of the unit of what has none.
pub const NO_UNIT: &str = "1";

/// What a parameter of a formula may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Its name in the formula.
    pub name: String,
    /// An ordinary size.
    pub typical: f64,
    /// Symbol of its unit; `1` where it has none.
    pub unit: String,
    /// Least and largest value.
    pub limits: [f64; 2],
}

/// What an effect is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Name in reports and model files.
    pub name: String,
    /// Where it adds something.
    pub site: Site,
    /// What it adds.
    pub function: Formula,
    /// Its parameters, those of the formula.
    pub constants: Vec<Constant>,
    /// Joints, links, cells or axes that it may act on; none for all.
    pub targets: Vec<String>,
    /// Where a load is in the frame of its link, m; at the link's CoM without it.
    pub at: Option<[f64; 3]>,
    /// Ends of what the log had of a variable, outside of which the function stays as it is there.
    pub range: BTreeMap<String, [f64; 2]>,
    /// Means of columns in the log, for code that does not take them.
    pub columns: BTreeMap<String, f64>,
    /// What it is, in words, of `{target}`.
    pub sentence: Option<String>,
}

impl Definition {
    /// What is wrong with it and what to do, by key.
    ///
    /// # Errors
    /// A name, parameter, variable or range that cannot be.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let spelled = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(spelled) {
            let reason = "give up to 64 letters, digits and `_`";
            return Err(("name", reason.to_string()));
        }
        if super::Catalog::standard().named(&self.name).is_some() {
            let reason = "an effect of sesc has this name; give another";
            return Err(("name", reason.to_string()));
        }
        for variable in self.function.variables() {
            if !self.site.takes(&variable) {
                return Err((
                    "adds",
                    format!(
                        "`{variable}` is no variable of site {}; it has {}",
                        self.site,
                        self.site.variables()
                    ),
                ));
            }
        }
        let used = self.function.parameters();
        for name in &used {
            if self.constants.iter().all(|known| known.name != *name) {
                let reason = format!(
                    "`{name}` of the formula is missing; add {name} = {{ typical = … }}, or is it \
                     a variable? There are {}",
                    self.site.variables()
                );
                return Err(("parameters", reason));
            }
        }
        for constant in &self.constants {
            let name = &constant.name;
            if !used.contains(name) {
                let reason = format!("`{name}` is not in the formula; remove it");
                return Err(("parameters", reason));
            }
            let [least, most] = constant.limits;
            let size = constant.typical;
            if !(size.is_finite() && size != 0.0) {
                let reason = format!("`{name}`: typical is a number other than 0");
                return Err(("parameters", reason));
            }
            if least.is_nan() || most.is_nan() || least > most {
                let reason = format!("`{name}`: min is above max; exchange them");
                return Err(("parameters", reason));
            }
            if constant.unit.is_empty() || constant.unit.chars().count() > 16 {
                let reason =
                    format!("`{name}`: give a unit of up to 16 characters, \"1\" for none");
                return Err(("parameters", reason));
            }
        }
        let variables = self.function.variables();
        let known = |text: &String| variables.iter().any(|v| v.to_string() == *text);
        if let Some(stray) = self.range.keys().find(|text| !known(text)) {
            return Err(("range", format!("`{stray}` is no variable of the function")));
        }
        let finite = |[least, most]: &[f64; 2]| least <= most && (most - least).is_finite();
        if !self.range.values().all(finite) {
            return Err(("range", "give [least, largest], finite".to_string()));
        }
        if self.at.is_some_and(|at| at.iter().any(|x| !x.is_finite())) {
            return Err(("at", "give [x, y, z], m".to_string()));
        }
        match self.columns.values().all(|mean| mean.is_finite()) {
            true => Ok(()),
            false => Err(("columns", "give the mean of each, a number".to_string())),
        }
    }
}

/// An effect that is made of a site and a function.
#[derive(Debug)]
pub struct Composed {
    definition: Definition,
    id: EffectId,
    parameters: &'static [Parameter],
    /// Where fits start.
    starts: Vec<Vec<f64>>,
}

/// What was made so far: an effect lives as long as the program, and equal ones are one.
static MADE: Mutex<BTreeMap<String, &'static Composed>> = Mutex::new(BTreeMap::new());

impl Composed {
    /// The effect of a definition.
    ///
    /// # Errors
    /// As of [`Definition::check`].
    pub fn new(definition: Definition) -> Result<&'static Composed, (&'static str, String)> {
        definition.check()?;
        let key = format!("{definition:?}");
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = made.get(&key) {
            return Ok(known);
        }
        let kept = |text: &str| -> &'static str { Box::leak(text.to_string().into_boxed_str()) };
        let function = definition.function.to_string();
        let parameters = definition.constants.iter().map(|constant| Parameter {
            unit: Unit::by_symbol(kept(&constant.unit)),
            ..Parameter::new(kept(&constant.name), libm::fabs(constant.typical))
        });
        let parameters: Vec<Parameter> = parameters.collect();
        let composed = Composed {
            id: EffectId::of(kept(&definition.name), kept(&function)),
            parameters: Box::leak(parameters.into_boxed_slice()),
            starts: starts(&definition),
            definition,
        };
        let composed: &'static Composed = Box::leak(Box::new(composed));
        made.insert(key, composed);
        Ok(composed)
    }

    /// What it is made of.
    pub fn definition(&self) -> &Definition {
        &self.definition
    }

    /// What its function depends on beside q and r, at a target.
    pub fn beyond(&self, robot: &Robot, target: &Target) -> Vec<Variable> {
        let variables = self.definition.function.variables().into_iter();
        let of_site = |variable| match (variable, target) {
            (Variable::Approach(None), Target::Joint(joint)) => {
                Variable::Approach(Some(robot.tree.dofs[*joint].joint.clone()))
            }
            (variable, _) => variable,
        };
        let beyond = |variable: &Variable| {
            matches!(
                variable,
                Variable::Time | Variable::Approach(_) | Variable::Column(_)
            )
        };
        variables.map(of_site).filter(beyond).collect()
    }

    /// Range and mean of a variable that is beside q and r.
    pub fn about(&self, variable: &Variable) -> ([f64; 2], f64) {
        let text = variable.to_string();
        let own = Variable::Approach(None).to_string();
        let range = self.definition.range.get(&text);
        match variable {
            Variable::Approach(_) => {
                let range = range.or_else(|| self.definition.range.get(&own));
                (range.copied().unwrap_or([-1.0, 1.0]), 0.0)
            }
            Variable::Column(name) => {
                let mean = self.definition.columns.get(name).copied().unwrap_or(0.0);
                let wide = MOST_OF_COLUMNS.max(libm::fabs(mean));
                (range.copied().unwrap_or([mean - wide, mean + wide]), mean)
            }
            _ => (range.copied().unwrap_or([0.0, MOST_SECONDS]), 0.0),
        }
    }

    /// The function's value at those of its parameters, in their order, and of its variables.
    pub fn value(&self, values: &[f64], variable: &dyn Fn(&Variable) -> f64) -> f64 {
        let held = |own: &Variable| {
            let value = variable(own);
            match self.definition.range.get(&own.to_string()) {
                Some([least, most]) => value.max(*least).min(*most),
                None => value,
            }
        };
        let parameter = |name: &str| {
            let mut own = self.parameters.iter().zip(values);
            let own = own.find(|(parameter, _)| parameter.name == name);
            own.map_or(0.0, |(_, value)| *value)
        };
        self.definition.function.value(&held, &parameter)
    }

    /// The function at a target.
    fn function(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) -> Id {
        let joints = &at.robot().tree.dofs;
        let own = match *target {
            Target::Joint(joint) => Some(joint),
            _ => None,
        };
        let place = |name: &Option<String>| match name {
            Some(name) => joints.iter().position(|dof| dof.joint == *name),
            None => own,
        };
        let mut variables = HashMap::new();
        for variable in self.definition.function.variables() {
            let mut value = match &variable {
                Variable::Reading(axis) => at.reading[*axis],
                Variable::Position(name) => match place(name) {
                    Some(joint) => at.wired[joint],
                    None => at.constant(0.0),
                },
                Variable::Moment(name) => match place(name) {
                    Some(joint) => at.moment(joint),
                    None => at.constant(0.0),
                },
                Variable::Approach(name) => {
                    let joint = place(name).map(|joint| joints[joint].joint.clone());
                    at.beyond(&Variable::Approach(joint), 0.0)
                }
                variable => at.beyond(variable, self.about(variable).1),
            };
            if let Some([least, most]) = self.definition.range.get(&variable.to_string()) {
                let (least, most) = (at.constant(*least), at.constant(*most));
                let above = at.g().max(value, least);
                value = at.g().min(above, most);
            }
            variables.insert(variable, value);
        }
        let names = self.parameters.iter().map(|parameter| parameter.name);
        let pairs = names.zip(unknowns.iter().copied());
        let formula = &self.definition.function;
        formula.write(at.g(), &variables, &pairs.collect())
    }

    /// The joints beside `own` that its function names, each once.
    pub fn other_joints(&self, own: &str) -> Vec<String> {
        let mut all = Vec::new();
        for variable in self.definition.function.variables() {
            let name = match variable {
                Variable::Position(name) | Variable::Moment(name) | Variable::Approach(name) => {
                    name
                }
                _ => None,
            };
            all.extend(name.filter(|name| name != own && !all.contains(name)));
        }
        all
    }

    /// Whether its function is one of the reading, of the CoP where the ground is soft.
    pub fn reads_cop(&self) -> bool {
        let variables = self.definition.function.variables();
        variables.iter().any(|v| matches!(v, Variable::Reading(_)))
    }

    /// Whether a robot has all that it names.
    fn is_of(&self, robot: &Robot) -> bool {
        let mut variables = self.definition.function.variables().into_iter();
        variables.all(|variable| match variable {
            Variable::Position(Some(name))
            | Variable::Moment(Some(name))
            | Variable::Approach(Some(name)) => robot.tree.dofs.iter().any(|dof| dof.joint == name),
            _ => true,
        })
    }
}

/// Bounds hold up to this time, s, and this far from the mean of a column, where no range is known.
const MOST_SECONDS: f64 = 1e5;
const MOST_OF_COLUMNS: f64 = 1e3;

/// Parts of their range where parameters of a nonlinear function start.
const GRID: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Where fits start: at no effect where every parameter is a size of it. Other parameters have no
/// slope there: then with an ordinary effect, others along their range, one after the other.
fn starts(definition: &Definition) -> Vec<Vec<f64>> {
    let Definition {
        function,
        constants,
        ..
    } = definition;
    let value = |values: &[f64], at: f64| {
        let parameter = |name: &str| {
            let place = constants.iter().position(|constant| constant.name == name);
            place.map_or(0.0, |place| values[place])
        };
        function.value(&|_| at, &parameter)
    };
    let typical: Vec<f64> = constants.iter().map(|c| c.typical).collect();
    let without = |k: usize| {
        let mut values = typical.clone();
        values[k] = 0.0;
        // Where no variable is special, nor all of them too small or too large to count.
        let sizes = [-2, -1, 0, 1, 2, 3].map(|k| libm::pow(10.0, f64::from(k)));
        let mut at = sizes.into_iter().flat_map(|size| [0.7 * size, -0.6 * size]);
        at.all(|at| value(&values, at) == 0.0)
    };
    let sizes: Vec<bool> = (0..constants.len()).map(without).collect();
    if sizes.iter().all(|is_size| *is_size) {
        return vec![vec![0.0; sizes.len()]];
    }
    let mut all = vec![typical.clone()];
    for (k, constant) in constants.iter().enumerate() {
        let [least, most] = constant.limits;
        if !sizes[k] && (most - least).is_finite() {
            all.extend(GRID.map(|part| {
                let mut start = typical.clone();
                start[k] = least + part * (most - least);
                start
            }));
        }
    }
    all
}

impl Effect for Composed {
    fn id(&self) -> EffectId {
        self.id
    }

    fn stage(&self) -> Stage {
        let variables = self.definition.function.variables();
        let of_moments = variables.iter().any(|v| matches!(v, Variable::Moment(_)));
        match self.definition.site {
            Site::Joint if of_moments => Stage::Bends,
            Site::Joint => Stage::Joints,
            Site::Sensor => Stage::Offset,
            Site::Ground => Stage::Ground,
            Site::Load => Stage::Loads,
            Site::Cell => Stage::Cells,
        }
    }

    fn composed(&self) -> Option<&Composed> {
        Some(self)
    }

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        let robot = context.robot;
        if !self.is_of(robot) {
            return Vec::new();
        }
        let mut all = match self.definition.site {
            Site::Joint => context.joints(),
            Site::Sensor | Site::Ground => ["x", "y"].map(Target::Way).to_vec(),
            Site::Load => context.links(),
            Site::Cell => context.cell_targets(),
        };
        let named = &self.definition.targets;
        if !named.is_empty() {
            if self.definition.site == Site::Load {
                let links = robot.tree.links.iter().enumerate();
                all = links
                    .filter(|(link, _)| robot.chain.places[*link].is_some())
                    .map(|(link, _)| Target::Link(link))
                    .collect();
            }
            all.retain(|target| named.contains(&context.name_of(target)));
        }
        // What fits are not told of.
        if let Some(timed) = context.fitted {
            let is_told = |variable: &Variable| match variable {
                Variable::Time => timed,
                Variable::Column(_) => false,
                _ => true,
            };
            all.retain(|target| self.beyond(robot, target).iter().all(is_told));
        }
        all
    }

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        self.parameters
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        match &self.definition.sentence {
            Some(sentence) => sentence.replace("{target}", name),
            None => format!("{} of {name}", self.id.name().replace('_', " ")),
        }
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let name = context.spoken_name(target);
        let (what, function) = match self.definition.site {
            Site::Joint => ("true position", "reading + "),
            Site::Sensor => ("reading along", "true CoP + "),
            Site::Ground => ("slope along", ""),
            Site::Load => ("mass on", "CAD + "),
            Site::Cell => ("reading of", "true load + "),
        };
        let of = if self.definition.site == Site::Joint {
            " of"
        } else {
            ""
        };
        let values = self.parameters.iter().zip(values);
        let values: Vec<String> = values
            .map(|(parameter, value)| format!("{} = {}", parameter.name, digits(*value, 4)))
            .collect();
        format!(
            "{what}{of} {name} = {function}{} with {}; the model file holds it",
            self.definition.function,
            values.join(", ")
        )
    }

    fn starts(&self, _: &EffectContext, _: &Target) -> Vec<Vec<f64>> {
        self.starts.clone()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let axis = usize::from(*target == Target::Way("y"));
        match (self.definition.site, target) {
            (Site::Joint, Target::Joint(joint)) => {
                let by = self.function(target, at, unknowns);
                match self.stage() {
                    Stage::Bends => at.give_way(*joint, by),
                    _ => at.shift_joint(*joint, by),
                }
            }
            (Site::Sensor, _) => {
                let by = self.function(target, at, unknowns);
                at.reading[axis] = at.add(at.reading[axis], by);
            }
            (Site::Ground, _) if self.reads_cop() => {
                at.reading = at.free_cop();
                let by = self.function(target, at, unknowns);
                at.soften(axis, by);
            }
            (Site::Ground, _) => {
                let by = self.function(target, at, unknowns);
                at.tilt[axis] = at.add(at.tilt[axis], by);
            }
            (Site::Load, Target::Link(link)) => {
                let mass = self.function(target, at, unknowns);
                let robot = at.constant(at.robot().tree.mass);
                let both = at.add(robot, mass);
                let share = at.div(mass, both);
                let own = at.robot().tree.links[*link].com;
                let place = self.definition.at.unwrap_or([own.x, own.y, own.z]);
                let moment = place.map(|x| {
                    let x = at.constant(x);
                    at.mul(share, x)
                });
                at.load(*link, share, moment);
            }
            (Site::Cell, _) => {
                let force = self.function(target, at, unknowns);
                let weight = at.constant(at.robot().tree.mass * crate::inertia::GRAVITY);
                let share = at.div(force, weight);
                cells::read_with(target, at, |at, load| at.add(load, share));
            }
            (Site::Joint | Site::Load, _) => {}
        }
    }

    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if self.reads_cop() || self.definition.site != Site::Sensor {
            return at.solve(|at| self.rewrite(target, at, unknowns));
        }
        let axis = usize::from(*target == Target::Way("y"));
        let by = self.function(target, at, unknowns);
        at.reading[axis] = at.sub(at.reading[axis], by);
    }

    fn load_share(&self, unknowns: &[f64], robot_kg: f64) -> f64 {
        if self.definition.site != Site::Load {
            return 0.0;
        }
        let mass = self.value(unknowns, &|variable| self.about(variable).1);
        mass / (robot_kg + mass)
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let constants = self.definition.constants.iter().zip(unknowns);
        let beyond = constants.map(|(constant, x)| {
            let [least, most] = constant.limits;
            (least - x).max(x - most).max(0.0) / (0.1 * libm::fabs(constant.typical))
        });
        beyond.collect()
    }

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let mut constants = self.definition.constants.iter().zip(values);
        let outside = |(constant, x): (&Constant, &f64)| {
            let [least, most] = constant.limits;
            *x < least || *x > most
        };
        let reason = "a parameter is outside of what its own file allows";
        constants.any(outside).then_some(reason)
    }

    fn caution(&self) -> Option<&'static str> {
        self.definition.function.has_corners().then_some(
            "Functions with corners (abs, sign, max, min): where one is at a corner, rounding can \
             choose the side. Bounds hold there too and are as large as the jump of sign, or of a \
             derivative at a corner; everywhere else the error is that of com.",
        )
    }
}
