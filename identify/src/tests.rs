//! Robots, noise and claims about texts that tests of several rooms share.

use std::fmt::Display;

/// Two skewed joints on a foot: every mass and every effect moves both axes, and flat CoP sees six
/// directions, two per posture.
pub(crate) const SKEW: &str = "<robot name='skew'>\
    <link name='foot'><inertial><origin xyz='0.01 0.02 0.05'/><mass value='2'/></inertial></link>\
    <joint name='hip' type='revolute'><parent link='foot'/><child link='thigh'/>\
    <origin xyz='0 0 0.1'/><axis xyz='0.3 0.8 0.2'/><limit lower='-0.6' upper='0.6'/></joint>\
    <link name='thigh'><inertial><origin xyz='0.05 0.1 0.2'/><mass value='3'/></inertial></link>\
    <joint name='knee' type='revolute'><parent link='thigh'/><child link='shank'/>\
    <origin xyz='0.02 0.01 0.4'/><axis xyz='0.9 -0.2 0.3'/><limit lower='-1' upper='1'/></joint>\
    <link name='shank'><inertial><origin xyz='0.1 -0.05 0.3'/><mass value='4'/></inertial></link>\
    </robot>";

/// Uniform numbers of deviation `std` about zero, the same every time.
pub(crate) fn noise(std: f64) -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * std * 12_f64.sqrt()
    }
}

/// Asserts that a text holds all of these words.
#[track_caller]
pub(crate) fn says(text: impl Display, words: &[&str]) {
    let text = text.to_string();
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}
