//! What a robot weighs with all that it carries, by the total force on its support.

use serde::{Deserialize, Serialize};

/// An estimate with its standard deviation, in the unit that its name ends in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Quantity {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// Weighed mass, and that of the robot's description.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Weight {
    /// Total force over gravity, kg: mean of the log, with the tolerance of a force plate.
    pub mass_kg: Quantity,
    /// Mass of the URDF, kg.
    pub urdf_kg: f64,
}

impl Weight {
    /// Weighed over described mass, less one, and the deviation of that.
    pub(crate) fn excess(&self) -> [f64; 2] {
        let Quantity { value, std } = self.mass_kg;
        [value / self.urdf_kg - 1.0, std / self.urdf_kg]
    }

    /// That of two logs which is farther from the URDF, in its deviations.
    pub(crate) fn farther(self, other: Weight) -> Weight {
        let far = |own: &Weight| own.excess()[0].abs() / own.excess()[1];
        if far(&other) > far(&self) {
            other
        } else {
            self
        }
    }

    /// What is said where the two differ by more than three deviations and 1 %.
    pub fn sentence(&self) -> Option<String> {
        let Quantity { value, std } = self.mass_kg;
        let [excess, known_to] = self.excess();
        let more = if excess > 0.0 { "more" } else { "less" };
        (excess.abs() > (3.0 * known_to).max(0.01)).then(|| {
            format!(
                "The total force weighs the robot with all that it carries: {value:.3} ± {std:.3} \
                 kg, {:.3} kg {more} than the {:.3} kg of its URDF.",
                (value - self.urdf_kg).abs(),
                self.urdf_kg
            )
        })
    }
}
