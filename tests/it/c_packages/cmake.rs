//! CMake's and pkg-config's users.

use std::fs;
use std::process::Command;

use super::user::*;
use sesc_test_support::command::write;

#[test]
fn find_package_serves_c_and_cpp() {
    found(&fresh("find_package"), installed());
    let folder = fresh("find_other_version");
    let built = consumer(&folder, "C", &format!("find_package({NAME} 99 REQUIRED)"));
    let output = Command::new("cmake")
        .arg(format!("-DCMAKE_PREFIX_PATH={}", installed().display()))
        .arg("-S")
        .arg(&folder)
        .arg("-B")
        .arg(&built)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && message.contains("version"),
        "{message}"
    );
}

/// Shared or static, with the sines of libm: who links the package need not know.
#[test]
fn options_of_the_package_stay_within_it() {
    for shared in ["ON", "OFF"] {
        let folder = fresh(&format!("libm_shared_{shared}"));
        let prefix = install(
            &folder,
            &[
                &format!("-D{NAME}_USE_LIBM=ON"),
                &format!("-DBUILD_SHARED_LIBS={shared}"),
            ],
        );
        let pc = fs::read_to_string(prefix.join(format!("lib/pkgconfig/{NAME}.pc"))).unwrap();
        assert!(pc.contains(&format!("-l{NAME} -lm\n")), "{pc}");
        let user = folder.join("user");
        fs::create_dir(&user).unwrap();
        found(&user, &prefix);
    }
    let pc = installed().join(format!("lib/pkgconfig/{NAME}.pc"));
    assert!(!fs::read_to_string(pc).unwrap().contains("-lm"));
}

/// Projects of either language alone, and nothing of ours in what they install.
#[test]
fn fetch_content_takes_the_folder_in() {
    let folder = fresh("fetch_content");
    let source = folder.join("package");
    generate_op2(&source, "cmake", "f32");
    for (language, suffix) in [("C", "c"), ("CXX", "cpp")] {
        let user = folder.join(language);
        fs::create_dir(&user).unwrap();
        let how = format!(
            "include(FetchContent)\nFetchContent_Declare({NAME} SOURCE_DIR \"{}\")\n\
             FetchContent_MakeAvailable({NAME})",
            source.display()
        );
        let built = consumer(&user, language, &how);
        configure(&user, &built, &[]);
        build(&built);
        agrees(&built.join(format!("from_{suffix}")));
        let prefix = user.join("prefix");
        install_to(&built, &prefix);
        assert_eq!(files(&prefix), [format!("bin/from_{suffix}")]);
    }
}

#[test]
fn pkg_config_serves_compilers_alone() {
    let prefix = installed();
    let pkg_config = |arguments: &[&str]| {
        run(Command::new("pkg-config")
            .env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"))
            .args(arguments)
            .arg(NAME))
    };
    assert_eq!(pkg_config(&["--modversion"]).trim(), VERSION);
    let said = pkg_config(&["--variable=prefix"]);
    assert_eq!(
        fs::canonicalize(said.trim()).unwrap(),
        fs::canonicalize(prefix).unwrap()
    );
    let flags = pkg_config(&["--cflags", "--libs"]);
    let folder = fresh("pkg_config");
    for (compiler, source) in [("cc", "main.c"), ("c++", "main.cpp")] {
        let source = write(&folder, source, program());
        let binary = folder.join(compiler);
        run(Command::new(compiler)
            .arg(source)
            .args(flags.split_whitespace())
            .arg("-o")
            .arg(&binary));
        agrees(&binary);
    }
}
