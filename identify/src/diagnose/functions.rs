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

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use sesc_model::effects::{
    Composed, Constant, Definition, Instance, PostureContext, Site, Target, Unit,
};
use sesc_model::formula::Formula;

use super::criteria::functions::{
    LEAST_PART, OF_A_PLACE, OF_ALL, PAIRS_OF_JOINTS, PARTS, PER_TURN, POSTURES, SIZES, STARTS,
};
use super::dictionary::Dictionary;
use super::hypothesis::Term;
use super::problem::{ALL, Fit, Problem, Proposal};
use crate::lsq::{factor_normal, transposed_times};
use crate::threads::each_long;

/// Knots of a curve.
const KNOTS: usize = 7;

/// A variable that functions take.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Variable {
    Position(usize),
    Moment(usize),
    Approach(usize),
    Reading(usize),
    Time,
}

/// A function of a variable without its size.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Linear,
    Square,
    Cube,
    Sine(f64),
    Cosine(f64),
    /// How far above, or below, it is.
    Above(f64),
    Below(f64),
    /// `v |v|`, `sign v √|v|`.
    Growing,
    Flattening,
    /// Whether it is above.
    Since(f64),
    Decay(f64),
    /// Times the reading along y.
    TimesY,
    /// One at a knot, falling to none at its neighbours, which are so far away.
    Hat(f64, f64),
}

impl Shape {
    fn of(self, v: f64, y: f64) -> f64 {
        match self {
            Shape::Linear => v,
            Shape::Square => v * v,
            Shape::Cube => v * v * v,
            Shape::Sine(n) => (n * v).sin(),
            Shape::Cosine(n) => (n * v).cos(),
            Shape::Above(from) => (v - from).max(0.0),
            Shape::Below(from) => (from - v).max(0.0),
            Shape::Growing => v * v.abs(),
            Shape::Flattening => v.signum() * v.abs().sqrt(),
            Shape::Since(from) => f64::from(u8::from(v > from)),
            Shape::Decay(lasts) => (-v / lasts).exp(),
            Shape::TimesY => v * y,
            Shape::Hat(at, apart) => (1.0 - ((v - at) / apart).abs()).max(0.0),
        }
    }

    /// As a formula of `v` with its own constant.
    fn text(self, v: &str, own: &str) -> String {
        let number = |n: f64| format!("{n:?}");
        match self {
            Shape::Linear => v.to_string(),
            Shape::Square => format!("{v} * {v}"),
            Shape::Cube => format!("{v} * {v} * {v}"),
            Shape::Sine(1.0) => format!("sin({v})"),
            Shape::Cosine(1.0) => format!("cos({v})"),
            Shape::Sine(n) => format!("sin({} * {v})", number(n)),
            Shape::Cosine(n) => format!("cos({} * {v})", number(n)),
            Shape::Above(_) => format!("max({v} - {own}, 0.0)"),
            Shape::Below(_) => format!("max({own} - {v}, 0.0)"),
            Shape::Growing => format!("{v} * abs({v})"),
            Shape::Flattening => format!("sign({v}) * sqrt(abs({v}))"),
            Shape::Since(_) => format!("sign(max({v} - {own}, 0.0))"),
            Shape::Decay(_) => format!("exp(-{v} / {own})"),
            Shape::TimesY => format!("{v} * y"),
            Shape::Hat(at, apart) => {
                let (at, apart) = (number(at), number(apart));
                format!("max(1.0 - abs({v} - {at}) / {apart}, 0.0)")
            }
        }
    }

    /// The same with another constant.
    fn with(self, at: f64) -> Shape {
        match self {
            Shape::Above(_) => Shape::Above(at),
            Shape::Below(_) => Shape::Below(at),
            Shape::Since(_) => Shape::Since(at),
            Shape::Decay(_) => Shape::Decay(at),
            other => other,
        }
    }

    /// Whether it has no unit, whatever that of its variable is.
    fn is_plain(self, variable: Variable) -> bool {
        match self {
            Shape::Sine(_) | Shape::Cosine(_) | Shape::Since(_) | Shape::Decay(_) => true,
            Shape::Hat(..) => true,
            Shape::Linear => matches!(variable, Variable::Approach(_)),
            _ => false,
        }
    }

    /// Its own constant, with its value.
    fn constant(self) -> Option<(&'static str, f64)> {
        match self {
            Shape::Above(from) | Shape::Below(from) | Shape::Since(from) => Some(("start", from)),
            Shape::Decay(lasts) => Some(("lasts", lasts)),
            _ => None,
        }
    }
}

/// Sizes of the terms of a form, in their order.
const COEFFICIENTS: [&str; KNOTS] = ["a", "b", "c", "d", "e", "f", "g"];

/// A function at a site: a sum of shapes of a variable, each times an unknown size.
#[derive(Clone)]
struct Form {
    place: usize,
    variable: Variable,
    shapes: Vec<Shape>,
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
    /// Values of variables, posture by posture.
    values: Values,
    /// Rows among all of the problem.
    rows: Vec<usize>,
    /// Postures of the log for each that is looked at.
    part: f64,
}

struct Values {
    positions: Vec<Vec<f64>>,
    moments: Vec<Vec<f64>>,
    approach: Vec<Vec<f64>>,
    reading: [Vec<f64>; 2],
    time: Vec<f64>,
}

impl Values {
    fn of(&self, variable: Variable) -> &[f64] {
        match variable {
            Variable::Position(j) => &self.positions[j],
            Variable::Moment(j) => &self.moments[j],
            Variable::Approach(j) => &self.approach[j],
            Variable::Reading(axis) => &self.reading[axis],
            Variable::Time => &self.time,
        }
    }
}

/// A hypothesis that forms are tried beside, in the rows that are looked at.
struct Beside {
    /// Masses' directions K, and L of `I + Kᵀ K = L Lᵀ`.
    k: DMatrix<f64>,
    l: DMatrix<f64>,
    /// Whether they are free within the usual tolerances.
    is_wide: bool,
    /// S times its slopes and, behind them, what it leaves.
    left: DMatrix<f64>,
    /// Of its own unknowns, with what is left of their gradient.
    own: Option<(Cholesky<f64, Dyn>, DVector<f64>)>,
}

impl Beside {
    fn of(functions: &Functions, fit: &Fit, problem: &Problem) -> Beside {
        let (own, rows) = (fit.unknowns.len(), &functions.rows);
        let weighting = problem.weighting(&fit.terms, fit.outliers.as_ref(), ALL);
        let mut residual = DMatrix::from_columns(&[fit.residual()]);
        weighting.weigh(&mut residual);
        let mut all = fit.slopes().insert_column(own, 0.0);
        all.set_column(own, &residual.column(0));
        let masses = problem.masses(&fit.terms);
        let left = problem.project_out(masses, &all).select_rows(rows);
        // Of the postures that are looked at, as if they were all.
        let of_own = transposed_times(&all.select_rows(rows), &left);
        let factor = factor_normal(of_own.view((0, 0), (own, own)).into_owned());
        let pull = of_own.view((0, own), (own, 1)).column(0).into_owned();
        Beside {
            k: masses.columns().select_rows(rows),
            l: masses.factor().l_dirty().clone(),
            is_wide: fit.frees_masses(),
            left,
            own: factor.filter(|_| own > 0).map(|factor| (factor, pull)),
        }
    }

    /// Gain and sizes of columns c, of which masses take L⁻¹ Kᵀ c; none where they do what others
    /// do already.
    fn gain(
        &self,
        c: &DMatrix<f64>,
        taken: &DMatrix<f64>,
        of_form: &DMatrix<f64>,
    ) -> Option<(f64, Vec<f64>)> {
        let (count, own) = (c.ncols(), of_form.ncols() - 1);
        let mut a = c.tr_mul(c) - taken.tr_mul(taken);
        let mut b = of_form.column(own).into_owned();
        if let Some((factor, pull)) = &self.own {
            let cross = of_form.columns(0, own).into_owned();
            a -= &cross * factor.solve(&cross.transpose());
            b -= cross * factor.solve(pull);
        }
        let tells = |k: usize| a[(k, k)] > LEAST_PART * c.column(k).norm_squared();
        if !(0..count).all(tells) {
            return None;
        }
        for k in 0..count {
            a[(k, k)] *= 1.0 + LEAST_PART;
        }
        let sizes = a.cholesky()?.solve(&b);
        Some((b.dot(&sizes).max(0.0), sizes.as_slice().to_vec()))
    }
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
        let context = problem.context();
        let postures: usize = problem.blocks.iter().map(|block| block.data.len()).sum();
        let every = postures.div_ceil(POSTURES).max(1);
        let (mut rows, mut values, mut seen) = (Vec::new(), Values::none(context.robot.dof()), 0);
        for (block, range) in problem.blocks.iter().zip(problem.readings()) {
            let chosen: Vec<usize> = (0..block.data.len())
                .filter(|k| (seen + k).is_multiple_of(every))
                .collect();
            seen += block.data.len();
            values.extend(problem, block, &chosen);
            rows.extend(
                chosen
                    .iter()
                    .flat_map(|k| [0, 1].map(|axis| range.start + 2 * k + axis)),
            );
        }
        let mut functions = Functions {
            places: places(problem, dictionary, &rows),
            forms: Vec::new(),
            part: postures as f64 / (rows.len() as f64 / 2.0).max(1.0),
            values,
            rows,
        };
        functions.forms = functions.all_forms(problem);
        functions
    }

    /// How many are tried.
    pub(super) fn tried(&self) -> usize {
        self.forms.len()
    }

    /// The forms that would improve each of some hypotheses most, fewer of one place than of all.
    pub(super) fn proposals(&self, parents: &[Fit], problem: &Problem) -> Vec<Proposal> {
        let beside = parents.iter().map(|fit| Beside::of(self, fit, problem));
        let beside: Vec<Beside> = beside.collect();
        let gains = self.gains(&beside, &self.forms).into_iter();
        let all = gains.zip(parents).zip(&beside);
        all.flat_map(|((gains, parent), beside)| self.best_of(gains, parent, beside, problem))
            .collect()
    }

    /// Those of one hypothesis.
    fn best_of(
        &self,
        mut found: Vec<Gain>,
        parent: &Fit,
        beside: &Beside,
        problem: &Problem,
    ) -> Vec<Proposal> {
        let price = |form: &Form| problem.penalty_of_function(form.unknowns());
        let score = |own: &Gain| price(&own.form) - own.gain;
        found.retain(|own| score(own) < 0.0);
        found.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let mut of_places = vec![0; self.places.len()];
        found.retain(|own| {
            of_places[own.form.place] += 1;
            of_places[own.form.place] <= OF_A_PLACE
        });
        found.truncate(OF_ALL);
        let proposals = found.iter().filter_map(|own| {
            let own = &self.settled(beside, own);
            let term = Term::Effect(self.instance(problem, own)?);
            let fits = parent.terms.iter().all(|other| other.is_compatible(&term));
            fits.then(|| Proposal {
                predicted_score: parent.score() + score(own),
                terms: [&parent.terms[..], &[term]].concat(),
                parent: Some(parent.clone()),
            })
        });
        proposals.collect()
    }

    /// The same form where it begins, or lasts, as long as is best.
    fn settled(&self, beside: &Beside, own: &Gain) -> Gain {
        let form = &own.form;
        let Some((shape, _)) = form.shapes[0].constant().map(|own| (form.shapes[0], own)) else {
            return own.clone();
        };
        let mut values = self.values.of(form.variable).to_vec();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let every = values.len().div_ceil(STARTS).max(1);
        let between = values.windows(2).step_by(every);
        let between = between.map(|pair| 0.5 * (pair[0] + pair[1]));
        let forms = between.map(|at| Form {
            shapes: vec![shape.with(at)],
            ..form.clone()
        });
        let all = self.gains(std::slice::from_ref(beside), &forms.collect::<Vec<_>>());
        let best = all
            .into_iter()
            .flatten()
            .max_by(|a, b| a.gain.total_cmp(&b.gain));
        best.filter(|best| best.gain > own.gain)
            .unwrap_or_else(|| own.clone())
    }

    /// What forms gain beside each of some hypotheses.
    fn gains(&self, beside: &[Beside], forms: &[Form]) -> Vec<Vec<Gain>> {
        let of_place = |place: usize| -> Vec<Vec<Gain>> {
            let forms: Vec<&Form> = forms.iter().filter(|form| form.place == place).collect();
            let columns = self.columns(&forms);
            let mut squares: [Option<DMatrix<f64>>; 2] = [None, None];
            let gains = beside.iter().map(|beside| {
                let taken = squares[usize::from(beside.is_wide)].get_or_insert_with(|| {
                    let mut taken = transposed_times(&beside.k, &columns);
                    beside.l.solve_lower_triangular_mut(&mut taken);
                    taken
                });
                let of_all = transposed_times(&columns, &beside.left);
                let mut at = 0;
                let gains = forms.iter().filter_map(|form| {
                    let count = form.shapes.len();
                    let (c, t) = (columns.columns(at, count), taken.columns(at, count));
                    let of_form = of_all.rows(at, count).into_owned();
                    at += count;
                    let (gain, sizes) = beside.gain(&c.into_owned(), &t.into_owned(), &of_form)?;
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
        let places = 0..self.places.len();
        let mut all = vec![Vec::new(); beside.len()];
        for of_place in each_long(places, of_place) {
            let both = all.iter_mut().zip(of_place);
            both.for_each(|(all, some)| all.extend(some));
        }
        all
    }

    /// The columns of forms at one place, side by side.
    fn columns(&self, forms: &[&Form]) -> DMatrix<f64> {
        let shapes = forms
            .iter()
            .flat_map(|form| form.shapes.iter().map(move |s| (*form, *s)));
        let columns: Vec<DVector<f64>> = shapes
            .map(|(form, shape)| {
                let slope = &self.places[form.place].slope;
                let (v, y) = (self.values.of(form.variable), &self.values.reading[1]);
                DVector::from_fn(self.rows.len(), |row, _| {
                    slope[row] * shape.of(v[row / 2], y[row / 2])
                })
            })
            .collect();
        match columns.is_empty() {
            true => DMatrix::zeros(self.rows.len(), 0),
            false => DMatrix::from_columns(&columns),
        }
    }

    fn all_forms(&self, problem: &Problem) -> Vec<Form> {
        let robot = problem.context().robot;
        let timed = problem.blocks.iter().all(|block| block.data.t.is_some());
        let mut forms = Vec::new();
        for (place, own) in self.places.iter().enumerate() {
            let mut of = |variable: Variable, shapes: Vec<Vec<Shape>>| {
                let values = self.values.of(variable);
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if most > least {
                    forms.extend(shapes.into_iter().map(|shapes| Form {
                        place,
                        variable,
                        shapes,
                    }));
                }
            };
            let alone = |shapes: Vec<Shape>| shapes.into_iter().map(|shape| vec![shape]).collect();
            let quantiles = |variable| quantiles_of(self.values.of(variable), &PARTS);
            let bends = |variable: Variable| {
                let from = quantiles(variable).into_iter();
                from.flat_map(|from| [Shape::Above(from), Shape::Below(from)])
                    .collect::<Vec<_>>()
            };
            // A curve that no formula of the table is.
            let curve = |variable: Variable| {
                let sorted = quantiles_of(self.values.of(variable), &[0.0, 1.0]);
                let digits = 10_f64.powf(2.0 - (sorted[1] - sorted[0]).log10().floor());
                let short = |x: f64| (x * digits).round() / digits;
                let apart = short((sorted[1] - sorted[0]) / (KNOTS - 1) as f64);
                let first = short(sorted[0]);
                let knots = (0..KNOTS).map(|k| short(first + k as f64 * apart));
                vec![knots.map(|at| Shape::Hat(at, apart)).collect::<Vec<_>>()]
            };
            let in_time = || {
                let span = self.values.time.iter().copied().fold(0.0, f64::max);
                let mut shapes: Vec<Shape> = quantiles(Variable::Time)
                    .into_iter()
                    .map(Shape::Since)
                    .collect();
                shapes.extend(SIZES.map(|part| Shape::Decay(part * span)));
                shapes
            };
            match (own.site, &own.target) {
                (Site::Joint, Target::Joint(joint)) => {
                    let q = Variable::Position(*joint);
                    if !robot.tree.dofs[*joint].prismatic {
                        let waves = PER_TURN.map(|n| vec![Shape::Sine(n), Shape::Cosine(n)]);
                        of(q, waves.to_vec());
                    }
                    of(q, alone(vec![Shape::Square, Shape::Cube]));
                    of(q, alone(bends(q)));
                    of(q, curve(q));
                    let tau = Variable::Moment(*joint);
                    of(tau, curve(tau));
                    of(tau, alone(vec![Shape::Growing, Shape::Flattening]));
                    of(Variable::Approach(*joint), alone(vec![Shape::Linear]));
                    for other in nearby(problem, *joint) {
                        of(Variable::Position(other), alone(vec![Shape::Linear]));
                        of(Variable::Moment(other), alone(vec![Shape::Linear]));
                    }
                    if timed {
                        of(
                            Variable::Time,
                            alone([vec![Shape::Linear], in_time()].concat()),
                        );
                    }
                }
                (Site::Sensor, Target::Way(way)) => {
                    let [x, y] = [Variable::Reading(0), Variable::Reading(1)];
                    let (along, across) = if *way == "x" { (x, y) } else { (y, x) };
                    of(along, alone(vec![Shape::Square, Shape::Cube]));
                    of(along, alone(bends(along)));
                    of(along, curve(along));
                    of(across, alone(vec![Shape::Linear, Shape::Square]));
                    of(x, alone(vec![Shape::TimesY]));
                    if timed {
                        of(Variable::Time, alone(in_time()));
                    }
                }
                (Site::Ground, _) => {
                    for axis in 0..2 {
                        of(Variable::Reading(axis), alone(vec![Shape::Linear]));
                    }
                    if timed {
                        of(
                            Variable::Time,
                            alone([vec![Shape::Linear], in_time()].concat()),
                        );
                    }
                }
                (Site::Load, _) if timed => of(Variable::Time, alone(in_time())),
                _ => {}
            }
        }
        forms
    }

    /// The effect of a form, which begins at the sizes of the linear fit.
    fn instance(&self, problem: &Problem, own: &Gain) -> Option<Instance> {
        let (form, context) = (&own.form, problem.context());
        let place = &self.places[form.place];
        let dofs = &context.robot.tree.dofs;
        let named = |word: &str, joint: usize| match &place.target {
            Target::Joint(own) if *own == joint => word.to_string(),
            _ => format!("{word}[\"{}\"]", dofs[joint].joint),
        };
        let v = match form.variable {
            Variable::Position(joint) => named("q", joint),
            Variable::Moment(joint) => named("tau", joint),
            Variable::Approach(joint) => named("approach", joint),
            Variable::Reading(axis) => ["x", "y"][axis].to_string(),
            Variable::Time => "t".to_string(),
        };
        // Names end in their unit where sizes have that of the site.
        let slides = |joint: usize| dofs[joint].prismatic;
        let unit = match (place.site, &place.target) {
            (Site::Joint, Target::Joint(joint)) if slides(*joint) => "_m",
            (Site::Joint | Site::Ground, _) => "_rad",
            (Site::Load, _) => "_kg",
            _ => "_m",
        };
        let of_size = |(shape, name): (&Shape, &str)| match shape.is_plain(form.variable) {
            true => format!("{name}{unit}"),
            false => name.to_string(),
        };
        let names: Vec<String> = form.shapes.iter().zip(COEFFICIENTS).map(of_size).collect();
        let own_constant = form.shapes[0].constant().map(|(name, value)| {
            let ending = match form.variable {
                Variable::Position(joint) if !slides(joint) => "_rad",
                Variable::Position(_) | Variable::Reading(_) => "_m",
                _ => "",
            };
            (format!("{name}{ending}"), value)
        });
        let within = own_constant.as_ref().map_or("", |(name, _)| name);
        let terms = form.shapes.iter().zip(&names);
        let text: Vec<String> = terms
            .map(|(shape, size)| format!("{size} * {}", shape.text(&v, within)))
            .collect();
        let constant = |name: &str, typical: f64| Constant {
            name: name.to_string(),
            typical: if typical == 0.0 { LEAST_PART } else { typical },
            unit: Unit::of(name).symbol().to_string(),
            limits: [f64::NEG_INFINITY, f64::INFINITY],
        };
        let sizes = own.sizes.iter().zip(&names);
        let mut constants: Vec<Constant> = sizes
            .map(|(size, name)| constant(name, rounded(*size)))
            .collect();
        constants.extend(
            own_constant
                .iter()
                .map(|(name, value)| constant(name, *value)),
        );
        let (name, sentence) = form.name(place, &|joint| dofs[joint].joint.clone());
        let definition = Definition {
            name: name.to_string(),
            site: place.site,
            function: Formula::parse(&text.join(" + ")).ok()?,
            constants,
            targets: vec![context.name_of(&place.target)],
            at: None,
            range: Default::default(),
            columns: Default::default(),
            sentence: Some(sentence),
        };
        Some(Instance {
            effect: Composed::new(definition).ok()?,
            target: place.target.clone(),
        })
    }
}

/// Values below which so large parts of some lie.
fn quantiles_of(values: &[f64], parts: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1) as f64;
    let at = |part: &f64| sorted.get((part * last) as usize).copied().unwrap_or(0.0);
    parts.iter().map(at).collect()
}

/// A number to one digit: what a fit begins with need not be known better.
fn rounded(size: f64) -> f64 {
    if size == 0.0 || !size.is_finite() {
        return LEAST_PART;
    }
    let unit = 10_f64.powf(size.abs().log10().floor());
    (size / unit).round() * unit
}

impl Form {
    fn unknowns(&self) -> usize {
        let own = self
            .shapes
            .iter()
            .filter(|shape| shape.constant().is_some());
        self.shapes.len() + own.count()
    }

    /// What people call it, and the subject of a sentence about it.
    fn name(&self, place: &Place, joint: &dyn Fn(usize) -> String) -> (&'static str, String) {
        let own = match place.target {
            Target::Joint(joint) => Some(joint),
            _ => None,
        };
        match (place.site, self.variable, self.shapes[0]) {
            (Site::Joint, Variable::Position(j), _) if Some(j) != own => (
                "joint_coupling",
                format!("an error of {{target}} that follows {}", joint(j)),
            ),
            (Site::Joint, Variable::Moment(j), _) if Some(j) != own => (
                "cross_compliance",
                format!("{{target}} giving way to the moment at {}", joint(j)),
            ),
            (Site::Joint, Variable::Moment(_), Shape::Hat(..)) => (
                "joint_error",
                "an error of {target} that is a curve of its moment".to_string(),
            ),
            (Site::Joint, _, Shape::Hat(..)) => (
                "joint_error",
                "an error of {target} that is a curve of its position".to_string(),
            ),
            (Site::Sensor, _, Shape::Hat(..)) => (
                "sensor_error",
                "an error of the readings along {target} that is a curve of them".to_string(),
            ),
            (Site::Joint, _, Shape::Sine(1.0)) => (
                "encoder_eccentricity",
                "an encoder of {target} that is off centre".to_string(),
            ),
            (Site::Joint, _, Shape::Sine(n)) => (
                "encoder_ripple",
                format!("an encoder of {{target}} that errs {n} times a turn"),
            ),
            (Site::Joint, Variable::Position(_), Shape::Above(_) | Shape::Below(_)) => (
                "joint_stop",
                "a stop or a pull at {target} from an angle on".to_string(),
            ),
            (Site::Joint, Variable::Position(_), _) => (
                "joint_curvature",
                "an error of {target} that is curved in its angle".to_string(),
            ),
            // It grows less than the moment, or more.
            (Site::Joint, Variable::Moment(_), Shape::Flattening) => (
                "spring_hardening",
                "a spring at {target} that hardens".to_string(),
            ),
            (Site::Joint, Variable::Moment(_), _) => (
                "spring_softening",
                "a spring at {target} that softens".to_string(),
            ),
            (Site::Joint, Variable::Approach(_), _) => {
                ("joint_hysteresis", "hysteresis of {target}".to_string())
            }
            (Site::Joint, Variable::Time, Shape::Since(_)) => (
                "joint_slip",
                "a slip of {target} during the log".to_string(),
            ),
            (Site::Joint, _, _) => ("joint_drift", "a drift of {target}".to_string()),
            (Site::Sensor, Variable::Time, Shape::Decay(_)) => (
                "sensor_warmup",
                "a sensor that warms up along {target}".to_string(),
            ),
            (Site::Sensor, Variable::Time, _) => (
                "sensor_error",
                "a step of the readings along {target}".to_string(),
            ),
            (Site::Sensor, _, Shape::Above(_) | Shape::Below(_)) => (
                "sensor_kink",
                "a kink of the readings along {target}".to_string(),
            ),
            (Site::Sensor, Variable::Reading(axis), Shape::Linear | Shape::TimesY)
                if place.target != Target::Way(["x", "y"][axis])
                    || self.shapes[0] == Shape::TimesY =>
            {
                (
                    "sensor_crosstalk",
                    "crosstalk into the readings along {target}".to_string(),
                )
            }
            (Site::Sensor, _, _) => (
                "sensor_nonlinearity",
                "readings along {target} that are not linear".to_string(),
            ),
            (Site::Ground, Variable::Reading(_), _) => (
                "soft_ground",
                "ground that gives way, with a slope along {target}".to_string(),
            ),
            (Site::Ground, _, _) => (
                "ground_error",
                "a slope of the ground along {target} that changes".to_string(),
            ),
            _ => ("load_error", "a load of {target} that changes".to_string()),
        }
    }
}

impl Values {
    fn none(dof: usize) -> Values {
        Values {
            positions: vec![Vec::new(); dof],
            moments: vec![Vec::new(); dof],
            approach: vec![Vec::new(); dof],
            reading: [Vec::new(), Vec::new()],
            time: Vec::new(),
        }
    }

    /// The variables in some postures of a block; what that robot does not have is zero.
    fn extend(&mut self, problem: &Problem, block: &super::problem::Block, chosen: &[usize]) {
        let (here, there) = (problem.context().robot, block.context.robot);
        let (dof, data) = (there.dof(), &block.data);
        let layout = PostureContext::of(there);
        let context = |k: usize, at: usize| data.posture_context[k * layout.len() + at];
        let weight = block.context.weight();
        let moments = block.moments_at(&data.q);
        for (joint, own) in here.tree.dofs.iter().enumerate() {
            let place = there
                .tree
                .dofs
                .iter()
                .position(|dof| dof.joint == own.joint);
            let of = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
                let at = |k: &usize| place.map_or(0.0, |place| value(*k, place));
                chosen.iter().map(at).collect()
            };
            self.positions[joint].extend(of(&|k, at| data.q[k * dof + at]));
            self.moments[joint].extend(of(&|k, at| weight * moments[k * 3 * dof + at]));
            self.approach[joint].extend(of(&|k, at| context(k, layout.approach(at))));
        }
        // As the robot without effects reads: noise of a reading is none of its variables.
        let predicted = block.evaluate(&[], &[], &data.q, &data.posture_context);
        for axis in 0..2 {
            self.reading[axis].extend(chosen.iter().map(|k| predicted[2 * k + axis]));
        }
        self.time
            .extend(chosen.iter().map(|k| context(*k, layout.time())));
    }
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
