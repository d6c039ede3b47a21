//! PlatformIO's and Arduino's users.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::user::*;
use sesc_test_support::command::write;

/// The part of Arduino's core that an example needs; the main program runs the loop once.
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
        // No core of 8-bit AVR, whose `double` has 32 bits.
        let cores: Vec<&str> = properties["architectures"].split(',').collect();
        assert_eq!(cores == ["*"], scalar != "f64");
        assert!(!cores.contains(&"avr") && !cores.contains(&"megaavr"));
        assert_eq!(properties["includes"], "op2_r_sole.h");
        assert_eq!(properties["category"], "Device Control");
        assert!(properties.contains_key("url"));
        for key in ["author", "maintainer", "sentence", "paragraph"] {
            assert!(!properties[key].is_empty(), "{key}");
        }
        near(
            &sketch(&library, NAME, &stub),
            reference(&[0.0; 20]),
            allowed_m,
        );
    }
    // No revolute joint: the example still has an array to pass.
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
