//! Devices that break a log, as they do on a bench.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_virtual::trial::Trial;

/// Rows that copying, clipping and so on need to be seen in.
const FEWEST: usize = 50;
/// A stuck encoder hides at least this much motion of the CoP, in deviations of a reading.
const HIDES: f64 = 12.0;

/// What is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Device {
    Constant,
    DeadAxis,
    Stuck,
    OtherFoot,
    Turned,
    Shuffled,
    Lifted,
    Far,
    Copied,
    Clipped,
    Coarse,
    Unplugged,
}

pub(super) const DEVICES: [Device; 12] = [
    Device::Constant,
    Device::DeadAxis,
    Device::Stuck,
    Device::OtherFoot,
    Device::Turned,
    Device::Shuffled,
    Device::Lifted,
    Device::Far,
    Device::Copied,
    Device::Clipped,
    Device::Coarse,
    Device::Unplugged,
];

impl Device {
    /// As the table says it.
    pub fn name(self) -> &'static str {
        match self {
            Device::Constant => "constant CoP",
            Device::DeadAxis => "dead axis",
            Device::Stuck => "stuck encoder",
            Device::OtherFoot => "other foot",
            Device::Turned => "turned frame",
            Device::Shuffled => "shuffled rows",
            Device::Lifted => "lost contact",
            Device::Far => "far readings",
            Device::Copied => "copied rows",
            Device::Clipped => "clipped channel",
            Device::Coarse => "coarse channel",
            Device::Unplugged => "unplugged cell",
        }
    }

    /// What is to be found.
    pub fn kind(self) -> &'static str {
        match self {
            Device::Constant => "cop_constant",
            Device::DeadAxis => "cop_axis_dead",
            Device::Stuck => "encoder_stuck",
            Device::OtherFoot => "other_foot",
            Device::Turned => "frame_turned",
            Device::Shuffled => "rows_shuffled",
            Device::Lifted | Device::Unplugged => "contact_lost",
            Device::Far => "cop_outside_sole",
            Device::Copied => "rows_copied",
            Device::Clipped | Device::Coarse => "channel_saturated",
        }
    }
}

/// A log that was broken, and how it is diagnosed.
pub(super) struct Broken {
    pub urdf: PathBuf,
    pub support: String,
    target: Option<String>,
}

/// Rows of a log as text.
struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Result<Table, Box<dyn Error>> {
        let text = fs::read_to_string(path)?;
        let cells = |line: &str| line.split(',').map(str::to_string).collect();
        let mut lines = text.lines();
        Ok(Table {
            header: cells(lines.next().unwrap_or_default()),
            rows: lines.map(cells).collect(),
        })
    }

    fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let lines = [&self.header].into_iter().chain(&self.rows);
        let lines: Vec<String> = lines.map(|row| row.join(",")).collect();
        Ok(fs::write(path, lines.join("\n") + "\n")?)
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|own| own == name)
    }

    fn numbers(&self, column: usize) -> Vec<f64> {
        let of = |row: &Vec<String>| row[column].parse().unwrap_or(f64::NAN);
        self.rows.iter().map(of).collect()
    }

    fn set(&mut self, column: usize, value: impl Fn(usize) -> Option<f64>) {
        for (k, row) in self.rows.iter_mut().enumerate() {
            if let Some(value) = value(k) {
                row[column] = value.to_string();
            }
        }
    }
}

impl Broken {
    /// Whether this is the target that is broken.
    pub fn is(&self, target: &str) -> bool {
        self.target.as_ref().is_none_or(|own| own == target)
    }

    /// Break a log where it lies; none where this device has nothing to break in it.
    pub fn of(
        device: Device,
        trial: &Trial,
        path: &Path,
        seed: u64,
    ) -> Result<Option<Broken>, Box<dyn Error>> {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut table = Table::read(path)?;
        let n = table.rows.len();
        let cells = table.column("fsr_1").is_some();
        if n < FEWEST || cells != (device == Device::Unplugged) {
            return Ok(None);
        }
        let mut broken = Broken {
            urdf: trial.stage.urdf.clone(),
            support: trial.stage.support.to_string(),
            target: None,
        };
        if device == Device::Unplugged {
            let cell = random.random_range(1..=4);
            let name = format!("fsr_{cell}");
            let column = table.column(&name).ok_or("no cell")?;
            table.set(column, |_| Some(0.0));
            broken.target = Some(name);
            table.write(path)?;
            return Ok(Some(broken));
        }
        let axis = random.random_range(0..2);
        let names = ["cop_x", "cop_y"];
        let columns = [
            table.column("cop_x").ok_or("no CoP")?,
            table.column("cop_y").ok_or("no CoP")?,
        ];
        let cop = columns.map(|column| table.numbers(column));
        match device {
            Device::Constant => {
                for column in columns {
                    table.set(column, |_| Some(0.004));
                }
            }
            Device::DeadAxis => {
                table.set(columns[axis], |_| Some(0.0));
                broken.target = Some(["x", "y"][axis].to_string());
            }
            Device::Stuck => {
                let Some(joint) = stuck(trial, random) else {
                    return Ok(None);
                };
                let column = table.column(&joint).ok_or("no joint")?;
                let middle = trial.stage.middle(&joint);
                table.set(column, |_| Some(middle));
                broken.target = Some(joint);
            }
            Device::OtherFoot => {
                let own = broken.support.clone();
                broken.support = match own.strip_prefix("right") {
                    Some(rest) => format!("left{rest}"),
                    None => format!("l{}", &own[1..]),
                };
                broken.target = Some(own);
            }
            Device::Turned => {
                let rpy = ["0 1.5707963267948966 0", "1.5707963267948966 0 0"][axis];
                let more = format!(
                    "<link name='turned'/><joint name='turn' type='fixed'><parent link='{}'/>\
                     <child link='turned'/><origin xyz='0 0 0' rpy='{rpy}'/></joint></robot>",
                    broken.support
                );
                let text = fs::read_to_string(&broken.urdf)?.replace("</robot>", &more);
                broken.urdf = path.with_extension("urdf");
                fs::write(&broken.urdf, text)?;
                broken.support = "turned".to_string();
            }
            Device::Shuffled => {
                let mut order: Vec<usize> = (0..n).collect();
                order.shuffle(random);
                for (column, cop) in columns.into_iter().zip(&cop) {
                    table.set(column, |row| Some(cop[order[row]]));
                }
            }
            Device::Lifted => {
                let from = random.random_range(0..n - n / 8);
                let gone = from..from + n / 8;
                for column in columns {
                    table.set(column, |row| gone.contains(&row).then_some(0.0));
                }
            }
            Device::Far => {
                let odd = random.random_range(7..15);
                let far = 2.5 * trial.stage.size;
                table.set(columns[axis], |row| (row % odd == 3).then_some(far));
            }
            Device::Copied => {
                let mut more = table.rows[..n / 3].to_vec();
                let number = |k: usize| (100_000 + k).to_string();
                (more.iter_mut().enumerate()).for_each(|(k, row)| row[0] = number(k));
                table.rows.extend(more);
            }
            Device::Clipped => {
                let mut sorted = cop[axis].clone();
                sorted.sort_by(f64::total_cmp);
                let end = sorted[n - n / 10];
                table.set(columns[axis], |row| Some(cop[axis][row].min(end)));
                broken.target = Some(names[axis].to_string());
            }
            Device::Coarse => {
                let step = 6.0 * trial.stage.reading_std();
                let step = if trial.log.sigma.len() == n {
                    step / 10.0
                } else {
                    step
                };
                table.set(columns[axis], |row| {
                    Some((cop[axis][row] / step).round() * step)
                });
                broken.target = Some(names[axis].to_string());
            }
            Device::Unplugged => {}
        }
        table.write(path)?;
        Ok(Some(broken))
    }
}

/// A joint whose motion in this log shows clearly in the CoP.
fn stuck(trial: &Trial, random: &mut ChaCha8Rng) -> Option<String> {
    let world = trial.stage.world();
    let noise = trial.stage.reading_std() / 10.0;
    let hides = |joint: &usize| {
        let middle = trial.stage.middle(&trial.log.joints[*joint]);
        let squares = trial.log.postures.iter().map(|q| {
            let mut still = q.clone();
            still[*joint] = middle;
            let (a, b) = (world.cop(q), world.cop(&still));
            (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
        });
        let n = trial.log.postures.len() as f64;
        (squares.sum::<f64>() / n).sqrt() > HIDES * noise
    };
    let mut all: Vec<usize> = (0..trial.log.joints.len()).filter(hides).collect();
    all.shuffle(random);
    Some(trial.log.joints[*all.first()?].clone())
}
