//! What is forgiven in a file, and what is not.

use crate::common::{kind, robot, urdf};
use sesc_reference::{Error, ErrorKind, Reference, Robot};

const PAIR: &str = "<link name='a'><inertial><mass value='1'/></inertial></link><link name='b'/>";

fn read(body: &str) -> Result<Robot, Error> {
    Robot::from_urdf(&urdf("name='r'", body))
}

/// An error with all that caused it.
fn chain(error: &dyn std::error::Error) -> String {
    let cause = error.source().map_or(String::new(), chain);
    format!("{error}: {cause}")
}

/// Everything that is odd but harmless, all at once.
#[test]
fn a_messy_file_reads() {
    let robot = Robot::from_urdf(
        "\u{feff}\n  <?xml version=\"1.0\" ?>
        <!-- made by hand -- on a Friday --->
        <robot name='messy' xmlns:xacro='http://ros.org/wiki/xacro'>
          <xacro:property name='k' value='${2 * pi}'/>
          <xacro:joint name='no joint'/>
          <material name='red'/>
          <link name='base'>
            <visual><geometry><teapot handles='two'/></geometry></visual>
            <inertial>
              <mass value=' 2.5e+0 '/>
              <origin xyz='  .1\t+0.2\n 3.e-1 ' rpy='nonsense'/>
            </inertial>
          </link>
          <link name='arm'><inertial><mass value='0'/><inertia ixx='?'/></inertial></link>
          <joint name='elbow' type='revolute'>
            <axis xyz='0 0 2'/>
            <limit effort='a lot' lower='-1' upper='1'/>
            <child link='arm'/>
            <parent link='base'/>
            <dynamics damping='?'/>
            <safety_controller/>
          </joint>
          <gazebo reference='arm'><interface:position name='p'/></gazebo>
          <ros2_control name='x' type='system'><joint name='elbow'/></ros2_control>
          <transmission name='t'><joint name='elbow'/></transmission>
        </robot>",
    )
    .unwrap();
    assert_eq!(robot.name(), "messy");
    assert_eq!(robot.links().len(), 2);
    assert_eq!(robot.joints().len(), 1);
    assert_eq!(robot.links()[0].com_m, nalgebra::Point3::new(0.1, 0.2, 0.3));
    assert_eq!(robot.links()[0].mass_kg, 2.5);
    assert_eq!(robot.joints()[0].axis, nalgebra::Vector3::z_axis());
    assert_eq!(robot.joints()[0].limits, (-1.0, 1.0));
}

#[test]
fn numbers_are_kept_to_the_last_bit() {
    let robot = robot(
        "<link name='a'><inertial><origin xyz='-0.0 0.1 2.2250738585072014e-308'/>
         <mass value='0.30000000000000004'/></inertial></link>",
    );
    let link = &robot.links()[0];
    assert_eq!(link.mass_kg.to_bits(), (0.1_f64 + 0.2).to_bits());
    assert_eq!(link.com_m.x.to_bits(), (-0.0_f64).to_bits());
    assert_eq!(link.com_m.z, f64::MIN_POSITIVE);
}

#[test]
fn mistakes_are_named() {
    let j = |kind: &str, more: &str| format!("{PAIR}\n{kind} j a b | | {more}");
    let fixed = |joint: &str| format!("{}\nfixed {joint}", j("fixed", ""));
    let cases = [
        ("", "no links"),
        ("<link name='a'/><link name='a'/>", "link `a` appears twice"),
        (PAIR, "no joint carries `a`, `b`"),
        ("<link/>", "missing field `name`"),
        ("<link name='a'><inertial/></link>", "missing field `mass`"),
        (
            "<link name='a'><inertial><mass value='heavy'/></inertial></link>",
            "invalid float literal",
        ),
        (
            "<link name='a'><inertial><mass value='-1'/></inertial></link>",
            "link `a`: mass -1 kg is negative",
        ),
        (
            "<link name='a'><inertial><origin xyz='0 0'/><mass value='1'/></inertial></link>",
            "xyz=\"0 0\" does not hold the numbers",
        ),
        (
            "<link name='a'><inertial><mass value='${m}'/></inertial></link>",
            "invalid float literal",
        ),
        (&j("wobbly", ""), "unknown variant `wobbly`"),
        (&j("spherical", ""), "type `spherical` is not supported"),
        (
            &j("revolute", "<axis xyz='0 0 0'/>"),
            "axis has no direction",
        ),
        (&j("revolute", "<axis xyz='nan 0 0'/>"), "xyz=\"nan 0 0\""),
        (
            &j("revolute", "<axis xyz='1e300 1e300 0'/>"),
            "axis has no direction",
        ),
        (
            &j("revolute", "<mimic joint='ghost'/>"),
            "mimics `ghost`, which does not exist",
        ),
        (&j("revolute", "<mimic joint='j'/>"), "mimics itself"),
        (&j("revolute", "<mimic/>"), "missing field `joint`"),
        (&format!("{PAIR}\nrevolute j a c"), "there is no link `c`"),
        (&format!("{PAIR}\nrevolute j a a"), "do not form one tree"),
        (&fixed("j b a"), "joint `j` appears twice"),
        (&fixed("k b a"), "closed circle"),
        (&fixed("k a b"), "link `b` hangs on both `j` and `k`"),
    ];
    for (body, message) in cases {
        let error = chain(&read(body).expect_err(body));
        assert!(error.contains(message), "{error:?} should say {message:?}");
    }
    for text in [
        "",
        "robot",
        "<robot>",
        "<!-- <robot/>",
        "<a:robot",
        "<robot><b:c/></robot",
    ] {
        let error = Robot::from_urdf(text).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Xml, "{text}");
    }
    let error = Robot::from_urdf("<sdf/>").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::NotARobot);
    assert!(error.to_string().contains("<sdf>"), "{error}");
    let turned = |origin: &str| {
        let pair = format!("<link name='a'/><link name='b'/>\nfixed j a b | {origin}");
        kind(Robot::from_urdf(&urdf("version='1.1'", &pair)))
    };
    let both = turned("rpy='0 0 0' quat_xyzw='0 0 0 1'");
    assert_eq!(both, ErrorKind::TwoOrientations);
    assert_eq!(turned("quat_xyzw='0 0 0 0'"), ErrorKind::NoQuaternion);
    assert_eq!(kind(Robot::from_file("no such file")), ErrorKind::File);
}

#[test]
fn a_robot_needs_a_support_and_mass() {
    let robot = robot("<link name='a'/>");
    assert_eq!(kind(Reference::new(&robot, "a")), ErrorKind::NoMass);
    let error = Reference::new(&robot, "b").unwrap_err().to_string();
    assert_eq!(error, "no link `b`; the robot has `a`");
}
