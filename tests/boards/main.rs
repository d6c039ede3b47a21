//! What needs more than Rust and a C compiler: generated C by gcc and clang, as C++, by a linter, on
//! machines of other kinds and on Cortex-M in qemu, and its packages by CMake and Arduino's builder.
//! `.ci/all boards misra` installs what it needs and runs it.

#[path = "../it/c99/mod.rs"]
mod c99;
mod cmake;
mod compilers;
mod firmware;
mod libraries;
mod machines;
mod misra;
#[path = "../it/c_packages/user.rs"]
mod user;

/// Compilers of C for this machine.
const COMPILERS: [&str; 2] = ["gcc", "clang"];
