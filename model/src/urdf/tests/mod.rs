//! What must load, what must be refused, and in which words.

mod bad_files;
mod fuzz;

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::*;

fn robot(body: &str) -> String {
    format!(
        "<robot name=\"r\">\n<link name=\"base\"><inertial><mass value=\"1\"/></inertial></link>\n{body}\n</robot>\n"
    )
}

fn load(text: &str) -> Description {
    let read = parse(text, "test.urdf").unwrap_or_else(|error| panic!("{error}\n{text}"));
    is_read_by_both(&read);
    read
}

/// The reference, which reads by urdf-rs, finds the same robot in the text.
pub(super) fn is_read_by_both(own: &Description) {
    let text = &own.text;
    let read = sesc_reference::Robot::from_urdf(text);
    let read = read.unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    assert_eq!(own.name, read.name());
    assert_eq!(own.links.len(), read.links().len(), "{text}");
    let rotation = |origin: &Origin| {
        let [roll, pitch, yaw] = origin.rpy;
        Rotation3::from_euler_angles(roll, pitch, yaw)
    };
    for (own, read) in own.links.iter().zip(read.links()) {
        let Inertial {
            mass_kg,
            origin,
            inertia,
        } = own.inertial;
        assert_eq!((&own.name, mass_kg), (&read.name, read.mass_kg));
        assert_eq!(bits(origin.xyz), bits(read.com_m.coords.into()), "{text}");
        let [xx, xy, xz, yy, yz, zz] = inertia;
        let about = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let turned = rotation(&origin) * about * rotation(&origin).matrix().transpose();
        let error = (turned - read.inertia_kg_m2).norm();
        assert!(error <= 1e-13 * about.norm(), "{error:e}\n{text}");
    }
    assert_eq!(own.joints.len(), read.joints().len(), "{text}");
    for (own, other) in own.joints.iter().zip(read.joints()) {
        let link = |index: usize| &read.links()[index].name;
        assert_eq!(own.name, other.name);
        assert_eq!(own.joint_type.name(), other.kind.as_str());
        assert_eq!(own.parent, *link(other.parent));
        assert_eq!(own.child, *link(other.child));
        let xyz = other.origin.translation.vector.into();
        assert_eq!(bits(own.origin.xyz), bits(xyz), "{text}");
        let error = rotation(&own.origin).matrix() - other.origin.rotation.matrix();
        assert!(error.norm() < 1e-14, "{error}\n{text}");
        if own.joint_type.is_single() {
            let error = Vector3::from(own.axis).normalize() - other.axis.into_inner();
            assert!(error.norm() < 1e-15, "{error}\n{text}");
        }
        if own.limit.lower.is_finite() && own.limit.upper.is_finite() {
            assert_eq!((own.limit.lower, own.limit.upper), other.limits, "{text}");
        }
        let mimic = |joint: &str, k: f64, o: f64| (joint.to_owned(), k.to_bits(), o.to_bits());
        let ours = own.mimic.as_ref();
        let ours = ours.map(|own| mimic(&own.joint, own.multiplier, own.offset));
        let theirs = other.mimic.as_ref();
        let theirs = theirs.map(|one| mimic(&one.master, one.multiplier, one.offset));
        assert_eq!(ours, theirs, "{text}");
    }
}

#[test]
fn what_other_tools_put_beside_it_is_not_read() {
    let read = load(
        "<robot name='r' xmlns='u' xmlns:x='v' x:name='s'><x:link name='b'/>\
         <link name='a' xmlns=''><x:inertial/><inertial><x:origin xyz='1 1 1'/><mass value='2' x:value='3'/>\
         <inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link></robot>",
    );
    assert_eq!(read.links.len(), 1);
    assert_eq!(read.links[0].inertial.mass_kg, 2.0);
    assert_eq!(read.links[0].inertial.origin, Origin::default());
}

fn refuse(text: &str) -> String {
    parse(text, "test.urdf").expect_err(text).to_string()
}

/// Two links and the joint between them.
fn jointed(attributes: &str, children: &str) -> Description {
    load(&robot(&format!(
        "<link name='arm'/><joint name='elbow' {attributes}><parent link='base'/><child link='arm'/>{children}</joint>"
    )))
}

/// Asserts that a joint of this type and these parts draws one note that holds these words.
#[track_caller]
fn notes(kind: &str, parts: &str, words: &str) -> Description {
    let found = jointed(&format!("type='{kind}'"), parts);
    assert_eq!(found.notes.len(), 1, "{:?}", found.notes);
    assert!(found.notes[0].contains(words), "{:?}", found.notes);
    found
}

fn bits(values: [f64; 3]) -> [u64; 3] {
    values.map(f64::to_bits)
}

#[test]
fn missing_files_and_directories_are_named() {
    let error = read(Path::new("no/such/robot.urdf")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    let said = error.to_string();
    assert!(
        said.starts_with("no/such/robot.urdf: no such file"),
        "{said}"
    );
    let error = read(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Directory);
}

#[test]
fn too_much_text_is_refused() {
    let text = robot(&" ".repeat(limits::FILE_BYTES as usize));
    assert!(refuse(&text).contains("larger than 64 MiB"));
}

#[test]
fn missing_parts_have_defaults() {
    let words = "test.urdf:3: joint `elbow`: no lower and upper limit; taken as unlimited";
    let robot = notes("revolute", "", words);
    let joint = &robot.joints[0];
    assert_eq!(joint.axis, [1.0, 0.0, 0.0]);
    assert_eq!(joint.origin, Origin::default());
    assert_eq!(joint.limit.lower, f64::NEG_INFINITY);
    assert_eq!(joint.limit.upper, f64::INFINITY);
    assert_eq!(robot.links[0].inertial.mass_kg, 1.0);
    assert_eq!(robot.links[0].inertial.inertia, [0.0; 6]);
    assert_eq!(robot.links[1].inertial.mass_kg, 0.0);
    let joint = &jointed("type='prismatic'", "<limit upper='0.5'/>").joints[0];
    assert_eq!((joint.limit.lower, joint.limit.upper), (0.0, 0.5));
    assert_eq!((joint.limit.effort, joint.limit.velocity), (0.0, 0.0));
    // Partial origins keep what they have.
    for (origin, xyz, rpy) in [
        ("<origin rpy='0 0 1'/>", [0.0; 3], [0.0, 0.0, 1.0]),
        ("<origin xyz='1 2 3'/>", [1.0, 2.0, 3.0], [0.0; 3]),
    ] {
        let found = jointed("type='fixed'", origin).joints[0].origin;
        assert_eq!((found.xyz, found.rpy), (xyz, rpy));
    }
}

#[test]
fn numbers_survive_to_the_last_bit() {
    let [a, b, c] = [0.1 + 0.2, -0.0, 5e-324];
    let [d, e, f] = [1.7976931348623157e5, 1e-7, 123456.78901234567];
    let joint = &jointed(
        "type='continuous'",
        &format!("<origin xyz='{a} {b:?} {c:e}' rpy='{d} {e} {f}'/><axis xyz='{a} {a} {e}'/>"),
    )
    .joints[0];
    assert_eq!(bits(joint.origin.xyz), [a, b, c].map(f64::to_bits));
    assert_eq!(bits(joint.origin.rpy), [d, e, f].map(f64::to_bits));
    assert_eq!(bits(joint.axis), [a, a, e].map(f64::to_bits));
    // They may be written in every usual way.
    let joint = &jointed(
        "type='prismatic'",
        "<origin xyz='\t1e-3\n  +.5\r\n-2.E1 '/><axis xyz='0 0 -2'/><limit lower=' -inf' upper='1E0 '/>",
    )
    .joints[0];
    assert_eq!(joint.origin.xyz, [0.001, 0.5, -20.0]);
    assert_eq!(joint.axis, [0.0, 0.0, -2.0]);
    assert_eq!(joint.limit.lower, f64::NEG_INFINITY);
    assert_eq!(joint.limit.upper, 1.0);
}

#[test]
fn line_ends_and_byte_order_mark_change_nothing() {
    let text = robot("<!-- two\nlines -->");
    let crlf = format!("\u{feff}{}", text.replace('\n', "\r\n"));
    assert_eq!(load(&text).hash, load(&crlf).hash);
    assert_ne!(load(&text).hash, load(&text.replace("two", "too")).hash);
    // FNV-1a of the empty text and of "a", from its publication.
    assert_eq!(hash(""), "cbf29ce484222325");
    assert_eq!(hash("a"), "af63dc4c8601ec8c");
}

#[test]
fn joints_keep_document_order_and_may_precede_links() {
    let description = load(
        "<robot name='r'><joint name='z' type='fixed'><child link='c'/><parent link='b'/></joint>\
         <link name='c'/><joint name='a' type='fixed'><child link='b'/><parent link='root'/></joint>\
         <link name='root'><inertial><mass value='1'/></inertial></link><link name='b'/></robot>",
    );
    let links: Vec<&str> = description.links.iter().map(|l| l.name.as_str()).collect();
    let joints: Vec<&str> = description.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(links, ["c", "root", "b"]);
    assert_eq!(joints, ["z", "a"]);
}

#[test]
fn any_name_will_do() {
    let odd = "arm.l/2-3|left  arm| padded |bras_é|機械|🤖|fn|a'b\"c<d>&e|$|{}|-->";
    let mut names: Vec<String> = odd.split('|').map(str::to_owned).collect();
    // Every character that XML allows, in blocks: two further XML readers
    // stand between here and the result.
    let allowed = (0x20..=0x10ffff_u32)
        .filter_map(char::from_u32)
        .filter(|c| !crate::text::is_hidden(*c) && !matches!(c, '\u{fffe}' | '\u{ffff}'));
    let all: Vec<char> = allowed.collect();
    let name = |block: &[char]| format!("n{}", block.iter().collect::<String>());
    names.extend(all.chunks(200).step_by(7).map(name));
    names.truncate(limits::LINKS - 1);
    let body: String = names
        .iter()
        .enumerate()
        .map(|(place, name)| {
            let name = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
            format!(
                "<link name=\"{name}\"/><joint name=\"{place}{name}\" type=\"fixed\"><parent link=\"base\"/><child link=\"{name}\"/></joint>\n"
            )
        })
        .collect();
    let description = load(&robot(&body));
    let read = description.links[1..].iter().zip(&description.joints);
    for ((link, joint), name) in read.zip(&names) {
        assert_eq!((&link.name, &joint.child), (name, name));
    }
}

#[test]
fn only_direct_children_are_the_robots() {
    let description = load(&robot(
        "<ros2_control name='c' type='system'><joint name='j'><param/></joint></ros2_control>\n\
         <gazebo reference='base'><link name='ghost'><inertial/></link><sensor:camera/></gazebo>\n\
         <transmission name='t'><joint name='k'/></transmission>\n\
         <material name='m'/><unknown/><xacro:property name='p' value='${1}'/><xacro:macro name='m'><link/></xacro:macro>",
    ));
    assert_eq!(description.links.len(), 1);
    let leftover = "test.urdf:6: `xacro:property`: a leftover of xacro, ignored with all such";
    assert_eq!(description.notes, [leftover]);
    // Calls of macros are parts that are missing.
    for call in [
        "<xacro:leg m='50'/>",
        "<xacro:include filename='a'/>",
        "<xacro:if value='1'/>",
    ] {
        let error = refuse(&robot(call));
        assert!(error.contains("unexpanded xacro"), "{error}");
        assert!(error.contains("stands for parts of the robot"), "{error}");
    }
}

#[test]
fn robot_tools_write_xml_of_their_own() {
    for head in [
        "\n<?xml version='1.0'?>\n",
        "<!-- a -- b -->",
        "<!DOCTYPE robot>",
        "<?pi?>",
    ] {
        load(&format!("{head}{}", robot("<!------>")));
    }
    load(
        "<robot name='r' xmlns='http://www.ros.org' xmlns:xacro='x'><link name='a'><inertial><mass value='1'/></inertial></link></robot>",
    );
    load(&(robot("") + "\n\n  <!-- end -->\n"));
}

#[test]
fn what_does_not_move_needs_no_axis_and_no_master() {
    let parts = "<axis xyz='0 0 0'/>\n<mimic joint='gone'/>";
    let words = "test.urdf:4: joint `elbow`: a fixed joint does not move; its mimic is ignored";
    let description = notes("fixed", parts, words);
    assert!(description.joints[0].mimic.is_none());
    jointed("type='floating'", "<axis xyz='0 0 0'/>");
    jointed("type='planar'", "<axis xyz='0 0 1'/>");
}

#[test]
fn mimics_have_defaults_and_may_follow_mimics() {
    let body: String = (0..3)
        .map(|place| {
            let parent = if place == 0 { "base".to_owned() } else { format!("l{}", place - 1) };
            let mimic = match place {
                0 => "<mimic joint='j1'/>",
                1 => "<mimic joint='j2' multiplier='-2' offset='0.5'/>",
                _ => "",
            };
            format!(
                "<link name='l{place}'/><joint name='j{place}' type='continuous'><parent link='{parent}'/><child link='l{place}'/>{mimic}</joint>"
            )
        })
        .collect();
    let description = load(&robot(&body));
    let mimics: Vec<_> = (description.joints.iter())
        .filter_map(|joint| joint.mimic.as_ref())
        .map(|mimic| (mimic.joint.as_str(), mimic.multiplier, mimic.offset))
        .collect();
    assert_eq!(mimics, [("j1", 1.0, 0.0), ("j2", -2.0, 0.5)]);
}

#[test]
fn quaternions_count_from_version_1_1() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let text = robot("<link name='a'/><joint name='j' type='fixed'><parent link='base'/><child link='a'/>\n<origin quat_xyzw='0 0 Q Q'/></joint>")
        .replace('Q', &half.to_string());
    let old = load(&text);
    assert_eq!(old.joints[0].origin.rpy, [0.0; 3]);
    assert!(old.notes[0].contains(":4: joint `j`: origin quat_xyzw is ignored"));
    let new = load(&text.replace("name=\"r\"", "name=\"r\" version=\"1.1\""));
    let quarter = std::f64::consts::FRAC_PI_2;
    assert_eq!(new.joints[0].origin.rpy, [0.0, 0.0, quarter]);
    assert!(new.notes.is_empty());
}

#[test]
fn what_is_odd_but_harmless_is_noted() {
    let degrees = "<limit lower='-90' upper='90'/>";
    notes("revolute", degrees, "limit 90 rad; is it in degrees?");
    let turn = "<limit lower='-1e16' upper='1e16'/><origin rpy='0 0 90'/>";
    notes(
        "revolute",
        turn,
        "origin rpy holds 90 rad; is it in degrees?",
    );
    let twice = "<axis xyz='0 0 1'/>\n<axis xyz='0 0 1'/>";
    notes(
        "continuous",
        twice,
        ":4: joint `elbow`: a second <axis>, the same",
    );
    // Limits the wrong way round mean none.
    for limits in ["<limit lower='2' upper='1'/>", "<limit lower='1'/>"] {
        let limit = notes("revolute", limits, "taken as unlimited").joints[0].limit;
        assert_eq!(
            (limit.lower, limit.upper),
            (f64::NEG_INFINITY, f64::INFINITY)
        );
    }
    let broken = "<limit lower='0' upper='1' effort='1 Nm' velocity='nan'/>";
    assert_eq!(jointed("type='revolute'", broken).notes.len(), 2);
    let inertia = robot("").replace("<mass", "<inertia ixx='-nan(ind)' iyy='2'/><mass");
    let description = load(&inertia);
    assert_eq!(description.links[0].inertial.inertia[3], 2.0);
    let said = description.notes.join("\n");
    assert!(said.contains("link `base`: inertia ixx is `-nan(ind)`; taken as 0"));
}

#[test]
fn files_are_named_without_directories_on_request() {
    let description = parse(&robot(""), "robots/op2/op2.urdf").unwrap();
    assert_eq!(description.file, "robots/op2/op2.urdf");
    assert_eq!(description.file_name(), "op2.urdf");
    assert_eq!(description.name, "r");
}

/// Tests as long a chain as is allowed, written from the tip to the root, and a ring.
#[test]
fn long_chains_and_rings_do_not_recurse() {
    let count = limits::LINKS - 1;
    let links: String = (0..count).map(|i| format!("<link name='l{i}'/>")).collect();
    let joint = |i: usize, parent: &str| {
        format!(
            "<joint name='j{i}' type='continuous'><parent link='{parent}'/><child link='l{i}'/><mimic joint='j{}'/></joint>",
            (i + 1) % count
        )
    };
    let chain: String = (1..count)
        .rev()
        .map(|i| joint(i, &format!("l{}", i - 1)))
        .collect();
    let free = joint(0, "base").replace("<mimic joint='j1'/>", "");
    let chain = links.clone() + &chain + &free;
    assert_eq!(load(&robot(&chain)).joints.len(), count);
    let ring: String = (0..count)
        .map(|i| joint(i, &format!("l{}", (i + count - 1) % count)))
        .collect();
    let message = refuse(&robot(&(links + &ring)));
    assert_eq!(message.lines().count(), 2, "{message}");
    assert!(message.contains("mimics itself: `j0` -> `j1`"));
    assert!(message.contains("closes a loop: `l0` -> `l1`"));
    let more = "<link name='x'/>".repeat(limits::LINKS + 1);
    assert!(refuse(&robot(&more)).contains("more than 10000 links"));
}

/// Consequences are not complained about again.
#[test]
fn one_fault_gives_one_complaint() {
    for (old, new) in [
        ("name='l1'", ""),
        ("name='l1'", "name='l0'"),
        ("link='l0'", "link='no'"),
    ] {
        let text = robot(
            "<link name='l0'/>\n<link name='l1'/>\n<joint name='a' type='fixed'><parent link='base'/><child link='l0'/></joint>",
        );
        let text = text.replacen(old, new, 1);
        assert_eq!(refuse(&text).lines().count(), 1, "{}", refuse(&text));
    }
}

#[test]
fn a_mimic_of_a_fixed_joint_stands_still() {
    let text = robot(
        "<link name='a'/><link name='b'/>\
         <joint name='still' type='fixed'><parent link='base'/><child link='a'/></joint>\
         <joint name='finger' type='revolute'><parent link='a'/><child link='b'/>\
         <axis xyz='1 0 0'/><limit lower='-1' upper='1'/><mimic joint='still' offset='0.5'/></joint>",
    );
    let description = parse(&text, "test.urdf").unwrap();
    assert!(description.notes[0].contains("stands still at its offset"));
}
