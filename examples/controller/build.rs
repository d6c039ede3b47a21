fn main() -> Result<(), Box<dyn std::error::Error>> {
    sesc_codegen::Builder::new("../../robots/op2/op2.urdf")
        .support("r_sole")
        .emit()?;
    Ok(())
}
