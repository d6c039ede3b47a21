//! Integration tests, a module a room: what Rust and a C compiler as `cc` can tell. `tests/boards` and
//! `tests/pages` need more, and are run by `.ci/all`.

mod asked;
mod bad_input;
mod batch_fit;
mod both_contacts;
mod both_feet;
mod c99;
mod c_packages;
mod cli;
mod compiled;
mod controller;
mod corrected_com;
mod diagnose_cli;
mod diagnose_input;
mod diagnose_outputs;
mod docs;
mod effects;
mod fit_outputs;
mod fleet;
mod fresh;
mod generate_c;
mod gravity;
mod health;
mod healthy;
mod hidden_effect;
mod hostile;
mod identify;
mod interface;
mod layers;
mod misfit;
mod model_file;
mod motion;
mod on_target_fit;
mod op2;
mod operations;
mod plan;
mod plates;
mod random_trees;
mod recordings;
mod simd;
mod stays;
mod strangers;
mod unstated_noise;
mod workspace;
mod zmp;

/// Compilers of C for this machine.
const COMPILERS: [&str; 1] = ["cc"];
