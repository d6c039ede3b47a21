//! The calls behind the commands, as a caller without a command line uses them: logs in
//! memory, owned requests, calls that stop, errors with kinds.

use std::ops::ControlFlow;
use std::sync::Arc;

use sesc_identify::logs::{
    LogSource, Options, PostureReader, PostureWriter, Sidecar, Table, Written,
};
use sesc_identify::plan::Region;
use sesc_identify::plan::{self, plan};
use sesc_identify::predict::{self, predict};
use sesc_identify::robot::Robot;
use sesc_identify::robot::Stance;
use sesc_identify::simulate::{self, simulate};
use sesc_identify::{Error, ErrorKind, Message, Progress, Setting, Watch};

/// |CoP| in the seed paper's postures of the OP2, m.
const COP_BOX: f64 = 0.023;

const OP2: &str = include_str!("../../robots/op2/op2.urdf");

fn stance() -> Stance {
    Stance::new(Robot::parse(OP2, "op2.urdf").unwrap()).on("r_sole")
}

/// A log of the left knee alone, while other joints stand at zero.
fn still(knee: Vec<f64>) -> Table {
    let joints = stance().robot.description.dofs();
    joints.iter().fold(Table::new("run"), |table, dof| {
        let is_knee = dof.joint == "l_knee";
        let values = knee.iter().map(|q| if is_knee { *q } else { 0.0 });
        table.numbers(&dof.joint, values.collect::<Vec<f64>>())
    })
}

/// What is simulated in memory is predicted from memory, to the last bit.
#[test]
fn simulated_logs_are_predicted_without_a_file() {
    let stance = stance();
    let mut request = simulate::Request::new(stance.model().unwrap(), 5000);
    request.range = Some(0.5);
    let log = simulate(&request, &mut ()).unwrap();
    let mut reader =
        PostureReader::open(&log, &stance.robot.description.dofs(), &Options::default()).unwrap();
    let block = reader.block(5000).unwrap();
    // The support comes from the log's sidecar.
    let anywhere = Stance::new(stance.robot.clone());
    let found = predict(&predict::Request::new(anywhere, log), &mut ()).unwrap();
    assert_eq!(found.pose, block.pose);
    assert_eq!(Some(found.cop_m), block.reading);
}

/// A file holds the postures of the plan, and its sidecar the support.
#[test]
fn a_plan_is_written_as_it_is_in_memory() {
    let stance = stance();
    let model = Arc::new(stance.model().unwrap());
    let region = Region::square(COP_BOX, 0.0).unwrap();
    let mut request = plan::Request::new(stance.robot.clone(), model.clone(), 6, region);
    request.candidates = Some(20);
    request.sigmas = 0.0;
    let found = plan(&request, &mut ()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (path, dofs) = (folder.path().join("plan.csv"), &model.tree.dofs);
    let log = PostureWriter::create(&path, dofs, Written::default()).unwrap();
    assert_eq!(found.write(log).unwrap(), Some(Sidecar::path(&path)));
    let mut reader = PostureReader::open(path.as_path(), dofs, &Options::default()).unwrap();
    let block = reader.block(100).unwrap();
    assert_eq!(block.pose, [1, 2, 3, 4, 5, 6]);
    assert_eq!(block.q, found.postures().collect::<Vec<_>>().concat());
    assert_eq!(reader.sidecar.support.as_deref(), Some("r_sole"));
}

/// Whoever hears of progress may end the call.
#[test]
fn every_long_call_stops_when_told() {
    struct Once(u32);
    impl Watch for Once {
        fn progress(&mut self, _: Progress) -> ControlFlow<()> {
            self.0 += 1;
            ControlFlow::Break(())
        }
    }
    let stance = stance();
    let model = Arc::new(stance.model().unwrap());
    let log = simulate(&simulate::Request::new(model.clone(), 9), &mut ()).unwrap();
    let region = Region::square(COP_BOX, 0.0).unwrap();
    let simulation = simulate::Request::new(model.clone(), 9);
    let prediction = predict::Request::new(stance.clone(), &log);
    let planning = plan::Request::new(stance.robot.clone(), model, 3, region);
    type Call<'a> = &'a dyn Fn(&mut Once) -> Option<Error>;
    let calls: [Call; 3] = [
        &|watch| simulate(&simulation, watch).err(),
        &|watch| predict(&prediction, watch).err(),
        &|watch| plan(&planning, watch).err(),
    ];
    for call in calls {
        let mut watch = Once(0);
        let kind = call(&mut watch).expect("the call was stopped").kind();
        assert_eq!((kind, watch.0), (ErrorKind::Interrupted, 1));
    }
}

#[test]
fn errors_say_what_kind_where_and_what_to_set() {
    let log = |knee: f64| LogSource::from(still(vec![0.0, knee]));
    let error = |stance: Stance, log: LogSource| {
        predict(&predict::Request::new(stance, log), &mut ()).unwrap_err()
    };
    let degrees = error(stance(), log(45.0));
    assert_eq!(degrees.kind(), ErrorKind::Log);
    assert_eq!((degrees.file(), degrees.line()), (Some("run"), Some(2)));
    assert!(degrees.to_string().contains("give `angles` or put"));
    let shell = degrees.worded(|setting| match setting {
        Setting::Angles => "--degrees".to_string(),
        other => panic!("{other:?} has nothing to do with it"),
    });
    assert!(shell.contains("give --degrees or put"), "{shell}");

    let nowhere = error(Stance::new(stance().robot), log(0.0));
    assert_eq!(nowhere.kind(), ErrorKind::Request);
    let said = nowhere.to_string();
    assert!(said.starts_with("no support link given; add `support`"));
    let unknown = error(stance().on("sole"), log(0.0));
    assert_eq!(unknown.kind(), ErrorKind::Model);
    assert_eq!(unknown.kind().name(), "model");
    assert!(unknown.model().is_some());
    let gone = error(stance(), LogSource::from("gone.csv"));
    assert_eq!(gone.kind(), ErrorKind::Read);
    assert_eq!(gone.file(), Some("gone.csv"));
    for error in [degrees, nowhere, unknown, gone] {
        assert!(!error.to_string().contains("--"), "{error}");
    }
}

/// What is odd is heard, not lost.
#[test]
fn warnings_reach_whoever_watches() {
    #[derive(Default)]
    struct Ear(Vec<String>);
    impl Watch for Ear {
        fn progress(&mut self, _: Progress) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
        fn warning(&mut self, warning: &Message) {
            self.0.push(warning.to_string());
        }
    }
    let mut ear = Ear::default();
    let log = still(vec![0.0]).numbers("note", vec![1.0]);
    predict(&predict::Request::new(stance(), log), &mut ear).unwrap();
    assert_eq!(ear.0, ["run: column `note` is no joint and is ignored"]);
}

/// Requests, logs and results may be handed to another thread.
#[test]
fn calls_are_owned_and_send() {
    fn send<T: Send + 'static>() {}
    send::<plan::Request>();
    send::<plan::Plan>();
    send::<predict::Request>();
    send::<predict::Predictor>();
    send::<predict::Predictions>();
    send::<simulate::Request>();
    send::<LogSource>();
    send::<PostureReader>();
    send::<Error>();
}
