//! Files in folders of their own.

use super::*;

/// A folder of its own for a test, removed with it.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let own = format!("sesc-files-{}-{name}", std::process::id());
        let folder = std::env::temp_dir().join(own);
        fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<_> = entries.map(name).collect();
        names.sort();
        names
            .into_iter()
            .map(|name| name.into_string().unwrap())
            .collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Write one file; whether it changed.
fn write(path: &Path, text: &str) -> Result<bool, Error> {
    let changed = write_all_if_changed(&[(path.to_path_buf(), text.to_string())])?;
    Ok(changed == [true])
}

#[test]
fn files_that_belong_together_appear_together() {
    let folder = Folder::new("together");
    let file = |name: &str, text: &str| (folder.0.join(name), text.to_string());
    let both = [file("new/a.c", "1"), file("new/a.h", "2")];
    assert_eq!(write_all_if_changed(&both).unwrap(), [true, true]);
    let one = [file("new/a.c", "1"), file("new/a.h", "3")];
    assert_eq!(write_all_if_changed(&one).unwrap(), [false, true]);
    // A folder in the place of the second: the first stays as it was.
    let bad = [file("new/a.c", "4"), file("new", "5")];
    assert!(write_all_if_changed(&bad).is_err());
    assert_eq!(fs::read_to_string(folder.0.join("new/a.c")).unwrap(), "1");
    let count = || fs::read_dir(folder.0.join("new")).unwrap().count();
    assert_eq!(count(), 2);
    // A file that cannot be renamed leaves none beside its place.
    let late = Beside::new(&folder.0.join("new/a.c"), "6").unwrap();
    assert_eq!(count(), 3);
    drop(late);
    assert_eq!(count(), 2);
}

#[cfg(unix)]
#[test]
fn links_and_permissions_are_kept_and_protected_files_stay() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};

    let folder = Folder::new("mode");
    let [path, link] = ["a.txt", "link"].map(|name| folder.0.join(name));
    let protect = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
    fs::write(&path, "old").unwrap();
    symlink(&path, &link).unwrap();
    protect(0o600);
    write(&link, "new").unwrap();
    let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
    assert!(link.is_symlink() && mode() == 0o600);
    protect(0o444);
    let error = write(&path, "newer").unwrap_err();
    assert!(format!("{error:?}").contains("write-protected"));
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(folder.names(), ["a.txt", "link"]);
    // Links that were planted where unfinished files stand are not followed.
    for k in 0..1000 {
        let name = format!(".sesc-{}-{k}.part", std::process::id());
        symlink(&path, folder.0.join(name)).unwrap();
    }
    let pair = [("a.h", "1"), ("a.c", "2")];
    let pair = pair.map(|(name, text)| (folder.0.join(name), text.to_string()));
    write_all_if_changed(&pair).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(fs::read_to_string(&pair[1].0).unwrap(), "2");
    assert!(!pair[1].0.is_symlink());
}

/// A rename onto `/dev/stdout` takes away the file that a shell appends to.
#[cfg(target_os = "linux")]
#[test]
fn descriptors_and_devices_are_no_places_for_files() {
    use std::os::fd::AsRawFd as _;

    let folder = Folder::new("stream");
    let log = folder.0.join("log.txt");
    fs::write(&log, "everything so far").unwrap();
    let open = File::options().append(true).open(&log).unwrap();
    let descriptor = format!("/proc/self/fd/{}", open.as_raw_fd());
    let link = folder.0.join("link");
    std::os::unix::fs::symlink(&descriptor, &link).unwrap();
    for path in [Path::new(&descriptor), &link, Path::new("/dev/null")] {
        let error = write(path, "text").unwrap_err();
        assert!(format!("{error:?}").contains("stream"), "{error:?}");
    }
    assert_eq!(fs::read_to_string(&log).unwrap(), "everything so far");
}

/// Two writers of one pair, again and again: the pair is one writer's.
#[test]
fn pairs_of_two_writers_are_not_mixed() {
    let folder = Folder::new("pairs");
    let names = ["a.h", "a.c"].map(|name| folder.0.join(name));
    std::thread::scope(|scope| {
        for writer in ["one", "two"] {
            let names = &names;
            scope.spawn(move || {
                for k in 0..10 {
                    let text = format!("{writer} {}", k % 2);
                    let pair = names.clone().map(|name| (name, text.clone()));
                    write_all_if_changed(&pair).unwrap();
                }
            });
        }
    });
    let text = names.map(|name| fs::read_to_string(name).unwrap());
    assert_eq!(text[0], text[1]);
}

#[test]
fn what_is_read_and_what_is_written_are_compared_where_they_really_are() {
    let folder = Folder::new("access");
    let at = |name: &str| folder.0.join(name);
    fs::write(at("a.urdf"), "").unwrap();
    let check = |written: &[PathBuf]| {
        let access = Access::default().reads([at("a.urdf"), at("missing")]);
        let access = access.reserves([at("l.csv.toml")], "the sidecar of a log");
        access.writes(written.iter().cloned()).check()
    };
    assert!(check(&[at("b.urdf"), at("missing")]).is_ok());
    let refused = |written: &[PathBuf], words: &str| {
        assert!(check(written).unwrap_err().contains(words), "{written:?}");
    };
    let again = folder.0.join("..").join(folder.0.file_name().unwrap());
    refused(&[again.join("a.urdf")], "is read here");
    refused(&[at("l.csv.toml")], "sidecar");
    refused(&[at("new/x"), again.join("new/x")], "two outputs");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("a.urdf"), at("link")).unwrap();
        refused(&[at("link")], "is read here");
        std::os::unix::fs::symlink(&folder.0, at("here")).unwrap();
        refused(&[at("here/a.urdf")], "is read here");
    }
}

#[test]
fn texts_are_read_up_to_their_bound() {
    let folder = Folder::new("bound");
    let path = folder.0.join("a.toml");
    fs::write(&path, vec![b' '; 1 << 20]).unwrap();
    assert_eq!(read_text(&path, 1).unwrap().len(), 1 << 20);
    fs::write(&path, vec![b' '; (1 << 20) + 1]).unwrap();
    let error = read_text(&path, 1).unwrap_err().to_string();
    assert!(error.contains("longer than 1 MiB"), "{error}");
    fs::write(&path, [0xff]).unwrap();
    assert!(read_text(&path, 1).is_err());
}
