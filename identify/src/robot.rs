//! A robot, and how it stands: what most calls start from.
//!
//! The program `xacro` makes URDFs of its own language. It evaluates Python that stands in the file, so it runs only for a path that the caller of
//! the program typed, never for one that a file or folder gave ([`Robot::read`]).

use std::collections::VecDeque;
use std::io::{self, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use nalgebra::DMatrix;
use sesc_model::text::listed;
use sesc_model::tree::{feet, on_many_feet, support_rank};
use sesc_model::urdf::{self, Description};
use sesc_model::{Error as ModelError, Model, ModelFile, Snapping};

use crate::{Error, Message, Setting, message};

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
        // Both feet of a robot, twice.
        kept.truncate(4);
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
        let file = path.display().to_string();
        let is_xacro = asked || path.extension().is_some_and(|end| end == "xacro");
        let expanded = match is_xacro.then(|| expand(path)).transpose() {
            Err(XacroFailed::NotInstalled) if !asked => None,
            Err(failed) => return Err(Error::log(file, None, failed.to_string())),
            Ok(expanded) => expanded,
        };
        Ok(Typed {
            expanded: expanded.is_some(),
            robot: match expanded {
                Some(text) => Robot::parse(&text, &file)?,
                None => Robot::read(path)?,
            },
        })
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
        let has = format!(" (the robot has {})", listed(names, 12));
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

/// A robot, the link it stands on, and the parameters it is taken to have.
#[derive(Clone)]
#[non_exhaustive]
pub struct Stance {
    /// The robot.
    pub robot: Arc<Robot>,
    /// The link on the ground, where the caller says it; it wins over logs and parameters.
    pub support: Option<String>,
    /// Whether decimals of right angles are made exact.
    pub snapping: Snapping,
    /// Identified parameters and effects; CAD unless given.
    pub parameters: Option<Arc<ModelFile>>,
}

impl Stance {
    /// A robot as its URDF describes it, on a support that is yet to be named.
    ///
    /// ```
    /// use sesc_identify::robot::Robot;
    /// use sesc_identify::robot::Stance;
    /// # let urdf = "<robot name='rod'><link name='foot'/>\
    /// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
    /// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    /// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
    /// #     </robot>";
    /// let stance = Stance::new(Robot::parse(urdf, "rod.urdf")?);
    /// assert_eq!(stance.clone().on("foot").model()?.support(), "foot");
    /// // Without a support the error names the links to choose from.
    /// assert!(stance.model().unwrap_err().to_string().contains("foot"));
    /// # Ok::<(), sesc_identify::Error>(())
    /// ```
    pub fn new(robot: impl Into<Arc<Robot>>) -> Stance {
        Stance {
            robot: robot.into(),
            support: None,
            snapping: Snapping::default(),
            parameters: None,
        }
    }

    /// The same robot on `support`.
    pub fn on(self, support: impl Into<String>) -> Stance {
        Stance {
            support: Some(support.into()),
            ..self
        }
    }

    /// The same robot with identified parameters.
    ///
    /// # Errors
    /// Parameters of another robot.
    pub fn with_parameters(self, file: ModelFile) -> Result<Stance, Error> {
        let description = &self.robot.description;
        file.check_robot(&description.hash, &description.file)?;
        Ok(Stance {
            parameters: Some(Arc::new(file)),
            ..self
        })
    }

    /// The link on the ground: the caller's, else that of a log, else that of the parameters.
    ///
    /// # Errors
    /// Where none of them says it.
    pub fn support<'a>(&'a self, logged: Option<&'a str>) -> Result<&'a str, Error> {
        let parameters = self.parameters.as_deref();
        let known = self.support.as_deref().or(logged);
        let known = known.or(parameters.map(|file| file.support.as_str()));
        known.ok_or_else(|| self.robot.no_support(&[]))
    }

    /// The model on its support.
    ///
    /// # Errors
    /// As [`support`](Self::support); a support that is none of the robot's links.
    pub fn model(&self) -> Result<Model, Error> {
        self.model_on(self.support(None)?)
    }

    /// The model on `support`, whatever the caller said.
    ///
    /// # Errors
    /// A support that is none of the robot's links.
    pub(crate) fn model_on(&self, support: &str) -> Result<Model, Error> {
        self.robot
            .model(support, self.snapping, self.parameters.as_deref())
    }
}

/// Longest URDF that it may make, bytes: as much as a URDF may have.
const LONGEST: u64 = 64 << 20;

/// Why there is no URDF.
#[derive(Debug, thiserror::Error)]
enum XacroFailed {
    #[error("the program `xacro` is not installed; install it, or give the URDF that it makes")]
    NotInstalled,
    #[error("standard input is not expanded by xacro; give the path of a file")]
    StandardInput,
    #[error("xacro does not run: {0}")]
    NotRun(io::Error),
    #[error("xacro does not expand it: {0}")]
    Refused(String),
    #[error("xacro makes more than {} MiB of it", LONGEST >> 20)]
    TooLong,
    #[error("xacro did not end within {} s", .0.as_secs_f64())]
    TooSlow(Duration),
    #[error("xacro expands it to what is no UTF-8")]
    NoText,
}

/// What `xacro` makes of a file.
fn expand(path: &Path) -> Result<String, XacroFailed> {
    if path.as_os_str() == "-" {
        return Err(XacroFailed::StandardInput);
    }
    // `./-x` is no option, and an absolute path stays as it is.
    let mut command = Command::new("xacro");
    command.arg(Path::new(".").join(path));
    run_xacro(&mut command, Duration::from_secs(60))
}

fn run_xacro(command: &mut Command, patience: Duration) -> Result<String, XacroFailed> {
    command.stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => XacroFailed::NotInstalled,
        _ => XacroFailed::NotRun(error),
    })?;
    let output = output(&mut child, patience);
    if output.is_err() {
        // It may have ended by itself.
        let _ = child.kill();
        let _ = child.wait();
    }
    output
}

fn output(child: &mut Child, patience: Duration) -> Result<String, XacroFailed> {
    let end = Instant::now() + patience;
    let text = received(child.stdout.take(), LONGEST + 1);
    let messages = received(child.stderr.take(), 64 << 10);
    let left = || end.saturating_duration_since(Instant::now());
    let late = |_| XacroFailed::TooSlow(patience);
    let text = text.recv_timeout(left()).map_err(late)?;
    if text.len() as u64 > LONGEST {
        return Err(XacroFailed::TooLong);
    }
    let messages = messages.recv_timeout(left()).map_err(late)?;
    let status = loop {
        match child.try_wait().map_err(XacroFailed::NotRun)? {
            Some(status) => break status,
            None if left().is_zero() => return Err(XacroFailed::TooSlow(patience)),
            None => thread::sleep(Duration::from_millis(2)),
        }
    };
    if !status.success() {
        let messages = String::from_utf8_lossy(&messages);
        let last = messages.trim_end().lines().next_back().unwrap_or_default();
        return Err(XacroFailed::Refused(last.escape_debug().to_string()));
    }
    String::from_utf8(text).map_err(|_| XacroFailed::NoText)
}

/// The first `most` bytes of a stream, read by a thread of its own: a program of the program may
/// hold the stream open for ever.
fn received(stream: Option<impl Read + Send + 'static>, most: u64) -> Receiver<Vec<u8>> {
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(stream) = stream {
            let mut begin = stream.take(most);
            // What broke off is judged by the exit code.
            let _ = begin.read_to_end(&mut bytes);
            let _ = send.send(bytes);
            // So that the program is not held up by its messages.
            let _ = io::copy(&mut begin.into_inner(), &mut io::sink());
        }
    });
    receive
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

    #[cfg(unix)]
    #[cfg(unix)]
    fn shell(script: &str, patience: Duration) -> Result<String, String> {
        let run = run_xacro(Command::new("/bin/sh").args(["-c", script]), patience);
        run.map_err(|failed| failed.to_string())
    }

    #[cfg(unix)]
    #[test]
    fn a_program_is_bounded_in_time_and_output() {
        let minute = Duration::from_secs(60);
        let moment = Duration::from_millis(200);
        assert_eq!(shell("cat; echo text", minute).unwrap(), "text\n");
        let endless = "while :; do echo 0123456789012345678901234567890123456789; done";
        let endless = shell(endless, minute);
        assert_eq!(endless.unwrap_err(), "xacro makes more than 64 MiB of it");
        let chatty =
            "i=0; while [ $i -lt 20000 ]; do echo warning >&2; i=$((i+1)); done; echo text";
        assert_eq!(shell(chatty, minute).unwrap(), "text\n");
        for slow in [
            "sleep 20",
            "echo text; exec >&- 2>&-; sleep 20",
            "sleep 20 & echo text",
        ] {
            let said = shell(slow, moment).unwrap_err();
            assert_eq!(said, "xacro did not end within 0.2 s", "{slow}");
        }
        let failed = shell(
            "echo first >&2; echo 'no\u{1b}[1m such' >&2; exit 2",
            minute,
        );
        let expected = "xacro does not expand it: no\\u{1b}[1m such";
        assert_eq!(failed.unwrap_err(), expected);
        let latin = shell("printf '\\377'", minute);
        assert!(latin.unwrap_err().contains("UTF-8"));
    }
}
