//! Nothing but the support body touches the ground.
//!
//! ```text
//! z of every shape and point of bodies i ≥ 1  ≥  clearance
//! ```
//!
//! A link with collision shapes is those; one without is its origin, its CoM
//! and the points of its joints. Bodies that are joined to the support body by
//! fixed joints are part of it and may touch, and so may the point of a joint
//! that the support body itself holds.

use nalgebra::Vector3;
use sesc_model::Model;

use super::geometry::{Geometry, Solid};
use crate::poses::{self, Pose};

/// What must stay above the ground.
pub struct Clearance {
    /// Least height, m.
    pub height: f64,
    parts: Vec<Part>,
    /// Links known by their shapes, and by points alone.
    pub by_shapes: usize,
    /// Links whose height follows from points.
    pub by_points: usize,
}

struct Part {
    body: usize,
    link: usize,
    kind: Kind,
}

enum Kind {
    Solid(Pose, Solid),
    Point(Vector3<f64>),
}

impl Clearance {
    /// Look at the shapes of all links but those of the support body.
    ///
    /// Body `standing` stands on the floor, too.
    pub fn new(
        model: &Model,
        geometry: &Geometry,
        height: f64,
        standing: Option<usize>,
    ) -> Clearance {
        let mut all = Clearance {
            height,
            parts: Vec::new(),
            by_shapes: 0,
            by_points: 0,
        };
        for (link, about) in model.tree.links.iter().enumerate() {
            let Some((body, place)) = poses::of_link(model, link) else {
                continue;
            };
            if body == 0 || Some(body) == standing {
                continue;
            }
            let shapes = geometry.shapes.iter().filter(|s| s.link == about.name);
            let solids = shapes.map(|s| Kind::Solid(place.then(&s.pose), s.solid));
            let mut kinds: Vec<Kind> = solids.collect();
            let has_shapes = !kinds.is_empty();
            all.by_shapes += usize::from(has_shapes);
            all.by_points += usize::from(!has_shapes);
            if !has_shapes {
                kinds.extend(points(model, link, &place).into_iter().map(Kind::Point));
            }
            let parts = kinds.into_iter();
            all.parts
                .extend(parts.map(|kind| Part { body, link, kind }));
        }
        all
    }

    /// The lowest height, m, and the link that is there; `None` when nothing moves.
    pub fn lowest(&self, bodies: &[Pose]) -> Option<(f64, usize)> {
        let height = |part: &Part| {
            let body = &bodies[part.body];
            match &part.kind {
                Kind::Point(point) => body.point(point).z,
                Kind::Solid(pose, solid) => {
                    let down = -pose.rotation.transpose() * body.rotation.row(2).transpose();
                    body.point(&pose.origin).z - solid.reach(&down)
                }
            }
        };
        let heights = self.parts.iter().map(|part| (height(part), part.link));
        heights.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// In a few words.
    pub fn sentence(&self) -> String {
        let mm = 1e3 * self.height;
        match (self.by_shapes, self.by_points) {
            (0, 0) => "nothing moves".to_string(),
            (0, points) => format!(
                "{mm:.1} mm for joints and CoMs of {points} links: they have no collision shapes, \
                 parts that reach beyond may touch"
            ),
            (shapes, 0) => format!("{mm:.1} mm for the collision shapes of {shapes} links"),
            (shapes, points) => format!(
                "{mm:.1} mm for the collision shapes of {shapes} links, and for joints and CoMs of \
                 {points} links without shapes"
            ),
        }
    }
}

/// Origin, CoM and joints of a link in its body, without what the support body holds.
fn points(model: &Model, link: usize, place: &Pose) -> Vec<Vector3<f64>> {
    let about = &model.tree.links[link];
    let mut points = vec![place.origin];
    if about.mass > 0.0 {
        points.push(place.point(&about.com().into()));
    }
    for edge in &model.tree.edges {
        if edge.near == link {
            points.push(place.point(&edge.anchor().into()));
        }
        if edge.far == link {
            points.push(place.point(&edge.offset().into()));
        }
    }
    let body = poses::of_link(model, link).map_or(0, |(body, _)| body);
    let held = model.chain.bodies[body].parent == Some(0);
    // The body's own origin is the point of the joint that carries it.
    points.retain(|point| !(held && point.norm() < 1e-9));
    points.dedup();
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    fn model(shape: &str) -> (Model, Geometry) {
        let urdf = format!(
            r#"<robot name="r"><link name="foot"/>
            <link name="leg"><inertial><origin xyz="0 0 0.3"/><mass value="1"/></inertial>{shape}</link>
            <link name="tip"><inertial><mass value="1"/></inertial></link>
            <joint name="ankle" type="continuous"><parent link="foot"/><child link="leg"/><axis xyz="0 1 0"/></joint>
            <joint name="top" type="continuous"><parent link="leg"/><child link="tip"/><origin xyz="0 0 1"/>
              <axis xyz="0 1 0"/></joint></robot>"#
        );
        let robot = Robot::parse(&urdf, "r.urdf").unwrap();
        let model = robot
            .model("foot", sesc_model::Snapping::default(), None)
            .unwrap();
        (model, Geometry::read(&robot.description, None))
    }

    #[test]
    fn points_and_shapes_are_measured_from_the_sole() {
        let mut bodies = Vec::new();
        let (plain, geometry) = model("");
        let clearance = Clearance::new(&plain, &geometry, 0.005, None);
        assert_eq!((clearance.by_shapes, clearance.by_points), (0, 2));
        poses::bodies(&plain, &[0.0, 0.0], &mut bodies);
        // The ankle lies on the ground and is the foot's; the CoM of the leg is next.
        let (z, link) = clearance.lowest(&bodies).unwrap();
        assert!((z - 0.3).abs() < 1e-15 && plain.tree.links[link].name == "leg");
        poses::bodies(&plain, &[2.0, 0.0], &mut bodies);
        let (z, _) = clearance.lowest(&bodies).unwrap();
        assert!((z - 2f64.cos()).abs() < 1e-15);

        let cylinder = r#"<collision><origin xyz="0 0 0.5"/><geometry>
            <cylinder radius="0.1" length="0.8"/></geometry></collision>"#;
        let (solid, geometry) = model(cylinder);
        let clearance = Clearance::new(&solid, &geometry, 0.005, None);
        assert_eq!((clearance.by_shapes, clearance.by_points), (1, 1));
        poses::bodies(&solid, &[0.0, 0.0], &mut bodies);
        assert!((clearance.lowest(&bodies).unwrap().0 - 0.1).abs() < 1e-15);
        let q = 1.0f64;
        poses::bodies(&solid, &[q, 0.0], &mut bodies);
        let expected = 0.5 * q.cos() - 0.4 * q.cos() - 0.1 * q.sin();
        assert!((clearance.lowest(&bodies).unwrap().0 - expected).abs() < 1e-15);
    }
}
