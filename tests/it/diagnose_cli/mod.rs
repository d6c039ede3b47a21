//! `sesc diagnose` from outside: its JSON as the contract has it, and files that
//! agree with what it says, judged by the virtual robot.

mod asking;
mod contract;
mod next;
mod outputs;
