//! Results of pictures for people: tables on the terminal and in docs/performance.md, and plots of error against time.

use super::{
    page::{self, list, number, text, three},
    plot::Plot,
    render, scenes, statistics,
};
use serde_json::{Value, json};
use std::{fmt::Write, fs, path::Path};

/// An estimate as `[value, low, high]`.
pub fn interval(e: statistics::Estimate) -> Value {
    json!([e.value, e.low, e.high])
}

/// Stores a scene's result.
pub fn keep(name: &str, result: &Value) -> Result<(), String> {
    let folder = render::results();
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    scenes::write(&folder.join(format!("{name}.json")), format!("{result:#}\n").as_bytes())
}

fn with_interval(value: &Value) -> String {
    page::with_interval([0, 1, 2].map(|i| number(&value[i])))
}

/// The rows of a scene's table, one a renderer.
fn rows(result: &Value) -> Vec<[String; 9]> {
    let row = |r: &Value| {
        let mark = if r["extrapolated"] == true { "~" } else { "" };
        [
            text(&r["name"]).to_owned(),
            r["spp"].to_string(),
            three(number(&r["build"])),
            three(number(&r["render_median"])),
            three(number(&r["mpaths_per_second"])),
            r["mrays_per_second"].as_f64().map(three).unwrap_or_default(),
            format!("{:.2e} / {:.2e}", number(&r["rel_mse"]), number(&r["rel_mse_trimmed"])),
            format!("{mark}{}", with_interval(&r["seconds_to_target"])),
            means(r),
        ]
    };
    list(&result["renderers"]).iter().map(row).collect()
}

/// How far the image's mean is from the reference's, and how many tiles are.
fn means(renderer: &Value) -> String {
    let image = format!("{:.2} %", 100.0 * number(&renderer["image_mean_off"]));
    if renderer["judged"] != true {
        return image;
    }
    let allowed = if number(&renderer["image_mean_excess"]) > 1.0 { " (too much)" } else { "" };
    format!("{image}{allowed}, {} of {}", renderer["tiles_disagreeing"], renderer["tiles"])
}

const TITLES: [&str; 9] = [
    "renderer",
    "spp",
    "build s",
    "render s",
    "Mpaths/s",
    "Mrays/s",
    "relMSE plain / trimmed",
    "s to target (95 %)",
    "mean off, tiles off",
];

/// Prints a scene's table.
pub fn print_scene(result: &Value) {
    let mut rows = rows(result);
    rows.insert(0, TITLES.map(str::to_owned));
    let width = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..TITLES.len()).map(width).collect();
    for row in &rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, w)| format!("{cell:w$}")).collect();
        println!("  {}", cells.join("  ").trim_end());
    }
    if result["ratio"].is_array() {
        println!("  ratio to {}: {}", text(&result["fastest_rival"]), with_interval(&result["ratio"]));
    }
}

/// Prints the mean over scenes.
pub fn print_all(results: &[Value]) {
    if let Some((count, mean)) = overall(results) {
        println!("geometric mean of the ratios over {count} scenes: {}", with_interval(&mean));
    }
}

/// How many scenes were compared, and the geometric mean of their ratios.
fn overall(results: &[Value]) -> Option<(usize, Value)> {
    let ratios: Vec<Vec<f64>> = results
        .iter()
        .filter(|r| r["ratio_resampled"].is_array())
        .map(|r| list(&r["ratio_resampled"]).iter().map(number).collect())
        .collect();
    let means = statistics::geometric_mean(&ratios);
    (!means.is_empty()).then(|| (ratios.len(), interval(statistics::estimate(&means))))
}

/// Writes the tables of pictures to docs/performance.md, and their plots to `images`; false if no results are kept.
pub fn write_page(path: &Path, images: &Path) -> Result<bool, String> {
    let results: Vec<Value> = scenes::NAMES.iter().filter_map(|name| page::kept(name)).collect();
    if results.is_empty() {
        return Ok(false);
    }
    page::put(path, "results", &tables(&results))?;
    for result in &results {
        scenes::write(&images.join(format!("{}.svg", text(&result["scene"]))), plot(result).as_bytes())?;
    }
    Ok(true)
}

/// The part of the page that results make.
fn tables(results: &[Value]) -> String {
    let mut out = String::new();
    if results.iter().any(|r| r["quick"] == true) {
        out += "\n**Some of these are from a quick run: 3 seeds of 64 samples, extrapolated to the target, and few scenes. Whole runs replace them.**\n";
    }
    if let Some((count, mean)) = overall(results) {
        let _ = writeln!(out, "\nGeometric mean of the ratios over {count} scenes: {}.", with_interval(&mean));
    }
    out += "\n| scene | ratio to the fastest rival (95 %) | which |\n|---|---|---|\n";
    for r in results {
        let ratio = if r["ratio"].is_array() { with_interval(&r["ratio"]) } else { String::new() };
        let _ = writeln!(out, "| {} | {ratio} | {} |", text(&r["scene"]), text(&r["fastest_rival"]));
    }
    for r in results {
        let _ = writeln!(
            out,
            "\n### {}\n\n{size} x {size}, {} threads, {} seeds, target {}; the reference's own error is {:.1e}.\n",
            text(&r["scene"]),
            r["threads"],
            r["seeds"],
            r["target"],
            number(&r["reference_error"]),
            size = r["size"],
        );
        let _ = writeln!(out, "| {} |\n|{}", TITLES.join(" | "), "---|".repeat(TITLES.len()));
        for row in rows(r) {
            let _ = writeln!(out, "| {} |", row.join(" | "));
        }
        let _ = writeln!(out, "\n![Error against time](images/performance/{}.svg)", text(&r["scene"]));
    }
    out.push('\n');
    out
}

/// Error against seconds.
fn plot(result: &Value) -> String {
    let points = |r: &Value| {
        let build = number(&r["build"]);
        let mut points: Vec<[f64; 2]> =
            list(&r["pilots"]).iter().map(|p| [build + number(&p[1]), number(&p[2])]).collect();
        let errors: Vec<f64> = list(&r["errors"]).iter().map(number).collect();
        points.push([build + number(&r["render_median"]), statistics::mean(&errors)]);
        points
    };
    let lines = list(&result["renderers"]).iter().map(|r| (text(&r["name"]), points(r))).collect();
    let seconds = format!("seconds, {size} x {size}", size = result["size"]);
    Plot { axes: [&seconds, "relMSE"], lines }.svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result() -> Value {
        let renderer = |name: &str| {
            json!({"name": name, "spp": 64, "build": 0.1, "render_median": 2.0, "errors": [1e-3, 2e-3],
                   "pilots": [[16, 0.5, 1e-2], [64, 2.0, 2e-3]], "seconds_to_target": [3.0, 2.5, 3.5], "extrapolated": true, "judged": true, "image_mean_excess": 0.5,
                   "tiles": 3, "tiles_disagreeing": 0, "image_mean_off": 0.001, "rel_mse": 1e-3, "rel_mse_trimmed": 9e-4})
        };
        json!({"scene": "x", "size": 512, "threads": 2, "seeds": 2, "target": 1e-3, "renderers": [renderer("A"), renderer("B")],
               "fastest_rival": "B", "ratio": [0.5, 0.4, 0.6], "ratio_resampled": [0.5, 0.4, 0.6], "quick": true})
    }

    #[test]
    fn tables_and_plots_hold_what_was_measured() {
        let page = tables(&[result()]);
        for part in [
            "0.500 (0.400-0.600)",
            "| A | 64 | 0.100 | 2.00 |",
            "~3.00 (2.50-3.50)",
            "quick run",
            "over 1 scenes: 0.500",
            "0.10 %, 0 of 3",
        ] {
            assert!(page.contains(part), "{part} in {page}");
        }
        let svg = plot(&result());
        assert_eq!((svg.matches("<polyline").count(), svg.matches("<circle").count()), (2, 6));
    }
}
