fn main() -> Result<(), Box<dyn std::error::Error>> {
    sesc_codegen::Builder::new("../../robots/op2/op2.urdf")
        .support("r_sole")
        // What main.rs calls, and the rows of the estimator: the rest need not be compiled.
        .functions([
            "com_jacobian",
            "cop",
            "cop_jacobian",
            "gravity_moments",
            "regressor",
            "regressor_cop",
        ])
        .emit()?;
    Ok(())
}
