//! A robot on its support, as the commands use it.

use std::path::Path;

use sesc_model::urdf::{self, Description};
use sesc_model::{Error as ModelError, Model, ModelFile, Snapping};

use crate::Error;

/// A URDF that was read, and the text it was read from.
#[derive(Debug)]
pub struct Robot {
    pub description: Description,
    text: String,
}

impl Robot {
    /// Read a URDF file.
    pub fn read(path: &Path) -> Result<Robot, Error> {
        let description = urdf::read(path).map_err(ModelError::from)?;
        let text = std::fs::read_to_string(path)
            .map_err(|source| Error::read(path.display().to_string(), source))?;
        Ok(Robot { description, text })
    }

    /// Parse the text of a URDF; `file` names it in messages.
    pub fn parse(text: &str, file: &str) -> Result<Robot, Error> {
        let description = urdf::parse(text, file).map_err(ModelError::from)?;
        Ok(Robot {
            description,
            text: text.to_string(),
        })
    }

    /// The URDF as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The symbolic model on `support`, with identified parameters if given.
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

/// The independent reference of a robot on a support link, for tests.
#[cfg(test)]
pub(crate) fn reference(robot: &Robot, support: &str) -> sesc_reference::Reference {
    let read = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
    sesc_reference::Reference::new(&read, support).unwrap()
}
