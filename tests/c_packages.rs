//! Generated C as its users take it in: CMake, pkg-config, PlatformIO, Arduino.

#[path = "common/command.rs"]
mod command;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use command::{ROOT, folder, op2, refused, sesc, stdout, write};
use serde_json::Value;
use sesc_reference::{Reference, Robot};

const NAME: &str = "op2_r_sole";
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The header promises 1.3e-6 m for the f32 CoM of the OP2; printing adds its own last digit.
const F32_M: f64 = 2e-6;

/// What `program` prints; its failure is ours, with all it said.
fn run(program: &mut Command) -> String {
    let package = match program.get_program().to_str().unwrap() {
        "cmake" => "cmake (and make or ninja)",
        "pkg-config" => "pkg-config or pkgconf",
        "cc" => "a C compiler as cc",
        "c++" => "a C++ compiler as c++",
        other => other,
    }
    .to_string();
    let output = program.output().unwrap_or_else(|error| {
        panic!("{program:?}: {error}; this test needs {package}: install it")
    });
    assert!(
        output.status.success(),
        "{program:?}: {}\n{}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// A folder of its own for one test, empty, under the target folder.
fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("c_packages")
        .join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn generate(out: &Path, urdf: &str, support: &str, more: &[&str]) -> Vec<PathBuf> {
    let out = out.display().to_string();
    let usual = [
        "generate",
        urdf,
        "--support",
        support,
        "--lang",
        "c",
        "--out",
        &out,
    ];
    stdout(&sesc(&[&usual[..], more].concat()))
        .lines()
        .map(PathBuf::from)
        .collect()
}

fn generate_op2(out: &Path, layout: &str, scalar: &str) {
    let more = ["--layout", layout, "--scalar", scalar, "--name", NAME];
    generate(out, &op2(), "r_sole", &more);
}

fn posture() -> Vec<f32> {
    (0..20).map(|k| 0.3 - 0.03 * k as f32).collect()
}

fn reference(q: &[f64]) -> [f64; 3] {
    let robot = Robot::from_file(op2()).unwrap();
    Reference::new(&robot, "r_sole").unwrap().com(q).into()
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

fn near(line: &str, expected: [f64; 3], allowed_m: f64) {
    let numbers: Vec<f64> = line
        .split_whitespace()
        .map(|x| x.parse().unwrap())
        .collect();
    assert_eq!(numbers.len(), 3, "{line}");
    for (got, expected) in numbers.iter().zip(expected) {
        assert!(
            (got - expected).abs() < allowed_m,
            "{line} is not {expected:?}"
        );
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

/// Compiles the generated source as strict C.
fn compile_c(source: &Path, include: &Path, object: &Path) {
    run(Command::new("cc")
        .args([
            "-x",
            "c",
            "-std=c99",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-c",
            "-I",
        ])
        .arg(include)
        .arg(source)
        .arg("-o")
        .arg(object));
}

/// Keys and forms of <https://docs.platformio.org/en/latest/manifests/library-json/>.
#[test]
fn platformio_finds_what_its_manifest_names() {
    let folder = fresh("platformio");
    for scalar in ["f64", "f32", "fixed32"] {
        let library = folder.join(scalar);
        generate_op2(&library, "platformio", scalar);
        assert_eq!(
            files(&library),
            [
                "README.md",
                "include/op2_r_sole.h",
                "library.json",
                "src/op2_r_sole.c"
            ]
        );
        let manifest = fs::read_to_string(library.join("library.json")).unwrap();
        let manifest: Value = serde_json::from_str(&manifest).unwrap();
        assert_eq!(manifest["name"], NAME);
        assert_eq!(manifest["version"], VERSION);
        assert!((1..256).contains(&manifest["description"].as_str().unwrap().len()));
        assert_eq!(manifest["frameworks"], "*");
        assert_eq!(manifest["platforms"], "*");
        for keyword in manifest["keywords"].as_array().unwrap() {
            let allowed = |c: char| c.is_ascii_lowercase() || " -_.+".contains(c);
            assert!(keyword.as_str().unwrap().chars().all(allowed), "{keyword}");
        }
        let include = library.join(manifest["build"]["includeDir"].as_str().unwrap());
        let sources = library.join(manifest["build"]["srcDir"].as_str().unwrap());
        assert!(include.join(manifest["headers"].as_str().unwrap()).exists());
        compile_c(
            &sources.join("op2_r_sole.c"),
            &include,
            &library.join("package.o"),
        );
    }
}

/// As much of Arduino's core as an example needs; the main program turns the loop once.
const ARDUINO_H: &str = r#"#pragma once
#include <cstdio>
struct Port {
  operator bool() { return true; }
  void begin(unsigned long) {}
  void print(double x, int digits = 2) { std::printf("%.*f", digits, x); }
  void print(const char *text) { std::printf("%s", text); }
  void println(const char *text) { std::printf("%s\r\n", text); }
};
static Port Serial;
static inline void delay(unsigned long) {}
void setup();
void loop();
int main() { setup(); loop(); }
"#;

/// Keys and values of <https://docs.arduino.cc/arduino-cli/library-specification>.
#[test]
fn arduino_library_and_its_example_run() {
    let folder = fresh("arduino");
    let stub = folder.join("core");
    fs::create_dir(&stub).unwrap();
    write(&stub, "Arduino.h", ARDUINO_H);
    for (scalar, allowed_m) in [("f64", 1e-6), ("f32", F32_M + 1e-6), ("fixed32", 2e-6)] {
        let library = folder.join(scalar);
        generate_op2(&library, "arduino", scalar);
        assert_eq!(
            files(&library),
            [
                "README.md",
                "examples/op2_r_sole_basic/op2_r_sole_basic.ino",
                "library.properties",
                "src/op2_r_sole.c",
                "src/op2_r_sole.h"
            ]
        );
        let properties = properties(&library);
        assert_eq!(properties["name"], NAME);
        assert_eq!(properties["version"], VERSION);
        assert_eq!(properties["architectures"], "*");
        assert_eq!(properties["includes"], "op2_r_sole.h");
        assert_eq!(properties["category"], "Device Control");
        assert!(properties["url"].starts_with("https://"));
        for key in ["author", "maintainer", "sentence", "paragraph"] {
            assert!(!properties[key].is_empty(), "{key}");
        }
        near(
            &sketch(&library, NAME, &stub),
            reference(&[0.0; 20]),
            allowed_m,
        );
    }
    // Nothing that turns: the example still has an array to pass.
    let post = write(
        &folder,
        "post.urdf",
        "<robot name='post'><link name='foot'><inertial><origin xyz='0 0 0.5'/>\
         <mass value='2'/></inertial></link></robot>",
    );
    for scalar in ["f32", "fixed32"] {
        let library = folder.join(format!("post_{scalar}"));
        let more = ["--layout", "arduino", "--scalar", scalar, "--name", "post"];
        generate(&library, &post, "foot", &more);
        near(&sketch(&library, "post", &stub), [0.0, 0.0, 0.5], 1e-6);
    }
}

fn properties(library: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(library.join("library.properties")).unwrap();
    text.lines()
        .map(|line| {
            let (key, value) = line.split_once('=').unwrap();
            (key.to_string(), value.to_string())
        })
        .collect()
}

/// What the example prints; the builder of Arduino puts its header before a sketch.
fn sketch(library: &Path, name: &str, core: &Path) -> String {
    let (source, object, binary) = (
        library.join(format!("src/{name}.c")),
        library.join("package.o"),
        library.join("example"),
    );
    compile_c(&source, &library.join("src"), &object);
    run(Command::new("c++")
        .args([
            "-x",
            "c++",
            "-std=c++11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-include",
            "Arduino.h",
            "-I",
        ])
        .arg(core)
        .arg("-I")
        .arg(library.join("src"))
        .arg(library.join(format!("examples/{name}_basic/{name}_basic.ino")))
        .args(["-x", "none"])
        .arg(&object)
        .arg("-o")
        .arg(&binary));
    run(&mut Command::new(binary))
}

/// Robots are named by people: every format quotes the name in its own way.
#[test]
fn names_of_robots_break_no_format() {
    let folder = fresh("names");
    let robot = r#"a"b'c;d $e @PATH@ $ENV{HOME} #f \" `h` <i>&*j*%k%]]=二足🤖\"#;
    let escaped = robot
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;");
    let urdf = write(
        &folder,
        "odd.urdf",
        format!(
            "<robot name=\"{escaped}\"><link name=\"{escaped}\"><inertial><mass value=\"1\"/>\
             </inertial></link></robot>"
        ),
    );
    let of = |layout: &str| {
        let out = folder.join(layout);
        generate(&out, &urdf, robot, &["--layout", layout, "--name", "odd"]);
        out
    };
    let manifest = fs::read_to_string(of("platformio").join("library.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let description = manifest["description"].as_str().unwrap();
    assert!(
        description.starts_with(&format!("Centre of mass of {robot} standing on {robot} (")),
        "{description}"
    );

    let library = of("arduino");
    assert_eq!(properties(&library)["sentence"], description);

    let (package, built) = (of("cmake"), folder.join("build"));
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

#[test]
fn layouts_are_refused_where_they_cannot_be() {
    let folder = folder();
    let out = folder.path().display().to_string();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    let base = ["generate", &two_link, "--support", "foot", "--out", &out];
    let run = |more: &[&str]| sesc(&[&base[..], more].concat());
    refused(
        &run(&["--lang", "rust", "--layout", "cmake"]),
        &["--layout", "--lang c"],
    );
    refused(&run(&["--layout", "bare"]), &["--layout", "--lang c"]);
    for (layout, name) in [("cmake", "test"), ("cmake", "m"), ("arduino", "Arduino")] {
        let asked = ["--lang", "c", "--layout", layout, "--name", name];
        refused(&run(&asked), &[layout, &format!("`{name}_robot`")]);
    }
    refused(
        &run(&["--lang", "c", "--layout", "meson"]),
        &["meson", "cmake", "platformio"],
    );
    assert_eq!(files(folder.path()), [""; 0]);
}

/// A file in the way of the last one: the others are not touched.
#[test]
fn packages_appear_whole_or_not_at_all() {
    let folder = folder();
    let out = folder.path().display().to_string();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    let run = || {
        sesc(&[
            "generate",
            &two_link,
            "--support",
            "foot",
            "--lang",
            "c",
            "--layout",
            "arduino",
            "--name",
            "legs",
            "--out",
            &out,
        ])
    };
    for blocked in ["examples", "src/legs.c/inside"] {
        let path = folder.path().join(blocked);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "mine").unwrap();
        refused(&run(), &["cannot write"]);
        assert_eq!(files(folder.path()), [blocked]);
        fs::remove_file(&path).unwrap();
        let _ = fs::remove_dir(path.parent().unwrap());
    }
    stdout(&run());
    assert_eq!(files(folder.path()).len(), 5);
}

#[test]
fn the_same_robot_gives_the_same_bytes() {
    let folder = folder();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    for layout in ["bare", "cmake", "platformio", "arduino"] {
        let more = ["--layout", layout, "--scalar", "f32", "--name", "legs"];
        let (one, two) = (
            folder.path().join(layout),
            folder.path().join("again").join(layout),
        );
        let printed = generate(&one, &two_link, "foot", &more);
        generate(&two, &two_link, "foot", &more);
        let printed: BTreeSet<PathBuf> = printed.into_iter().collect();
        let there: BTreeSet<PathBuf> = files(&one).iter().map(|file| one.join(file)).collect();
        assert_eq!(printed, there, "every file is named on stdout");
        for file in files(&one) {
            let text = fs::read_to_string(one.join(&file)).unwrap();
            assert_eq!(text, fs::read_to_string(two.join(&file)).unwrap(), "{file}");
            assert!(text.ends_with('\n') && !text.ends_with("\n\n"), "{file}");
            assert!(!text.lines().any(|line| line.ends_with(' ')), "{file}");
        }
        assert_eq!(files(&one), files(&two));
    }
    assert_eq!(files(&folder.path().join("bare")), ["legs.c", "legs.h"]);
    let plain = folder.path().join("plain");
    generate(&plain, &two_link, "foot", &["--name", "legs"]);
    assert_eq!(files(&plain), ["legs.c", "legs.h"], "bare unless asked");
}

/// Files below `folder`, sorted, with `/` between names.
fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let file = path.strip_prefix(folder).unwrap();
                let parts: Vec<_> = file.iter().map(|part| part.to_str().unwrap()).collect();
                found.push(parts.join("/"));
            }
        }
    }
    found.sort();
    found
}
