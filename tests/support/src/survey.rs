//! Many trials, each drawn, written, diagnosed and judged.

use std::path::Path;

use crate::diagnoser::Diagnoser;
use crate::hidden::Effect;
use crate::judge::{Answer, Judgement};
use crate::stage::Platform;
use crate::trial::{Choice, Question, Trial};

/// A trial and what became of it.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// What was asked.
    pub question: Question,
    /// What was hidden.
    pub effects: Vec<Effect>,
    /// Robot, postures, what is hidden, how visible: for a reader.
    pub description: String,
    /// How visible it was: χ² of the hidden effects.
    pub chi2: f64,
    /// Seed of the trial.
    pub seed: u64,
    /// What became of the answer.
    pub judgement: Judgement,
    /// Time of the answer, s.
    pub seconds: f64,
}

/// Asks one question; the log's files stay in `folder` as `trial_<seed>`.
///
/// # Errors
/// What the diagnoser said where it did not answer.
pub fn ask(diagnoser: &Diagnoser, trial: &Trial, folder: &Path) -> Result<Outcome, String> {
    let stem = format!("trial_{}", trial.seed);
    let log = trial.log.write(folder, &stem);
    let (urdf, model) = (&trial.stage.urdf, folder.join(format!("{stem}_model.toml")));
    let start = std::time::Instant::now();
    let named = |error| format!("{}: {error}", log.display());
    let json = diagnoser.diagnose(urdf, &log, &model).map_err(named)?;
    let seconds = start.elapsed().as_secs_f64();
    let answer = Answer::read(&json).map_err(named)?;
    let mut judgement = Judgement::of(&answer, trial);
    // No model is written where it would not predict its log as the diagnosis states.
    if !trial.aside.is_empty() && model.exists() {
        let postures = folder.join(format!("{stem}_aside.csv"));
        let predicted = diagnoser.predict(urdf, &model, &postures).map_err(named)?;
        judgement.aside = Some(over_noise(&predicted, trial)?);
    }
    Ok(Outcome {
        question: trial.question,
        effects: trial.hidden.iter().map(|hidden| hidden.effect).collect(),
        description: format!(
            "{:?} {:?} {}",
            trial.stage.platform,
            trial.postures,
            trial.sizes()
        ),
        chi2: trial.chi2,
        seed: trial.seed,
        judgement,
        seconds,
    })
}

/// RMSE of predictions of the postures put aside, noise included, over the noise.
fn over_noise(predicted: &[[f64; 2]], trial: &Trial) -> Result<f64, String> {
    let (count, of) = (predicted.len(), trial.aside.len());
    if count != of {
        return Err(format!("{count} of {of} postures predicted"));
    }
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let sigma = &trial.log.sigma;
    let noise = sigma.iter().map(|sigma| square(*sigma)).sum::<f64>() / sigma.len() as f64;
    let gaps = predicted.iter().zip(&trial.aside);
    let gaps = gaps.map(|(found, truth)| square([found[0] - truth[0], found[1] - truth[1]]));
    Ok((1.0 + gaps.sum::<f64>() / predicted.len() as f64 / noise).sqrt())
}

/// The questions of a study: what is asked how often, of `trials` in all.
pub fn questions(trials: usize, choice: &Choice) -> Vec<Question> {
    if let Some(only) = choice.only {
        let question = if only.is_outside() {
            Question::Outside
        } else {
            Question::Library(1)
        };
        return vec![question; trials];
    }
    let shares = [
        (Question::Library(1), 50),
        (Question::Library(2), 16),
        (Question::Library(3), 8),
        (Question::Nothing, 14),
        (Question::Outside, 6),
        (Question::Invisible, 3),
        (Question::Absorbed, 3),
    ];
    // Each time the question that lags most, so that a study may be cut short.
    let mut asked = [0; 7];
    (1..=trials as i64)
        .map(|n| {
            let lag = |i: usize| shares[i].1 * n - 100 * asked[i];
            let next = (0..shares.len()).max_by_key(|&i| lag(i)).unwrap_or(0);
            asked[next] += 1;
            shares[next].0
        })
        .collect()
}

/// All robots, logs of every length.
pub fn everything() -> Choice {
    // The OP2 seven times in ten.
    let platforms = [
        vec![Platform::Op2; 7],
        vec![Platform::Skew; 2],
        vec![Platform::Plain],
    ];
    Choice {
        platforms: platforms.concat(),
        long: true,
        ..Choice::on(Platform::Op2)
    }
}
