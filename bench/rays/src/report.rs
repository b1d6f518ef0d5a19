//! Tables for people, JSON for the page.

use serde_json::{Value, json};

use crate::mesh::Mesh;
use crate::rays::Set;
use crate::statistics::Median;
use crate::trace::{Agreement, EMBREE, OURS, OURS_SINGLE};

/// A ratio with what is wanted of it.
struct Judged {
    what: String,
    ratio: Median,
    target: f64,
}

/// What was measured.
#[derive(Default)]
pub struct Report {
    sets: Vec<Value>,
    rows: Vec<Value>,
    judged: Vec<Judged>,
    /// Nanoseconds a ray of ours by faces.
    growth: Vec<(usize, f64)>,
    /// Seconds of ours and of Embree's single rays by what, for the gain from threads.
    alone: Vec<(String, usize, [f64; 2])>,
}

/// Least share of Embree's gain from a second thread.
const SPEEDUP_TARGET: f64 = 0.97;

impl Report {
    /// A set of rays and how far both agree about it.
    pub fn set(&mut self, mesh: &Mesh, set: &str, rays: usize, agreement: Agreement) {
        let Agreement { other, largest, hits } = agreement;
        println!(
            "\n{} ({} faces), {set}: {rays} rays, {:.1} % hit, {:.4} % differ, largest relative difference of t {:.1e}",
            mesh.name,
            mesh.indices().len(),
            100.0 * hits,
            100.0 * other,
            largest
        );
        self.sets.push(json!({"mesh": mesh.name, "faces": mesh.indices().len(), "set": set, "rays": rays,
            "hit": hits, "differ": other, "largest_difference": largest}));
    }

    /// The turns of one set of rays.
    pub fn rays(
        &mut self,
        mesh: &Mesh,
        set: Set,
        threads: usize,
        count: usize,
        names: &[String],
        seconds: &[Vec<f64>],
    ) {
        let of = |name: &str| names.iter().position(|n| n == name);
        let Some(single) = of(EMBREE[0]).or(if names.is_empty() { None } else { Some(0) }) else { return };
        println!("  {threads} thread(s){:25} Mrays/s        ns   times {}", "", names[single]);
        for (name, times) in names.iter().zip(seconds) {
            let median = Median::of(times);
            let ratio = ratio(&seconds[single], times);
            let (speed, cost) = (count as f64 / median.value / 1e6, median.value / count as f64 * 1e9);
            println!("    {name:32} {speed:10.2} {cost:9.1} {:7.3} [{:.3}, {:.3}]", ratio.value, ratio.low, ratio.high);
            self.rows.push(json!({"mesh": mesh.name, "faces": mesh.indices().len(), "set": set.name(), "threads": threads, "name": name,
                "mrays": speed, "nanoseconds": cost, "ratio": [ratio.low, ratio.value, ratio.high], "seconds": times}));
        }
        let Some(ours) = of(OURS) else { return };
        if threads == 1 {
            self.growth.push((mesh.indices().len(), Median::of(&seconds[ours]).value / count as f64 * 1e9));
        }
        self.judge(mesh, set, threads, names, seconds);
        self.judge_threads(&format!("{}, {}", mesh.name, set.name()), threads, [&seconds[ours], &seconds[single]]);
    }

    fn judge(&mut self, mesh: &Mesh, set: Set, threads: usize, names: &[String], seconds: &[Vec<f64>]) {
        let of = |name: &str| names.iter().position(|n| n == name).map(|i| &seconds[i]);
        let (Some(slices), Some(alone), Some(single)) = (of(OURS), of(OURS_SINGLE), of(EMBREE[0])) else { return };
        let what = |how: &str| format!("{}, {}, {threads} thread(s): {how}", mesh.name, set.name());
        let dragon = mesh.name == "dragon";
        let fastest = || {
            let all = EMBREE.iter().filter_map(|name| of(name));
            all.min_by(|a, b| Median::of(a).value.total_cmp(&Median::of(b).value)).unwrap_or(single)
        };
        let mut add = |how, rival: &[f64], ours: &[f64], target| {
            self.judged.push(Judged { what: what(how), ratio: ratio(rival, ours), target });
        };
        match set {
            Set::Camera if dragon => add("slices against Embree's fastest", fastest(), slices, 1.0),
            Set::Shuffled | Set::ShadowShuffled | Set::Shadow if dragon => {
                add("slices against one ray a call", single, slices, 1.5);
            }
            _ if !dragon => add("slices against one ray a call", single, slices, 1.0),
            _ => {}
        }
        if dragon {
            add("one ray a call on both sides", single, alone, 0.95);
        }
    }

    fn judge_threads(&mut self, what: &str, threads: usize, [ours, theirs]: [&[f64]; 2]) {
        let values = [Median::of(ours).value, Median::of(theirs).value];
        let one = self.alone.iter().find(|(name, one, _)| name == what && *one == 1);
        if let Some((_, _, alone)) = one {
            let gains = [alone[0] / values[0], alone[1] / values[1]];
            println!("  {threads} threads against one: ours {:.2}, Embree's {:.2} times as fast", gains[0], gains[1]);
            let value = gains[0] / gains[1];
            let what = format!("{what}: gain from {threads} threads over Embree's");
            let ratio = Median { low: value, value, high: value };
            self.judged.push(Judged { what, ratio, target: SPEEDUP_TARGET });
        }
        self.alone.push((what.to_owned(), threads, values));
    }

    /// The turns of building.
    pub fn build(&mut self, mesh: &Mesh, threads: usize, names: &[String], seconds: &[Vec<f64>], memory: &[f64]) {
        let faces = mesh.indices().len() as f64;
        println!("\n{} ({faces} faces), build on {threads} thread(s)", mesh.name);
        println!("    {:20} {:>10} {:>10} {:>14}   speed over ours", "", "seconds", "Mfaces/s", "bytes a face");
        for ((name, times), bytes) in names.iter().zip(seconds).zip(memory) {
            let (median, ratio) = (Median::of(times), ratio(&seconds[0], times));
            println!(
                "    {name:20} {:10.4} {:10.2} {:14.1} {:7.3} [{:.3}, {:.3}]",
                median.value,
                faces / median.value / 1e6,
                bytes / faces,
                ratio.value,
                ratio.low,
                ratio.high
            );
            self.rows.push(json!({"mesh": mesh.name, "faces": mesh.indices().len(), "build": name, "threads": threads, "seconds": times,
                "bytes_a_face": bytes / faces}));
        }
        if let Some(medium) = names.iter().position(|name| name == "embree medium") {
            let what = |how: &str| format!("{}, {threads} thread(s): {how}", mesh.name);
            let memory = memory[medium] / memory[0];
            self.judged.push(Judged {
                what: what("build against Embree's medium quality"),
                ratio: ratio(&seconds[medium], &seconds[0]),
                target: 1.0,
            });
            let ratio = Median { low: memory, value: memory, high: memory };
            self.judged.push(Judged { what: what("memory against Embree's"), ratio, target: 1.0 });
        }
    }

    /// The growth of the cost of a ray from the smallest mesh to the largest.
    pub fn growth(&mut self) {
        let (Some(first), Some(last)) = (self.growth.first(), self.growth.last()) else { return };
        let value = first.1 / last.1;
        let what = format!("cost of a ray of {} faces over that of {}", first.0, last.0);
        self.judged.push(Judged { what, ratio: Median { low: value, value, high: value }, target: 0.25 });
    }

    /// Prints what was judged; false if a ratio's lower end is below its target times a factor.
    pub fn passes(&self, factor: f64) -> bool {
        let mut passed = true;
        println!();
        for judged in &self.judged {
            let ok = judged.ratio.low >= factor * judged.target;
            passed &= ok;
            let Median { low, value, high } = judged.ratio;
            let verdict = if ok { "ok  " } else { "MISS" };
            println!("{verdict} {value:6.3} [{low:.3}, {high:.3}], target {:.2}: {}", judged.target, judged.what);
        }
        passed
    }

    pub fn json(&self) -> Value {
        let judged = |j: &Judged| json!({"what": j.what, "ratio": [j.ratio.low, j.ratio.value, j.ratio.high], "target": j.target});
        json!({"sets": self.sets, "rows": self.rows, "judged": self.judged.iter().map(judged).collect::<Vec<_>>()})
    }
}

/// How many times as fast the second is, pair by pair.
fn ratio(first: &[f64], second: &[f64]) -> Median {
    let ratios: Vec<f64> = first.iter().zip(second).map(|(a, b)| a / b).collect();
    Median::of(&ratios)
}
