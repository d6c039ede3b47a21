//! Files of other formats than those that are read: what they are, and the command that converts
//! them.

use std::path::Path;

/// First bytes of a file, what it is, and what makes a log of it; `@` stands for its path, `$`
/// for its path without the ending.
const FORMATS: [(&[u8], &str, &str); 15] = [
    (
        b"SQLite f",
        "a recording of ROS 2 in SQLite",
        "convert it by `mcap convert @ $.mcap`",
    ),
    (
        b"#ROSBAG ",
        "a recording of ROS 1",
        "convert it by `mcap convert @ $.mcap`",
    ),
    (
        b"\x28\xb5\x2f\xfd",
        "compressed by zstd",
        "unpack it by `zstd -d @`",
    ),
    (b"BZh", "compressed by bzip2", "unpack it by `bunzip2 @`"),
    (b"\xfd7zXZ", "compressed by xz", "unpack it by `unxz @`"),
    (
        b"\x04\x22\x4d\x18",
        "compressed by lz4",
        "unpack it by `unlz4 @`",
    ),
    (
        b"PK\x03\x04",
        "a packed folder or a spreadsheet",
        "unpack it, or save the sheet as CSV",
    ),
    (b"7z\xbc\xaf", "a packed folder", "unpack it by `7z x @`"),
    (
        b"\xd0\xcf\x11\xe0",
        "a spreadsheet of Excel",
        "save it as CSV",
    ),
    (
        b"\x89HDF",
        "an HDF5 file, as MATLAB and h5py write them",
        "write a table: `writetable(T, '$.csv')`, or `DataFrame.to_parquet`",
    ),
    (
        b"MATLAB 5",
        "a MAT-file",
        "write a table in MATLAB: `writetable(T, '$.csv')`",
    ),
    (
        b"\x93NUMPY",
        "an array of NumPy, without names of columns",
        "write it by `numpy.savetxt('$.csv', a, delimiter=',', header='pose,…', comments='')`",
    ),
    (
        b"ARROW1",
        "an Arrow or Feather file",
        "write it as Parquet: `pandas.read_feather('@').to_parquet('$.parquet')`",
    ),
    (
        b"\x80\x04\x95",
        "a pickle of Python",
        "write the data frame by `to_parquet` or `to_csv`",
    ),
    (
        b"\x80\x05\x95",
        "a pickle of Python",
        "write the data frame by `to_parquet` or `to_csv`",
    ),
];

/// What is said of a file that begins as one of another format does.
pub(super) fn file(name: &str, head: &[u8]) -> Option<String> {
    let (_, what, remedy) = FORMATS.iter().find(|(first, ..)| head.starts_with(first))?;
    let stem = Path::new(name).with_extension("");
    let remedy = remedy.replace('$', &stem.display().to_string());
    Some(format!("{what}; {}", remedy.replace('@', name)))
}

/// What is said of a folder, which may be a recording of ROS 2.
pub(super) fn folder(path: &Path) -> String {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let mut files: Vec<String> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    files.sort();
    let ends = |end: &'static str| move |name: &&String| name.ends_with(end);
    match (
        files.iter().find(ends(".mcap")),
        files.iter().find(ends(".db3")),
    ) {
        (Some(own), _) => format!("a folder; give the recording in it, `{own}`"),
        (_, Some(own)) => {
            let stem = own.trim_end_matches(".db3");
            format!(
                "a folder with a recording of ROS 2 in SQLite, `{own}`; convert it by `mcap \
                 convert {} {stem}.mcap`",
                path.join(own).display()
            )
        }
        _ => "a folder; give a log, or the folder to `fleet`".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_converts_what_is_not_read() {
        let said = file("run/a.bag", b"#ROSBAG V2.0\n").unwrap();
        assert!(
            said.ends_with("`mcap convert run/a.bag run/a.mcap`"),
            "{said}"
        );
        assert_eq!(file("a.csv", b"pose,hip"), None);
        assert_eq!(file("a.csv", b"# pose,h"), None);
    }

    #[test]
    fn a_folder_of_ros_2_names_its_recording() {
        let at = tempfile::tempdir().unwrap();
        assert!(folder(at.path()).contains("`fleet`"));
        std::fs::write(at.path().join("r_0.db3"), "").unwrap();
        assert!(folder(at.path()).contains("r_0.db3 r_0.mcap`"));
        std::fs::write(at.path().join("r_0.mcap"), "").unwrap();
        assert!(folder(at.path()).ends_with("`r_0.mcap`"));
    }
}
