//! Mass, first and second moments of what each body carries, for dynamics.
//!
//! ```text
//! m_i = ∫ dm        h_i = ∫ y dm        J_i = ∫ y yᵀ dm        y from the body's origin, over M
//! J = ½ tr(I) 1 − I + m c cᵀ                                  of a link with inertia I about c
//! ```
//!
//! A revolute joint leaves every point of its axis where it is in the parent. The mass of a
//! body, its first moment along the axis and what of J is along the axis alone act on the
//! ground as if they were parts of the parent, and are written there: a body keeps 2 of its
//! h and 5 of its J. Its origin may be any point of the axis; it is the one that spares a
//! coordinate of its place in the parent. A body on a prismatic joint keeps all it has.

use nalgebra::{Matrix3, Vector3};

use crate::robot::Robot;
use crate::snap::tidy;
use crate::tree::Motion;

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// Entries this much smaller than the largest are what cancellation left of a zero.
const NOISE: f64 = 1e-15;

/// What a body is to dynamics, in its canonical axes, over the mass of the robot.
#[derive(Debug, Clone)]
pub(crate) struct Moments {
    /// Its mass with all that its revolute joints carry; 0 on a revolute joint.
    pub(crate) mass: f64,
    /// First moment, m.
    pub(crate) first: Vector3<f64>,
    /// Second moments, m².
    pub(crate) second: Matrix3<f64>,
    /// Place of its origin in the canonical axes of its parent, where its joint is at zero, m.
    pub(crate) place: Vector3<f64>,
}

/// A point mass that joins a link, over the mass of the bare robot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointMass {
    /// Index among [`crate::tree::Tree::links`].
    pub(crate) link: usize,
    /// Over the mass of the bare robot.
    pub(crate) mass: f64,
    /// In the frame of the link, m.
    pub(crate) at: Vector3<f64>,
}

/// A distribution of mass about a point.
#[derive(Clone, Copy)]
struct Spread {
    mass: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl Spread {
    const NONE: Spread = Spread {
        mass: 0.0,
        first: Vector3::new(0.0, 0.0, 0.0),
        second: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    fn point(mass: f64, at: Vector3<f64>) -> Spread {
        Spread {
            mass,
            first: at * mass,
            second: at * at.transpose() * mass,
        }
    }

    fn join(&mut self, other: Spread) {
        self.mass += other.mass;
        self.first += other.first;
        self.second += other.second;
    }

    /// The same about another point.
    fn about(self, origin: Vector3<f64>) -> Spread {
        let crossed = origin * self.first.transpose();
        Spread {
            mass: self.mass,
            first: self.first - origin * self.mass,
            second: self.second - crossed - crossed.transpose()
                + origin * origin.transpose() * self.mass,
        }
    }

    /// What of it is on the line of `axis` through the origin, written for a line along `to`
    /// through `place`; it is taken away here.
    fn give_line(&mut self, axis: Vector3<f64>, to: Vector3<f64>, place: Vector3<f64>) -> Spread {
        let (first, second) = (axis.dot(&self.first), axis.dot(&(self.second * axis)));
        let crossed = place * to.transpose() * first;
        let given = Spread {
            mass: self.mass,
            first: place * self.mass + to * first,
            second: place * place.transpose() * self.mass
                + crossed
                + crossed.transpose()
                + to * to.transpose() * second,
        };
        self.mass = 0.0;
        self.first -= axis * first;
        self.second -= axis * axis.transpose() * second;
        given
    }
}

/// The moments of every body of `robot` with point masses `loads`.
pub(crate) fn moments(robot: &Robot, loads: &[PointMass]) -> Vec<Moments> {
    let bodies = &robot.chain.bodies;
    let origins = origins(robot);
    let mut spreads = own(robot, loads);
    for (spread, origin) in spreads.iter_mut().zip(&origins) {
        *spread = spread.about(*origin);
    }
    let mut places = vec![Vector3::zeros(); bodies.len()];
    for i in (1..bodies.len()).rev() {
        let body = &bodies[i];
        let parent = body.parent.expect("only body 0 has no parent");
        // The origin in the parent, from the parent's own origin.
        let place = body.anchor + body.rotation * origins[i] - origins[parent];
        places[i] = (robot.axes(parent).transpose() * place).map(tidy);
        let given = match body.motion {
            Motion::Revolute { axis, .. } => {
                spreads[i].give_line(axis, body.rotation * axis, place)
            }
            _ => Spread::point(spreads[i].mass, place),
        };
        spreads[parent].join(given);
    }
    let largest = |of: fn(&Spread) -> f64| spreads.iter().map(of).fold(0.0, f64::max);
    let noise = NOISE * largest(|spread| spread.first.amax());
    let noise_of_second = NOISE * largest(|spread| spread.second.amax());
    let clean = |x: f64, noise: f64| if libm::fabs(x) > noise { x } else { 0.0 };
    let seen = spreads.iter().enumerate().map(|(i, spread)| {
        let axes = robot.axes(i);
        let second = axes.transpose() * spread.second * axes;
        Moments {
            mass: spread.mass,
            first: (axes.transpose() * spread.first).map(|x| clean(x, noise)),
            second: second.map(|x| clean(x, noise_of_second)),
            place: places[i],
        }
    });
    seen.collect()
}

/// What the links of every body are, about the body's point on its joint, over the mass of
/// all with the loads.
fn own(robot: &Robot, loads: &[PointMass]) -> Vec<Spread> {
    let added: f64 = loads.iter().map(|load| load.mass).sum();
    let scale = 1.0 / (1.0 + added);
    let mut spreads = vec![Spread::NONE; robot.chain.bodies.len()];
    for (k, (link, place)) in robot.tree.links.iter().zip(&robot.chain.places).enumerate() {
        let Some(place) = place else { continue };
        let share = scale / robot.tree.mass;
        let inertia = place.orientation * link.inertia * place.orientation.transpose();
        let spread = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
        let at = |point: Vector3<f64>| place.orientation * point + place.origin;
        let body = &mut spreads[place.body];
        body.join(Spread::point(share * link.mass, at(link.com)));
        body.second += spread * share;
        for load in loads.iter().filter(|load| load.link == k) {
            body.join(Spread::point(scale * load.mass, at(load.at)));
        }
    }
    spreads
}

/// The origin of every body in its own frame: on the axis of a revolute joint, where a
/// coordinate of its place in the parent vanishes.
fn origins(robot: &Robot) -> Vec<Vector3<f64>> {
    let bodies = &robot.chain.bodies;
    let mut origins: Vec<Vector3<f64>> = Vec::with_capacity(bodies.len());
    for body in bodies {
        let origin = match (body.motion, body.parent) {
            (Motion::Revolute { axis, .. }, Some(parent)) => {
                let axes = robot.axes(parent).transpose();
                let place = axes * (body.anchor - origins[parent]);
                let along = axes * (body.rotation * axis);
                let k = along.iamax();
                axis * (-place[k] / along[k])
            }
            _ => Vector3::zeros(),
        };
        origins.push(origin);
    }
    origins
}
