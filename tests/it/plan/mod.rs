//! `sesc plan`: how efficient planned postures are, that they can be stood in, and
//! what is refused.

pub(crate) mod efficiency;
mod revisits;
mod sole;

use std::path::Path;
use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc::OP2_URDF;
use sesc_identify::fit::prior::Prior;
use sesc_identify::plan::Limits;
use sesc_identify::plan::Region;
use sesc_identify::plan::{Plan, Request, plan};
use sesc_identify::robot::Robot;
use sesc_model::{Model, Snapping};
use sesc_reference::Reference;
use sesc_test_support::command::{Folder, ROOT};

use sesc_test_support::examine::bought::bought;

/// The seed paper's: |CoP| < 23 mm, 38 postures, 100 readings of 4.93 mm each.
const COP_BOX: f64 = 0.023;
const POSES: usize = 38;
const NOISE: f64 = 0.000493;

fn paper_limits() -> String {
    format!("{ROOT}/robots/op2/limits_paper.csv")
}

fn op2_plan(prior: &str, seed: u64, candidates: usize) -> (Arc<Robot>, Arc<Model>, Plan) {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let (robot, model) = (Arc::new(robot), Arc::new(model));
    let region = Region::square(COP_BOX, 0.0).unwrap();
    let mut request = Request::new(robot.clone(), model.clone(), POSES, region);
    request.candidates = Some(candidates);
    request.limits = Limits::read(Path::new(&paper_limits()), &model.tree.dofs).unwrap();
    request.prior = Prior::named(prior, &model).unwrap();
    request.noise = NOISE;
    request.seed = seed;
    let found = plan(&request, &mut ()).unwrap();
    (robot, model, found)
}

/// Limits from the file, balance and ground from the reference.
#[test]
fn every_planned_posture_can_be_stood_in() {
    let (robot, model, found) = op2_plan("cad", 7, 400);
    let reference = sesc::verify::reference(&robot, &model).unwrap();
    let text = std::fs::read_to_string(paper_limits()).unwrap();
    let support = reference.robot().link_index("r_sole").unwrap();
    let still: Vec<usize> = reference
        .robot()
        .joints()
        .iter()
        .filter(|j| j.parent == support || j.child == support)
        .flat_map(|j| [j.parent, j.child])
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let others: Vec<Reference> = (0..20)
        .map(|_| Reference::new(&bought(reference.robot(), &mut rng), "r_sole").unwrap())
        .collect();
    let mut outside = 0;
    for q in found.q.chunks(model.dof()) {
        for (dof, angle) in model.tree.dofs.iter().zip(q) {
            let line = text
                .lines()
                .find(|l| l.starts_with(&format!("{},", dof.joint)))
                .unwrap();
            let ends: Vec<f64> = line
                .split(',')
                .skip(1)
                .map(|x| x.parse().unwrap())
                .collect();
            let degrees = angle.to_degrees();
            assert!(
                ends[0] - 1e-9 <= degrees && degrees <= ends[1] + 1e-9,
                "{line}: {degrees}"
            );
            assert!(angle.abs() <= 2.6179939 + 1e-12);
        }
        let com = reference.com(q);
        assert!(com.x.abs() < COP_BOX && com.y.abs() < COP_BOX, "{com}");
        for (link, pose) in reference.link_poses(q).iter().enumerate() {
            if still.contains(&link) {
                continue;
            }
            let about = &reference.robot().links()[link];
            assert!(
                pose.translation.z >= 0.005 - 1e-9,
                "{}: {}",
                about.name,
                pose.translation.z
            );
            if about.mass_kg > 0.0 {
                assert!((pose * about.com_m).z >= 0.005 - 1e-9, "{}", about.name);
            }
        }
        outside += others
            .iter()
            .filter(|other| other.com(q).xy().amax() >= COP_BOX)
            .count();
    }
    // Two standard deviations on each side of each axis: a few robots in a hundred at most.
    let share = outside as f64 / (others.len() * found.candidates) as f64;
    assert!(share < 0.05, "{share}");
}

#[test]
fn the_same_seed_gives_the_same_file_and_another_does_not() {
    let folder = Folder::with("op2");
    folder.write("limits.csv", std::fs::read(paper_limits()).unwrap());
    let run = |seed: u32| {
        let options = "--poses 10 --candidates 200 --limits limits.csv --out a.csv";
        let json = folder.json(&format!(
            "plan op2.urdf --support r_sole {options} --seed {seed}"
        ));
        (json, folder.read("a.csv"))
    };
    let first = run(3);
    assert_eq!(first, run(3));
    let (json, text) = &first;
    // Ten postures.
    assert_eq!(text.lines().count(), 11);
    assert!(text.starts_with("pose,head_pan,"));
    let sidecar = folder.read("a.csv.toml");
    assert!(sidecar.contains("support = \"r_sole\""), "{sidecar}");
    assert_eq!(json["poses"], 10);
    let draws = ["drawn", "balanced", "clear", "collision_free"];
    let draws = draws.map(|key| json["draws"][key].as_u64().unwrap());
    assert!(
        draws.is_sorted_by(|a, b| a >= b) && draws[3] == 200,
        "{draws:?}"
    );
    let motion = &json["motion"];
    assert!(motion["ordered"].as_f64() < motion["as_chosen"].as_f64());
    assert_ne!(*text, run(4).1);
}

/// A column of revolute joints about x and y in turn, on a wide foot.
fn column(joints: usize) -> String {
    let mut text = String::from("<robot name=\"column\"><link name=\"foot\"/>");
    for k in 0..joints {
        let parent = if k == 0 {
            "foot".to_string()
        } else {
            format!("l{}", k - 1)
        };
        let axis = if k % 2 == 0 { "1 0 0" } else { "0 1 0" };
        text += &format!(
            "<link name=\"l{k}\"><inertial><origin xyz=\"0 0 0.02\"/><mass value=\"0.1\"/></inertial></link>\
             <joint name=\"j{k}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"l{k}\"/>\
             <origin xyz=\"0 0 0.04\"/><axis xyz=\"{axis}\"/><limit lower=\"-1\" upper=\"1\"/></joint>"
        );
    }
    text + "</robot>"
}

#[test]
fn robots_of_one_joint_and_of_hundreds_are_planned() {
    let folder = Folder::empty();
    for joints in [1, 2, 120] {
        folder.write("column.urdf", column(joints));
        let options = "--poses 5 --candidates 40 --cop-box 0.15 --prior tight --out poses.csv";
        let json = folder.json(&format!("plan column.urdf --support foot {options}"));
        assert_eq!(json["candidates"], 40, "{json}");
    }
}

/// Two arms whose hands can meet in front of the column they are on.
#[test]
fn planned_postures_do_not_collide() {
    let radius = 0.05;
    let arm = |side: &str, y: f64| {
        format!(
            "<link name=\"{side}_upper\"><inertial><mass value=\"0.1\"/></inertial></link>\
             <link name=\"{side}_hand\"><inertial><mass value=\"0.1\"/></inertial>\
             <collision><geometry><sphere radius=\"{radius}\"/></geometry></collision></link>\
             <joint name=\"{side}_shoulder\" type=\"continuous\"><parent link=\"trunk\"/>\
             <child link=\"{side}_upper\"/><origin xyz=\"0 {y} 0.3\"/><axis xyz=\"0 0 1\"/></joint>\
             <joint name=\"{side}_wrist\" type=\"continuous\"><parent link=\"{side}_upper\"/>\
             <child link=\"{side}_hand\"/><origin xyz=\"0.1 0 0\"/><axis xyz=\"0 0 1\"/></joint>"
        )
    };
    let urdf = format!(
        "<robot name=\"pair\"><link name=\"foot\"/><link name=\"trunk\"><inertial>\
         <origin xyz=\"0 0 0.2\"/><mass value=\"1\"/></inertial></link>\
         <joint name=\"ankle\" type=\"revolute\"><parent link=\"foot\"/><child link=\"trunk\"/>\
         <origin xyz=\"0 0 0.05\"/><axis xyz=\"0 1 0\"/><limit lower=\"-0.3\" upper=\"0.3\"/></joint>{}{}</robot>",
        arm("left", 0.06),
        arm("right", -0.06)
    );
    let robot = Robot::parse(&urdf, "pair.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let (robot, model) = (Arc::new(robot), Arc::new(model));
    let region = Region::square(0.1, 0.0).unwrap();
    let mut request = Request::new(robot.clone(), model.clone(), 10, region);
    request.candidates = Some(300);
    request.sigmas = 1.0;
    request.noise = NOISE;
    let found = plan(&request, &mut ()).unwrap();
    let reference = sesc::verify::reference(&robot, &model).unwrap();
    let hand = |side: &str| {
        reference
            .robot()
            .link_index(&format!("{side}_hand"))
            .unwrap()
    };
    let (left, right) = (hand("left"), hand("right"));
    let apart = found.q.chunks(model.dof()).map(|q| {
        let poses = reference.link_poses(q);
        (poses[left].translation.vector - poses[right].translation.vector).norm()
    });
    let nearest = apart.fold(f64::INFINITY, f64::min);
    if cfg!(feature = "collision") {
        assert!(nearest > 2.0 * radius, "{nearest}");
        assert!(found.draws.collision_free < found.draws.clear);
    } else {
        assert!(found.collision.contains("not checked"));
    }
}

#[test]
fn a_page_is_written_and_takes_no_other_files_place() {
    let folder = Folder::with("op2");
    let plan = "plan op2.urdf --support r_sole --poses 12 --candidates 60 --sigmas 0 \
                --out poses.csv --report";
    let json = folder.json(&format!("{plan} plan.html"));
    let curve = json["curve"].as_array().unwrap();
    assert_eq!(curve[0]["postures"], 0);
    let last = &curve[curve.len() - 1];
    assert_eq!(last["postures"], 12);
    assert_eq!(last["planned"], json["expected_error"]);
    assert_eq!(json["corners"].as_array().unwrap().len(), 4);
    assert_eq!(json["joints"].as_array().unwrap().len(), 20);
    let text = folder.read("plan.html");
    assert!(text.contains("12 postures to take, of 60") && text.contains("--report"));
    for taken in ["poses.csv", "poses.csv.toml"] {
        folder.refuses(&format!("{plan} {taken}"), &["meant for two outputs"]);
    }
    folder.refuses(&format!("{plan} op2.urdf"), &["op2.urdf is read here"]);
}

#[test]
fn bad_input_is_refused_with_a_remedy() {
    let folder = Folder::with("op2");
    // Last come a box narrower than what CAD knows of the CoP, and a height that nothing reaches.
    let table = "--poses 0 | --poses | 1..=2000
        --poses 1000000000 | --poses | 1..=2000
        --poses 5 --limits gone.csv | gone.csv
        --poses 5 --cop-box=0 | --cop-box
        --poses 5 --cop-box=-1 | --cop-box
        --poses 5 --cop-box=NaN | --cop-box
        --poses 5 --cop-box=inf | --cop-box
        --poses 5 --noise=0 | --noise
        --poses 5 --noise=-1 | --noise
        --poses 5 --noise=NaN | --noise
        --poses 5 --noise=inf | --noise
        --poses 5 --clearance=-0.1 | --clearance
        --poses 5 --candidates 4 | --candidates | at least
        --poses 5 --sole 0,0;1,1 | --sole | corners
        --poses 5 --prior gone.toml | gone.toml
        --poses 5 --cop-box 0.0001 | 0 balance on `r_sole` | --cop-box | misses by
        --poses 5 --clearance 0.5 | 0 of them keep clear | --clearance";
    for row in table.lines() {
        let plan = "plan op2.urdf --support r_sole --out poses.csv";
        folder.refuses_each(&format!("{plan} {}", row.trim()));
    }
    for (text, words) in [
        ("kneee,0,1", ["limits.csv:2", "no joint `kneee`"]),
        ("r_knee,10,0", ["limits.csv:2", "swap"]),
        ("r_knee,NaN,0", ["limits.csv:2", "`NaN`"]),
        ("r_knee,0,inf", ["limits.csv:2", "`inf`"]),
    ] {
        folder.write("limits.csv", format!("joint,lower_deg,upper_deg\n{text}\n"));
        let plan = "plan op2.urdf --support r_sole --poses 5 --limits limits.csv --out poses.csv";
        folder.refuses(plan, &words);
    }
    let nowhere = "plan op2.urdf --support r_sole --poses 5 --out no/such/poses.csv";
    folder.refuses(nowhere, &["cannot write"]);
    assert_eq!(folder.names(), ["limits.csv", "op2.urdf"]);
}
