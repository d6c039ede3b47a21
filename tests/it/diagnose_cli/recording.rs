//! `--mcap`: the recording has the log's postures and readings, and what the virtual robot of
//! CAD and of the explanation reads there.

use std::fs;

use sesc_test_support::command::{in_words, op2, refused, sesc};

use super::asking::*;

/// What the command says of the file without the format, and that it does so before any work.
#[cfg(not(feature = "mcap"))]
#[test]
fn without_the_format_the_feature_is_named() {
    let folder = sesc_test_support::command::folder();
    let log = logged(folder.path(), "log", vec![]);
    let path = folder.path().join("a.mcap").display().to_string();
    let asked = ["diagnose", &op2(), "--data", &log, "--mcap", &path];
    refused(&sesc(&asked), &["built without MCAP", "--features mcap"]);
    assert!(fs::metadata(path).is_err());
}

#[cfg(feature = "mcap")]
mod with_the_format {
    use std::path::Path;

    use sesc_identify::logs::{Block, Options, PostureReader};
    use sesc_identify::robot::Robot;
    use sesc_model::Snapping;
    use sesc_reference::World;
    use sesc_test_support::command::{folder, stdout, write};
    use sesc_test_support::hidden::{Effect, NOWHERE};

    use super::super::outputs::{told, worst};
    use super::*;

    /// A recording as the library reads it, its CoP from a topic or from that which it names.
    fn read(path: &str, topic: Option<&str>) -> Block {
        let robot = Robot::read(Path::new(&op2())).unwrap();
        let model = robot.model("r_sole", Snapping::Off, None).unwrap();
        let mut options = Options::default();
        options.topic = topic.map(str::to_string);
        options.links = vec!["r_sole".to_string()];
        let mut reader = PostureReader::open(path, &model.tree.dofs, &options).unwrap();
        let block = reader.block(10_000).unwrap();
        assert!(reader.warnings.is_empty(), "{:?}", reader.warnings);
        block
    }

    #[test]
    fn it_holds_the_log_and_what_cad_and_the_explanation_read_there() {
        let told = told(vec![
            hidden(Effect::JointScale, "r_ank_roll", &[0.2]),
            hidden(Effect::SensorRotation, NOWHERE, &[0.15]),
        ]);
        let path = told.path("told.mcap");
        let readings = postures(&told.log, &["cop_x".into(), "cop_y".into()]);
        let block = read(&path, None);
        assert!(block.q == told.q.concat());
        assert!(
            block
                .support
                .unwrap()
                .iter()
                .all(|link| &**link == "r_sole")
        );
        let measured: Vec<[f64; 2]> = readings.iter().map(|cop| [cop[0], cop[1]]).collect();
        assert!(block.reading == Some(measured));
        // The log has no times.
        let seconds: Vec<f64> = (0..told.q.len()).map(|k| k as f64).collect();
        assert_eq!(block.t, Some(seconds));
        let robot = sesc_reference::Robot::from_file(Path::new(&op2())).unwrap();
        let cad = World::new(&robot, "r_sole").unwrap();
        let cad: Vec<[f64; 2]> = told.q.iter().map(|q| cad.cop(q)).collect();
        let explained = told.truth();
        for (topic, truth) in [("/cop/cad", &cad), ("/cop/explained", &explained)] {
            let found = read(&path, Some(topic)).reading.unwrap();
            assert!(
                worst(&found, truth) < 1e-12,
                "{topic}: {:e}",
                worst(&found, truth)
            );
        }
        // They are not alike.
        assert!(worst(&cad, &explained) > 1e-3);
    }

    #[test]
    fn it_is_a_log_with_the_same_fit_and_the_times_of_its_log() {
        let folder = folder();
        let log = logged(
            folder.path(),
            "log",
            vec![hidden(Effect::JointOffset, "r_knee", &[0.02])],
        );
        let text = fs::read_to_string(&log).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap();
        let columns = header.split(',').filter(|name| !name.ends_with("_std"));
        let count = columns.count();
        let kept = |line: &str| line.split(',').take(count).collect::<Vec<_>>().join(",");
        assert!(
            header.ends_with("_std") && kept(header).ends_with("cop_y"),
            "{header}"
        );
        let mut timed = format!("t,{}\n", kept(header));
        for (k, line) in lines.enumerate() {
            timed += &format!("{},{}\n", 100.0 + 2.5 * k as f64, kept(line));
        }
        write(folder.path(), "timed.csv", timed);
        let path = |name: &str| folder.path().join(name).display().to_string();
        let [csv, mcap] = ["timed.csv", "timed.mcap"].map(path);
        let diagnosed = diagnose(
            &csv,
            &["--support", "r_sole", "--noise", "0.0005", "--mcap", &mcap],
        );
        let last = diagnosed["times"][1].as_f64().unwrap();
        assert!(last > 300.0, "{last}");
        let fit = |data: &str| -> serde_json::Value {
            let urdf = op2();
            let robot = in_words("fit @ --support r_sole --noise 0.0005 --json", &[&urdf]);
            let said = stdout(&sesc(&[&robot[..], &["--data", data]].concat()));
            serde_json::from_str(&said).unwrap()
        };
        let (of_log, of_recording) = (fit(&csv), fit(&mcap));
        for key in ["postures", "rank", "parameters", "held_out_rmse", "samples"] {
            assert_eq!(of_log[key], of_recording[key], "{key}");
        }
        assert_eq!(read(&mcap, None).t.unwrap().last(), Some(&last));
    }

    #[test]
    fn a_recording_is_a_file() {
        let asked = ["diagnose", &op2(), "--data", "log.csv", "--mcap", "-"];
        refused(
            &sesc(&asked),
            &["a recording that sesc wrote", "give its name"],
        );
    }
}
