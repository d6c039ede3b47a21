//! Devices that break a log, as they do on a bench.

use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::sheet::Sheet;

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
    Frozen,
    Copied,
    Clipped,
    Coarse,
    Unplugged,
    Overstated,
}

/// Devices, their names in the table, and the finding that each should have.
pub(super) const DEVICES: [(Device, &str, &str); 14] = [
    (Device::Constant, "constant CoP", "cop_constant"),
    (Device::DeadAxis, "dead axis", "cop_axis_dead"),
    (Device::Stuck, "stuck encoder", "encoder_stuck"),
    (Device::OtherFoot, "other foot", "other_foot"),
    (Device::Turned, "turned frame", "frame_turned"),
    (Device::Shuffled, "shuffled rows", "rows_shuffled"),
    (Device::Lifted, "lost contact", "contact_lost"),
    (Device::Far, "far readings", "cop_outside_sole"),
    (Device::Frozen, "frozen stretch", "cop_frozen"),
    (Device::Copied, "copied rows", "rows_copied"),
    (Device::Clipped, "clipped channel", "channel_saturated"),
    (Device::Coarse, "coarse channel", "channel_saturated"),
    (Device::Unplugged, "unplugged cell", "contact_lost"),
    (Device::Overstated, "overstated noise", "noise_overstated"),
];

/// A log that was broken, and how it is diagnosed.
pub(super) struct Broken {
    pub urdf: String,
    pub support: String,
    /// Noise of a single reading, m, where the user says.
    pub noise: Option<f64>,
    target: Option<String>,
}

impl Broken {
    /// Whether this is the target that is broken.
    pub fn is(&self, target: &str) -> bool {
        self.target.as_ref().is_none_or(|own| own == target)
    }

    /// Break a log; none where this device has nothing to break in it.
    pub fn of(device: Device, sheet: &mut Sheet, seed: u64) -> Option<Broken> {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let n = sheet.rows();
        if n < FEWEST || sheet.cells != (device == Device::Unplugged) {
            return None;
        }
        let mut broken = Broken {
            urdf: std::fs::read_to_string(&sheet.stage.urdf).ok()?,
            support: sheet.stage.support.to_string(),
            noise: None,
            target: None,
        };
        if device == Device::Unplugged {
            let name = format!("fsr_{}", random.random_range(1..=4));
            // An open input shows its zero, or wherever it drifted to.
            let level = if random.random_bool(0.5) { 0.0 } else { 0.3 };
            sheet.column(&name)?.fill(level);
            broken.target = Some(name);
            return Some(broken);
        }
        let axis = random.random_range(0..2);
        let names = ["cop_x", "cop_y"];
        let name = names[axis];
        let stretch = |part: usize, random: &mut ChaCha8Rng| {
            let from = random.random_range(1..n - n / part);
            from..from + n / part
        };
        match device {
            Device::Constant => {
                let at = random.random_range(-0.03..0.03);
                for name in names {
                    sheet.column(name)?.fill(at);
                }
            }
            Device::DeadAxis => {
                let noisy = random.random_bool(0.3);
                let std = 0.1 * sheet.noise;
                for x in sheet.column(name)? {
                    // An amplifier without its sensor has noise of its own.
                    *x = if noisy {
                        std * random.random_range(-1.0..1.0)
                    } else {
                        0.0
                    };
                }
                broken.target = Some(["x", "y"][axis].to_string());
            }
            Device::Stuck => {
                let joint = stuck(sheet, random)?;
                let middle = sheet.stage.middle(&joint);
                let first = random.random_bool(0.5);
                let column = sheet.column(&joint)?;
                let at = if first { column[0] } else { middle };
                column.fill(at);
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
                broken.urdf = broken.urdf.replace("</robot>", &more);
                broken.support = "turned".to_string();
            }
            Device::Shuffled => {
                let mut order: Vec<usize> = (0..n).collect();
                order.shuffle(random);
                for name in names {
                    let column = sheet.column(name)?;
                    *column = order.iter().map(|&k| column[k]).collect();
                }
            }
            Device::Lifted => {
                let gone = stretch(random.random_range(3..12), random);
                for name in names {
                    sheet.column(name)?[gone.clone()].fill(0.0);
                }
            }
            Device::Far => {
                let odd = random.random_range(7..15);
                let far = 2.5 * sheet.stage.size;
                let rows = sheet.column(name)?.iter_mut().enumerate();
                rows.filter(|(row, _)| row % odd == 3)
                    .for_each(|(_, x)| *x = far);
            }
            Device::Frozen => {
                let gone = stretch(random.random_range(4..10), random);
                for name in names {
                    let column = sheet.column(name)?;
                    let last = column[gone.start - 1];
                    column[gone.clone()].fill(last);
                }
            }
            Device::Copied => {
                let order: Vec<usize> = (0..n).chain(0..n / 3).collect();
                sheet.reorder(&order);
                if let Some(pose) = sheet.column("pose") {
                    (n..pose.len()).for_each(|k| pose[k] = (100_000 + k) as f64);
                }
                // As they were, or with stamps of when they were copied.
                let restamped = random.random_bool(0.5);
                if let Some(t) = sheet.column("t").filter(|_| restamped) {
                    let (end, step) = (t[n - 1], t[1] - t[0]);
                    let first = t[0];
                    (n..t.len()).for_each(|k| t[k] += end - first + step);
                }
            }
            Device::Clipped => {
                let column = sheet.column(name)?;
                let mut sorted = column.clone();
                sorted.sort_by(f64::total_cmp);
                let upper = random.random_bool(0.5);
                let part = random.random_range(5..15);
                let end = if upper {
                    sorted[n - n / part]
                } else {
                    sorted[n / part]
                };
                for x in column {
                    *x = if upper { x.min(end) } else { x.max(end) };
                }
                broken.target = Some(name.to_string());
            }
            Device::Coarse => {
                let step = 6.0 * sheet.row_std;
                for x in sheet.column(name)? {
                    *x = (*x / step).round() * step;
                }
                broken.target = Some(name.to_string());
            }
            Device::Overstated => {
                let mut stated = false;
                for name in ["cop_x_std", "cop_y_std"] {
                    if let Some(column) = sheet.column(name) {
                        column.iter_mut().for_each(|std| *std *= 4.0);
                        stated = true;
                    }
                }
                broken.noise = (!stated).then_some(4.0 * sheet.reading_std());
            }
            Device::Unplugged => {}
        }
        Some(broken)
    }
}

/// A joint whose motion in this log shows clearly in the CoP.
fn stuck(sheet: &Sheet, random: &mut ChaCha8Rng) -> Option<String> {
    let world = sheet.stage.world();
    let every = sheet.postures.len().div_ceil(200);
    let hides = |joint: &usize| {
        let middle = sheet.stage.middle(&sheet.joints[*joint]);
        let squares: Vec<f64> = (sheet.postures.iter().step_by(every))
            .map(|q| {
                let mut still = q.clone();
                still[*joint] = middle;
                let (a, b) = (world.cop(q), world.cop(&still));
                (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() > HIDES * sheet.noise
    };
    let mut all: Vec<usize> = (0..sheet.joints.len()).filter(hides).collect();
    all.shuffle(random);
    Some(sheet.joints[*all.first()?].clone())
}
