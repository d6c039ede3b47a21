//! Generated C as its users take it in: CMake, pkg-config, PlatformIO, Arduino.

mod corrected;
mod header;
mod output;
mod pairs;
mod shared;
mod symbols;
mod user;
