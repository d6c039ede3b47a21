#![no_std]
#![forbid(unsafe_code)]
pub mod op2_r_sole; pub mod op2_l_sole; pub mod skew_humanoid_right_sole; pub mod two_link_foot;
