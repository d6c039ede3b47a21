//! Writes the modules into `OUT_DIR`.

fn main() -> Result<(), sesc_codegen::Error> {
    sesc_codegen::Builder::new("../../robots/skew_humanoid/skew_humanoid.urdf")
        .support("right_sole")
        .emit()?;
    Ok(())
}
