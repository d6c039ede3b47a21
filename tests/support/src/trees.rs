//! Random robots as URDF text, one per seed.

use std::fmt::Write as _;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// What kind of trees to draw.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Number of joints.
    pub joints: usize,
    /// Revolute joints with axes along coordinate axes and right angles only.
    pub canonical: bool,
    /// Revolute joints only: no prismatic joints, no fixed joints, no mimics.
    pub revolute: bool,
    /// How likely a joint hangs on the latest link: 1 makes a chain, 0 a bush.
    pub chained: f64,
}

/// A random tree as URDF text, and the names of its links.
pub fn tree(seed: u64, kind: Kind) -> (String, Vec<String>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let links: Vec<String> = (0..=kind.joints).map(|k| format!("link-{k}")).collect();
    let mut blocks: Vec<String> = Vec::new();
    for (k, link) in links.iter().enumerate() {
        // Some links are massless, wherever they are; one surely is not.
        if k != 1 && rng.random_bool(0.15) {
            blocks.push(format!("  <link name=\"{link}\"/>\n"));
            continue;
        }
        let mass: f64 = 0.05 + 2.0 * rng.random::<f64>();
        let com = vector(&mut rng, 0.15);
        blocks.push(format!(
            "  <link name=\"{link}\"><inertial><origin xyz=\"{com}\" rpy=\"0.3 0.1 2\"/>\
             <mass value=\"{mass}\"/>{}</inertial></link>\n",
            inertia(k, mass)
        ));
    }
    let mut masters: Vec<String> = Vec::new();
    for k in 0..kind.joints {
        let latest = rng.random_bool(kind.chained);
        let parent = if latest { k } else { rng.random_range(0..=k) };
        blocks.push(joint(&mut rng, kind, k, parent, &mut masters));
    }
    // A massless world on a joint without an angle is dropped.
    if !kind.revolute && rng.random_bool(0.3) {
        let free = ["floating", "planar"][rng.random_range(0..2)];
        blocks.push(format!(
            "  <link name=\"world\"/>\n  <joint name=\"free\" type=\"{free}\">\
             <parent link=\"world\"/><child link=\"link-0\"/><axis xyz=\"0 0 1\"/></joint>\n"
        ));
    }
    // Document order is nobody's tree order.
    for k in (1..blocks.len()).rev() {
        blocks.swap(k, rng.random_range(0..=k));
    }
    (
        format!(
            "<robot name=\"random {seed}\">\n{}</robot>\n",
            blocks.concat()
        ),
        links,
    )
}

/// `text` without some of what a URDF may lack, and with what other tools put beside it.
pub fn stripped(text: &str, seed: u64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut out = String::from("<!-- stripped -- by chance --><robot name=\"stripped\">");
    for element in text.split('<').skip(2) {
        let name = element.split([' ', '/', '>']).next().unwrap_or_default();
        let optional = matches!(name, "inertia" | "limit" | "axis" | "origin");
        if optional && rng.random_bool(0.3) {
            out += element.split_once('>').map_or("", |(_, blank)| blank);
            continue;
        }
        let mut element = element.to_owned();
        for attribute in [
            "xyz",
            "rpy",
            "ixy",
            "izz",
            "lower",
            "upper",
            "effort",
            "multiplier",
            "offset",
        ] {
            let start = element.find(&format!(" {attribute}=\""));
            if let Some(start) = start.filter(|_| rng.random_bool(0.2)) {
                let value = start + attribute.len() + 3;
                let end = value + element[value..].find('"').map_or(0, |end| end + 1);
                element.replace_range(start..end, "");
            }
        }
        if name == "joint" && rng.random_bool(0.3) {
            out += "<undeclared:tool of:use=\"1\"/>";
        }
        out += "<";
        out += &element;
        if name == "link" && !element.ends_with("/>\n") && rng.random_bool(0.3) {
            out += "<visual><geometry><teapot handles=\"two\"/></geometry></visual>";
        }
    }
    out
}

/// A link's inertia, no two alike; some have none.
fn inertia(k: usize, mass: f64) -> String {
    if k % 7 == 3 {
        return String::new();
    }
    let size = 2e-3 * mass * (1.0 + (k % 5) as f64);
    let [xx, xy, xz, yy, yz, zz] = [1.0, 0.1, -0.2, 1.4, 0.15, 0.8].map(|part| part * size);
    format!(
        "<inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>"
    )
}

fn joint(
    rng: &mut ChaCha8Rng,
    kind: Kind,
    k: usize,
    parent: usize,
    masters: &mut Vec<String>,
) -> String {
    let name = format!("Joint.{k}");
    let kinds = [
        "revolute",
        "revolute",
        "revolute",
        "continuous",
        "prismatic",
        "fixed",
    ];
    let mut which = if kind.revolute {
        "revolute"
    } else {
        kinds[rng.random_range(0..kinds.len())]
    };
    if !kind.revolute && k == 0 {
        which = "revolute";
    }
    let mut text = format!("  <joint name=\"{name}\" type=\"{which}\">\n");
    let _ = writeln!(
        text,
        "    <parent link=\"link-{parent}\"/><child link=\"link-{}\"/>",
        k + 1
    );
    let _ = writeln!(
        text,
        "    <origin xyz=\"{}\" rpy=\"{}\"/>",
        vector(rng, 0.3),
        angles(rng, kind)
    );
    if which != "fixed" {
        let _ = writeln!(text, "    <axis xyz=\"{}\"/>", axis(rng, kind));
        if which != "continuous" {
            let _ = writeln!(
                text,
                "    <limit lower=\"-1.9\" upper=\"2.2\" effort=\"1\"/>"
            );
        }
        // Targets may be declared later and need not be ancestors.
        if !kind.revolute && !masters.is_empty() && rng.random_bool(0.2) {
            let master = &masters[rng.random_range(0..masters.len())];
            let factor = [1.0, -1.0, 2.0, 0.5, -0.75][rng.random_range(0..5)];
            let offset = [0.0, 0.3][rng.random_range(0..2)];
            let _ = writeln!(
                text,
                "    <mimic joint=\"{master}\" multiplier=\"{factor}\" offset=\"{offset}\"/>"
            );
        } else {
            masters.push(name);
        }
    }
    text + "  </joint>\n"
}

fn vector(rng: &mut ChaCha8Rng, size: f64) -> String {
    let mut one = || size * (2.0 * rng.random::<f64>() - 1.0);
    format!("{} {} {}", one(), one(), one())
}

fn angles(rng: &mut ChaCha8Rng, kind: Kind) -> String {
    let right = [
        "0",
        "1.5708",
        "-1.57079632679",
        "3.14159",
        "1.5707964",
        "1.5707963267949",
    ];
    let one = |rng: &mut ChaCha8Rng| match kind.canonical || rng.random_bool(0.6) {
        true => right[rng.random_range(0..right.len())].to_string(),
        false => format!("{}", 6.0 * rng.random::<f64>() - 3.0),
    };
    format!("{} {} {}", one(rng), one(rng), one(rng))
}

fn axis(rng: &mut ChaCha8Rng, kind: Kind) -> String {
    let aligned = ["1 0 0", "0 1 0", "0 0 1", "-1 0 0", "0 -2 0", "0 0 -1"];
    if kind.canonical || rng.random_bool(0.5) {
        aligned[rng.random_range(0..aligned.len())].to_string()
    } else {
        vector(rng, 1.0)
    }
}

/// A robot's description, written element by element.
#[derive(Debug, Clone)]
pub struct Urdf(String);

impl Urdf {
    /// A robot of this name.
    pub fn new(name: &str) -> Urdf {
        Urdf(format!("<robot name='{name}'>"))
    }

    /// Adds a link whose mass (kg) is at this place, "x y z" in m.
    pub fn link(self, name: &str, mass: f64, at: &str) -> Urdf {
        self.link_with(name, mass, at, "")
    }

    /// The same with further elements.
    pub fn link_with(self, name: &str, mass: f64, at: &str, more: &str) -> Urdf {
        let inertial = format!("<origin xyz='{at}'/><mass value='{mass}'/>");
        self.raw(&format!(
            "<link name='{name}'><inertial>{inertial}</inertial>{more}</link>"
        ))
    }

    /// Adds a revolute joint between two links, parent and child, with limits of ± `limit` rad.
    pub fn revolute(self, name: &str, links: [&str; 2], at: &str, axis: &str, limit: f64) -> Urdf {
        let limits = format!("<limit lower='-{limit}' upper='{limit}'/>");
        let more = format!("<origin xyz='{at}'/><axis xyz='{axis}'/>{limits}");
        self.joint(name, "revolute", links, &more)
    }

    /// Adds a joint of this type between two links, parent and child, with further elements.
    pub fn joint(self, name: &str, kind: &str, [parent, child]: [&str; 2], more: &str) -> Urdf {
        self.raw(&format!(
            "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
             {more}</joint>"
        ))
    }

    /// Adds elements as they are.
    pub fn raw(self, elements: &str) -> Urdf {
        Urdf(self.0 + elements)
    }

    /// The whole description.
    pub fn text(self) -> String {
        self.0 + "</robot>"
    }
}
