//! Rows of a log with how the joints move in them, block by block.
//!
//! ```text
//! before │ block │ ahead      what is known of a row reaches into the blocks beside its own
//! ```
//!
//! One block more is taken and the end of the last one is kept: memory does not grow with the log.

use super::correlation;
use super::motion::{Motion, Plan, Wanted};
use crate::Error;
use crate::logs::{Block, PostureReader};

/// Rows of a log for which one knows their motion where it has a plan for it.
pub(crate) struct Moving {
    /// The rows themselves.
    pub log: PostureReader,
    dof: usize,
    /// How rows are differentiated; none where their motion is not known.
    pub plan: Option<Plan>,
    wanted: Wanted,
    /// Between rows, s, where times are in order.
    pub step_s: Option<f64>,
    ahead: Option<Block>,
    /// Rows before the block ahead: times and joints.
    before: (Vec<f64>, Vec<f64>),
    /// Rows that were left out by [`Moving::known_rows`].
    pub left_out: u64,
}

impl Moving {
    /// Read postures of a robot with `dof` joints; plain rows without a plan.
    pub(crate) fn new(
        log: PostureReader,
        dof: usize,
        plan: Option<Plan>,
        wanted: Wanted,
    ) -> Moving {
        Moving {
            log,
            dof,
            step_s: plan.as_ref().map(|plan| plan.step_s),
            plan,
            wanted,
            ahead: None,
            before: (Vec::new(), Vec::new()),
            left_out: 0,
        }
    }

    /// With the plan that the first `head` rows of the log suggest.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub(crate) fn planned(
        mut log: PostureReader,
        dof: usize,
        head: usize,
        wanted: Wanted,
    ) -> Result<Moving, Error> {
        let first = log.block(head)?;
        let t = first.t.as_ref();
        let plan = t.and_then(|t| Plan::of(t, &first.q, dof));
        Ok(Moving {
            step_s: t.and_then(|t| correlation::step(t)),
            ahead: Some(first),
            ..Moving::new(log, dof, plan, wanted)
        })
    }

    /// The next rows, at most `rows`; empty at the end. With their motion, where joints move.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub(crate) fn rows(&mut self, rows: usize) -> Result<(Block, Option<Motion>), Error> {
        let block = match self.ahead.take() {
            Some(block) => block,
            None => self.log.block(rows)?,
        };
        if self.plan.is_none() || block.t.is_none() {
            return Ok((block, None));
        }
        if block.is_empty() {
            self.ahead = Some(Block::default());
            return Ok((block, None));
        }
        let next = self.log.block(rows)?;
        let motion = self.motion(&block, &next);
        self.ahead = Some(next);
        Ok((block, motion))
    }

    /// The same without rows whose motion is not known.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub(crate) fn known_rows(&mut self, rows: usize) -> Result<(Block, Option<Motion>), Error> {
        loop {
            let (mut block, motion) = self.rows(rows)?;
            let Some(mut motion) = motion else {
                return Ok((block, None));
            };
            self.left_out += motion.leave_out_unknown(&mut block);
            if !block.is_empty() {
                return Ok((block, Some(motion)));
            }
        }
    }

    fn motion(&mut self, block: &Block, next: &Block) -> Option<Motion> {
        let plan = self.plan.as_ref()?;
        let (dof, reach) = (self.dof, plan.reach_s());
        let times = |block: &Block| block.t.clone().unwrap_or_default();
        let (mut t, mut q) = std::mem::take(&mut self.before);
        let first = t.len();
        t.extend(times(block));
        q.extend(&block.q);
        let last = t.len();
        let end = t[last - 1];
        let mut following = times(next);
        let near = following.iter().take_while(|t| **t - end <= reach);
        following.truncate(near.count());
        q.extend(&next.q[..following.len() * dof]);
        t.extend(following);
        let motion = plan.motion((&t, &q, dof), first..last, self.wanted);
        let kept = t[..last].iter().rev().take_while(|t| end - **t <= reach);
        let kept = last - kept.count();
        self.before = (t[kept..last].to_vec(), q[kept * dof..last * dof].to_vec());
        motion
    }
}
