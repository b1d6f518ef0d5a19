//! Tables of rays, builds and growth in docs/performance.md, from what `bench rays`, `build` and `scaling` kept.

use super::{
    page::{self, list, number, text, three},
    plot::Plot,
    scenes, statistics,
};
use serde_json::Value;
use std::{fmt::Write, path::Path};

/// Ours, as the measuring program names it: in slices, and one a call.
const OURS: [&str; 2] = ["etendue, slices of 1024", "etendue, one per call"];
/// Embree's calls, a ray each first.
const EMBREE: [&str; 3] = ["embree 1", "embree 8", "embree 16"];

/// Writes what is kept, with the plot in `images`; false if nothing is.
pub fn write_page(path: &Path, images: &Path) -> Result<bool, String> {
    let mut any = false;
    if let Some(result) = page::kept("rays") {
        page::put(path, "rays", &rays(&result, page::kept("rays-kdtree").as_ref()))?;
        any = true;
    }
    if let Some(result) = page::kept("build") {
        page::put(path, "builds", &builds(&result))?;
        any = true;
    }
    if let Some(result) = page::kept("scaling") {
        page::put(path, "growth", &growth(&result))?;
        scenes::write(&images.join("growth.svg"), growth_plot(&result).as_bytes())?;
        any = true;
    }
    Ok(any)
}

/// The kept row of a set of rays.
fn row<'a>(result: &'a Value, set: &Value, threads: u64, name: &str) -> Option<&'a Value> {
    let is_it = |row: &&Value| {
        row["mesh"] == set["mesh"] && row["set"] == set["set"] && row["threads"] == threads && row["name"] == name
    };
    list(&result["rows"]).iter().find(is_it)
}

/// Times the speed of Embree's single rays, with the interval.
fn ratio(row: Option<&Value>) -> String {
    row.map_or_else(String::new, |row| page::with_interval([1, 0, 2].map(|i| number(&row["ratio"][i]))))
}

/// How much faster two threads are than one.
fn gain(result: &Value, set: &Value, name: &str) -> f64 {
    let speed = |threads| row(result, set, threads, name).map_or(f64::NAN, |row| number(&row["mrays"]));
    speed(2) / speed(1)
}

fn rays(result: &Value, kd_tree: Option<&Value>) -> String {
    let mut out = "\n| rays | hit | ours in slices, Mrays/s | ours in slices, times Embree | ours one a call, times Embree | \
                   Embree's best packet, times Embree | two threads, ours / Embree's | kd-tree in slices, times Embree |\n\
                   |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for set in list(&result["sets"]) {
        let [slices, alone] = OURS.map(|name| row(result, set, 1, name));
        let packet = EMBREE[1..].iter().filter_map(|name| row(result, set, 1, name));
        let packet = packet.max_by(|a, b| number(&a["ratio"][1]).total_cmp(&number(&b["ratio"][1])));
        let _ = writeln!(
            out,
            "| {}, {} | {:.0} % | {} | {} | {} | {} | {} / {} | {} |",
            text(&set["mesh"]),
            text(&set["set"]),
            100.0 * number(&set["hit"]),
            slices.map_or_else(String::new, |row| three(number(&row["mrays"]))),
            ratio(slices),
            ratio(alone),
            ratio(packet),
            three(gain(result, set, OURS[0])),
            three(gain(result, set, EMBREE[0])),
            ratio(kd_tree.and_then(|kd_tree| row(kd_tree, set, 1, OURS[0]))),
        );
    }
    out.push('\n');
    out
}

fn builds(result: &Value) -> String {
    let rows = list(&result["rows"]);
    let mut out = "\n| mesh | threads | ours, s | Embree's seconds over ours: low, medium, high quality | bytes a face, ours / medium |\n\
                   |---|---|---|---|---|\n"
        .to_owned();
    for ours in rows.iter().filter(|row| row["build"] == "etendue") {
        let other = |quality: &str| {
            let name = format!("embree {quality}");
            rows.iter().find(|r| r["mesh"] == ours["mesh"] && r["threads"] == ours["threads"] && r["build"] == *name)
        };
        let seconds = |row: &Value| statistics::median(&list(&row["seconds"]).iter().map(number).collect::<Vec<_>>());
        let times = |row: Option<&Value>| row.map_or_else(String::new, |row| three(seconds(row) / seconds(ours)));
        let bytes = |row: &Value| format!("{:.1}", number(&row["bytes_a_face"]));
        let _ = writeln!(
            out,
            "| {}, {} faces | {} | {} | {}, {}, {} | {} / {} |",
            text(&ours["mesh"]),
            ours["faces"],
            ours["threads"],
            three(seconds(ours)),
            times(other("low")),
            times(other("medium")),
            times(other("high")),
            bytes(ours),
            other("medium").map_or_else(String::new, bytes),
        );
    }
    out.push('\n');
    out
}

/// Nanoseconds a ray by faces, of those named so.
fn costs(result: &Value, name: &str) -> Vec<[f64; 2]> {
    let rows = list(&result["rows"]).iter().filter(|row| row["name"] == name);
    rows.map(|row| [number(&row["faces"]), number(&row["nanoseconds"])]).collect()
}

fn growth(result: &Value) -> String {
    let mut out = "\n| faces | ours in slices, ns a ray | Embree's single rays, ns a ray |\n|---|---|---|\n".to_owned();
    let [ours, theirs] = [costs(result, OURS[0]), costs(result, EMBREE[0])];
    for (ours, theirs) in ours.iter().zip(&theirs) {
        let _ = writeln!(out, "| {} | {} | {} |", ours[0], three(ours[1]), three(theirs[1]));
    }
    let grown = |costs: &[[f64; 2]]| match costs {
        [first, .., last] => last[1] / first[1],
        _ => f64::NAN,
    };
    let [ours, theirs] = [grown(&ours), grown(&theirs)].map(three);
    let _ = writeln!(
        out,
        "\nFrom the first to the last it grows {ours} times, Embree's {theirs}.\n\n\
         ![Cost of a ray by faces](images/performance/growth.svg)\n"
    );
    out
}

fn growth_plot(result: &Value) -> String {
    let line = |shown, name| (shown, costs(result, name));
    let lines = vec![line("Etendue, slices", OURS[0]), line("Embree, single rays", EMBREE[0])];
    Plot { axes: ["faces", "ns a ray, shuffled bounces"], lines }.svg()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn measured(faces: u64, threads: u64, name: &str, mrays: f64) -> Value {
        json!({"mesh": "knot", "faces": faces, "set": "camera", "threads": threads, "name": name, "mrays": mrays,
               "nanoseconds": 1e3 / mrays, "ratio": [mrays / 2.1, mrays / 2.0, mrays / 1.9]})
    }

    fn result() -> Value {
        let rows: Vec<Value> = [1, 2]
            .into_iter()
            .flat_map(|threads| {
                let speeds = [(OURS[0], 8.0), (OURS[1], 1.0), (EMBREE[0], 2.0), (EMBREE[1], 5.0), (EMBREE[2], 4.0)];
                speeds.map(|(name, speed)| measured(7000, threads, name, speed * threads as f64))
            })
            .collect();
        json!({"sets": [{"mesh": "knot", "faces": 7000, "set": "camera", "hit": 0.5}], "rows": rows})
    }

    #[test]
    fn rays_are_set_beside_embree() {
        let table = rays(&result(), Some(&result()));
        let row = "| knot, camera | 50 % | 8.00 | 4.00 (3.81-4.21) | 0.500 (0.476-0.526) | 2.50 (2.38-2.63) | 2.00 / 2.00 | 4.00 (3.81-4.21) |";
        assert!(table.contains(row), "{table}");
        assert!(rays(&result(), None).contains("2.00 / 2.00 |  |"));
    }

    #[test]
    fn builds_have_all_qualities() {
        let build = |name: &str, seconds: f64| json!({"mesh": "knot", "faces": 7000, "build": name, "threads": 1, "seconds": [seconds], "bytes_a_face": 60.0});
        let table = builds(
            &json!({"rows": [build("etendue", 0.5), build("embree low", 0.25), build("embree medium", 0.6), build("embree high", 1.0)]}),
        );
        assert!(table.contains("| knot, 7000 faces | 1 | 0.500 | 0.500, 1.20, 2.00 | 60.0 / 60.0 |"), "{table}");
    }

    #[test]
    fn growth_is_from_the_first_to_the_last() {
        let rows = [(10_000, 8.0), (100_000, 4.0)]
            .into_iter()
            .flat_map(|(faces, speed)| [OURS[0], EMBREE[0]].map(|name| measured(faces, 1, name, speed)));
        let result = json!({"rows": rows.collect::<Vec<_>>()});
        let part = growth(&result);
        assert!(part.contains("| 10000 | 125 | 125 |") && part.contains("grows 2.00 times"), "{part}");
        assert_eq!(growth_plot(&result).matches("<circle").count(), 4);
    }
}
