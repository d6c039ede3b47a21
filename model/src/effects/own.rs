//! A user's own effects, from a file.
//!
//! ```text
//! [[effect]]
//! name = "cable_pull"
//! site = "joint"                      # joint, sensor, ground, load, cell
//! targets = ["r_knee"]                # all of that site without it
//! adds = "stiffness * max(q - start, 0.0)"
//! sentence = "a cable pulls at {target}"
//! parameters.stiffness = { typical = 0.05 }
//! parameters.start = { typical = 0.5, unit = "rad", min = -1.0, max = 1.6 }
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::{Catalog, Composed, Constant, Definition, NO_UNIT, Site};
use crate::error::Problem;
use crate::formula::Formula;
use crate::text::{shortened, visible};
use crate::{Error, files};

/// The newest format that is read.
const NEWEST: u32 = 1;
/// Effects of one file, at most.
const MOST: usize = 1000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Own {
    #[serde(default)]
    effect: Vec<OwnEffect>,
    #[serde(default, rename = "format")]
    _format: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OwnEffect {
    name: String,
    site: Site,
    #[serde(default)]
    targets: Vec<String>,
    adds: String,
    at: Option<[f64; 3]>,
    #[serde(default)]
    parameters: BTreeMap<String, OwnParameter>,
    #[serde(default)]
    columns: BTreeMap<String, f64>,
    sentence: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OwnParameter {
    typical: f64,
    unit: Option<String>,
    min: Option<f64>,
    max: Option<f64>,
}

impl Catalog {
    /// These effects and those of a user's own file.
    ///
    /// # Errors
    /// When the file cannot be read, or an effect in it cannot be: which key of it, and what to do.
    pub fn with_file(self, path: &Path) -> Result<Catalog, Error> {
        let file = path.display().to_string();
        let text = files::read_text(path, files::SETTINGS).map_err(|source| Problem::Read {
            file: file.clone(),
            source,
        })?;
        self.with_text(&text, &file)
    }

    /// The same from its text; `file` names it in messages.
    ///
    /// # Errors
    /// As of [`Catalog::with_file`].
    pub fn with_text(mut self, text: &str, file: &str) -> Result<Catalog, Error> {
        let own: Own = files::parse_toml(text, NEWEST).map_err(|fault| Problem::ModelFile {
            file: file.to_string(),
            line: fault.line,
            reason: fault.reason,
        })?;
        let bad = |reason: String| Error::model_file(file, reason);
        match own.effect.len() {
            0 => return Err(bad("no effect in it; begin one with [[effect]]".to_string())),
            1..=MOST => {}
            more => return Err(bad(format!("{more} effects, more than {MOST}; give fewer"))),
        }
        for effect in own.effect {
            let name = shortened(&visible(&effect.name), 64);
            let composed = effect.composed();
            let composed = composed
                .map_err(|(key, reason)| bad(format!("effect `{name}`: {key}: {reason}")))?;
            if self.named(&name).is_some() {
                let reason = format!("effect `{name}`: name: it stands there twice; give another");
                return Err(bad(reason));
            }
            self = self.with(composed);
        }
        Ok(self)
    }
}

impl OwnEffect {
    fn composed(self) -> Result<&'static Composed, (&'static str, String)> {
        let function = Formula::parse(&self.adds).map_err(|fault| ("adds", fault.to_string()))?;
        let mut parameters = self.parameters;
        // In the order of the formula, then what is not in it.
        let names = function.parameters().into_iter();
        let known = names.filter_map(|name| parameters.remove_entry(&name));
        let mut all: Vec<(String, OwnParameter)> = known.collect();
        all.extend(parameters);
        let constants = all.into_iter().map(|(name, own)| Constant {
            name,
            typical: own.typical,
            unit: own.unit.unwrap_or_else(|| NO_UNIT.to_string()),
            limits: [
                own.min.unwrap_or(f64::NEG_INFINITY),
                own.max.unwrap_or(f64::INFINITY),
            ],
        });
        Composed::new(Definition {
            name: self.name,
            site: self.site,
            constants: constants.collect(),
            function,
            targets: self.targets,
            at: self.at,
            range: BTreeMap::new(),
            columns: self.columns,
            sentence: self.sentence,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CABLE: &str = r#"
        [[effect]]
        name = "cable_pull"
        site = "joint"
        targets = ["r_knee"]
        adds = "stiffness * max(q - start, 0.0)"
        parameters = { stiffness = { typical = 0.05, unit = "1" }, start = { typical = 0.5, unit = "rad", min = -1.0, max = 1.6 } }
        sentence = "a cable pulls at {target}"
    "#;

    fn refused(text: &str) -> String {
        let found = Catalog::standard().with_text(text, "own.toml");
        found.unwrap_err().to_string()
    }

    #[test]
    fn effects_of_a_file_join_the_catalog() {
        let catalog = Catalog::standard().with_text(CABLE, "own.toml").unwrap();
        let own = catalog.named("cable_pull").unwrap();
        let composed = own.composed().unwrap();
        let definition = composed.definition();
        assert_eq!(
            definition.function.to_string(),
            "stiffness * max(q - start, 0.0)"
        );
        assert_eq!(definition.constants[1].name, "start");
        // It starts anywhere in its range, as no size of the effect does.
        let robot = crate::urdf::parse(
            "<robot name='r'><link name='foot'/><link name='leg'><inertial><mass value='1'/>\
             </inertial></link><joint name='r_knee' type='continuous'><parent link='foot'/>\
             <child link='leg'/></joint></robot>",
            "r.urdf",
        );
        let robot = crate::Robot::new(&robot.unwrap(), "foot", Default::default()).unwrap();
        let context = super::super::EffectContext::new(&robot, &[], false, catalog.clone());
        let targets = own.targets(&context);
        assert_eq!(targets.len(), 1);
        let starts = own.starts(&context, &targets[0]);
        assert!(starts.len() > 3 && starts.iter().all(|start| start[0] == 0.05));
        assert_eq!(own.phrase(&targets[0], "r_knee"), "a cable pulls at r_knee");
    }

    #[test]
    fn what_cannot_be_is_refused_by_effect_and_key() {
        for (from, to, said) in [
            (
                "q - start",
                "q ^ start",
                "effect `cable_pull`: adds: column 19: `^` is no power",
            ),
            ("max(", "most(", "adds: column 13: no function `most`"),
            (
                "q - start",
                "x - start",
                "adds: `x` is no variable of site joint",
            ),
            (
                "q - start",
                "q - begin",
                "parameters: `begin` of the formula is missing",
            ),
            (
                "q - start",
                "q - 0.5",
                "parameters: `start` is not in the formula",
            ),
            (
                "typical = 0.05",
                "typical = 0.0",
                "typical is a number other than 0",
            ),
            (
                "typical = 0.05",
                "typical = nan",
                "typical is a number other than 0",
            ),
            ("min = -1.0", "min = 2.0", "min is above max"),
            (
                "\"cable_pull\"",
                "\"joint_offset\"",
                "an effect of sesc has this name",
            ),
            ("\"cable_pull\"", "\"cable pull\"", "letters, digits"),
            ("\"joint\"", "\"joints\"", "unknown variant"),
            ("sentence", "sentences", "unknown field"),
            ("unit = \"1\"", "unit = \"\"", "give a unit"),
        ] {
            let text = CABLE.replace(from, to);
            assert!(refused(&text).contains(said), "{to}: {}", refused(&text));
            assert!(refused(&text).starts_with("own.toml: "));
        }
        assert!(refused("").contains("begin one with [[effect]]"));
        assert!(refused(&CABLE.repeat(2)).contains("twice"));
    }

    #[test]
    fn no_broken_file_panics() {
        let mut state = 11_u64;
        let mut any = |n: usize| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as usize % n
        };
        let pieces = [
            "\"", "[", "]", "{", "}", "=", "\n", "1e999", "q", "-", "(", "inf", "nan", ",",
        ];
        for _ in 0..3_000 {
            let mut text = CABLE.to_string();
            for _ in 0..1 + any(3) {
                let at = any(text.len());
                let end = (at + any(6)).min(text.len());
                text.replace_range(at..end, pieces[any(pieces.len())]);
            }
            // Whatever comes out: an effect or a sentence.
            let _ = Catalog::standard().with_text(&text, "own.toml");
        }
    }
}
