//! What the library's messages call a setting, as a shell knows it.

use sesc_identify::Setting;

/// The option of a setting, with its value where it takes one that is not a number.
pub(crate) fn option(setting: Setting) -> String {
    let option = match setting {
        Setting::Angles => "--degrees",
        Setting::Columns => "put this line into the log's sidecar: columns =",
        Setting::Snapping => "--no-snap",
        Setting::OtherFoot => "--other-foot LINK",
        Setting::Support => "--support LINK",
        Setting::Feature(name) => return format!("`cargo install --features {name}`"),
        other => return format!("--{}", other.name().replace('_', "-")),
    };
    option.to_string()
}
