//! Effects beyond the list: what functions of one variable at one site would do to the readings,
//! to first order.
//!
//! ```text
//! c = J f(v)        J: derivative of the reading by what is added at the site
//! gain = bᵀ A⁻¹ b   A = Cᵀ S C, b = Cᵀ S residual, once the unknowns of the hypothesis took their
//!                   part; C: the columns c of a form, S: no mass error, see `nuisance`
//! ```
//!
//! Columns are made site by site, scored and thrown away; of long logs an even choice of postures
//! is looked at. Sites of the reading take no position or moment of joints: else every fault of a
//! joint has a twin that corrects the reading and not the body.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{
    Composed, Constant, Definition, Instance, PostureContext, Site, Target, Unit,
};
use sesc_model::formula::Formula;

use super::criteria::functions::{
    LEAST_PART, OF_A_PLACE, OF_ALL, PAIRS_OF_JOINTS, PARTS, PER_TURN, POSTURES, SIZES, STARTS,
};
use super::dictionary::{Beside, Dictionary};
use super::hypothesis::{Term, compatible, keep_some};
use super::problem::{Block, Fit, Problem, Proposal};
use crate::lsq::transposed_times;
use crate::observations::postures::range;
use crate::threads::each_long;

/// A variable that functions take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Variable {
    Position(usize),
    Moment(usize),
    Approach(usize),
    Reading(usize),
    Time,
}

/// A function of a variable v without its size, and of up to two constants c and d.
struct Shape {
    /// As a formula.
    text: &'static str,
    /// Of v and of the reading along y, and of the constants.
    of: fn([f64; 2], [f64; 2]) -> f64,
    /// Name of c where a fit moves it; else c is a number of the formula.
    constant: Option<&'static str>,
    /// Whether it has no unit, whatever that of its variable is.
    is_plain: bool,
}

const fn shape(text: &'static str, of: fn([f64; 2], [f64; 2]) -> f64) -> Shape {
    Shape {
        text,
        of,
        constant: None,
        is_plain: false,
    }
}

impl Shape {
    const fn plain(self) -> Shape {
        Shape {
            is_plain: true,
            ..self
        }
    }

    const fn fitted(self, constant: &'static str) -> Shape {
        Shape {
            constant: Some(constant),
            ..self
        }
    }
}

static LINEAR: Shape = shape("{v}", |[v, _], _| v);
static SQUARE: Shape = shape("{v} * {v}", |[v, _], _| v * v);
static CUBE: Shape = shape("{v} * {v} * {v}", |[v, _], _| v * v * v);
static TIMES_Y: Shape = shape("{v} * y", |[v, y], _| v * y);
static GROWING: Shape = shape("{v} * abs({v})", |[v, _], _| v * v.abs());
static FLATTENING: Shape = shape("sign({v}) * sqrt(abs({v}))", |[v, _], _| {
    v.signum() * v.abs().sqrt()
});
/// The side that a joint came from.
static SIDE: Shape = shape("{v}", |[v, _], _| v).plain();
static WAVES: [Shape; 2] = [
    shape("sin({v})", |[v, _], _| v.sin()).plain(),
    shape("cos({v})", |[v, _], _| v.cos()).plain(),
];
static RIPPLES: [Shape; 2] = [
    shape("sin({c} * {v})", |[v, _], [c, _]| (c * v).sin()).plain(),
    shape("cos({c} * {v})", |[v, _], [c, _]| (c * v).cos()).plain(),
];
static ABOVE: Shape = shape("max({v} - {c}, 0.0)", |[v, _], [c, _]| (v - c).max(0.0)).fitted(START);
static BELOW: Shape = shape("max({c} - {v}, 0.0)", |[v, _], [c, _]| (c - v).max(0.0)).fitted(START);
static SINCE: Shape = shape("sign(max({v} - {c}, 0.0))", |[v, _], [c, _]| {
    f64::from(u8::from(v > c))
})
.plain()
.fitted(START);
static DECAY: Shape = shape("exp(-{v} / {c})", |[v, _], [c, _]| (-v / c).exp())
    .plain()
    .fitted("lasts");
/// One at a knot, falling to none at its neighbours, which are d away.
static HAT: Shape = shape("max(1.0 - abs({v} - {c}) / {d}, 0.0)", |[v, _], [c, d]| {
    (1.0 - ((v - c) / d).abs()).max(0.0)
})
.plain();
const START: &str = "start";

/// A shape with its constants.
type At = (&'static Shape, [f64; 2]);

/// What people call a form, and the subject of a sentence about it.
type Words = (&'static str, &'static str);
const ECCENTRICITY: Words = (
    "encoder_eccentricity",
    "an encoder of {target} that is off centre",
);
const CURVATURE: Words = (
    "joint_curvature",
    "an error of {target} that is curved in its angle",
);
const STOP: Words = (
    "joint_stop",
    "a stop or a pull at {target} from an angle on",
);
const OF_POSITION: Words = (
    "joint_error",
    "an error of {target} that is a curve of its position",
);
const OF_MOMENT: Words = (
    "joint_error",
    "an error of {target} that is a curve of its moment",
);
const SOFTENING: Words = ("spring_softening", "a spring at {target} that softens");
const HARDENING: Words = ("spring_hardening", "a spring at {target} that hardens");
const HYSTERESIS: Words = ("joint_hysteresis", "hysteresis of {target}");
const DRIFT: Words = ("joint_drift", "a drift of {target}");
const SLIP: Words = ("joint_slip", "a slip of {target} during the log");
const NONLINEARITY: Words = (
    "sensor_nonlinearity",
    "readings along {target} that are not linear",
);
const KINK: Words = ("sensor_kink", "a kink of the readings along {target}");
const OF_READING: Words = (
    "sensor_error",
    "an error of the readings along {target} that is a curve of them",
);
const CROSSTALK: Words = (
    "sensor_crosstalk",
    "crosstalk into the readings along {target}",
);
const STEP: Words = ("sensor_error", "a step of the readings along {target}");
const WARMUP: Words = ("sensor_warmup", "a sensor that warms up along {target}");
const SOFT_GROUND: Words = (
    "soft_ground",
    "ground that gives way, with a slope along {target}",
);
const GROUND: Words = (
    "ground_error",
    "a slope of the ground along {target} that changes",
);
const LOAD: Words = ("load_error", "a load of {target} that changes");

/// Knots of a curve.
const KNOTS: usize = 7;
/// Sizes of the terms of a form, in their order.
const COEFFICIENTS: [&str; KNOTS] = ["a", "b", "c", "d", "e", "f", "g"];

/// A function at a site: a sum of shapes of a variable, each times an unknown size.
#[derive(Clone)]
struct Form {
    place: usize,
    variable: Variable,
    shapes: Vec<At>,
    name: &'static str,
    sentence: String,
}

impl Form {
    /// Name and value of the constant that a fit moves.
    fn constant(&self) -> Option<(&'static str, f64)> {
        let (shape, [c, _]) = self.shapes[0];
        Some((shape.constant?, c))
    }

    fn unknowns(&self) -> usize {
        self.shapes.len() + usize::from(self.constant().is_some())
    }
}

/// A site with the columns of what is added there.
struct Place {
    site: Site,
    target: Target,
    /// Per reading of the postures that are looked at, whitened.
    slope: DVector<f64>,
}

/// All forms at all sites, on some postures.
pub(super) struct Functions {
    places: Vec<Place>,
    forms: Vec<Form>,
    /// Of variables, posture by posture.
    values: HashMap<Variable, Vec<f64>>,
    /// Rows among all of the problem.
    rows: Vec<usize>,
    /// Postures of the log for each that is looked at.
    part: f64,
}

/// A hypothesis that forms are tried beside, in the rows that are looked at.
struct Tried {
    beside: Beside,
    /// Masses' directions K, and L of `I + Kᵀ K = L Lᵀ`.
    k: DMatrix<f64>,
    l: DMatrix<f64>,
    /// Whether they are free within the usual tolerances.
    is_wide: bool,
}

/// Gain and sizes of columns c, of which masses take L⁻¹ Kᵀ c, by their products with what is left
/// beside a hypothesis; none where they do what others do already.
fn gain(
    beside: &Beside,
    c: &DMatrix<f64>,
    taken: &DMatrix<f64>,
    products: &DMatrix<f64>,
) -> Option<(f64, Vec<f64>)> {
    let (mut a, b) = beside.rest(c.tr_mul(c) - taken.tr_mul(taken), products);
    let tells = |k: usize| a[(k, k)] > LEAST_PART * c.column(k).norm_squared();
    if !(0..c.ncols()).all(tells) {
        return None;
    }
    for k in 0..c.ncols() {
        a[(k, k)] *= 1.0 + LEAST_PART;
    }
    let sizes = a.cholesky()?.solve(&b);
    Some((b.dot(&sizes).max(0.0), sizes.as_slice().to_vec()))
}

/// What a form gains beside a hypothesis, and the sizes at which it does.
#[derive(Clone)]
struct Gain {
    form: Form,
    gain: f64,
    sizes: Vec<f64>,
}

impl Functions {
    /// All that the logs of a problem have the variables of.
    pub(super) fn new(problem: &Problem, dictionary: &Dictionary) -> Functions {
        let postures: usize = problem.blocks.iter().map(|block| block.data.len()).sum();
        let every = postures.div_ceil(POSTURES).max(1);
        let (mut rows, mut values, mut seen) = (Vec::new(), HashMap::new(), 0);
        for (block, range) in problem.blocks.iter().zip(problem.readings()) {
            let chosen: Vec<usize> = (0..block.data.len())
                .filter(|k| (seen + k).is_multiple_of(every))
                .collect();
            seen += block.data.len();
            read(problem, block, &chosen, &mut values);
            let of_posture = |k: &usize| [0, 1].map(|axis| range.start + 2 * k + axis);
            rows.extend(chosen.iter().flat_map(of_posture));
        }
        let mut functions = Functions {
            places: places(problem, dictionary, &rows),
            forms: Vec::new(),
            part: postures as f64 / (rows.len() as f64 / 2.0).max(1.0),
            values,
            rows,
        };
        for place in 0..functions.places.len() {
            functions.forms_of(place, problem);
        }
        functions
    }

    /// How many are tried.
    pub(super) fn tried(&self) -> usize {
        self.forms.len()
    }

    /// The forms that would improve each of some hypotheses most, fewer of one place than of all.
    pub(super) fn proposals(&self, parents: &[Fit], problem: &Problem) -> Vec<Proposal> {
        let tried = parents.iter().map(|fit| {
            let masses = problem.masses(&fit.terms);
            Tried {
                beside: Beside::new(problem, fit, Some(&self.rows)),
                k: masses.columns().select_rows(&self.rows),
                l: masses.factor().l_dirty().clone(),
                is_wide: fit.frees_masses(),
            }
        });
        let tried: Vec<Tried> = tried.collect();
        let score = |own: &Gain| problem.penalty_of_function(own.form.unknowns()) - own.gain;
        let mut proposals = Vec::new();
        let gains = self.gains(&tried, &self.forms).into_iter();
        for ((mut found, parent), tried) in gains.zip(parents).zip(&tried) {
            found.retain(|own| score(own) < 0.0);
            found.sort_by(|a, b| score(a).total_cmp(&score(b)));
            keep_some(&mut found, |own| own.form.place, OF_A_PLACE, OF_ALL);
            proposals.extend(found.into_iter().filter_map(|own| {
                let own = self.settled(tried, own);
                let term = Term::Effect(self.instance(problem, &own)?);
                compatible(&parent.terms, &term).then(|| Proposal {
                    predicted_score: parent.score() + score(&own),
                    terms: [&parent.terms[..], &[term]].concat(),
                    parent: Some(parent.clone()),
                })
            }));
        }
        proposals
    }

    /// The same form where it begins, or lasts, as long as is best.
    fn settled(&self, beside: &Tried, own: Gain) -> Gain {
        if own.form.constant().is_none() {
            return own;
        }
        let mut values = self.values[&own.form.variable].clone();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let every = values.len().div_ceil(STARTS).max(1);
        let forms = values.windows(2).step_by(every).map(|pair| Form {
            shapes: vec![(own.form.shapes[0].0, [0.5 * (pair[0] + pair[1]), 0.0])],
            ..own.form.clone()
        });
        let all = self.gains(std::slice::from_ref(beside), &forms.collect::<Vec<_>>());
        let best = all.into_iter().flatten();
        let best = best.max_by(|a, b| a.gain.total_cmp(&b.gain));
        best.filter(|best| best.gain > own.gain).unwrap_or(own)
    }

    /// What forms gain beside each of some hypotheses.
    fn gains(&self, tried: &[Tried], forms: &[Form]) -> Vec<Vec<Gain>> {
        let of_place = |place: usize| -> Vec<Vec<Gain>> {
            let forms: Vec<&Form> = forms.iter().filter(|form| form.place == place).collect();
            let columns = self.columns(&forms);
            let mut of_masses: [Option<DMatrix<f64>>; 2] = [None, None];
            let gains = tried.iter().map(|own| {
                let taken = of_masses[usize::from(own.is_wide)].get_or_insert_with(|| {
                    let mut taken = transposed_times(&own.k, &columns);
                    own.l.solve_lower_triangular_mut(&mut taken);
                    taken
                });
                let products = transposed_times(&columns, &own.beside.left);
                let mut at = 0;
                let gains = forms.iter().filter_map(|form| {
                    let count = form.shapes.len();
                    let of_form = |all: &DMatrix<f64>| all.columns(at, count).into_owned();
                    let (c, taken) = (of_form(&columns), of_form(taken));
                    let products = products.rows(at, count).into_owned();
                    at += count;
                    let (gain, sizes) = gain(&own.beside, &c, &taken, &products)?;
                    Some(Gain {
                        form: (*form).clone(),
                        gain: self.part * gain,
                        sizes,
                    })
                });
                gains.collect()
            });
            gains.collect()
        };
        let mut all = vec![Vec::new(); tried.len()];
        for of_place in each_long(0..self.places.len(), of_place) {
            let both = all.iter_mut().zip(of_place);
            both.for_each(|(all, some)| all.extend(some));
        }
        all
    }

    /// The columns of forms at one place, side by side.
    fn columns(&self, forms: &[&Form]) -> DMatrix<f64> {
        let y = &self.values[&Variable::Reading(1)];
        let columns = forms.iter().flat_map(|form| {
            let (slope, v) = (&self.places[form.place].slope, &self.values[&form.variable]);
            form.shapes.iter().flat_map(move |(shape, constants)| {
                let value = move |row: usize| (shape.of)([v[row / 2], y[row / 2]], *constants);
                let slopes = slope.iter().enumerate();
                slopes.map(move |(row, slope)| slope * value(row))
            })
        });
        let columns: Vec<f64> = columns.collect();
        let rows = self.rows.len();
        DMatrix::from_vec(rows, columns.len() / rows.max(1), columns)
    }

    /// Add the forms at a place whose variables vary.
    fn forms_of(&mut self, place: usize, problem: &Problem) {
        let (values, forms) = (&self.values, &mut self.forms);
        let timed = problem.blocks.iter().all(|block| block.data.t.is_some());
        let ends = |variable| range(values[&variable].iter().copied());
        let mut add = |variable, (name, sentence): (&'static str, &str), all: Vec<Vec<At>>| {
            let (least, most) = ends(variable);
            if most > least && (timed || variable != Variable::Time) {
                forms.extend(all.into_iter().map(|shapes| Form {
                    place,
                    variable,
                    shapes,
                    name,
                    sentence: sentence.to_string(),
                }));
            }
        };
        let starts = |variable, shapes: &[&'static Shape]| {
            let mut sorted = values[&variable].clone();
            sorted.sort_by(f64::total_cmp);
            let last = sorted.len().saturating_sub(1) as f64;
            let at = |part: f64| sorted.get((part * last) as usize).copied().unwrap_or(0.0);
            PARTS.map(|part| alone(shapes, at(part))).concat()
        };
        // What no formula of the table is.
        let curve = |variable| {
            let (least, most) = ends(variable);
            let digits = 10_f64.powf(2.0 - (most - least).log10().floor());
            let short = |x: f64| (x * digits).round() / digits;
            let apart = short((most - least) / (KNOTS - 1) as f64);
            let knot = |k: usize| short(short(least) + k as f64 * apart);
            let hats = (0..KNOTS).map(|k| (&HAT, [knot(k), apart]));
            vec![hats.collect::<Vec<At>>()]
        };
        let span = ends(Variable::Time).1.max(0.0);
        let decays = || SIZES.map(|part| alone(&[&DECAY], part * span)).concat();
        let (time, linear) = (Variable::Time, || alone(&[&LINEAR], 0.0));
        let [x, y] = [0, 1].map(Variable::Reading);
        let dofs = &problem.context().robot.tree.dofs;
        let Place { site, target, .. } = &self.places[place];
        match (site, target) {
            (Site::Joint, Target::Joint(joint)) => {
                let (q, tau) = (Variable::Position(*joint), Variable::Moment(*joint));
                for n in PER_TURN.into_iter().filter(|_| !dofs[*joint].prismatic) {
                    let errs = format!("an encoder of {{target}} that errs {n} times a turn");
                    let (words, shapes) = match n {
                        1.0 => (ECCENTRICITY, &WAVES),
                        _ => (("encoder_ripple", &*errs), &RIPPLES),
                    };
                    add(
                        q,
                        words,
                        vec![shapes.iter().map(|own| (own, [n, 0.0])).collect()],
                    );
                }
                add(q, CURVATURE, alone(&[&SQUARE, &CUBE], 0.0));
                add(q, STOP, starts(q, &[&ABOVE, &BELOW]));
                add(q, OF_POSITION, curve(q));
                add(tau, OF_MOMENT, curve(tau));
                // It grows more than the moment, or less.
                add(tau, SOFTENING, alone(&[&GROWING], 0.0));
                add(tau, HARDENING, alone(&[&FLATTENING], 0.0));
                add(Variable::Approach(*joint), HYSTERESIS, alone(&[&SIDE], 0.0));
                for other in nearby(problem, *joint) {
                    let name = &dofs[other].joint;
                    let follows = format!("an error of {{target}} that follows {name}");
                    let gives_way = format!("{{target}} giving way to the moment at {name}");
                    let (q, tau) = (Variable::Position(other), Variable::Moment(other));
                    add(q, ("joint_coupling", &follows), linear());
                    add(tau, ("cross_compliance", &gives_way), linear());
                }
                add(time, DRIFT, linear());
                add(time, SLIP, starts(time, &[&SINCE]));
                add(time, DRIFT, decays());
            }
            (Site::Sensor, Target::Way(way)) => {
                let (along, across) = if *way == "x" { (x, y) } else { (y, x) };
                add(along, NONLINEARITY, alone(&[&SQUARE, &CUBE], 0.0));
                add(along, KINK, starts(along, &[&ABOVE, &BELOW]));
                add(along, OF_READING, curve(along));
                add(across, CROSSTALK, linear());
                add(across, NONLINEARITY, alone(&[&SQUARE], 0.0));
                add(x, CROSSTALK, alone(&[&TIMES_Y], 0.0));
                add(time, STEP, starts(time, &[&SINCE]));
                add(time, WARMUP, decays());
            }
            (Site::Ground, _) => {
                add(x, SOFT_GROUND, linear());
                add(y, SOFT_GROUND, linear());
                add(time, GROUND, linear());
                add(time, GROUND, starts(time, &[&SINCE]));
                add(time, GROUND, decays());
            }
            (Site::Load, _) => {
                add(time, LOAD, starts(time, &[&SINCE]));
                add(time, LOAD, decays());
            }
            _ => {}
        }
    }

    /// The effect of a form, which begins at the sizes of the linear fit.
    fn instance(&self, problem: &Problem, own: &Gain) -> Option<Instance> {
        let (form, context) = (&own.form, problem.context());
        let Place { site, target, .. } = &self.places[form.place];
        let dofs = &context.robot.tree.dofs;
        let named = |word: &str, joint: usize| match *target == Target::Joint(joint) {
            true => word.to_string(),
            false => format!("{word}[\"{}\"]", dofs[joint].joint),
        };
        let v = match form.variable {
            Variable::Position(joint) => named("q", joint),
            Variable::Moment(joint) => named("tau", joint),
            Variable::Approach(joint) => named("approach", joint),
            Variable::Reading(axis) => ["x", "y"][axis].to_string(),
            Variable::Time => "t".to_string(),
        };
        // Names end in their unit where sizes have that of the site.
        let of_joint = |joint: usize| if dofs[joint].prismatic { "_m" } else { "_rad" };
        let unit = match (site, target) {
            (Site::Joint, Target::Joint(joint)) => of_joint(*joint),
            (Site::Joint | Site::Ground, _) => "_rad",
            (Site::Load, _) => "_kg",
            _ => "_m",
        };
        let of_variable = match form.variable {
            Variable::Position(joint) => of_joint(joint),
            Variable::Reading(_) => "_m",
            _ => "",
        };
        let fitted = form.constant();
        let fitted = fitted.map(|(name, value)| (format!("{name}{of_variable}"), value));
        let constant = |name: &str, typical: f64| Constant {
            name: name.to_string(),
            typical: if typical == 0.0 { LEAST_PART } else { typical },
            unit: Unit::of(name).symbol().to_string(),
            limits: [f64::NEG_INFINITY, f64::INFINITY],
        };
        let (mut text, mut constants) = (Vec::new(), Vec::new());
        let shapes = form.shapes.iter().zip(COEFFICIENTS).zip(&own.sizes);
        for (((shape, [c, d]), letter), size) in shapes {
            let name = format!("{letter}{}", if shape.is_plain { unit } else { "" });
            let c = match &fitted {
                Some((name, _)) => name.clone(),
                None => format!("{c:?}"),
            };
            let constants_in = [("{c}", c), ("{d}", format!("{d:?}")), ("{v}", v.clone())];
            let function = constants_in
                .iter()
                .fold(shape.text.to_string(), |text, (key, own)| {
                    text.replace(key, own)
                });
            text.push(format!("{name} * {function}"));
            constants.push(constant(&name, rounded(*size)));
        }
        constants.extend(fitted.iter().map(|(name, value)| constant(name, *value)));
        let definition = Definition {
            name: form.name.to_string(),
            site: *site,
            function: Formula::parse(&text.join(" + ")).ok()?,
            constants,
            targets: vec![context.name_of(target)],
            at: None,
            range: Default::default(),
            columns: Default::default(),
            sentence: Some(form.sentence.clone()),
        };
        Some(Instance {
            effect: Composed::new(definition).ok()?,
            target: target.clone(),
        })
    }
}

/// Forms of one shape each, with a constant.
fn alone(shapes: &[&'static Shape], constant: f64) -> Vec<Vec<At>> {
    let shapes = shapes.iter().map(|shape| vec![(*shape, [constant, 0.0])]);
    shapes.collect()
}

/// A number to one digit: what a fit begins with need not be known better.
fn rounded(size: f64) -> f64 {
    if size == 0.0 || !size.is_finite() {
        return LEAST_PART;
    }
    let unit = 10_f64.powf(size.abs().log10().floor());
    (size / unit).round() * unit
}

/// Add the variables in some postures of a block; what that robot does not have is zero.
fn read(
    problem: &Problem,
    block: &Block,
    chosen: &[usize],
    values: &mut HashMap<Variable, Vec<f64>>,
) {
    let (here, there) = (problem.context().robot, block.context.robot);
    let (dof, data) = (there.dof(), &block.data);
    let layout = PostureContext::of(there);
    let context = |k: usize, at: usize| data.posture_context[k * layout.len() + at];
    let weight = block.context.weight();
    let moments = block.moments_at(&data.q);
    // As the robot without effects reads: noise of a reading is none of its variables.
    let predicted = block.evaluate(&[], &[], &data.q, &data.posture_context);
    let mut add = |variable, value: &dyn Fn(usize) -> f64| {
        let known: &mut Vec<f64> = values.entry(variable).or_default();
        known.extend(chosen.iter().map(|k| value(*k)));
    };
    for (joint, own) in here.tree.dofs.iter().enumerate() {
        let mut dofs = there.tree.dofs.iter();
        let place = dofs.position(|dof| dof.joint == own.joint);
        let mut of = |variable, value: &dyn Fn(usize, usize) -> f64| {
            add(variable, &|k| place.map_or(0.0, |at| value(k, at)));
        };
        of(Variable::Position(joint), &|k, at| data.q[k * dof + at]);
        of(Variable::Moment(joint), &|k, at| {
            weight * moments[k * 3 * dof + at]
        });
        of(Variable::Approach(joint), &|k, at| {
            context(k, layout.approach(at))
        });
    }
    for axis in 0..2 {
        add(Variable::Reading(axis), &|k| predicted[2 * k + axis]);
    }
    add(Variable::Time, &|k| context(k, layout.time()));
}

/// Sites with the slopes of what is added there, as the named effects that add a constant have them.
fn places(problem: &Problem, dictionary: &Dictionary, rows: &[usize]) -> Vec<Place> {
    let context = problem.context();
    let mut places = Vec::new();
    let mut add = |site: Site, target: Target, slope: DVector<f64>| {
        places.push(Place {
            site,
            target,
            slope: slope.select_rows(rows),
        });
    };
    for (term, slopes) in dictionary.of_each() {
        let Some(instance) = term.effect() else {
            continue;
        };
        let column = |k: usize| slopes.column(k).into_owned();
        match (term.name(), &instance.target) {
            ("joint_offset", Target::Joint(_)) => {
                add(Site::Joint, instance.target.clone(), column(0));
            }
            ("sensor_offset", _) => {
                add(Site::Sensor, Target::Way("x"), column(0));
                add(Site::Sensor, Target::Way("y"), column(1));
            }
            ("ground_slope", _) => {
                add(Site::Ground, Target::Way("x"), column(0));
                add(Site::Ground, Target::Way("y"), column(1));
            }
            ("payload", Target::Link(link)) => {
                // A mass at the link's CoM, per kg.
                let [x, y, z] = context.robot.tree.links[*link].com();
                let at = column(0) + column(1) * x + column(2) * y + column(3) * z;
                add(Site::Load, instance.target.clone(), at / context.mass());
            }
            _ => {}
        }
    }
    places
}

/// Other joints that an error of a joint may follow: the nearest in the tree.
fn nearby(problem: &Problem, joint: usize) -> Vec<usize> {
    let robot = problem.context().robot;
    let bodies = &robot.chain.bodies;
    let to_support = |joint: usize| {
        let name = &robot.tree.dofs[joint].joint;
        let body = bodies
            .iter()
            .position(|body| body.joint.as_ref() == Some(name));
        std::iter::successors(body, |body| bodies[*body].parent).collect::<Vec<_>>()
    };
    let own = to_support(joint);
    let apart = |other: &usize| {
        let other = to_support(*other);
        let common = other.iter().filter(|body| own.contains(body)).count();
        own.len() + other.len() - 2 * common
    };
    let mut others: Vec<usize> = (0..robot.dof()).filter(|other| *other != joint).collect();
    others.sort_by_cached_key(apart);
    others.truncate(PAIRS_OF_JOINTS / robot.dof().max(1));
    others
}
