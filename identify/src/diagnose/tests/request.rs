//! The one call: what it returns is whole, wherever the log is, and it can be stopped.

use std::ops::ControlFlow;

use super::{SKEW, off_hip, request, says, table};
use crate::diagnose::{Report, Request, Verdict, diagnose};
use crate::logs::LogSource;
use crate::{ErrorKind, Progress};

#[test]
fn a_report_is_whole_wherever_the_log_is() {
    fn travels<T: Send + Sync + 'static>() {}
    travels::<Request>();
    travels::<Report>();
    let (q, data) = off_hip();
    let rows = q.chunks(2).zip(data.reading.chunks(2));
    let rows = rows.map(|(q, y)| format!("{},{},{},{}\n", q[0], q[1], y[0], y[1]));
    let csv = format!("hip,knee,cop_x,cop_y\n{}", rows.collect::<String>());
    let mut of_table = request(table(&q, &data));
    of_table.view = true;
    let of_table = diagnose(&of_table, &mut ()).unwrap();
    let of_bytes = request(LogSource::bytes("log.csv", csv));
    let of_bytes = diagnose(&of_bytes, &mut ()).unwrap();
    assert_eq!(of_table.diagnosis, of_bytes.diagnosis);
    let said = &of_table.diagnosis;
    assert_ne!(said.verdict, Verdict::None, "{}", said.sentence);
    assert_eq!(said.steps[0].effect, "joint_offset");
    assert_eq!(said.steps[0].target, "hip");
    says(&said.sentence, &["an offset of hip"]);
    assert!(!said.next_postures.why.is_empty());
    assert_eq!(of_table.model_file.effects[0].target, "hip");
    assert_eq!(of_table.model_file.data.len(), 1);
    assert_ne!(of_table.corrected_urdf.unwrap().text, SKEW);
    assert_eq!(of_table.view.unwrap().postures.len(), 60);
}

#[test]
fn whoever_waits_can_stop_it() {
    let (q, data) = off_hip();
    let mut request = request(table(&q, &data));
    for stage in ["reading", "hypotheses"] {
        let mut watch = |progress: Progress| match progress.what == stage {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let stopped = diagnose(&request, &mut watch).unwrap_err();
        assert_eq!(stopped.kind(), ErrorKind::Interrupted, "{stage}");
    }
    request.noise = Some(f64::NAN);
    let refused = diagnose(&request, &mut ()).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Request);
    says(refused, &["`noise` NaN"]);
}
