//! The box around a mesh: STL files, binary or text; others are not read.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use sesc_model::files;

/// Larger files are not cheap to read, MiB.
const LARGEST: u64 = 64;
/// Bytes before the triangles of a binary STL: a title and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal, three corners, an attribute.
const TRIANGLE: usize = 50;

/// Lowest and highest corner of the mesh, m, before scaling.
///
/// # Errors
/// Why the mesh is left out, in a few words.
pub fn bounds(name: &str, folder: Option<&Path>) -> Result<(Vector3<f64>, Vector3<f64>), String> {
    let stl = name.to_ascii_lowercase().ends_with(".stl");
    if !stl {
        return Err("a mesh that is no STL file".to_string());
    }
    let path = find(name, folder).ok_or("a mesh whose file is not found")?;
    let bytes = files::read_found(&path, LARGEST)
        .map_err(|_| "a mesh whose file cannot be read, or is larger than 64 MiB")?;
    let around = binary(&bytes).or_else(|| text(&bytes));
    around.ok_or_else(|| "a mesh that is no valid STL".to_string())
}

/// A file named as ROS does it, looked for beside the URDF and above.
fn find(name: &str, folder: Option<&Path>) -> Option<PathBuf> {
    let is_file = |path: &PathBuf| path.is_file();
    if let Some(path) = name.strip_prefix("file://") {
        return Some(PathBuf::from(path)).filter(is_file);
    }
    let folder = match folder? {
        here if here.as_os_str().is_empty() => Path::new("."),
        there => there,
    };
    let folder = folder.canonicalize().ok()?;
    match name.strip_prefix("package://") {
        Some(path) => folder
            .ancestors()
            .map(|above| above.join(path))
            .find(is_file),
        None => Some(folder.join(name)).filter(is_file),
    }
}

fn binary(bytes: &[u8]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let count = u32::from_le_bytes(bytes.get(80..HEADER)?.try_into().ok()?) as usize;
    let triangles = bytes.get(HEADER..)?;
    if triangles.len() != count.checked_mul(TRIANGLE)? {
        return None;
    }
    let float = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corners = triangles.chunks_exact(TRIANGLE).flat_map(|triangle| {
        triangle[12..48]
            .chunks_exact(12)
            .map(|c| Vector3::new(float(c), float(&c[4..]), float(&c[8..])))
    });
    around(corners)
}

fn text(bytes: &[u8]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut words = text.split_whitespace();
    let mut corners = Vec::new();
    while words.any(|word| word == "vertex") {
        let mut next = || words.next()?.parse::<f64>().ok();
        corners.push(Vector3::new(next()?, next()?, next()?));
    }
    around(corners.into_iter())
}

fn around(corners: impl Iterator<Item = Vector3<f64>>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (low, high) = corners.fold(
        (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ),
        |(low, high), corner| (low.inf(&corner), high.sup(&corner)),
    );
    let sound = |v: &Vector3<f64>| v.iter().all(|x| x.abs() < 1e6);
    (sound(&low) && sound(&high)).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_of_stl_are_boxed() {
        let folder = tempfile::tempdir().unwrap();
        let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 -2\n\
                    vertex 0 3e0 0\nendloop\nendfacet\nendsolid x\n";
        std::fs::write(folder.path().join("a.stl"), text).unwrap();
        let mut bytes = vec![b'x'; 80];
        bytes.extend(1u32.to_le_bytes());
        for x in [
            0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -2.0, 0.0, 3.0, 0.0,
        ] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0, 0]);
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        std::fs::write(folder.path().join("meshes/B.STL"), &bytes).unwrap();
        let expected = (Vector3::new(0.0, 0.0, -2.0), Vector3::new(1.0, 3.0, 0.0));
        let here = Some(folder.path());
        assert_eq!(bounds("a.stl", here), Ok(expected));
        let below = folder.path().join("meshes");
        assert_eq!(bounds("package://meshes/B.STL", Some(&below)), Ok(expected));
        std::fs::write(folder.path().join("cut.stl"), &bytes[..100]).unwrap();
        for bad in ["cut.stl", "gone.stl", "a.dae"] {
            assert!(bounds(bad, here).is_err(), "{bad}");
        }
    }
}
