//! What was found, for the README (Markdown) and for a spreadsheet (TSV).

use std::fmt::Write as _;

use crate::turns::Found;

/// Peers that have a column of their own.
const COLUMNS: [&str; 6] = ["Pinocchio", "CasADi", "symplex", "MuJoCo", "k", "our C"];

#[derive(Default)]
pub struct Table {
    functions: Vec<Line>,
    fit: Vec<Line>,
    postures: usize,
}

struct Line {
    range: String,
    asked: String,
    function: String,
    /// Times per posture, s.
    found: Vec<Found>,
}

impl Table {
    /// Times of passes over `postures` postures; the first found is ours.
    pub fn functions(
        &mut self,
        range: &str,
        asked: &str,
        function: &str,
        postures: usize,
        found: &[Found],
    ) {
        let each = |found: &Found| Found {
            time: found.time / postures as f64,
            ..found.clone()
        };
        self.functions.push(Line {
            range: range.to_string(),
            asked: asked.to_string(),
            function: function.to_string(),
            found: found.iter().map(each).collect(),
        });
    }

    /// Times of whole fits.
    pub fn fit(&mut self, postures: usize, found: &[Found]) {
        self.postures = postures;
        self.fit.push(Line {
            range: "±29°".to_string(),
            asked: format!("{postures} postures"),
            function: "fit".to_string(),
            found: found.to_vec(),
        });
    }

    /// Ratios of medians: how many times as long as ours a peer takes.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        let ranges = self.functions.chunk_by(|a, b| a.range == b.range);
        for lines in ranges {
            let _ = writeln!(
                text,
                "\nJoints in {}: time of the peer / ours\n",
                lines[0].range
            );
            let _ = writeln!(text, "| | | ours, ns | {} |", COLUMNS.join(" | "));
            let _ = writeln!(text, "|---|---|---|{}", "---|".repeat(COLUMNS.len()));
            for line in lines {
                let _ = write!(
                    text,
                    "| {} | {} | {:.1} |",
                    line.function,
                    line.asked,
                    1e9 * line.found[0].time
                );
                for column in COLUMNS {
                    let _ = write!(text, " {} |", cell(&line.found, column));
                }
                text.push('\n');
            }
        }
        for line in &self.fit {
            let _ = writeln!(text, "\nFit of {} postures from memory\n", self.postures);
            let _ = writeln!(text, "| | s | time / ours |\n|---|---|---|");
            for found in &line.found {
                let _ = writeln!(
                    text,
                    "| {} | {:.3} | {:.2} |",
                    found.name, found.time, found.ratio[1]
                );
            }
        }
        text
    }

    /// Every median, with quartiles of the ratios.
    pub fn tsv(&self) -> String {
        let mut text =
            String::from("range\tasked\tfunction\tcontestant\tseconds\tratio\tq25\tq75\n");
        for line in self.functions.iter().chain(&self.fit) {
            for found in &line.found {
                let [low, ratio, high] = found.ratio;
                let _ = writeln!(
                    text,
                    "{}\t{}\t{}\t{}\t{:e}\t{ratio}\t{low}\t{high}",
                    line.range, line.asked, line.function, found.name, found.time
                );
            }
        }
        text
    }
}

/// All variants of a peer, the one of our shape first.
fn cell(found: &[Found], column: &str) -> String {
    let of_peer = found.iter().filter(|found| {
        let rest = found.name.strip_prefix(column);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(','))
    });
    let cells: Vec<String> = of_peer
        .map(|found| match found.name.split_once(", ") {
            None => format!("{:.2}", found.ratio[1]),
            Some((_, variant)) => format!("({variant}: {:.2})", found.ratio[1]),
        })
        .collect();
    if cells.is_empty() {
        "–".into()
    } else {
        cells.join(" ")
    }
}
