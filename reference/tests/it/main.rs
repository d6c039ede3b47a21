//! Tests of the yardstick, a module a room.

mod common;
mod dynamics;
mod joints;
mod pendulum;
mod rank;
mod reading;
mod world;
mod world_ground;
mod world_joints;
mod world_sensor;
mod world_statics;
mod world_unmodelled;
