//! The statically equivalent serial chain seen from the support frame.
//!
//! ```text
//! CoM(q) = r_0 + Σ_{i≥1} B_i(q) r_i + Σ_{prismatic j} B_parent(j) a_j q_j s_j
//! r_i = (m_i c_i + Σ_{children k of i} M_k d_k) / M        s_j = M_j / M
//! ```
//!
//! Bodies are groups of links joined by fixed joints; body 0 holds the support
//! link. `B_i` is the orientation of body i, `M_i` the mass carried through its
//! joint, `d_k` the point of child joint k in body i. This is the seed paper's
//! Eq. (4), with its `d_1` gathered in `r_0`.

use nalgebra::{Matrix3, Vector3};

use crate::tree::{Coordinate, Motion, Tree};

/// A group of links that moves as one.
#[derive(Debug, Clone)]
pub struct Body {
    /// The link through which the body is entered from the support; its frame
    /// gives the body's orientation, the joint's point is the body's origin.
    pub name: String,
    /// The joint that carries it; `None` for body 0.
    pub joint: Option<String>,
    /// Index of the body towards the support; `None` for body 0.
    pub parent: Option<usize>,
    /// Indices into [`Tree::links`].
    pub links: Vec<usize>,
    /// How it moves against its parent; an axis of [`Motion::Prismatic`] is given
    /// in the parent body, one of [`Motion::Revolute`] in the body itself.
    pub motion: Motion,
    /// Orientation in the parent body at θ = 0.
    pub(crate) rotation: Matrix3<f64>,
    /// The joint's point d in the parent body, m.
    pub(crate) anchor: Vector3<f64>,
    /// Its own mass, kg.
    pub mass: f64,
    /// Mass of this body and everything beyond, kg.
    pub carried: f64,
    /// CAD value of r_i in the body frame, m.
    pub(crate) r: Vector3<f64>,
    /// CAD value of s_i, for a body on a prismatic joint.
    pub s: Option<f64>,
    /// Column of r_i in the full regressor (s_i follows at +3).
    pub column: usize,
}

impl Body {
    /// Orientation in the parent body at θ = 0, row by row.
    pub fn rotation(&self) -> [[f64; 3]; 3] {
        rows(&self.rotation)
    }

    /// CAD value of r_i in the body frame, m.
    pub fn r(&self) -> [f64; 3] {
        self.r.into()
    }

    /// The joint's point d in the parent body, m.
    pub fn anchor(&self) -> [f64; 3] {
        self.anchor.into()
    }
}

/// The rows of a matrix.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    matrix.transpose().into()
}

/// Where a link sits in its body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the body.
    pub body: usize,
    /// Orientation of the link in the body frame.
    pub(crate) orientation: Matrix3<f64>,
    /// Origin of the link in the body frame, m.
    pub(crate) origin: Vector3<f64>,
}

impl Place {
    /// Orientation of the link in the body frame, row by row.
    pub fn orientation(&self) -> [[f64; 3]; 3] {
        rows(&self.orientation)
    }

    /// Origin of the link in the body frame, m.
    pub fn origin(&self) -> [f64; 3] {
        self.origin.into()
    }
}

/// Bodies in preorder of the re-rooted tree: parents come first.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Body 0 holds the support link.
    pub bodies: Vec<Body>,
    /// Place of each of [`Tree::links`]; `None` beyond a cut.
    pub places: Vec<Option<Place>>,
    /// Number of full parameters: 3 per body, one more per prismatic joint.
    pub full_params: usize,
    /// Independent joints, to name angles by.
    dofs: Vec<String>,
}

/// Fold fixed joints and gather masses and lengths into r and s.
pub fn expand(tree: &Tree) -> Chain {
    let mut bodies = vec![Body {
        name: tree.links[tree.support].name.clone(),
        joint: None,
        parent: None,
        links: Vec::new(),
        motion: Motion::Fixed,
        rotation: Matrix3::identity(),
        anchor: Vector3::zeros(),
        mass: 0.0,
        carried: 0.0,
        r: Vector3::zeros(),
        s: None,
        column: 0,
    }];
    let mut places: Vec<Option<Place>> = vec![None; tree.links.len()];
    let place = |body, orientation, origin| Place {
        body,
        orientation,
        origin,
    };
    places[tree.support] = Some(place(0, Matrix3::identity(), Vector3::zeros()));
    for edge in &tree.edges {
        let Place {
            body,
            orientation,
            origin,
        } = places[edge.near].expect("edges are in preorder: the near link is placed first");
        let rotation = (orientation * edge.rotation).map(crate::snap::tidy);
        let anchor = origin + orientation * edge.anchor;
        places[edge.far] = Some(match edge.motion {
            Motion::Fixed => place(body, rotation, anchor - rotation * edge.offset),
            motion => {
                let motion = match motion {
                    Motion::Prismatic { axis, by } => Motion::Prismatic {
                        axis: (orientation * axis).map(crate::snap::tidy),
                        by,
                    },
                    other => other,
                };
                bodies.push(Body {
                    name: tree.links[edge.far].name.clone(),
                    joint: Some(edge.joint.clone()),
                    parent: Some(body),
                    motion,
                    rotation,
                    anchor,
                    s: matches!(motion, Motion::Prismatic { .. }).then_some(0.0),
                    ..bodies[0].clone()
                });
                place(bodies.len() - 1, Matrix3::identity(), -edge.offset)
            }
        });
    }

    // The preorder of edges makes `bodies` a preorder too, so that leaf-to-root
    // sums are one reverse pass.
    for (index, (link, place)) in tree.links.iter().zip(&places).enumerate() {
        let Some(place) = place else { continue };
        let body = &mut bodies[place.body];
        body.links.push(index);
        body.mass += link.mass;
        body.r += (place.orientation * link.com + place.origin) * link.mass;
    }
    for body in &mut bodies {
        body.carried = body.mass;
    }
    for i in (1..bodies.len()).rev() {
        let carried = bodies[i].carried;
        let parent = bodies[i].parent.expect("only body 0 has no parent");
        bodies[parent].carried += carried;
        let anchor = bodies[i].anchor;
        bodies[parent].r += anchor * carried;
    }
    let mut column = 0;
    for body in &mut bodies {
        body.r /= tree.mass;
        if let Some(s) = &mut body.s {
            *s = body.carried / tree.mass;
        }
        body.column = column;
        column += if body.s.is_some() { 4 } else { 3 };
    }
    Chain {
        bodies,
        places,
        full_params: column,
        dofs: tree.dofs.iter().map(|dof| dof.joint.clone()).collect(),
    }
}

impl Chain {
    /// CAD values of the full parameters: r_0 (m), r_1 …, with s_j after its r_j.
    pub fn full_cad(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.full_params);
        for body in &self.bodies {
            values.extend(body.r.iter());
            values.extend(body.s);
        }
        values
    }

    /// Bodies carried directly by each body.
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = vec![Vec::new(); self.bodies.len()];
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(parent) = body.parent {
                children[parent].push(i);
            }
        }
        children
    }

    /// What turns body `body` against the one that carries it, for people: `Ry(-r_knee)`.
    pub fn own_rotation(&self, body: usize) -> String {
        let body = &self.bodies[body];
        let mut factors = Vec::new();
        if (body.rotation - Matrix3::identity()).norm() > 0.0 {
            factors.push(format!("A[{}]", body.joint.as_deref().unwrap_or_default()));
        }
        if let Motion::Revolute { axis, by } = body.motion {
            factors.push(rotation(&axis, &self.dofs[by.dof], &by));
        }
        product(factors)
    }

    /// `B_i` of every body as a product, for people: `Rx(r_ank_roll) Ry(-r_ank_pitch)`.
    pub fn orientation_products(&self) -> Vec<String> {
        let mut products: Vec<String> = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            let carrier = body.parent.map_or(IDENTITY, |parent| &products[parent]);
            let own = self.own_rotation(i);
            let factors = [carrier, &own].map(str::to_string);
            products.push(product(
                factors
                    .into_iter()
                    .filter(|f| f.as_str() != IDENTITY)
                    .collect(),
            ));
        }
        products
    }
}

/// A rotation that turns nothing.
const IDENTITY: &str = "I";

fn product(factors: Vec<String>) -> String {
    match factors.is_empty() {
        true => IDENTITY.to_string(),
        false => factors.join(" "),
    }
}

/// `Ry(-knee)`, `Rx(0.4 knee + 0.25)`, or `R[0.1 0.9 0.2](knee)` for a skewed axis.
fn rotation(axis: &Vector3<f64>, dof: &str, by: &Coordinate) -> String {
    let aligned = crate::snap::aligned(axis);
    // A rotation about −y by x is one about y by −x.
    let sense = aligned.map_or(1.0, |k| axis[k]);
    let (factor, offset) = (sense * by.factor, sense * by.offset);
    let sign = if factor < 0.0 { "-" } else { "" };
    let times = match factor.abs() {
        1.0 => String::new(),
        other => format!("{other} "),
    };
    let plus = match offset {
        0.0 => String::new(),
        x if x < 0.0 => format!(" - {}", -x),
        x => format!(" + {x}"),
    };
    let about = match aligned {
        Some(k) => ["x", "y", "z"][k].to_string(),
        None => format!("[{:.4} {:.4} {:.4}]", axis[0], axis[1], axis[2]),
    };
    format!("R{about}({sign}{times}{dof}{plus})")
}
