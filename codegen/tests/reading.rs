//! Generated code is made to be read: `generated/` as a person sees it.

/// The OP2 on its right sole; `tests/fresh.rs` sees to it that it is what is written today.
const OP2: &str = include_str!("../../generated/src/op2_r_sole.rs");
const TWO_LINK: &str = include_str!("../../generated/src/two_link_foot.rs");
const OP2_FIXED: &str = include_str!("../../generated/c/op2_r_sole_fixed.c");

#[test]
fn a_statement_and_an_entry_hold_one_product_sum() {
    for line in OP2.lines().chain(TWO_LINK.lines()) {
        let whole_vector = line.trim_start().starts_with('[');
        assert!(
            whole_vector || line.matches("mul_plus").count() <= 1,
            "{line}"
        );
    }
}

/// No number of 2^30 stands in a body, and a mass is known by its kilograms.
#[test]
fn fixed_point_says_what_its_integers_are() {
    let bodies = OP2_FIXED.split("_total_mass_kg = ").nth(1).unwrap();
    assert!(bodies.contains("/* 2.925325253 kg, 29 bits below the point */"));
    assert!(bodies.contains("rows[0] = (int32_t)op2_r_sole_fixed_shift_up(1, 30u);"));
    assert!(!bodies.contains("= 1073741824;"));
}

/// A robot that does not move has a centre of mass all the same.
#[test]
fn a_robot_without_joints_becomes_code() {
    let text = "<robot name='still'><link name='foot'><inertial><origin xyz='0.1 0 0.2'/>\
                <mass value='2'/></inertial></link></robot>";
    let folder = std::env::temp_dir().join(format!("sesc_still_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let urdf = folder.join("still.urdf");
    std::fs::write(&urdf, text).unwrap();
    let builder = sesc_codegen::Builder::new(&urdf).support("foot");
    let module = builder.out_dir(&folder).emit().unwrap();
    let module = std::fs::read_to_string(module).unwrap();
    assert!(module.contains("pub const DOF: usize = 0;"), "{module}");
    std::fs::remove_dir_all(&folder).unwrap();
}
