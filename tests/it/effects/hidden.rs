//! What each effect is called, how large it may be, and how a virtual robot comes
//! to have it.

use sesc::verify::with_effect;
use sesc_model::effects::{Catalog, Effect, EffectContext, Instance, Target};
use sesc_model::{EffectRecord, Quantity};
use sesc_reference::World;

use super::robots::Stand;

/// An effect at its target with values as people know them.
#[derive(Debug, Clone)]
pub(crate) struct Hidden {
    pub instance: Instance,
    pub target: String,
    pub values: Vec<f64>,
}

/// Values of several sizes, in the order of [`Effect::parameters`].
///
/// # Panics
/// For an effect that nobody has given any.
pub(crate) fn sizes(
    effect: &dyn Effect,
    context: &EffectContext,
    target: &Target,
) -> Vec<Vec<f64>> {
    let stiff = context.weight() * context.height();
    let heavy = context.mass();
    let weight = context.weight();
    let long = context.height();
    match effect.id().name() {
        "sensor_offset" => vec![vec![0.001, -0.002], vec![-0.02, 0.01]],
        "sensor_rotation" => vec![vec![0.03], vec![-0.5], vec![3.0]],
        "sensor_gain" => vec![vec![1.05, 0.9], vec![0.5, 2.0], vec![-1.0, 1.0]],
        "ground_slope" => vec![vec![0.01, -0.02], vec![-0.2, 0.1]],
        "joint_offset" => vec![vec![0.01], vec![-0.3]],
        "joint_scale" => vec![vec![1.03], vec![0.7]],
        "joint_compliance" => vec![vec![100.0 * stiff], vec![20.0 * stiff]],
        "backlash" => vec![vec![0.01], vec![0.05]],
        "payload" => vec![
            vec![0.02 * heavy, 0.1 * long, 0.0, 0.05 * long],
            vec![0.4 * heavy, -0.1 * long, 0.2 * long, 0.0],
        ],
        "external_force" => vec![
            vec![0.01 * weight, 0.0, 0.0],
            vec![-0.05 * weight, 0.03 * weight, 0.1 * weight],
        ],
        "sensor_drift" => vec![vec![0.003, -0.001], vec![-0.02, 0.01]],
        "cell_gain" => vec![vec![1.1], vec![0.6], vec![2.0], vec![0.0]],
        "cell_offset" => vec![vec![0.02 * weight], vec![-0.05 * weight]],
        "cell_exponent" => vec![vec![1.1], vec![0.7], vec![1.5]],
        "cell_saturation" => vec![vec![0.5 * weight], vec![0.25 * weight]],
        "time_delay" => vec![vec![0.005], vec![-0.02], vec![0.04]],
        "joint_sign" | "joint_swap" | "sensor_axes" | "units" => vec![vec![]],
        other => panic!("effect `{other}` at {target:?} has no test: add it to tests/effects"),
    }
}

/// A virtual robot with the effect.
///
/// # Panics
/// For an effect that nobody has taught it.
pub(crate) fn hide(world: World, stand: &Stand, hidden: &Hidden) -> World {
    let found = with_effect(world, &stand.model, &hidden.instance, &hidden.values);
    found.unwrap_or_else(|error| panic!("{hidden:?}: {error}"))
}

/// A virtual robot with all of them.
pub(crate) fn hide_all(world: World, stand: &Stand, hidden: &[Hidden]) -> World {
    let all = hidden.iter();
    all.fold(world, |world, own| hide(world, stand, own))
}

impl Hidden {
    pub(crate) fn new(context: &EffectContext, instance: Instance, values: Vec<f64>) -> Hidden {
        Hidden {
            target: context.name_of(&instance.target),
            instance,
            values,
        }
    }

    /// An effect by the name of its target.
    pub(crate) fn named(
        context: &EffectContext,
        effect: &str,
        target: &str,
        values: &[f64],
    ) -> Hidden {
        let effect = Catalog::standard().named(effect).unwrap();
        let target = context.target_named(effect, target).unwrap();
        Hidden::new(context, Instance { effect, target }, values.to_vec())
    }

    /// Every size at up to `most` targets, first and last among them.
    pub(crate) fn of(
        effect: &'static dyn Effect,
        context: &EffectContext,
        most: usize,
    ) -> Vec<Hidden> {
        let targets = effect.targets(context);
        assert!(!targets.is_empty(), "{} has no target", effect.id().name());
        let step = (targets.len() - 1).div_ceil(most - 1).max(1);
        let last = targets.len() - 1;
        let chosen = targets.into_iter().enumerate();
        let chosen = chosen.filter(|(k, _)| k % step == 0 || *k == last);
        chosen
            .flat_map(|(_, target)| {
                let sizes = sizes(effect, context, &target);
                sizes
                    .into_iter()
                    .map(move |values| (target.clone(), values))
            })
            .map(|(target, values)| Hidden::new(context, Instance { effect, target }, values))
            .collect()
    }

    pub(crate) fn unknowns(&self, context: &EffectContext) -> Vec<f64> {
        let Instance { effect, target } = &self.instance;
        effect.unknowns(context, target, &self.values)
    }

    /// The record of a model file.
    pub(crate) fn record(&self, context: &EffectContext) -> EffectRecord {
        let Instance { effect, target } = &self.instance;
        let parameters = effect.parameters(context, target).iter();
        let names = parameters.map(|parameter| parameter.name.to_string());
        let quantity = |value: &f64| Quantity {
            value: *value,
            std: Some(0.1 * value.abs()),
        };
        EffectRecord {
            effect: effect.id().name().to_string(),
            target: self.target.clone(),
            parameters: names.zip(self.values.iter().map(quantity)).collect(),
            ..EffectRecord::default()
        }
    }
}
