//! Odd rows in: still trees of shapes.

use super::{arrows, confusion, course, predicted, regions, rest, spread, trends, waterfall};
use crate::report::svg::tests::sound;
use crate::report::tests::says;
use sesc_identify::diagnose::view::{
    DiagnosisView, Middle, Point, Posture, Predicted, PredictedPoint, Region, Regions, Spread,
    Stage, StageKind, Trend,
};
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::Snapping;

fn skeleton() -> Skeleton {
    let text =
        "<robot name='r'><link name='a'><inertial><mass value='1'/></inertial></link></robot>";
    let robot = Robot::parse(text, "r.urdf").unwrap();
    let model = robot.model("a", Snapping::Off, None).unwrap();
    Skeleton::of(&model, &robot.description, None)
}

fn empty() -> DiagnosisView {
    DiagnosisView {
        postures: Vec::new(),
        timed: false,
        rms_lengths: [f64::NAN; 2],
        foot: None,
        predicted: Vec::new(),
        by_position: Vec::new(),
        by_moment: Vec::new(),
        trends_of_rest: false,
        spread: Spread {
            before: vec![0; 4],
            after: vec![0; 4],
            beyond: [0, 0],
            rms: [f64::NAN; 2],
            count: 0,
        },
        regions: Regions {
            side: 0.01,
            squares: Vec::new(),
        },
        differences: Vec::new(),
        stages: Vec::new(),
        subjects: Vec::new(),
        skeleton: skeleton(),
        cells: Vec::new(),
        used: Vec::new(),
        chi2: [0.0; 3],
        chi2_readings: 0,
        chi2_expected: 0.0,
    }
}

fn all(view: &DiagnosisView) {
    for svg in [
        course(&view.postures),
        rest(view),
        predicted(&view.predicted),
        trends(&view.by_position, "joint position"),
        regions(&view.regions, true),
        spread(&view.spread),
        waterfall(&view.stages),
        confusion(&view.differences),
    ] {
        sound(&svg);
    }
    arrows(view).iter().for_each(|svg| drop(sound(svg)));
}

#[test]
fn figures_of_nothing_and_of_no_numbers() {
    all(&empty());
    let posture = |x: f64| Posture {
        pose: 0,
        q: vec![x],
        at: x,
        measured: [x, 0.0],
        simulated: [0.0, x],
        corrected: [f64::NAN, 0.01],
        outlier: x.is_nan(),
    };
    let point = |at: f64| Point {
        posture: 0,
        at,
        before: 0.001,
        after: f64::NAN,
        outlier: true,
    };
    let trend = Trend {
        joint: "a<b> & a name that is too long for a panel".to_string(),
        named: true,
        unit: "°",
        axis: 1,
        share: [f64::NAN, 0.5],
        points: vec![point(1.0), point(f64::NAN)],
        means: vec![Middle {
            at: f64::NAN,
            before: 0.0,
            after: 0.0,
        }],
    };
    let row = |axis, slope| Predicted {
        subject: "an offset of a<b> & a name that is too long for a panel".to_string(),
        axis,
        slope,
        points: [f64::NAN, f64::INFINITY, 0.002]
            .map(|change| PredictedPoint {
                posture: 0,
                change,
                gap: f64::NAN,
                outlier: change.is_nan(),
            })
            .to_vec(),
    };
    let stage = |rmse, kind| Stage {
        name: "+ joint_offset <a & b> of a robot with long names".to_string(),
        rmse,
        kind,
    };
    all(&DiagnosisView {
        postures: vec![posture(0.01), posture(f64::NAN), posture(f64::INFINITY)],
        foot: Some([[-0.03, -0.02], [0.03, 0.02]]),
        predicted: vec![row(0, f64::NAN), row(1, 40.0)],
        by_position: vec![trend],
        regions: Regions {
            side: 0.01,
            squares: vec![Region {
                corner: [0.0, 0.01],
                postures: 1,
                rms: [f64::NAN, f64::INFINITY],
            }],
        },
        differences: vec![vec![0.0, f64::NAN], vec![7.0, 0.0]],
        stages: vec![
            stage(0.01, StageKind::Cad),
            stage(f64::NAN, StageKind::Better),
            stage(0.02, StageKind::Better),
            stage(0.0, StageKind::Noise),
        ],
        ..empty()
    });
}

#[test]
fn strong_differences_are_dark_and_small_maps_numbered() {
    let svg = confusion(&[vec![0.0, 3.0], vec![3.0, 0.0]]);
    says(&svg, &["3.0", "fill-opacity=\"0.45\""]);
    let many = vec![vec![3.0; 20]; 20];
    assert!(!confusion(&many).contains("3.0"));
}
