//! Generated code of another version does not compile, and says what to do.

use sesc_test_support::child::Child;
use sesc_test_support::command::ROOT;

#[test]
fn generated_code_of_another_version_says_what_to_do() {
    let child = Child::new("interface", "");
    let module = std::fs::read_to_string(format!("{ROOT}/generated/src/two_link_foot.rs"));
    let module = module.unwrap();
    child.write("src/lib.rs", &module);
    child.cargo(&["check"]).unwrap();
    let other = module.replace("__interface!(1)", "__interface!(2)");
    let other = other.replace("v1", "v2");
    assert_ne!(other, module);
    child.write("src/lib.rs", &other);
    let refused = child.cargo(&["check"]).unwrap_err();
    let sentence = "this file was generated for version 2 of the interface between \
                    sesc-codegen and sesc-runtime, and the sesc-runtime of this build has \
                    version 1: give both crates the same version in Cargo.toml";
    assert!(refused.contains(sentence), "{refused}");
}
