//! Functions of the body as effects leave it.
//!
//! ```text
//! q ─ wiring, offset, scale ─▶ φ ─ bends under gravity ─▶ φ'        r ─ loads ─▶ r'
//! c = r'_0 + Σ B_i(φ') r'_i        J = ∂c/∂φ' ∂φ'/∂q        τ = −(∂c/∂φ')_z        ċ = J q̇
//! p = ZMP(φ', φ̇', φ̈', r')          φ̇' = ∂φ'/∂q q̇             φ̈' = d/dt φ̇'
//! ```
//!
//! The Jacobian and the velocity are with respect to what encoders read; the moments of
//! gravity act about the joints themselves, per kg of the mass with its loads. Regressor
//! rows know no masses, so they take what bends no joint: their positions are φ.

use super::Measured;
use crate::expr::{Argument, Id};
use crate::functions::{self, JointMotion, Wanted};
use crate::interface::{Function, Given};
use crate::program::Program;

impl Measured<'_> {
    /// The outputs of a function of the body, row-major, once all effects of the body are
    /// written.
    pub(crate) fn outputs(&mut self, function: Function) -> Vec<Id> {
        match function {
            Function::Com => {
                self.at_rest();
                self.scratch.subtrees(Wanted::Sums)[0].v.entries.to_vec()
            }
            Function::ComJacobian => {
                let directions = self.scratch.directions(function);
                self.at_rest();
                let rows = self.scratch.slopes(&directions, false);
                let rows = rows.chunks(self.robot().dof().max(1)).zip(&directions);
                rows.flat_map(|(row, direction)| self.by_encoders(row, direction.tag))
                    .collect()
            }
            Function::GravityMoments => {
                let directions = self.scratch.directions(function);
                self.at_rest();
                self.scratch.slopes(&directions, true)
            }
            Function::ComVelocity => {
                let encoders = self.encoder_rates();
                let rates = self.rates(&encoders);
                self.at_rest();
                let subtrees = self.scratch.subtrees(Wanted::Rotated);
                let moving = self.scratch.subtree_rates(&subtrees, &rates);
                moving[0].v.entries.to_vec()
            }
            Function::Zmp => {
                let encoders = self.encoder_rates();
                let rates = self.rates(&encoders);
                let accelerations = self.accelerations(&rates);
                self.at_rest();
                let joints = JointMotion {
                    rates,
                    accelerations,
                };
                self.scratch.zmp(&joints, &self.loads).to_vec()
            }
            Function::Regressor | Function::RegressorCop | Function::RegressorFull => {
                let straight = self.straight.clone();
                let directions = self.scratch.directions(function);
                self.at(straight, "");
                match function {
                    Function::RegressorFull => self.scratch.regressor_full(&directions),
                    _ => self.scratch.regressor(&directions),
                }
            }
            Function::Cop | Function::CopJacobian | Function::CorrectCop => {
                unreachable!("the reading is no function of the body")
            }
        }
    }

    /// Joint velocities as encoders have them.
    fn encoder_rates(&self) -> Vec<Id> {
        self.g().inputs(Argument::Velocities, self.robot().dof())
    }

    /// The program of a function of these outputs; `None` where sines and cosines do not tell all of it.
    pub(crate) fn program(
        self,
        function: Function,
        given: Given,
        outputs: &[Id],
    ) -> Option<Program> {
        functions::program(self.scratch, function, given, outputs)
    }

    /// From here on expressions are those of the robot at rest.
    fn at_rest(&mut self) {
        let joints = self.joints.clone();
        self.at(joints, "");
    }
}
