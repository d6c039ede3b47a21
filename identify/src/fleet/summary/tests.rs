//! What is said of fleets of which everything is known.

mod drawn;

use rand::RngExt as _;

use super::*;
use crate::diagnose::Quantity;
use crate::fleet::row::Absent;
use crate::tests::says;
use drawn::{Drawn, PARAMS, STD};

#[test]
fn a_batch_is_found_with_its_size_and_its_robots_alone() {
    let mut fleet = Drawn::fleet(60, 7, 1);
    let batch = [3, 8, 15, 22, 29, 36, 43, 50];
    for robot in batch {
        // Each of the batch differs from it by half a milliradian of its own.
        let own = 5e-4 * fleet.normal();
        fleet.offset(robot, "l_knee", 0.03 + own, 1..);
    }
    // Robots with offsets of their own, of this joint too.
    fleet.offset(5, "l_knee", -0.05, 1..);
    fleet.offset(9, "r_knee", 0.03, 1..);
    fleet.offset(9, "l_el", 0.08, 1..);
    let found = fleet.summary();
    assert_eq!(found.shared.len(), 1, "{:?}", found.shared);
    let shared = &found.shared[0];
    assert_eq!(
        (&*shared.effect, &*shared.target),
        ("joint_offset", "l_knee")
    );
    assert_eq!(shared.robots, batch.map(|robot| format!("r{robot:02}")));
    // The mean of eight that differ by 0.5 mrad, known to 1/√7 mrad each.
    assert!((shared.size - 0.03).abs() < 4.0 * shared.std, "{shared:?}");
    assert!((1e-4..4e-4).contains(&shared.std), "{shared:?}");
    assert!(shared.own_std < 1.5e-3, "{shared:?}");
    // What each has of its own is 0.5 mrad, and every robot has its size with its deviation.
    let [low, high] = shared.own_std_interval;
    assert!((low..=high).contains(&shared.own_std), "{shared:?}");
    assert!(low <= 5e-4 && (5e-4..3e-3).contains(&high), "{shared:?}");
    assert!(shared.sentence.contains("95 %: "), "{}", shared.sentence);
    assert_eq!(shared.members.len(), 8);
    for (member, robot) in shared.members.iter().zip(&shared.robots) {
        assert_eq!(member.robot, *robot);
        assert!((member.value - 0.03).abs() < 3e-3, "{member:?}");
        // Seven days of 1 mrad each, or more where they scatter more.
        assert!((3e-4..1.2e-3).contains(&member.std), "{member:?}");
    }
    assert!(found.changes.is_empty(), "{:?}", found.changes);
    // The robot with two offsets of its own comes first.
    assert_eq!(found.look_first[0], "r09");
    assert_eq!(found.look_first.len(), 10);
    // Nothing is before it; the batch, of one weight, shares the last places.
    let places: Vec<[usize; 2]> = found.reasons.iter().map(|reason| reason.places).collect();
    assert_eq!((places[0], places[1], places[9]), ([1, 1], [2, 2], [3, 10]));
    for reason in &found.reasons {
        let is_sure = reason.chance < 1e-6 && reason.weight_std < 1e-3;
        assert!(is_sure, "{reason:?}");
        let said: Vec<&str> = reason.said.iter().map(|one| &*one.sentence).collect();
        assert_eq!(reason.why, said.join(" "));
    }
}

/// Rows of a batch name its joint on some days, the joint beside it on others, and nothing on the rest.
#[test]
fn a_batch_is_found_whatever_its_days_name() {
    let mut fleet = Drawn::fleet(24, 4, 23);
    (0..5).for_each(|robot| fleet.offset(robot, "l_knee", 0.026, 1..));
    for (k, row) in fleet.rows.iter_mut().enumerate() {
        let effects = &mut row.effects;
        let Some(mut named) = effects.explanation.pop() else {
            continue;
        };
        named.evidence = effects.scores[0].evidence;
        // It explains each day nearly as well, by another size each day.
        let mut other = effects.scores[0].clone();
        other.target = "l_hip_pitch".into();
        other.evidence -= 4.0;
        for size in other.parameters.values_mut() {
            size.value *= 0.7 + 0.05 * (k % 4) as f64;
        }
        effects.scores.push(other.clone());
        match k % 3 {
            0 => effects.explanation.push(named),
            1 => effects.explanation.push(other),
            _ => {}
        }
    }
    let found = fleet.summary();
    assert_eq!(found.shared.len(), 1, "{:?}", found.shared);
    let shared = &found.shared[0];
    assert_eq!(shared.target, "l_knee");
    assert_eq!(shared.robots, ["r00", "r01", "r02", "r03", "r04"]);
    assert!((shared.size - 0.026).abs() < 4.0 * shared.std, "{shared:?}");
}

/// An effect that one day hardly shows is less sure than one that many show clearly, and may be
/// anywhere among robots of its kind.
#[test]
fn what_is_less_sure_counts_for_less_and_may_have_more_places() {
    let mut fleet = Drawn::fleet(6, 2, 5);
    fleet.offset(1, "l_knee", 0.05, 1..);
    fleet.offset(2, "r_el", 0.03, 1..);
    for row in &mut fleet.rows {
        for found in &mut row.effects.explanation {
            // Twice the logarithm of the odds: 12 to 1 of one of two days.
            found.evidence = if row.robot == "r02" { 5.0 } else { 60.0 };
        }
    }
    let found = fleet.summary();
    assert_eq!(found.look_first, ["r01", "r02"]);
    let [sure, unsure] = [&found.reasons[0], &found.reasons[1]];
    assert!((sure.weight - 3.0).abs() < 1e-9, "{sure:?}");
    let chance = 1.0 / (1.0 + 2.5_f64.exp() / 2.0);
    assert!((unsure.chance - chance).abs() < 1e-12, "{unsure:?}");
    let off = unsure.weight - 3.0 * (1.0 - chance);
    assert!(off.abs() < 1e-12, "{unsure:?}");
    assert_eq!((sure.places, unsure.places), ([1, 2], [1, 2]));
    assert_eq!(unsure.chance_in_words(), "in 1 of 7 robots");
}

/// Offsets of random sizes at random joints: whoever shares one does so by chance.
#[test]
fn robots_that_share_nothing_are_no_group() {
    let mut alarms = 0;
    for seed in 0..200 {
        let mut fleet = Drawn::fleet(40, 2, seed);
        for robot in 0..40 {
            if fleet.random.random_bool(0.4) {
                let joint = format!("joint_{}", fleet.random.random_range(0..6));
                let sign = [-1.0, 1.0][usize::from(fleet.random.random_bool(0.5))];
                let size = sign * (0.01 + 0.07 * fleet.random.random::<f64>());
                fleet.offset(robot, &joint, size, 1..);
            }
        }
        alarms += usize::from(!fleet.summary().shared.is_empty());
    }
    // 1 % of 200 are 2; more than 7 would be seen once in 1000 such tests.
    assert!(alarms <= 7, "{alarms} of 200 fleets");
}

/// Days of a real fleet may scatter by more than their deviations say: the last by three times.
#[test]
fn days_that_differ_by_noise_alone_are_no_change() {
    for (fleets, first, std, most) in [(200, 500, STD, 7), (50, 900, STD / 3.0, 3)] {
        let alarms = (first..first + fleets).filter(|seed| {
            let mut fleet = Drawn::fleet(30, 7, *seed);
            for row in &mut fleet.rows {
                row.std = vec![Some(std); PARAMS];
            }
            !fleet.summary().changes.is_empty()
        });
        let alarms = alarms.count();
        assert!(alarms <= most, "{alarms} of {fleets} fleets");
    }
}

#[test]
fn a_step_and_a_drift_are_told_with_their_first_day() {
    let mut fleet = Drawn::fleet(60, 7, 7);
    // A parameter steps by twelve deviations, and an offset drifts by eight a day.
    fleet
        .rows(10, 3..)
        .for_each(|row| row.params[5] += 12.0 * STD);
    for (k, day) in (4..=7).enumerate() {
        fleet.offset(20, "r_ank_pitch", 8.0 * STD * (k + 1) as f64, day..=day);
    }
    let changes = fleet.summary().changes;
    let said = changes.iter().map(|c| (&*c.robot, &*c.day, c.kind));
    let first = ("r10", "3", ChangeKind::Parameter);
    let second = ("r20", "4", ChangeKind::Effect);
    assert_eq!(said.collect::<Vec<_>>(), [first, second], "{changes:?}");
    assert_eq!(changes[1].target, "joint_offset:r_ank_pitch");
    says(&changes[1].what, &["not seen on 3"]);
}

#[test]
fn a_new_urdf_is_a_change_and_its_parameters_are_not_compared() {
    let mut fleet = Drawn::fleet(30, 6, 8);
    for row in fleet.rows(4, 4..) {
        row.urdf_hash = "b".into();
        row.params.iter_mut().for_each(|x| *x += 100.0 * STD);
    }
    let changes = fleet.summary().changes;
    assert_eq!(changes.len(), 1, "{changes:?}");
    assert_eq!(changes[0].kind, ChangeKind::Urdf);
    assert_eq!(changes[0].day, "4");
    let json = serde_json::to_value(&changes[0]).unwrap();
    assert_eq!(json["kind"], "urdf");
}

#[test]
fn the_order_of_rows_says_nothing() {
    let mut fleet = Drawn::fleet(20, 3, 11);
    for robot in [2, 5, 7, 11] {
        fleet.offset(robot, "l_knee", 0.03, 1..);
    }
    let forward = fleet.summary();
    fleet.rows.reverse();
    assert_eq!(forward, fleet.summary());
    assert_eq!(forward.shared.len(), 1);
}

/// An effect of angles that an encoder got wrong is nobody's.
#[test]
fn rows_of_a_stuck_encoder_say_nothing_of_effects() {
    let mut fleet = Drawn::fleet(20, 3, 12);
    for robot in [2, 5, 7, 11] {
        fleet.offset(robot, "l_knee", 0.03, 1..);
    }
    for row in fleet.rows(5, ..) {
        let finding = r#"{"kind": "encoder_stuck", "target": "r_el", "sentence": "It is stuck."}"#;
        row.health = vec![serde_json::from_str(finding).unwrap()];
        row.verdict = Some(crate::diagnose::Verdict::Unusable);
    }
    let found = fleet.summary();
    assert_eq!(found.shared[0].robots, ["r02", "r07", "r11"]);
    assert_eq!(found.look_first[0], "r05");
    assert_eq!(found.reasons[0].why, "It is stuck.");
}

/// Six robots of one batch, six of another with the opposite offset of the same joint.
#[test]
fn two_batches_of_one_joint_are_two_groups() {
    let mut fleet = Drawn::fleet(40, 3, 13);
    let (one, other) = ([1, 4, 9, 16, 25, 36], [2, 3, 5, 7, 11, 13]);
    for robot in one {
        fleet.offset(robot, "l_hip_roll", 0.035, 1..);
    }
    for robot in other {
        fleet.offset(robot, "l_hip_roll", -0.052, 1..);
    }
    let found = fleet.summary();
    let groups = found
        .shared
        .iter()
        .map(|group| (group.size, group.robots.clone()));
    let mut groups: Vec<(f64, Vec<String>)> = groups.collect();
    groups.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(groups.len(), 2, "{:?}", found.shared);
    let names = |robots: [usize; 6]| robots.map(|robot| format!("r{robot:02}")).to_vec();
    assert_eq!((&groups[0].1, &groups[1].1), (&names(other), &names(one)));
    assert!((groups[0].0 + 0.052).abs() < 0.002 && (groups[1].0 - 0.035).abs() < 0.002);
    let alone = |reason: &&Reason| reason.why.contains("no group shares");
    assert_eq!(found.reasons.iter().find(alone), None);
}

/// Steps of a joint's offset on the days of a robot: (first day, what is added from then on).
fn stepped(seed: u64, days: usize, steps: &[(usize, f64)]) -> Vec<(String, String)> {
    let mut fleet = Drawn::fleet(20, days, seed);
    for (k, (from, size)) in steps.iter().enumerate() {
        let to = steps.get(k + 1).map_or(days + 1, |next| next.0);
        if *size != 0.0 {
            fleet.offset(7, "l_knee", *size, *from..to);
        }
    }
    let changes = fleet.summary().changes.into_iter();
    changes.map(|change| (change.day, change.what)).collect()
}

/// A second step beside the first, what came and went, and what came for two days of thirty: what
/// is between other changes is held against its neighbours alone.
#[test]
fn two_steps_are_two_changes() {
    let second = ["not seen on 2", "on 9.", "on 9,", "on 12."];
    let gone = ["", "", "", "not seen on 12"];
    for (seed, days, steps, words) in [
        (14, 12, [(3, 0.035), (10, 0.105)], second),
        (15, 12, [(3, 0.035), (10, 0.0)], gone),
        (23, 30, [(20, 0.018), (22, 0.0)], [""; 4]),
    ] {
        let told = stepped(seed, days, &steps);
        let found: Vec<&str> = told.iter().map(|(day, _)| day.as_str()).collect();
        assert_eq!(found, steps.map(|(day, _)| day.to_string()), "{told:?}");
        for (k, word) in words.iter().enumerate() {
            assert!(told[k / 2].1.contains(word), "{told:?}");
        }
    }
}

/// A robot that changed once seems to change again no more often than a sound one does.
#[test]
fn one_step_is_one_change() {
    let again = |seed: &u64| stepped(2000 + seed, 9, &[(4, 0.035)]).len() > 1;
    let more = (0..100).filter(again).count();
    assert!(more <= 4, "{more} of 100 robots");
}

/// A row of effects of which each robot has another one.
fn with_effects_of_their_own(robots: usize) -> Drawn {
    let mut fleet = Drawn::fleet(20, 3, 17);
    for robot in 0..robots {
        let size = 0.02 + 0.001 * robot as f64;
        fleet.offset(robot, &format!("j{robot}"), size, 1..);
    }
    fleet
}

#[test]
fn bodies_that_differ_are_told_from_faults_of_a_few() {
    let said = with_effects_of_their_own(11).summary().bodies.unwrap();
    assert!(said.starts_with("11 of 20 robots"), "{said}");
    assert_eq!(with_effects_of_their_own(10).summary().bodies, None);
    // A batch of half of the fleet is a batch.
    let mut fleet = Drawn::fleet(20, 3, 18);
    (0..15).for_each(|robot| fleet.offset(robot, "l_knee", 0.03, 1..));
    let found = fleet.summary();
    assert_eq!((found.shared.len(), found.bodies), (1, None));
}

/// An explanation that comes and goes while the robot stays as it is.
#[test]
fn an_effect_that_nothing_bears_out_is_no_change() {
    let bear = |moved: bool, gap: Option<f64>| {
        let mut fleet = Drawn::fleet(12, 6, 19);
        let before = fleet.rows.clone();
        fleet.offset(3, "l_knee", 0.03, 4..);
        for (row, old) in fleet.rows.iter_mut().zip(before) {
            row.held_out_rmse = Some(5e-4);
            if !moved {
                row.params = old.params;
            }
            if let (Some(gap), false) = (gap, row.effects.explanation.is_empty()) {
                row.held_out_rmse = Some(gap);
            }
        }
        let mut changes = fleet.summary().changes.into_iter();
        changes.any(|change| change.kind == ChangeKind::Effect)
    };
    assert!(!bear(false, None));
    assert!(bear(true, None));
    // Backlash moves no parameter and leaves a gap.
    assert!(bear(false, Some(1e-3)));
    assert!(!bear(false, Some(5.2e-4)));
}

/// Each of forty parameters is known ten times less well than the sum of any two that follow each
/// other: masses that make up for an offset move along what is known.
#[test]
fn what_parameters_tell_together_bears_an_effect_out() {
    let bear = |sign: f64| {
        let mut fleet = Drawn::fleet(12, 2, 24);
        for row in &mut fleet.rows {
            for pair in (0..40).step_by(2) {
                let apart = 10.0 * row.params[pair];
                let sum = row.params[pair + 1];
                (row.params[pair], row.params[pair + 1]) = (apart + sum, sum - apart);
                let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
                let own = 101.0 * STD * STD;
                row.covariance[at(pair, pair)] = own;
                row.covariance[at(pair + 1, pair + 1)] = own;
                row.covariance[at(pair + 1, pair)] = -99.0 * STD * STD;
                row.std[pair] = Some(own.sqrt());
                row.std[pair + 1] = Some(own.sqrt());
            }
        }
        // Links without mass have parameters that are known exactly.
        for row in &mut fleet.rows {
            row.params.push(0.1);
            row.std.push(Some(0.0));
            row.covariance.extend(vec![0.0; PARAMS + 1]);
        }
        let before = fleet.rows.clone();
        fleet.offset(3, "l_knee", 0.05, 2..);
        for (row, old) in fleet.rows.iter_mut().zip(before) {
            row.params = old.params;
            if !row.effects.explanation.is_empty() {
                for pair in (0..40).step_by(2) {
                    row.params[pair] += 4.0 * STD;
                    row.params[pair + 1] += sign * 4.0 * STD;
                }
            }
        }
        let mut told = fleet.summary().changes.into_iter();
        told.any(|change| change.target == "joint_offset:l_knee")
    };
    assert!(bear(1.0));
    assert!(!bear(-1.0));
}

/// How days scatter is not known of two robots that both changed.
#[test]
fn robots_that_all_change_are_told() {
    let mut fleet = Drawn::fleet(2, 2, 22);
    fleet.offset(0, "l_knee", 0.05, 2..);
    fleet.offset(1, "l_knee", 0.05, 2..);
    let changes = fleet.summary().changes.into_iter();
    let told: Vec<String> = changes.map(|change| change.target).collect();
    assert_eq!(told, ["joint_offset:l_knee"; 2]);
}

/// A factor is 1 where nothing is wrong, and a stiffness infinite.
#[test]
fn factors_differ_from_one_and_stiffness_from_none() {
    let of = |name: &str, absent: Absent, sizes: [f64; 4]| {
        let mut fleet = Drawn::fleet(12, 3, 20);
        let parameter = [(name.to_string(), absent)];
        for (robot, value) in sizes.into_iter().enumerate() {
            fleet.offset(robot, "l_knee", 0.0, 1..);
            for row in fleet.rows(robot, ..) {
                let std = 0.02 * value;
                row.effects.explanation[0].effect = "joint_scale".into();
                row.effects.explanation[0].parameters =
                    [(name.to_string(), Quantity { value, std })].into();
                row.effects.explanation[0].absent = parameter.clone().into();
            }
        }
        fleet.summary().shared
    };
    // Sizes that scatter around nothing agree in being near 1, which says nothing.
    assert_eq!(of("scale", Absent::One, [0.95, 1.02, 0.98, 1.05]).len(), 0);
    let found = of("scale", Absent::One, [1.3; 4]);
    assert_eq!(found.len(), 1);
    assert!((found[0].size - 1.3).abs() < 1e-9 && (found[0].members[0].std - 0.026).abs() < 0.02);
    let found = of("stiffness_nm_per_rad", Absent::Infinite, [20.0; 4]);
    assert!((found[0].size - 20.0).abs() < 1e-9, "{found:?}");
    let off = found[0].std - 0.4 / 12.0_f64.sqrt();
    assert!(off.abs() < 1e-3, "{found:?}");
}

#[test]
fn changes_say_sizes_and_the_days_on_which_they_may_have_come() {
    let mut fleet = Drawn::fleet(20, 12, 21);
    fleet
        .rows(10, 6..)
        .for_each(|row| row.params[5] += 30.0 * STD);
    let found = fleet.summary().changes;
    assert_eq!(found.len(), 1, "{found:?}");
    let days = Some(["6", "6"].map(str::to_string));
    assert_eq!(found[0].day_interval, days);
    let [before, after] = [&found[0].before, &found[0].after].map(|size| size.unwrap());
    assert!((after.value - before.value - 30.0 * STD).abs() < 5.0 * STD);
    assert!(before.std >= STD && after.std >= STD);
}

/// A row that a file holds may have any numbers.
#[test]
fn numbers_of_any_size_make_no_panic() {
    for odd in [1e308, -1e308, f64::NAN, f64::INFINITY] {
        let mut fleet = Drawn::fleet(6, 6, 30);
        fleet.offset(1, "l_knee", 0.05, 3..);
        for row in fleet.rows(1, ..) {
            row.params[3] = odd;
            row.covariance[5] = odd;
            row.held_out_rmse = Some(odd);
        }
        for (k, row) in fleet.rows.iter_mut().enumerate().skip(20) {
            row.std[k % PARAMS] = Some(odd);
            row.params[7] = if k % 2 == 0 { odd } else { -odd };
        }
        fleet.summary();
    }
}
