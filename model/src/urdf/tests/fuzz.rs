//! No input may panic, overflow the stack or take long: random damage to a
//! description that uses everything the reader knows.

use super::super::*;

const GOOD: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE robot>
<!-- everything -- at once -->
<robot name="r" version="1.1" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="p" value="${1 + 2}"/>
  <material name="grey"><color rgba="0 0 0 1"/></material>
  <link name="base"><inertial><origin xyz="0 0 1e-3" rpy="0 0 0"/><mass value="1.5"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <link name='arm &amp; hand'><![CDATA[ <odd> ]]></link>
  <link name="größe"/><link name="finger"/>
  <joint name="elbow" type="revolute"><origin quat_xyzw="0 0 0.6 0.8" xyz="1 2 3"/>
    <parent link="base"/><child link="arm &amp; hand"/><axis xyz="0 1 0"/>
    <limit lower="-1.57" upper="1.57" effort="1" velocity="2"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm &#38; hand"/><child link="größe"/>
    <limit lower="0" upper="0.1"/><mimic joint="elbow" multiplier="0.5" offset="-0.1"/></joint>
  <joint name="tip" type="fixed"><parent link="größe"/><child link="finger"/></joint>
  <gazebo reference="base"><sensor:camera/></gazebo>
</robot>
"#;

/// Pieces that change the meaning of what surrounds them.
const PIECES: [&str; 32] = [
    "<", ">", "/", "\"", "'", "=", "&", ";", "<!--", "-->", "[", "]]>", "<?", "?>", "</robot>",
    "<robot>", "<joint>", "</joint>", "a:", "nan", "-inf", "1e999", "${", "$(", "\0", "\u{feff}",
    "é", "base", LINK, SPACE, TYPE, DATA,
];
const LINK: &str = "<link name=\"x\"/>";
const SPACE: &str = " xmlns:a=\"b\"";
const TYPE: &str = "<!DOCTYPE ";
const DATA: &str = "<![CDATA[";

/// The generator of Knuth's MMIX; its high bits.
struct Draw(u64);

impl Draw {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % bound
    }
}

/// The same XML with other attribute values: names, numbers, nonsense.
fn reworded(draw: &mut Draw) -> Vec<u8> {
    let parts: Vec<&str> = GOOD.split('"').collect();
    let mut values: Vec<String> = parts.iter().map(|&part| part.to_owned()).collect();
    for _ in 0..1 + draw.below(3) {
        // Odd parts stand between quotes; the declaration comes first.
        let place = 5 + 2 * draw.below((parts.len() - 5) / 2);
        values[place] = match draw.below(4) {
            0 => PIECES[draw.below(PIECES.len())].replace(['<', '"', '&'], ""),
            1 => format!("{} {}", values[place], draw.below(3)),
            2 => format!("{:e}", f64::from_bits((draw.below(1 << 31) as u64) << 33)),
            _ => parts[5 + 2 * draw.below((parts.len() - 5) / 2)].to_owned(),
        };
    }
    values.join("\"").into_bytes()
}

fn damaged(draw: &mut Draw) -> Vec<u8> {
    let mut bytes = GOOD.as_bytes().to_vec();
    for _ in 0..1 + draw.below(4) {
        let length = bytes.len().max(1);
        let from = draw.below(length);
        let to = (from + draw.below(60)).min(bytes.len());
        let from = from.min(to);
        match draw.below(6) {
            0 => bytes[from..to]
                .iter_mut()
                .take(1)
                .for_each(|byte| *byte = draw.below(256) as u8),
            1 => bytes.truncate(from),
            2 => drop(bytes.drain(from..to)),
            3 => {
                let copy = bytes[from..to].to_vec();
                let at = draw.below(bytes.len() + 1);
                drop(bytes.splice(at..at, copy));
            }
            _ => {
                let piece = PIECES[draw.below(PIECES.len())];
                drop(bytes.splice(from..from, piece.bytes()));
            }
        }
    }
    bytes
}

fn attempt(bytes: &[u8]) -> Result<Description, Error> {
    let text = text::decode(bytes).map_err(|fault| fault.into_complaint("f", bytes))?;
    parse(text, "f")
}

#[test]
fn damage_is_survived() {
    let mut draw = Draw(2);
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..20_000 {
        let alter = [damaged, reworded][round % 2];
        let bytes = alter(&mut draw);
        match attempt(&bytes) {
            Ok(description) => {
                loaded += 1;
                tests::is_read_by_both(&description);
            }
            Err(error) if error.kind() == ErrorKind::Faulty => {
                refused += 1;
                let complaints = error.complaints();
                assert!(!complaints.is_empty());
                for complaint in complaints {
                    assert_eq!(complaint.to_string().lines().count(), 1, "{complaint}");
                }
            }
            Err(other) => panic!("{other:?} of {}", String::from_utf8_lossy(&bytes)),
        }
    }
    // Some damage is harmless, most is not.
    assert!(loaded > 1000 && refused > 1000, "{loaded} {refused}");
}

#[test]
fn every_truncation_is_refused() {
    let end = GOOD.trim_end().len();
    for length in 0..end {
        assert!(attempt(&GOOD.as_bytes()[..length]).is_err(), "{length}");
    }
    assert!(attempt(&GOOD.as_bytes()[..end]).is_ok());
}

/// Inputs on which a careless reader would recurse, or compare each with each.
#[test]
fn large_inputs_end_soon() {
    let texts = [
        "<a>".repeat(1 << 20),
        "<".repeat(1 << 20),
        "<a b='".repeat(1 << 18),
        format!("<robot name='r'>{}", "<!-- ".repeat(1 << 20)),
        format!("<robot name='{}'/>", "x".repeat(1 << 22)),
        format!("<robot name='r' {}/>", "a='' ".repeat(1 << 20)),
        format!("<robot name='r'>{}</robot>", "<link/>".repeat(200_000)),
        format!(
            "<robot name='r'>{}</robot>",
            "<x xmlns:a='b'/>".repeat(200_000)
        ),
        format!("<robot name='r'>{}</robot>", "<a:b/>".repeat(200_000)),
        format!(
            "<robot name='r'><link name='l'/>{}</robot>",
            "<joint name='jjjjjjjj' type='fixed'><parent link='lx'/><child link='xl'/></joint>"
                .repeat(9_000)
        ),
        format!(
            "<robot name='r'><link name='l'><inertial><mass value='{}'/></inertial></link></robot>",
            "1 ".repeat(1 << 20)
        ),
    ];
    for text in texts {
        let message = attempt(text.as_bytes())
            .expect_err("must be refused")
            .to_string();
        assert!(message.lines().all(|line| line.len() < 2000));
    }
}
