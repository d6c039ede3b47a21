//! Robot descriptions.

use sesc_model::{Model, Snapping, urdf};

/// Links of a robot that is worked out further than its tree.
const FEW: usize = 12;

/// Any text: read, and where it is a small robot, its programs, CoM and edits.
pub fn text(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let Ok(description) = urdf::parse(&text, "fuzz.urdf") else {
        return;
    };
    let _ = urdf::collisions(&description);
    let _ = urdf::extents(&description);
    if let Ok(edited) = urdf::edit_masses(&description, &vec![None; description.links.len()]) {
        assert!(
            urdf::parse(&edited, "edited.urdf").is_ok(),
            "what was read is written"
        );
    }
    let support = description.link_names().next().map(str::to_string);
    let (Some(support), true) = (support, description.links.len() <= FEW) else {
        return;
    };
    let Ok(model) = Model::new(&description, &support, Snapping::default()) else {
        return;
    };
    let q: Vec<f64> = (model.tree.dofs.iter())
        .map(|dof| 0.5 * dof.lower + 0.5 * dof.upper)
        .collect();
    let com = model.evaluate(sesc_model::Function::Com, &q, &model.cad_params());
    assert!(com.iter().all(|x| x.is_finite()), "{com:?} at {q:?}");
}
