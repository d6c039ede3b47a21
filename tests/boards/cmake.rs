//! CMake's and pkg-config's users.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::user::*;
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

fn configure(source: &Path, build: &Path, options: &[&str]) {
    let mut cmake = Command::new("cmake");
    cmake.arg("-S").arg(source).arg("-B").arg(build);
    // Deprecations and misuse of the package fail here, not at its users.
    run(cmake
        .args(["-Werror=dev", "-DCMAKE_BUILD_TYPE=Release"])
        .args(options));
}

fn build(build: &Path) {
    run(Command::new("cmake").arg("--build").arg(build));
}

/// Generated, built and installed below `folder`; the prefix.
fn install(folder: &Path, options: &[&str]) -> PathBuf {
    let (source, built, prefix) = (
        folder.join("source"),
        folder.join("build"),
        folder.join("prefix"),
    );
    generate_op2(&source, "cmake", "f32");
    configure(
        &source,
        &built,
        &[&["-DCMAKE_INSTALL_LIBDIR=lib"], options].concat(),
    );
    build(&built);
    install_to(&built, &prefix);
    prefix
}

fn install_to(built: &Path, prefix: &Path) {
    run(Command::new("cmake")
        .arg("--install")
        .arg(built)
        .arg("--prefix")
        .arg(prefix));
}

/// The package as most users have it, installed once.
fn installed() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| install(&fresh("installed"), &[]))
}

/// A CMake project that takes the package in by `how` and links it, in C, C++ or both.
fn consumer(folder: &Path, languages: &str, how: &str) -> PathBuf {
    let mut lists = format!(
        "cmake_minimum_required(VERSION 3.14)\nproject(consumer LANGUAGES {languages})\n{how}\n"
    );
    for language in languages.split(' ') {
        let suffix = if language == "C" { "c" } else { "cpp" };
        write(folder, &format!("main.{suffix}"), program());
        lists += &format!(
            "add_executable(from_{suffix} main.{suffix})\n\
             target_link_libraries(from_{suffix} PRIVATE {NAME}::{NAME})\n\
             install(TARGETS from_{suffix} DESTINATION bin)\n"
        );
    }
    write(folder, "CMakeLists.txt", lists);
    folder.join("build")
}

fn found(folder: &Path, prefix: &Path) {
    let how = format!("find_package({NAME} {VERSION} REQUIRED)");
    let built = consumer(folder, "C CXX", &how);
    configure(
        folder,
        &built,
        &[&format!("-DCMAKE_PREFIX_PATH={}", prefix.display())],
    );
    build(&built);
    agrees(&built.join("from_c"));
    agrees(&built.join("from_cpp"));
}

#[test]
fn names_of_robots_break_neither_cmake_nor_pkg_config() {
    let folder = fresh("names_of_cmake");
    let description = odd_description(&folder);
    let (_, package) = oddly_named(&folder, "cmake");
    let built = folder.join("build");
    configure(&package, &built, &[]);
    let cache = fs::read_to_string(built.join("CMakeCache.txt")).unwrap();
    assert!(
        cache.contains(&format!("CMAKE_PROJECT_DESCRIPTION:STATIC={description}\n")),
        "{cache}"
    );
    let list = run(Command::new("pkg-config")
        .env("PKG_CONFIG_PATH", &built)
        .env("PKG_CONFIG_LIBDIR", &built)
        .arg("--list-all"));
    let said = description.replace('\\', "/");
    assert!(list.trim_end().ends_with(&said), "{list} is not {said}");
}

/// A user's program in C and C++ alike: prints the CoM, returns what the self-test says.
fn program() -> String {
    let q: Vec<String> = posture().iter().map(|q| format!("{q:?}f")).collect();
    format!(
        "#include <{NAME}.h>\n#include <stdio.h>\n\n\
         int main(void)\n{{\n    const {NAME}_real q[{NAME}_DOF] = {{{}}};\n    \
         {NAME}_real com[3];\n    {NAME}_com(q, {NAME}_cad_params, com);\n    \
         printf(\"%.9g %.9g %.9g\\n\", (double)com[0], (double)com[1], (double)com[2]);\n    \
         return {NAME}_selftest();\n}}\n",
        q.join(", ")
    )
}

/// Runs a compiled [`program`].
fn agrees(binary: &Path) {
    let q: Vec<f64> = posture().into_iter().map(f64::from).collect();
    near(&run(&mut Command::new(binary)), reference(&q), F32_M);
}
