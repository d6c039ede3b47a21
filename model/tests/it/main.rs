//! Tests of the model through its public face, a module a room.

mod measured;
mod moving_loads;
mod standard;
