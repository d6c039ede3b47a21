//! Generated C as its users take it in: CMake, pkg-config, PlatformIO, Arduino.

#[path = "../common/command.rs"]
mod command;

mod boards;
mod cmake;
mod output;
mod user;
