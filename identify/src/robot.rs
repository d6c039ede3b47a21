//! A robot on its support, as the commands use it.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::DMatrix;
use sesc_model::text::listed;
use sesc_model::tree::{feet, on_many_feet, support_rank};
use sesc_model::urdf::{self, Description};
use sesc_model::{Error as ModelError, Model, ModelFile, Snapping};

use crate::xacro::{self, Failed};
use crate::{Error, Message, Setting, message};

/// Links named in a message.
const NAMED: usize = 12;
/// Factors that are kept: both feet of a robot, twice.
const FACTORS: usize = 4;

/// A robot as its URDF describes it.
#[derive(Debug)]
pub struct Robot {
    /// What the URDF says, and its text.
    pub description: Description,
    /// Factors of its regressor over ranges of its joints.
    pub(crate) over_range: Factors,
}

/// A robot that [`Robot::read_typed`] read.
#[derive(Debug)]
pub struct Typed {
    /// The robot.
    pub robot: Robot,
    /// Whether the program `xacro` was run over the file.
    pub expanded: bool,
}

/// Factors that all logs of a robot ask for, by what they are of; the last few are kept.
#[derive(Debug, Default)]
pub(crate) struct Factors(Mutex<VecDeque<(String, Arc<DMatrix<f64>>)>>);

impl Factors {
    /// What is kept under a name, or is made now.
    pub(crate) fn get(&self, name: &str, make: impl FnOnce() -> DMatrix<f64>) -> Arc<DMatrix<f64>> {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept().iter().find(|(own, _)| own == name).cloned();
        if let Some((_, factor)) = known {
            return factor;
        }
        // Nobody waits for another's: both make the same.
        let made = Arc::new(make());
        let mut kept = kept();
        kept.push_front((name.to_string(), Arc::clone(&made)));
        kept.truncate(FACTORS);
        made
    }
}

impl Robot {
    fn of(description: Description) -> Robot {
        Robot {
            description,
            over_range: Factors::default(),
        }
    }

    /// Read a URDF file, once: it may be a pipe; `-` is standard input. No program is started,
    /// whatever stands in the file.
    ///
    /// # Errors
    /// When the file cannot be read, or everything that is wrong with its text.
    pub fn read(path: &Path) -> Result<Robot, Error> {
        let description = urdf::read(path).map_err(ModelError::from)?;
        Ok(Robot::of(description))
    }

    /// Read a file whose path the caller of the program typed: `asked`, or where the path ends in
    /// `.xacro` and the program `xacro` is installed, what `xacro` makes of the file.
    ///
    /// `xacro` runs code that stands in the file. Take [`Robot::read`] for paths that come from
    /// folders, manifests or other files.
    ///
    /// # Errors
    /// When the file cannot be read or expanded, or everything that is wrong with its text.
    pub fn read_typed(path: &Path, asked: bool) -> Result<Typed, Error> {
        let read = |robot| Typed {
            robot,
            expanded: false,
        };
        if !asked && path.extension().is_none_or(|end| end != "xacro") {
            return Robot::read(path).map(read);
        }
        match xacro::expand(path) {
            Ok(text) => Ok(Typed {
                robot: Robot::parse(&text, &path.display().to_string())?,
                expanded: true,
            }),
            Err(Failed::NotInstalled) if !asked => Robot::read(path).map(read),
            Err(failed) => Err(Error::log(
                path.display().to_string(),
                None,
                failed.to_string(),
            )),
        }
    }

    /// Parse the text of a URDF; `file` names it in messages.
    ///
    /// ```
    /// use sesc_identify::robot::Robot;
    ///
    /// let broken = Robot::parse("<robot name='rod'><link name='foot'>", "rod.urdf");
    /// assert!(broken.unwrap_err().to_string().starts_with("rod.urdf"));
    /// ```
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    pub fn parse(text: &str, file: &str) -> Result<Robot, Error> {
        let description = urdf::parse(text, file).map_err(ModelError::from)?;
        Ok(Robot::of(description))
    }

    /// The URDF as it was read.
    pub fn text(&self) -> &str {
        &self.description.text
    }

    /// What is said where nobody names the link on the ground: soles and feet first, and what
    /// is odd about sidecars, which may have meant to name it; and what can be said of a robot
    /// on more feet than two.
    pub(crate) fn no_support(&self, odd: &[Message]) -> Error {
        self.missing_support(
            message!["no support link given; add ", Setting::Support],
            odd,
        )
    }

    /// The same of the logs of a fleet.
    pub(crate) fn no_support_of_fleet(&self, odd: &[Message]) -> Error {
        let what = "no support link given; name it for all logs, as `support` in the sidecar of \
                    the log, or in a column `support` of the manifest";
        self.missing_support(message![what], odd)
    }

    fn missing_support(&self, what: Message, odd: &[Message]) -> Error {
        let mut names: Vec<&str> = self.description.link_names().collect();
        names.sort_by_key(|name| support_rank(name));
        let has = format!(" (the robot has {})", listed(names, NAMED));
        let odd: String = odd.iter().map(|message| format!("; {message}")).collect();
        Error::request(what.and(has).and(odd).and(self.feet_note()))
    }

    /// What ends a message about the support of a robot with more than two feet; empty of others.
    pub(crate) fn feet_note(&self) -> String {
        let said = on_many_feet(&feet(&self.description));
        said.map_or(String::new(), |said| format!(". Note that {said}"))
    }

    /// The symbolic model on `support`, with identified parameters if given.
    ///
    /// # Errors
    /// When no link is called `support`, mass hangs on a planar or floating
    /// joint, or the model file belongs to another robot.
    pub fn model(
        &self,
        support: &str,
        snapping: Snapping,
        file: Option<&ModelFile>,
    ) -> Result<Model, Error> {
        let model = Model::new(&self.description, support, snapping)?;
        Ok(match file {
            Some(file) => model.with_file(file.clone())?,
            None => model,
        })
    }
}

/// # Errors
/// Where rows of `dof` joints stand on a link of the virtual base, which was named only by a row.
pub(crate) fn check_joints(model: &Model, dof: usize) -> Result<(), Error> {
    if model.dof() == dof {
        return Ok(());
    }
    let what = format!(
        "rows stand on `{}`, seen from which the robot has other joints ({} for {dof}): nothing \
         between it and the robot has mass; name the support of the whole log by ",
        model.support(),
        model.dof()
    );
    let end = " or `support` in the sidecar";
    Err(Error::request(message![what, Setting::Support, end]))
}

/// A leg that turns about a hip over its foot, for tests.
#[cfg(test)]
pub(crate) const ROD: &str = "<robot name='rod'><link name='foot'/>\
    <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
    <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
    </robot>";

/// The independent reference of a robot on a support link, for tests.
#[cfg(test)]
pub(crate) fn reference(robot: &Robot, support: &str) -> sesc_reference::Reference {
    let read = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
    sesc_reference::Reference::new(&read, support).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn soles_and_feet_are_offered_first() {
        let links = ["base", "l_foot", "head", "R_Sole"]
            .map(|l| format!("<link name='{l}'><inertial><mass value='1'/></inertial></link>"));
        let joint = |l| {
            format!(
                "<joint name='to_{l}' type='fixed'><parent link='base'/><child link='{l}'/></joint>"
            )
        };
        let (links, joints) = (
            links.concat(),
            ["l_foot", "head", "R_Sole"].map(joint).concat(),
        );
        let urdf = format!("<robot name='r'>{links}{joints}</robot>");
        let robot = Robot::parse(&urdf, "r.urdf").unwrap();
        let words = "(the robot has R_Sole, l_foot, base, head)";
        crate::tests::says(robot.no_support(&[]), &[words]);
    }
}
