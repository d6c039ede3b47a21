//! Header and source as a package that a build system takes as it is.
//!
//! What stands around the two files is in `templates/layout/`. Names of robots
//! and links hold any character: each format quotes them in its own way.

use std::path::PathBuf;

use minijinja::value::Value;
use minijinja::{Environment, context};

use super::{Options, Package, Scalar};
use crate::Error;
use crate::error::Problem;
use crate::facts::Facts;
use sesc_model::text::visible;

/// What a package is made for.
///
/// ```
/// use sesc_codegen::{Builder, Layout};
///
/// let builder = Builder::new("op2.urdf").support("r_sole").c99("lib").layout(Layout::PlatformIo);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Layout {
    /// `NAME.h` and `NAME.c`.
    Bare,
    /// A CMake project: target `NAME::NAME`, `find_package` and pkg-config.
    Cmake,
    /// A PlatformIO library.
    PlatformIo,
    /// A library of the Arduino IDE, with an example.
    Arduino,
}

impl Layout {
    /// Names that tools of this layout keep for themselves, in lower case.
    fn taken(self) -> &'static [&'static str] {
        match self {
            Layout::Bare | Layout::PlatformIo => &[],
            // Targets of its generators, and libraries that `-l` would then mistake.
            Layout::Cmake => &[
                "all",
                "all_build",
                "c",
                "clean",
                "depend",
                "edit_cache",
                "help",
                "install",
                "list_install_components",
                "m",
                "package",
                "package_source",
                "preinstall",
                "rebuild_cache",
                "run_tests",
                "test",
                "zero_check",
            ],
            // Its header is Arduino.h, and some file systems ignore case.
            Layout::Arduino => &["arduino"],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Layout::Bare => "bare",
            Layout::Cmake => "cmake",
            Layout::PlatformIo => "platformio",
            Layout::Arduino => "arduino",
        }
    }
}

/// Longest name of a robot or link in a description, so that it stays a sentence.
const LONGEST_WORD: usize = 60;

macro_rules! template {
    ($path:literal) => {
        include_str!(concat!("templates/layout/", $path))
    };
}

/// The files of `package`, generated as `name`: paths within its folder, and texts.
///
/// # Errors
/// When tools of the layout keep `name` for themselves.
pub fn files(
    facts: &Facts,
    package: Package,
    name: &str,
    options: &Options,
    layout: Layout,
) -> Result<Vec<(PathBuf, String)>, Error> {
    if layout.taken().contains(&name.to_lowercase().as_str()) {
        return Err(Problem::TakenName {
            name: name.to_string(),
            layout: layout.name(),
            suggestion: format!("{name}_robot"),
        }
        .into());
    }
    let ([headers, sources], around): ([&str; 2], &[(&str, &str)]) = match layout {
        Layout::Bare => (["", ""], &[]),
        Layout::Cmake => (
            ["include/", "src/"],
            &[
                ("CMakeLists.txt", template!("cmake/CMakeLists.txt")),
                ("{name}.pc.in", template!("cmake/package.pc.in")),
                ("README.md", template!("cmake/README.md")),
            ],
        ),
        Layout::PlatformIo => (
            ["include/", "src/"],
            &[
                ("library.json", template!("platformio/library.json")),
                ("README.md", template!("platformio/README.md")),
            ],
        ),
        Layout::Arduino => (
            ["src/", "src/"],
            &[
                (
                    "library.properties",
                    template!("arduino/library.properties"),
                ),
                (
                    "examples/{name}_basic/{name}_basic.ino",
                    template!("arduino/basic.ino"),
                ),
                ("README.md", template!("arduino/README.md")),
            ],
        ),
    };
    let texts = texts(facts, name, options)?;
    let mut files = vec![
        (format!("{headers}{name}.h").into(), package.header),
        (format!("{sources}{name}.c").into(), package.source),
    ];
    for (path, template) in around {
        files.push((
            path.replace("{name}", name).into(),
            render(template, &texts)?,
        ));
    }
    Ok(files)
}

/// What templates read.
fn texts(facts: &Facts, name: &str, options: &Options) -> Result<Value, Error> {
    let texts = context! {
        name,
        version => env!("CARGO_PKG_VERSION"),
        robot => word(facts.robot),
        support => word(facts.support),
        hash => &*facts.model.tree.hash,
        dof => facts.dof(),
        scalar => match options.scalar {
            Scalar::F64 => "f64",
            Scalar::F32 => "f32",
            Scalar::Fixed32 => "fixed32",
        },
        floats => options.scalar != Scalar::Fixed32,
        // Boards with a `double` of 64 bits, by the names of their cores.
        architectures => match options.scalar {
            Scalar::F64 => {
                "esp32,esp8266,mbed,mbed_giga,mbed_nano,mbed_opta,mbed_portenta,mbed_rp2040,nrf52,\
                 renesas,renesas_portenta,renesas_uno,rp2040,sam,samd,stm32,teensy"
            }
            Scalar::F32 | Scalar::Fixed32 => "*",
        },
        params => match facts.identified {
            Some(_) => "model_params",
            None => "cad_params",
        },
    };
    let description = render(template!("description.txt"), &texts)?;
    Ok(context! { description => description.trim_end(), ..texts })
}

fn render(template: &str, texts: &Value) -> Result<String, Error> {
    let mut environment = Environment::new();
    environment.add_filter("cmake", cmake);
    environment.add_filter("pkg_config", pkg_config);
    environment.add_filter("code", code);
    environment
        .add_template("call.c", template!("call.c"))
        .and_then(|()| environment.render_str(template, texts))
        .map(|text| text + "\n")
        .map_err(super::emitted)
}

/// A name on one line, and not the whole of a very long one.
fn word(name: &str) -> String {
    let name = visible(name.trim());
    match name.char_indices().nth(LONGEST_WORD) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name,
    }
}

/// Inside a quoted argument of CMake.
fn cmake(text: &str) -> String {
    let special = |c| matches!(c, '"' | '\\' | '$');
    let quoted = text
        .chars()
        .flat_map(|c| special(c).then_some('\\').into_iter().chain([c]));
    quoted.collect()
}

/// On a line of a pkg-config file. pkg-config and pkgconf agree on no way to
/// write `${`, nor a backslash before `#`.
fn pkg_config(text: &str) -> String {
    text.replace('\\', "/")
        .replace("${", "$ {")
        .replace('#', "\\#")
}

/// A code span of Markdown, fenced by more backticks than the text holds.
fn code(text: &str) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    let fence = "`".repeat(longest + 1);
    match longest {
        0 => format!("{fence}{text}{fence}"),
        _ => format!("{fence} {text} {fence}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_quotes_in_its_own_way() {
        assert_eq!(cmake(r#"a "b" \ ${c};$d"#), r#"a \"b\" \\ \${c};\$d"#);
        assert_eq!(pkg_config(r"a\#b ${c} $d"), r"a/\#b $ {c} $d");
        assert_eq!(code("r_sole"), "`r_sole`");
        assert_eq!(code("a``b"), "``` a``b ```");
        assert_eq!(word(" a\nb\u{1f916} "), "a\\u{a}b\u{1f916}");
        let long = word(&"é".repeat(100));
        assert_eq!(long.chars().count(), LONGEST_WORD + 1);
        assert!(long.ends_with('…'));
    }

    #[test]
    fn taken_names_would_serve_with_their_suggestion() {
        for layout in [Layout::Cmake, Layout::Arduino] {
            for name in layout.taken() {
                assert_eq!(*name, name.to_lowercase());
                let suggested = format!("{name}_robot");
                assert!(super::super::PREFIX.check(&suggested).is_ok(), "{name}");
            }
        }
    }
}
