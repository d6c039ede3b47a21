//! A robot, and how it stands: what most calls start from.

use std::sync::Arc;

use sesc_model::{Model, ModelFile, Snapping};

use crate::Error;
use crate::robot::Robot;

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
    /// use sesc_identify::stance::Stance;
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
    pub fn model_on(&self, support: &str) -> Result<Model, Error> {
        self.robot
            .model(support, self.snapping, self.parameters.as_deref())
    }
}
