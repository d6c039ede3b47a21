//! The search for what is missing.
//!
//! Forward, with several hypotheses kept alive, at least one of each family:
//! linear screening ranks what to add, a joint nonlinear fit of all unknowns
//! decides. Pairs are ranked together from the start, since one effect often
//! takes the part of two. Earlier steps are re-examined: drop one, replace one.

use std::collections::{BTreeMap, HashMap};

use sesc_model::effects::{self, Instance, LIST, Stage};

use super::dictionary::Dictionary;
use super::outliers::Outliers;
use super::problem::{ALL, Fit, Problem};
use super::wiring;

/// Effects in one hypothesis, at most.
const DEEPEST: usize = 4;
/// Hypotheses that are carried on to the next depth.
const BEAM: usize = 10;
/// Candidates that are fitted per hypothesis and kind at the first depth, and later.
const PER_KIND: usize = 3;
const LATER: usize = 8;
const NEAR: usize = 60;
/// Pairs from the linear search that are fitted.
const PAIRS: usize = 40;
/// χ² over what noise leaves from which wiring is suspected beside other effects,
/// and how many hypotheses it is tried beside.
const LARGE: f64 = 2.0;
const WIRED: usize = 5;
/// What is this much worse than the best is not worth a fit.
const HOPELESS: f64 = 12.0;

/// How many extensions of a hypothesis are fitted.
#[derive(Clone, Copy)]
enum Width {
    /// Some of every kind.
    First,
    /// The most promising.
    Later,
    /// All that promise to come near the best.
    Near,
}

/// Fitted hypotheses.
pub struct Search<'p, 'm> {
    problem: &'p Problem<'m>,
    known: HashMap<String, Fit>,
    base: Dictionary,
    visible: Vec<(Instance, f64)>,
    pub fitted: usize,
}

/// Progress of a search: hypotheses fitted so far.
pub type Watch<'w> = &'w mut dyn FnMut(usize);

impl<'p, 'm> Search<'p, 'm> {
    pub fn new(problem: &'p mut Problem<'m>) -> Self {
        let base = Dictionary::new(problem, &problem.data.q);
        let visible = base.visible(problem);
        problem.weigh_targets(&visible);
        Search {
            problem,
            known: HashMap::new(),
            base,
            visible,
            fitted: 0,
        }
    }

    pub fn problem(&self) -> &'p Problem<'m> {
        self.problem
    }

    /// χ² that each effect of ordinary size would have in this log.
    pub fn visible(&self) -> &[(Instance, f64)] {
        &self.visible
    }

    fn price(&self, instance: &Instance) -> f64 {
        self.problem.price(std::slice::from_ref(instance))
    }

    /// All hypotheses that were fitted, the best first.
    pub fn run(&mut self, watch: Watch) -> Vec<Fit> {
        let null = self.fit(&[], None);
        let mut beam = vec![null];
        for depth in 1..=DEEPEST {
            let mut proposals = Vec::new();
            for parent in &beam {
                let width = if depth == 1 {
                    Width::First
                } else {
                    Width::Later
                };
                proposals.extend(self.extensions(parent, width));
            }
            if depth > 1 {
                // Wiring faults come together too, and only large gaps are theirs.
                let large = LARGE * 2.0 * self.problem.data.len() as f64;
                let gaps = beam.iter().filter(|f| f.objective > large);
                let further = gaps
                    .take(WIRED)
                    .flat_map(|f| wiring::beside(self.problem, f));
                proposals.extend(further);
            }
            if depth == 1 {
                proposals.extend(self.pairs(&beam[0]));
                proposals.extend(wiring::proposals(self.problem, &self.base));
            }
            self.refine(proposals, depth, watch);
            beam = self.beam(depth);
            let with = |count: usize| {
                let fits = self.known.values().filter(|f| f.instances.len() == count);
                fits.map(Fit::score).fold(f64::INFINITY, f64::min)
            };
            if with(depth) >= with(depth - 1) && with(depth + 1) >= with(depth - 1) {
                break;
            }
        }
        for _ in 0..3 {
            let before = self.best_score();
            self.reexamine(watch);
            if self.best_score() >= before - 1e-6 {
                break;
            }
        }
        self.ranked()
    }

    pub fn ranked(&self) -> Vec<Fit> {
        let mut all: Vec<Fit> = self.known.values().cloned().collect();
        // Ties go to the fewest, then to the order of the list.
        all.sort_by(|a, b| {
            let score = a.score().total_cmp(&b.score());
            score
                .then(a.instances.len().cmp(&b.instances.len()))
                .then_with(|| key(self.problem, &a.instances).cmp(&key(self.problem, &b.instances)))
        });
        all
    }

    fn best_score(&self) -> f64 {
        self.known
            .values()
            .map(Fit::score)
            .fold(f64::INFINITY, f64::min)
    }

    /// Fit a set of instances once.
    pub fn fit(&mut self, instances: &[Instance], parent: Option<&Fit>) -> Fit {
        let instances = sorted(instances);
        let key = key(self.problem, &instances);
        if let Some(fit) = self.known.get(&key) {
            return fit.clone();
        }
        self.fitted += 1;
        let starts = self.starts(&instances, parent);
        let fits = starts
            .iter()
            .map(|start| self.problem.fit(&instances, Some(start), ALL));
        let fit = fits
            .min_by(|a, b| a.objective.total_cmp(&b.objective))
            .expect("there is a start");
        self.known.insert(key, fit.clone());
        fit
    }

    /// A parent's unknowns, with every start of what is new beside them.
    fn starts(&self, instances: &[Instance], parent: Option<&Fit>) -> Vec<Vec<f64>> {
        let setting = &self.problem.setting;
        let mut starts = vec![Vec::new()];
        for instance in instances {
            let inherited = parent.and_then(|fit| {
                let mut at = 0;
                for own in &fit.instances {
                    let count = own.unknowns(setting);
                    if own == instance {
                        return Some(fit.unknowns[at..at + count].to_vec());
                    }
                    at += count;
                }
                None
            });
            let own = match inherited {
                Some(own) => vec![own],
                None => instance.effect.starts(setting, &instance.target),
            };
            let longer = |before: &Vec<f64>| -> Vec<Vec<f64>> {
                own.iter()
                    .map(|own| [before.as_slice(), own].concat())
                    .collect()
            };
            starts = starts.iter().flat_map(longer).collect();
        }
        starts.truncate(8);
        starts
    }

    /// What could be added to a hypothesis, with the score it promises.
    fn extensions(&self, parent: &Fit, width: Width) -> Vec<Proposal> {
        let own;
        let wired = parent
            .instances
            .iter()
            .any(|i| i.effect.stage() == Stage::Wiring);
        let dictionary = match wired {
            true => {
                own = Dictionary::new(self.problem, &self.problem.bent(parent));
                &own
            }
            false => &self.base,
        };
        let gains = dictionary.gains(parent, self.problem);
        let mut proposals: Vec<Proposal> = dictionary
            .candidates
            .iter()
            .zip(gains)
            .filter(|(c, _)| compatible(&parent.instances, &c.instance))
            .map(|(c, gain)| Proposal {
                instances: with(&parent.instances, &c.instance),
                promise: parent.score() - gain + self.price(&c.instance),
                parent: Some(parent.clone()),
            })
            .collect();
        proposals.sort_by(|a, b| a.promise.total_cmp(&b.promise));
        let (per_kind, most) = match width {
            Width::First => (PER_KIND, usize::MAX),
            Width::Later => (2, LATER),
            Width::Near => (usize::MAX, NEAR),
        };
        let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
        proposals.retain(|p| {
            let added = p.instances.iter().find(|i| !parent.instances.contains(i));
            let count = seen
                .entry(added.map_or("", |i| i.effect.name()))
                .or_default();
            *count += 1;
            *count <= per_kind
        });
        proposals.truncate(most);
        for name in ["cop_outliers", "mass_distribution"] {
            proposals.extend(self.whole(parent, name));
        }
        proposals
    }

    /// Outliers or free masses beside a hypothesis.
    fn whole(&self, parent: &Fit, name: &str) -> Option<Proposal> {
        let effect = effects::named(name)?;
        let target = effect.targets(&self.problem.setting).into_iter().next()?;
        let instance = Instance { effect, target };
        if !compatible(&parent.instances, &instance) {
            return None;
        }
        // Masses that are as free already are no effect.
        if name == "mass_distribution" && !self.problem.is_wider() {
            return None;
        }
        let price = self.problem.price(std::slice::from_ref(&instance));
        let promise = match name {
            "cop_outliers" => {
                let outliers = Outliers::of(&parent.residual, None);
                let root = outliers.root_weights(None);
                let squares = parent
                    .residual
                    .iter()
                    .zip(&root)
                    .map(|(e, w)| (e * w).powi(2));
                let mixture = outliers.objective(&parent.residual, None, squares.sum());
                let plain = parent.residual.norm_squared();
                parent.score() + (mixture - plain) + price
            }
            _ => {
                let (wide, tight) = (&self.problem.wide, &self.problem.nuisance);
                let left = |n: &super::nuisance::Nuisance| {
                    parent.residual.dot(&n.beyond_one(&parent.residual))
                };
                let change = left(wide) + wide.log_det - left(tight) - tight.log_det;
                parent.score() + change + price
            }
        };
        Some(Proposal {
            instances: with(&parent.instances, &instance),
            promise,
            parent: Some(parent.clone()),
        })
    }

    /// The best pairs of a linear search over all of them.
    fn pairs(&mut self, null: &Fit) -> Vec<Proposal> {
        let residual = null.residual.clone();
        let pairs = self.base.pairs(&residual);
        let candidates = &self.base.candidates;
        let mut proposals: Vec<Proposal> = pairs
            .into_iter()
            .map(|(i, j, gain)| (&candidates[i], &candidates[j], gain))
            .filter(|(a, b, _)| compatible(std::slice::from_ref(&a.instance), &b.instance))
            .map(|(a, b, gain)| Proposal {
                instances: vec![a.instance.clone(), b.instance.clone()],
                promise: null.score() - gain + self.price(&a.instance) + self.price(&b.instance),
                parent: None,
            })
            .collect();
        proposals.sort_by(|a, b| a.promise.total_cmp(&b.promise));
        let mut per_kinds: BTreeMap<String, usize> = BTreeMap::new();
        proposals.retain(|p| {
            let count = per_kinds.entry(kinds(&p.instances)).or_default();
            *count += 1;
            *count <= PER_KIND
        });
        proposals.truncate(PAIRS);
        proposals
    }

    fn refine(&mut self, mut proposals: Vec<Proposal>, depth: usize, watch: Watch) {
        proposals.sort_by(|a, b| a.promise.total_cmp(&b.promise));
        for proposal in proposals {
            // A linear promise is hardly ever too modest, but where gaps are large.
            let best = self.best_score();
            let room = HOPELESS
                + if depth == 1 {
                    0.3 * best.abs()
                } else {
                    0.02 * best.abs()
                };
            if depth > 1 && proposal.promise > best + room {
                continue;
            }
            self.fit(&proposal.instances, proposal.parent.as_ref());
            watch(self.fitted);
        }
    }

    /// The best of a depth, one of each family before seconds.
    fn beam(&self, depth: usize) -> Vec<Fit> {
        let of_depth = self
            .ranked()
            .into_iter()
            .filter(|f| f.instances.len() == depth);
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        let mut beam = Vec::new();
        for fit in of_depth {
            let count = seen.entry(kinds(&fit.instances)).or_default();
            *count += 1;
            if *count <= 2 && beam.len() < BEAM {
                beam.push(fit);
            }
        }
        beam
    }

    /// Drop one, replace one, of the best hypotheses; of the very best, by
    /// everything that comes near it.
    fn reexamine(&mut self, watch: Watch) {
        let null = self.fit(&[], None);
        let alone = self.extensions(&null, Width::Near);
        self.refine(alone, 2, watch);
        let best: Vec<Fit> = self.ranked().into_iter().take(3).collect();
        for (place, fit) in best.iter().enumerate() {
            for k in 0..fit.instances.len() {
                let mut fewer = fit.instances.clone();
                fewer.remove(k);
                let parent = self.fit(&fewer, Some(fit));
                let width = if place == 0 {
                    Width::Near
                } else {
                    Width::Later
                };
                let proposals = self.extensions(&parent, width);
                self.refine(proposals, 2, watch);
            }
        }
    }
}

/// A hypothesis to be fitted.
pub struct Proposal {
    pub instances: Vec<Instance>,
    /// Score to first order.
    pub promise: f64,
    pub parent: Option<Fit>,
}

fn with(instances: &[Instance], more: &Instance) -> Vec<Instance> {
    let mut all = instances.to_vec();
    all.push(more.clone());
    sorted(&all)
}

/// Whether an instance may stand beside others: not twice, and not one joint and
/// all joints by the same effect.
fn compatible(instances: &[Instance], more: &Instance) -> bool {
    use effects::Target;
    instances.iter().all(|i| {
        let same = i.effect.name() == more.effect.name();
        let all = i.target == Target::AllJoints || more.target == Target::AllJoints;
        let cells = i.effect.stage() == Stage::Cells && more.effect.stage() == Stage::Cells;
        !(same && (i.target == more.target || all)) && !cells
    })
}

fn kinds(instances: &[Instance]) -> String {
    let mut names: Vec<&str> = instances.iter().map(|i| i.effect.name()).collect();
    names.sort_unstable();
    names.join("+")
}

fn rank(instance: &Instance) -> usize {
    let name = instance.effect.name();
    LIST.iter()
        .position(|e| e.name() == name)
        .unwrap_or(LIST.len())
}

pub fn sorted(instances: &[Instance]) -> Vec<Instance> {
    let mut all = instances.to_vec();
    all.sort_by(|a, b| rank(a).cmp(&rank(b)).then_with(|| a.target.cmp(&b.target)));
    all
}

fn key(problem: &Problem, instances: &[Instance]) -> String {
    let labels = instances
        .iter()
        .map(|i| format!("{:02}{}", rank(i), problem.setting.name_of(&i.target)));
    labels.collect::<Vec<_>>().join(" + ")
}
