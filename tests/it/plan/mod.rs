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
use sesc_identify::plan::{Limits, Plan, Region, Request, plan};
use sesc_identify::robot::Robot;
use sesc_model::{Model, Snapping};
use sesc_reference::Reference;
use sesc_test_support::command::{Folder, ROOT, Sheet, list, says};
use sesc_test_support::examine::bought::bought;
use sesc_test_support::trees::Urdf;

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
    let limits = Sheet::read(&std::fs::read_to_string(paper_limits()).unwrap());
    let ends = limits.numbers(&limits.names[1..]);
    let support = reference.robot().link_index("r_sole").unwrap();
    let joints = reference.robot().joints().iter();
    let beside = joints.filter(|j| j.parent == support || j.child == support);
    let still: Vec<usize> = beside.flat_map(|j| [j.parent, j.child]).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let others = (0..20).map(|_| bought(reference.robot(), &mut rng));
    let others = others.map(|robot| Reference::new(&robot, "r_sole").unwrap());
    let others: Vec<Reference> = others.collect();
    let mut outside = 0;
    for q in found.q.chunks(model.dof()) {
        for (dof, angle) in model.tree.dofs.iter().zip(q) {
            let line = limits
                .rows
                .iter()
                .position(|row| row[0] == dof.joint)
                .unwrap();
            let within = ends[line][0] - 1e-9..=ends[line][1] + 1e-9;
            let degrees = angle.to_degrees();
            assert!(within.contains(&degrees), "{}: {degrees}", dof.joint);
            assert!(angle.abs() <= 2.6179939 + 1e-12);
        }
        let com = reference.com(q);
        assert!(com.x.abs() < COP_BOX && com.y.abs() < COP_BOX, "{com}");
        for (link, pose) in reference.link_poses(q).iter().enumerate() {
            if still.contains(&link) {
                continue;
            }
            let about = &reference.robot().links()[link];
            let height = pose.translation.z;
            assert!(height >= 0.005 - 1e-9, "{}: {height}", about.name);
            if about.mass_kg > 0.0 {
                assert!((pose * about.com_m).z >= 0.005 - 1e-9, "{}", about.name);
            }
        }
        let others = others.iter().map(|other| other.com(q).xy().amax());
        outside += others.filter(|off| *off >= COP_BOX).count();
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
    let mut robot = Urdf::new("column").raw("<link name='l0'/>");
    for k in 0..joints {
        let (parent, link) = (format!("l{k}"), format!("l{}", k + 1));
        let axis = ["1 0 0", "0 1 0"][k % 2];
        robot = robot.link(&link, 0.1, "0 0 0.02");
        robot = robot.revolute(&format!("j{k}"), [&parent, &link], "0 0 0.04", axis, 1.0);
    }
    robot.text()
}

#[test]
fn robots_of_one_joint_and_of_hundreds_are_planned() {
    let folder = Folder::empty();
    for joints in [1, 2, 120] {
        folder.write("column.urdf", column(joints));
        let options = "--poses 5 --candidates 40 --cop-box 0.15 --prior tight --out poses.csv";
        let json = folder.json(&format!("plan column.urdf --support l0 {options}"));
        assert_eq!(json["candidates"], 40, "{json}");
    }
}

/// Two arms whose hands can meet in front of the column they are on.
#[test]
fn planned_postures_do_not_collide() {
    let radius = 0.05;
    let mut urdf = Urdf::new("pair")
        .raw("<link name='foot'/>")
        .link("trunk", 1.0, "0 0 0.2");
    urdf = urdf.revolute("ankle", ["foot", "trunk"], "0 0 0.05", "0 1 0", 0.3);
    let ball = format!("<collision><geometry><sphere radius='{radius}'/></geometry></collision>");
    for (side, y) in [("left", 0.06), ("right", -0.06)] {
        let [upper, hand] = ["upper", "hand"].map(|part| format!("{side}_{part}"));
        let turn = |at: &str| format!("<origin xyz='{at}'/><axis xyz='0 0 1'/>");
        let shoulder = turn(&format!("0 {y} 0.3"));
        let joint = |name: &str| format!("{side}_{name}");
        urdf = urdf
            .link(&upper, 0.1, "0 0 0")
            .link_with(&hand, 0.1, "0 0 0", &ball);
        urdf = urdf.joint(
            &joint("shoulder"),
            "continuous",
            ["trunk", &upper],
            &shoulder,
        );
        urdf = urdf.joint(
            &joint("wrist"),
            "continuous",
            [&upper, &hand],
            &turn("0.1 0 0"),
        );
    }
    let urdf = urdf.text();
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
    let hands = ["left_hand", "right_hand"].map(|hand| reference.robot().link_index(hand));
    let [left, right] = hands.map(Result::unwrap);
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
    let curve = list(&json, "/curve");
    assert_eq!(curve[0]["postures"], 0);
    let last = &curve[curve.len() - 1];
    assert_eq!(last["postures"], 12);
    assert_eq!(last["planned"], json["expected_error"]);
    assert_eq!(list(&json, "/corners").len(), 4);
    assert_eq!(list(&json, "/joints").len(), 20);
    let page = folder.read("plan.html");
    says(page, &["12 postures to take, of 60", "--report"]);
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
