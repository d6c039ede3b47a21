use sesc_codegen::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let t0 = Instant::now();
    let d = urdf::read(a[1].as_ref()).unwrap_or_else(|e| panic!("{e}"));
    let t1 = Instant::now();
    let m = Model::new(&d, &a[2], Snapping::default()).unwrap_or_else(|e| panic!("{e}"));
    println!("{:?} {:?}", t1 - t0, t1.elapsed());
    println!(
        "dof {} bodies {} full {} base {} cop {}",
        m.dof(),
        m.chain.bodies.len(),
        m.chain.full_params,
        m.base.params.len(),
        m.base.rank_cop
    );
    for f in Function::ALL {
        for g in [Given::Positions, Given::SinesCosines] {
            let t = Instant::now();
            if let Some(p) = m.program(f, g) {
                let tp = t.elapsed();
                let b = m.rounding(&p, bounds::Precision::F64).worst;
                println!(
                    "{} {:?} {:?} f64 {:.2e} f32 {:.2e} {:?} {:?}",
                    f.name(),
                    g,
                    p.counts(),
                    b,
                    m.rounding(&p, bounds::Precision::F32).worst,
                    tp,
                    t.elapsed()
                );
            }
        }
    }
    let t = Instant::now();
    let text = emit::rust::module(&m, "robot").unwrap();
    println!("emit {:?} {} bytes", t.elapsed(), text.len());
    if let Some(p) = a.get(3) {
        std::fs::write(p, text).unwrap();
    }
}
