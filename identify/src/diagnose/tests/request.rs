//! The one call: what it returns is whole, wherever the log is, and it can be stopped.

use std::ops::ControlFlow;
use std::sync::Arc;

use super::{Bench, NOISE, SKEW};
use crate::diagnose::{Report, Request, Verdict, diagnose};
use crate::logs::{LogSource, Table};
use crate::robot::Robot;
use crate::{ErrorKind, Progress};

/// A log of the skewed robot whose hip is 0.05 rad off, as a table and as a file.
fn logs() -> (Table, String) {
    let bench = Bench::skew();
    let q = bench.postures(60, 3);
    let world = bench.world().joint_offset("hip", 0.05).unwrap();
    let data = bench.log(&world, &q, 3);
    let column = |values: &[f64], from: usize| -> Vec<f64> {
        values.iter().skip(from).step_by(2).copied().collect()
    };
    let columns = [
        ("hip", column(&q, 0)),
        ("knee", column(&q, 1)),
        ("cop_x", column(&data.reading, 0)),
        ("cop_y", column(&data.reading, 1)),
    ];
    let mut csv = String::from("hip,knee,cop_x,cop_y\n");
    for k in 0..60 {
        let row = columns.each_ref().map(|(_, values)| values[k].to_string());
        csv += &(row.join(",") + "\n");
    }
    let table = columns
        .into_iter()
        .fold(Table::new("log.csv"), |table, (name, values)| {
            table.numbers(name, values)
        });
    (table, csv)
}

fn request(log: impl Into<LogSource>) -> Request {
    let robot = Robot::parse(SKEW, "skew.urdf").unwrap();
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("foot".into());
    request.prior = "tight".into();
    request.noise = Some(NOISE);
    request.floor = 0.0;
    request.corrected_urdf = true;
    request.view = true;
    request
}

#[test]
fn a_report_is_whole_wherever_the_log_is() {
    fn travels<T: Send + Sync + 'static>() {}
    travels::<Request>();
    travels::<Report>();
    let (table, csv) = logs();
    let of_table = diagnose(&request(table), &mut ()).unwrap();
    let of_bytes = diagnose(&request(LogSource::bytes("log.csv", csv)), &mut ()).unwrap();
    assert_eq!(of_table.diagnosis, of_bytes.diagnosis);
    let said = &of_table.diagnosis;
    assert_ne!(said.verdict, Verdict::None, "{}", said.sentence);
    assert_eq!(said.steps[0].effect, "joint_offset");
    assert_eq!(said.steps[0].target, "hip");
    assert!(said.sentence.contains("an offset of hip"));
    assert!(!said.next_postures.why.is_empty());
    assert_eq!(of_table.model_file.effects[0].target, "hip");
    assert_eq!(of_table.model_file.data.len(), 1);
    assert_ne!(of_table.corrected_urdf.unwrap().text, SKEW);
    assert_eq!(of_table.view.unwrap().postures.len(), 60);
}

#[test]
fn whoever_waits_can_stop_it() {
    let (table, _) = logs();
    for stage in ["reading", "hypotheses"] {
        let mut watch = |progress: Progress| match progress.what == stage {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let stopped = diagnose(&request(logs().0), &mut watch).unwrap_err();
        assert_eq!(stopped.kind(), ErrorKind::Interrupted, "{stage}");
    }
    let mut nonsense = request(table);
    nonsense.noise = Some(f64::NAN);
    let refused = diagnose(&nonsense, &mut ()).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Request);
    assert!(refused.to_string().contains("`noise` NaN"), "{refused}");
}
