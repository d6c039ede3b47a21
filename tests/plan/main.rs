//! `sesc plan`: how efficient planned postures are, that they can be stood in, and
//! what is refused.

mod efficiency;

use std::path::Path;
use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc::OP2_URDF;
use sesc_identify::fit::prior::Prior;
use sesc_identify::plan::balance::Region;
use sesc_identify::plan::limits::Limits;
use sesc_identify::plan::{Plan, Request, plan};
use sesc_identify::robot::Robot;
use sesc_model::{Model, Snapping};
use sesc_reference::Reference;
use sesc_test_support::command::{ROOT, folder, op2, refused, sesc, stdout, write};

use efficiency::true_robot;

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
    let reference = sesc::verify::reference(&robot, "r_sole").unwrap();
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
        .map(|_| Reference::new(&true_robot(&mut rng), "r_sole").unwrap())
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
    let folder = folder();
    let run = |name: &str, seed: &str| {
        let out = folder.path().join(name);
        let output = sesc(&[
            "plan",
            &op2(),
            "--support",
            "r_sole",
            "--poses",
            "10",
            "--candidates",
            "200",
            "--limits",
            &paper_limits(),
            "--seed",
            seed,
            "--json",
            "--out",
            out.to_str().unwrap(),
        ]);
        (stdout(&output), std::fs::read_to_string(out).unwrap())
    };
    let first = run("a.csv", "3");
    assert_eq!(first, run("b.csv", "3"));
    assert_ne!(first.1, run("c.csv", "4").1);
    // Ten postures.
    assert_eq!(first.1.lines().count(), 11);
    assert!(first.1.starts_with("pose,head_pan,"));
    let sidecar = std::fs::read_to_string(folder.path().join("a.csv.toml")).unwrap();
    assert!(sidecar.contains("support = \"r_sole\""), "{sidecar}");
    let json: serde_json::Value = serde_json::from_str(&first.0).unwrap();
    assert_eq!(json["poses"], 10);
    let draws = &json["draws"];
    let count = |key: &str| draws[key].as_u64().unwrap();
    assert!(count("drawn") >= count("balanced") && count("balanced") >= count("clear"));
    assert!(count("clear") >= count("collision_free") && count("collision_free") == 200);
    let motion = &json["motion"];
    assert!(motion["ordered"].as_f64() < motion["as_chosen"].as_f64());
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
    let folder = folder();
    for joints in [1, 2, 120] {
        let urdf = write(folder.path(), "column.urdf", column(joints));
        let out = folder.path().join("poses.csv").display().to_string();
        let output = sesc(&[
            "plan",
            &urdf,
            "--support",
            "foot",
            "--poses",
            "5",
            "--candidates",
            "40",
            "--cop-box",
            "0.15",
            "--prior",
            "tight",
            "--out",
            &out,
            "--json",
        ]);
        let json: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
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
    let reference = sesc::verify::reference(&robot, "foot").unwrap();
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
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (poses, page) = (at("poses.csv"), at("plan.html"));
    let plan = |report: &str| {
        let first = ["plan", &op2(), "--support", "r_sole", "--poses", "12"];
        let more = ["--candidates", "60", "--sigmas", "0", "--json"];
        let files = ["--out", &poses, "--report", report];
        sesc(&[&first[..], &more, &files].concat())
    };
    let json: serde_json::Value = serde_json::from_str(&stdout(&plan(&page))).unwrap();
    let curve = json["curve"].as_array().unwrap();
    assert_eq!(curve[0]["postures"], 0);
    let last = &curve[curve.len() - 1];
    assert_eq!(last["postures"], 12);
    assert_eq!(last["planned"], json["expected_error"]);
    assert_eq!(json["corners"].as_array().unwrap().len(), 4);
    assert_eq!(json["joints"].as_array().unwrap().len(), 20);
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("12 postures to take, of 60") && text.contains("--report"));
    for taken in [&poses, &at("poses.csv.toml")] {
        refused(&plan(taken), &["meant for two outputs"]);
    }
    refused(&plan(&op2()), &["op2.urdf is read here"]);
}

#[test]
fn bad_input_is_refused_with_a_remedy() {
    let folder = folder();
    let out = folder.path().join("poses.csv").display().to_string();
    let plan = |more: &[&str]| {
        let op2 = op2();
        let mut arguments = vec!["plan", &op2, "--support", "r_sole", "--out", &out];
        arguments.extend(more);
        sesc(&arguments)
    };
    let limits = |text: &str| {
        write(
            folder.path(),
            "limits.csv",
            format!("joint,lower_deg,upper_deg\n{text}\n"),
        )
    };
    refused(&plan(&["--poses", "0"]), &["--poses", "1..=2000"]);
    refused(&plan(&["--poses", "1000000000"]), &["--poses", "1..=2000"]);
    for (text, words) in [
        ("kneee,0,1", ["limits.csv:2", "no joint `kneee`"]),
        ("r_knee,10,0", ["limits.csv:2", "swap"]),
        ("r_knee,NaN,0", ["limits.csv:2", "`NaN`"]),
        ("r_knee,0,inf", ["limits.csv:2", "`inf`"]),
    ] {
        refused(&plan(&["--poses", "5", "--limits", &limits(text)]), &words);
    }
    refused(
        &plan(&["--poses", "5", "--limits", "gone.csv"]),
        &["gone.csv"],
    );
    for value in ["0", "-1", "NaN", "inf"] {
        let flag = format!("--cop-box={value}");
        refused(&plan(&["--poses", "5", &flag]), &["--cop-box"]);
        let flag = format!("--noise={value}");
        refused(&plan(&["--poses", "5", &flag]), &["--noise"]);
    }
    refused(
        &plan(&["--poses", "5", "--clearance=-0.1"]),
        &["--clearance"],
    );
    refused(
        &plan(&["--poses", "5", "--candidates", "4"]),
        &["--candidates", "at least"],
    );
    refused(
        &plan(&["--poses", "5", "--sole", "0,0;1,1"]),
        &["--sole", "corners"],
    );
    refused(
        &plan(&["--poses", "5", "--prior", "gone.toml"]),
        &["gone.toml"],
    );
    // A box narrower than what CAD knows of the CoP.
    refused(
        &plan(&["--poses", "5", "--cop-box", "0.0001"]),
        &["0 balance on `r_sole`", "--cop-box", "misses by"],
    );
    // Nothing can be half a metre above the ground.
    refused(
        &plan(&["--poses", "5", "--clearance", "0.5"]),
        &["0 of them keep clear", "--clearance"],
    );
    let nowhere = folder
        .path()
        .join("no/such/poses.csv")
        .display()
        .to_string();
    let op2 = op2();
    refused(
        &sesc(&[
            "plan",
            &op2,
            "--support",
            "r_sole",
            "--poses",
            "5",
            "--out",
            &nowhere,
        ]),
        &["cannot write"],
    );
    assert!(!Path::new(&out).exists());
}

/// Without a log that has visits five postures are to come back at the end; a log whose visits
/// differ by 2 mm says what a posture is known to, and nothing needs to be asked for.
#[test]
fn a_plan_asks_for_revisits_until_a_log_knows_what_they_differ_by() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let [out, data, second] = ["poses.csv", "log.csv", "second.csv"].map(at);
    let op2 = op2();
    let plan = |out: &str, more: &[&str]| -> serde_json::Value {
        let words = [
            "plan",
            &op2,
            "--support",
            "r_sole",
            "--poses",
            "12",
            "--candidates",
            "100",
        ];
        let all = [&words[..], &["--json", "--out", out], more].concat();
        serde_json::from_str(&stdout(&sesc(&all))).unwrap()
    };
    // Named, and written where that is asked for.
    let found = plan(&out, &[]);
    assert_eq!(found["revisits"]["written"], false);
    assert_eq!(found["revisits"]["poses"].as_array().unwrap().len(), 5);
    assert_eq!(std::fs::read_to_string(&out).unwrap().lines().count(), 13);
    let found = plan(&out, &["--revisits", "5"]);
    assert_eq!(found["revisits"]["written"], true);
    let again: Vec<usize> = found["revisits"]["poses"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pose| pose.as_u64().unwrap() as usize)
        .collect();
    let mut different = again.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), 5, "{again:?}");
    let text = std::fs::read_to_string(&out).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 17);
    for (row, pose) in rows[12..].iter().zip(&again) {
        assert_eq!(*row, rows[pose - 1]);
    }
    // Each posture four times in turn, 2 mm apart.
    let stage = sesc_virtual::stage::Stage::new(sesc_virtual::stage::Platform::Op2);
    let world = stage.world();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut log = format!("{},cop_x,cop_y\n", text.lines().next().unwrap());
    for _ in 0..4 {
        for row in &rows[..12] {
            let q: Vec<f64> = row.split(',').skip(1).map(|x| x.parse().unwrap()).collect();
            let cop = world.cop(&q).map(|x| x + 2e-3 * gauss());
            log += &format!("{row},{:.6},{:.6}\n", cop[0], cop[1]);
        }
    }
    std::fs::write(&data, log).unwrap();
    let known = plan(&second, &["--data", &data]);
    assert_eq!(
        known["revisits"]["poses"].as_array().unwrap().len(),
        0,
        "{}",
        known["revisits"]
    );
    let said = known["revisits"]["sentence"].as_str().unwrap();
    assert!(said.contains("visits of one posture differ by"), "{said}");
    // 72 degrees of freedom: to 8 %.
    let noise = known["noise"].as_f64().unwrap();
    assert!((noise / 2e-3 - 1.0).abs() < 0.3, "{noise}");
    let rows = std::fs::read_to_string(&second).unwrap().lines().count();
    assert_eq!(rows, 13);
    assert_eq!(
        plan(&second, &["--revisits", "0"])["revisits"]["poses"]
            .as_array()
            .unwrap()
            .len(),
        0
    );
}

/// A pole on a foot of 0.2 m by 0.1 m; `collision` is the shape of the foot.
fn pole(collision: &str) -> String {
    let inertial =
        |z: f64| format!("<inertial><origin xyz='0 0 {z}'/><mass value='1'/></inertial>");
    let joint = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>\
             <origin xyz='0 0 0.1'/><axis xyz='{axis}'/><limit lower='-1' upper='1'/></joint>"
        )
    };
    format!(
        "<robot name='pole'><link name='foot'>{}{collision}</link><link name='shin'>{}</link>\
         <link name='top'>{}</link>{}{}</robot>",
        inertial(0.02),
        inertial(0.1),
        inertial(0.2),
        joint("roll", "foot", "shin", "1 0 0"),
        joint("pitch", "shin", "top", "0 1 0")
    )
}

/// Unless somebody says, the CoP stays in the inner part of the sole that the URDF has.
#[test]
fn the_sole_of_the_urdf_is_where_the_cop_stays() {
    let folder = folder();
    let plan = |collision: &str, more: &[&str]| -> serde_json::Value {
        let urdf = write(folder.path(), "pole.urdf", pole(collision));
        let out = folder.path().join("poses.csv").display().to_string();
        let usual = [
            "plan",
            &urdf,
            "--support",
            "foot",
            "--poses",
            "5",
            "--candidates",
            "60",
        ];
        let rest = ["--sigmas", "0", "--out", &out, "--json"];
        serde_json::from_str(&stdout(&sesc(&[&usual[..], &rest, more].concat()))).unwrap()
    };
    let shape = "<collision><origin xyz='0.03 0 0.01'/><geometry><box size='0.2 0.1 0.02'/>\
                 </geometry></collision>";
    let of_shape = plan(shape, &[]);
    let corners = of_shape["corners"].as_array().unwrap();
    let mut x: Vec<f64> = corners.iter().map(|c| c[0].as_f64().unwrap()).collect();
    x.sort_by(f64::total_cmp);
    assert!(
        (x[0] + 0.07).abs() < 1e-12 && (x[3] - 0.13).abs() < 1e-12,
        "{x:?}"
    );
    // 0.7 of the way from its middle to the edge of its narrower side.
    assert!((of_shape["margin"].as_f64().unwrap() - 0.015).abs() < 1e-12);
    for cop in of_shape["cop"].as_array().unwrap() {
        let [x, y] = [0, 1].map(|axis| cop[axis].as_f64().unwrap());
        assert!(
            (x - 0.03).abs() < 0.085 + 1e-9 && y.abs() < 0.035 + 1e-9,
            "{x} {y}"
        );
    }
    let said = |plan: &serde_json::Value| plan["cop_region"].as_str().unwrap().to_string();
    assert!(said(&of_shape).ends_with("by the collision shapes of the support"));
    let without = plan("", &[]);
    assert_eq!(
        said(&without),
        "|x|, |y| <= 23.0 mm, for the URDF has no shape of the sole"
    );
    assert_eq!(
        said(&plan(shape, &["--cop-box", "0.02"])),
        "|x|, |y| <= 20.0 mm"
    );
}
