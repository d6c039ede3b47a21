//! Tests of the model through its public face, a module a room.

mod measured;
mod moving_loads;
mod standard;

use sesc_model::{Model, Snapping, urdf};

const GRAVITY: f64 = 9.80665;

/// An inverted pendulum: `rod` rotates about y, 0.05 m above the sole.
const PENDULUM: &str = r#"<robot name="pendulum">
    <link name="foot"><inertial><mass value="0.5"/><origin xyz="0.01 0.02 0.02"/></inertial></link>
    <link name="rod"><inertial><mass value="2"/><origin xyz="0 0 0.4"/></inertial></link>
    <joint name="ankle" type="revolute"><parent link="foot"/><child link="rod"/>
        <origin xyz="0 0 0.05"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <link name="tip"/>
    <joint name="top" type="fixed"><parent link="rod"/><child link="tip"/>
        <origin xyz="0 0 0.7"/></joint>
</robot>"#;

/// A lift that carries an arm with a skewed axis, and a hand that follows, with LOAD.
const LIFT: &str = r#"<robot name="lift">
    <link name="base"><inertial><mass value="3"/><origin xyz="0.01 0 0.1"/></inertial></link>
    <link name="mast"><inertial><mass value="1"/><origin xyz="0 0.1 0.2"/></inertial></link>
    <link name="arm"><inertial><mass value="0.8"/><origin xyz="0.2 0 0.05"/>
        <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
    <link name="hand"><inertial><mass value="0.4"/><origin xyz="0.1 0.02 0"/></inertial></link>
    <joint name="rail" type="prismatic"><parent link="base"/><child link="mast"/>
        <axis xyz="0.1 0 1"/><limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>
    <joint name="shoulder" type="revolute"><parent link="mast"/><child link="arm"/>
        <origin xyz="0 0 0.3" rpy="0.3 0.2 0.1"/><axis xyz="1 2 0.5"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
    <joint name="wrist" type="revolute"><parent link="arm"/><child link="hand"/>
        <origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
    LOAD
</robot>"#;

fn model(text: &str, support: &str) -> Model {
    let description = urdf::parse(text, "robot.urdf").unwrap();
    Model::new(&description, support, Snapping::Off).unwrap()
}
