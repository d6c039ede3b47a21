//! The region of planned CoPs comes from the sole that the URDF has.

use sesc_test_support::command::{folder, sesc, stdout, write};

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
