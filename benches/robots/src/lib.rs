//! Generated modules that are measured and tested, and too long to be read:
//! `build.rs` writes them into `OUT_DIR`, as a controller's does.

#![no_std]
#![forbid(unsafe_code)]

/// A humanoid with skewed axes: constants everywhere, the costly case.
pub mod skew_humanoid_right_sole {
    include!(concat!(env!("OUT_DIR"), "/skew_humanoid_right_sole.rs"));
}

/// The OP2 on its other foot, which tests alone need.
pub mod op2_l_sole {
    include!(concat!(env!("OUT_DIR"), "/op2_l_sole.rs"));
}

/// Two links with a load, joints that give way and an offset: effects of the body in every
/// function.
pub mod two_link_bent {
    include!(concat!(env!("OUT_DIR"), "/two_link_bent.rs"));
}
