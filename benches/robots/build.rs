//! Writes the modules into `OUT_DIR`.

fn main() -> Result<(), sesc_codegen::Error> {
    sesc_codegen::Builder::new("../../robots/skew_humanoid/skew_humanoid.urdf")
        .support("right_sole")
        .emit()?;
    sesc_codegen::Builder::new("../../robots/op2/op2.urdf")
        .support("l_sole")
        .emit()?;
    sesc_codegen::Builder::new("../../robots/two_link/two_link.urdf")
        .support("foot")
        .model("two_link_bent.toml")
        .name("two_link_bent")
        .emit()?;
    Ok(())
}
