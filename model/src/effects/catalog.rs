//! Lists of effects, and what identifies an effect.

use std::fmt;

use super::Effect;

/// Which effect it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EffectId {
    name: &'static str,
    /// Of one that is made of a site and a function: which function.
    function: &'static str,
}

impl EffectId {
    /// The identity of the effect that is called `name` in reports and model files.
    pub const fn new(name: &'static str) -> EffectId {
        EffectId { name, function: "" }
    }

    /// The same name with a function: two functions at one place are two effects.
    pub(super) const fn of(name: &'static str, function: &'static str) -> EffectId {
        EffectId { name, function }
    }

    /// Name in reports and model files: `joint_offset`.
    pub const fn name(self) -> &'static str {
        self.name
    }
}

impl fmt::Debug for EffectId {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// A list of effects, the plainest first.
///
/// ```
/// use sesc_model::effects::Catalog;
///
/// let catalog = Catalog::standard();
/// let names: Vec<&str> = catalog.iter().map(|effect| effect.id().name()).collect();
/// assert!(names.contains(&"joint_offset"));
/// assert!(catalog.named("joint_ofset").is_none());
/// ```
#[derive(Clone)]
pub struct Catalog {
    effects: Vec<&'static dyn Effect>,
}

impl Catalog {
    /// These effects, the plainest first.
    pub(super) fn of(effects: &[&'static dyn Effect]) -> Catalog {
        Catalog {
            effects: effects.to_vec(),
        }
    }

    /// The same and one more, the least plain of them.
    pub fn with(mut self, effect: &'static dyn Effect) -> Catalog {
        self.effects.push(effect);
        self
    }

    /// All of them, the plainest first.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &'static dyn Effect> + '_ {
        self.effects.iter().copied()
    }

    /// The effect of this name.
    pub fn named(&self, name: &str) -> Option<&'static dyn Effect> {
        self.iter().find(|effect| effect.id().name() == name)
    }

    /// The place of an effect in the list; one past the last if it is not there.
    pub fn rank(&self, id: EffectId) -> usize {
        let place = self.effects.iter().position(|effect| effect.id() == id);
        place.unwrap_or(self.effects.len())
    }
}

impl fmt::Debug for Catalog {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list()
            .entries(self.iter().map(|effect| effect.id()))
            .finish()
    }
}
