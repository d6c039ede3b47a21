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
fn a_link_stays_a_link() {
    let folder = Folder::new("link");
    let link = folder.0.join("link");
    write(&folder.0.join("a.txt"), "old").unwrap();
    std::os::unix::fs::symlink(folder.0.join("a.txt"), &link).unwrap();
    write(&link, "new").unwrap();
    assert!(link.is_symlink());
    assert_eq!(fs::read_to_string(folder.0.join("a.txt")).unwrap(), "new");
}

#[cfg(unix)]
#[test]
fn planted_links_are_not_followed() {
    let folder = Folder::new("planted");
    let precious = folder.0.join("precious");
    fs::write(&precious, "old").unwrap();
    for k in 0..1000 {
        let name = format!(".sesc-{}-{k}.part", std::process::id());
        std::os::unix::fs::symlink(&precious, folder.0.join(name)).unwrap();
    }
    let pair = [("a.h", "1"), ("a.c", "2")];
    let pair = pair.map(|(name, text)| (folder.0.join(name), text.to_string()));
    write_all_if_changed(&pair).unwrap();
    assert_eq!(fs::read_to_string(&precious).unwrap(), "old");
    assert_eq!(fs::read_to_string(folder.0.join("a.c")).unwrap(), "2");
    assert!(!folder.0.join("a.c").is_symlink());
}

#[cfg(unix)]
#[test]
fn permissions_are_kept_and_protected_files_stay() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = Folder::new("mode");
    let path = folder.0.join("a.txt");
    fs::write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    write(&path, "new").unwrap();
    let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(), 0o600);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    let error = write(&path, "newer").unwrap_err();
    assert!(
        format!("{error:?}").contains("write-protected"),
        "{error:?}"
    );
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(folder.names(), ["a.txt"]);
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
    let again = folder.0.join("..").join(folder.0.file_name().unwrap());
    assert!(
        check(&[again.join("a.urdf")])
            .unwrap_err()
            .contains("is read here")
    );
    assert!(check(&[at("l.csv.toml")]).unwrap_err().contains("sidecar"));
    let twice = [at("new/x"), again.join("new/x")];
    assert!(check(&twice).unwrap_err().contains("two outputs"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("a.urdf"), at("link")).unwrap();
        assert!(check(&[at("link")]).unwrap_err().contains("is read here"));
        std::os::unix::fs::symlink(&folder.0, at("here")).unwrap();
        assert!(
            check(&[at("here/a.urdf")])
                .unwrap_err()
                .contains("is read here")
        );
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
