//! The tables of docs/simplify.md.

use super::{CLAIM, CURVE, kept};
use crate::{
    bench::page::{self, list, number, text, three},
    root,
};
use serde_json::Value;
use std::fmt::Write;

/// Writes the tables from the kept results; false if there are none.
pub fn write_page() -> Result<bool, String> {
    let results = kept("simplify");
    if results.is_empty() {
        return Ok(false);
    }
    let tables = tables(&results) + &curves(&kept(CURVE)) + &claim(&kept(CLAIM));
    page::put(&root().join("docs/simplify.md"), "results", &tables)?;
    Ok(true)
}

fn tables(results: &[Value]) -> String {
    let mut out = String::new();
    for result in results {
        let _ = writeln!(
            out,
            "\n### {}\n\n{}; {} turns, {} points each way.\n",
            text(&result["model"]),
            text(&result["what"]),
            result["turns"],
            result["samples"]
        );
        let sizes = list(&result["sizes"]);
        out += &by_size(sizes, cell);
        for size in sizes.iter().filter(|size| size["check"].is_object()) {
            let [rms, largest] = ["rms", "largest"].map(|key| number(&size["check"][key]));
            let _ = write!(out, "\nMeshLab's distances over ours at {}: {rms:.4}, {largest:.4}.", size["faces"]);
        }
        let tried = list(&result["sigma"]["tried"]);
        if !tried.is_empty() {
            let _ = writeln!(out, "\n\nSigma, to {} without polish:\n", result["sigma"]["faces"]);
            let row = |title: &str, key: &str, scale: f64| {
                let cells: Vec<String> = tried.iter().map(|t| three(scale * number(&t[key]))).collect();
                format!("| {title} | {} |", cells.join(" | "))
            };
            let _ = writeln!(out, "{}\n|---|{}", row("sigma", "sigma", 1.0), "---|".repeat(tried.len()));
            let _ = writeln!(out, "{}\n{}", row("rms", "rms", 1e4), row("largest", "largest", 1e4));
        }
    }
    out.push('\n');
    out
}

/// A row for each tool, a column for each size.
fn by_size(sizes: &[Value], cell: fn(&Value, usize) -> String) -> String {
    let mut out = String::new();
    let titles: Vec<String> = sizes.iter().map(|size| format!("to {}", size["faces"])).collect();
    let _ = writeln!(out, "| tool | {} |\n|---|{}", titles.join(" | "), "---|".repeat(sizes.len()));
    for (i, tool) in sizes.first().map_or(&[][..], |size| list(&size["tools"])).iter().enumerate() {
        let cells: Vec<String> = sizes.iter().map(|size| cell(size, i)).collect();
        let _ = writeln!(out, "| {} | {} |", text(&tool["name"]), cells.join(" | "));
    }
    out
}

/// Error over time, for each model: seconds, rms / largest.
fn curves(results: &[Value]) -> String {
    let short = |size: &Value, tool: usize| {
        let cell = cell(size, tool);
        let (seconds, rest) = cell.split_once(" (").unwrap_or((&cell, ""));
        format!("{seconds}; {}", rest.split_once("; ").map_or("", |(_, errors)| errors))
    };
    let mut out = String::new();
    for result in results {
        let (model, turns, samples) = (text(&result["model"]), &result["turns"], &result["samples"]);
        let _ = writeln!(out, "### Error over time: {model}\n\n{turns} turns, {samples} points each way.\n");
        out += &by_size(list(&result["sizes"]), short);
        out.push('\n');
    }
    out
}

/// The union of faces over accumulated quadrics, for each placement: ratios of rms, of the largest distance, and of seconds.
fn claim(results: &[Value]) -> String {
    let mut out = String::new();
    for result in results {
        for size in list(&result["sizes"]) {
            let pairs = list(&size["tools"]).chunks_exact(2);
            if out.is_empty() {
                let placement = |pair: &[Value]| text(&pair[0]["name"]).rsplit(' ').next().unwrap_or("").to_owned();
                let titles: Vec<String> = pairs.clone().map(placement).collect();
                let _ = writeln!(
                    out,
                    "### Both forms of the quadric\n\n`quadric-union` over `quadric`, without polish: rms / largest, and times the \
                     seconds.\n\n| model | {} |\n|---|{}",
                    titles.join(" | "),
                    "---|".repeat(titles.len())
                );
            }
            let ratios = |pair: &[Value]| {
                let of = |value: fn(&Value) -> f64| value(&pair[1]) / value(&pair[0]);
                let [rms, largest] = [of(|v| number(&v["rms"])), of(|v| number(&v["largest"]))];
                format!("{rms:.2} / {largest:.2}, {:.1}", of(|v| number(&v["seconds"][0])))
            };
            let cells: Vec<String> = pairs.map(ratios).collect();
            let _ = writeln!(out, "| {} to {} | {} |", text(&result["model"]), size["faces"], cells.join(" | "));
        }
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

/// Seconds with their interval, and distances in 1e-4 of the diagonal; the fewest of the others in bold.
fn cell(size: &Value, tool: usize) -> String {
    let all = list(&size["tools"]);
    let entry = &all[tool];
    let [seconds, low, high] = [0, 1, 2].map(|i| number(&entry["seconds"][i]));
    // One that is left with more faces than were asked for is no rival; in a tie all are best, as far as digits are shown.
    let asked = size["faces"].as_u64().unwrap_or(u64::MAX);
    let hits = |t: &Value| t["faces"].as_u64().is_none_or(|faces| faces <= asked);
    let least = |key: &str| all.iter().filter(|t| hits(t)).map(|t| number(&t[key])).fold(f64::INFINITY, f64::min);
    let [rms, largest] = ["rms", "largest"].map(|key| {
        let value = three(1e4 * number(&entry[key]));
        if hits(entry) && value == three(1e4 * least(key)) { format!("**{value}**") } else { value }
    });
    let missed = match (entry["faces"].as_u64(), size["faces"].as_u64()) {
        (Some(faces), Some(asked)) if faces > asked => format!(" ({faces} faces)"),
        _ => String::new(),
    };
    format!("{} s ({}-{}); {rms} / {largest}{missed}", three(seconds), three(low), three(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn tables_hold_what_was_measured() {
        let tool = |name: &str, rms: f64, faces: u64| json!({ "name": name, "seconds": [0.5, 0.4, 0.6], "faces": faces, "rms": rms, "largest": 2e-3 });
        let size = json!({ "faces": 10, "tools": [tool("A", 1.5e-4, 10), tool("B", 1e-4, 12)], "check": { "rms": 1.0, "largest": 0.99 } });
        let sigma = json!({ "faces": 10, "tried": [{ "sigma": 0.01, "rms": 1e-4, "largest": 3e-4 }] });
        let result =
            json!({ "model": "cube", "what": "a cube", "turns": 5, "samples": 100, "sizes": [size], "sigma": sigma });
        let page = tables(&[result]);
        for part in [
            "### cube",
            "| tool | to 10 |",
            "| A | 0.500 s (0.400-0.600); **1.50** / **20.0** |",
            "| B | 0.500 s (0.400-0.600); 1.00 / 20.0 (12 faces) |",
            "at 10: 1.0000, 0.9900",
            "| rms | 1.00 |",
        ] {
            assert!(page.contains(part), "{part} in {page}");
        }
    }

    #[test]
    fn curves_have_seconds_and_errors() {
        let tool = json!({ "name": "A", "seconds": [0.5, 0.4, 0.6], "faces": 12, "rms": 1e-4, "largest": 2e-3 });
        let size = |faces: u64| json!({ "faces": faces, "tools": [tool] });
        let result = json!({ "model": "cube", "turns": 5, "samples": 100, "sizes": [size(10), size(20)] });
        let page = curves(&[result]);
        assert!(page.contains("| A | 0.500 s; 1.00 / 20.0 (12 faces) | 0.500 s; **1.00** / **20.0** |"), "{page}");
    }

    #[test]
    fn forms_are_set_beside_each_other() {
        let tool = |name: &str, rms: f64, seconds: f64| json!({ "name": name, "seconds": [seconds, 0.4, 0.6], "rms": rms, "largest": 2e-3 });
        let tools = [tool("quadric, perturbed", 2e-4, 0.5), tool("quadric-union, perturbed", 1.5e-4, 1.0)];
        let table = claim(&[json!({ "model": "cube", "sizes": [{ "faces": 10, "tools": tools }] })]);
        assert!(
            table.contains("| model | perturbed |") && table.contains("| cube to 10 | 0.75 / 1.00, 2.0 |"),
            "{table}"
        );
        assert_eq!(claim(&[]), "");
    }
}
