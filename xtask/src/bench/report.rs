//! Results for people: tables on the terminal and in docs/performance.md, and plots of error against time.

use super::{render, scenes, statistics};
use crate::root;
use serde_json::{Value, json};
use std::{fmt::Write, fs};

/// Marks in the page between which tables are written.
const MARKS: [&str; 2] = ["<!-- results -->", "<!-- end of results -->"];
/// Colours of the lines of a plot.
const COLOURS: [&str; 4] = ["#c0392b", "#2471a3", "#229954", "#7d3c98"];

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

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// `1.23 (1.1-1.4)`.
fn with_interval(value: &Value) -> String {
    let [v, low, high] = [0, 1, 2].map(|i| number(&value[i]));
    format!("{} ({}-{})", three(v), three(low), three(high))
}

/// Three digits.
fn three(v: f64) -> String {
    let digits = if v > 0.0 && v.is_finite() { (2 - libm::log10(v).floor() as i32).clamp(0, 6) as usize } else { 2 };
    format!("{v:.digits$}")
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

/// Writes the tables of docs/performance.md, and its plots, from the kept results.
pub fn page() -> Result<(), String> {
    let results: Vec<Value> = scenes::NAMES.iter().filter_map(|name| render::kept(name)).collect();
    if results.is_empty() {
        return Err("no results are kept: `cargo xtask bench render --peers`".to_owned());
    }
    let path = root().join("docs/performance.md");
    let page = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let split = page.split_once(MARKS[0]).and_then(|(a, b)| Some((a, b.split_once(MARKS[1])?.1)));
    let (before, after) = split.ok_or_else(|| format!("{}: {} is missing", path.display(), MARKS.join(" or ")))?;
    let page = format!("{before}{}\n{}{}{after}", MARKS[0], tables(&results), MARKS[1]);
    scenes::write(&path, page.as_bytes())?;
    let images = root().join("docs/images/performance");
    fs::create_dir_all(&images).map_err(|e| format!("{}: {e}", images.display()))?;
    for result in &results {
        scenes::write(&images.join(format!("{}.svg", text(&result["scene"]))), plot(result).as_bytes())?;
    }
    println!("{} scenes written to {}", results.len(), path.display());
    Ok(())
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

/// Error against seconds, both logarithmic, as SVG.
fn plot(result: &Value) -> String {
    const SIZE: [f64; 2] = [480.0, 300.0];
    const EDGE: [f64; 2] = [56.0, 40.0];
    let lines: Vec<(&str, Vec<[f64; 2]>)> = list(&result["renderers"])
        .iter()
        .map(|r| {
            let build = number(&r["build"]);
            let mut points: Vec<[f64; 2]> =
                list(&r["pilots"]).iter().map(|p| [build + number(&p[1]), number(&p[2])]).collect();
            let errors: Vec<f64> = list(&r["errors"]).iter().map(number).collect();
            points.push([build + number(&r["render_median"]), statistics::mean(&errors)]);
            points.retain(|p| p.iter().all(|v| *v > 0.0 && v.is_finite()));
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            (text(&r["name"]), points)
        })
        .collect();
    let decades = |axis: usize| {
        let all = lines.iter().flat_map(|(_, points)| points).map(|p| libm::log10(p[axis]));
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        if low > high { [0.0, 1.0] } else { [low.floor(), high.ceil().max(low.floor() + 1.0)] }
    };
    let range = [decades(0), decades(1)];
    let place = |p: [f64; 2]| {
        let t = [0, 1].map(|i| (p[i] - range[i][0]) / (range[i][1] - range[i][0]));
        [EDGE[0] + t[0] * (SIZE[0] - EDGE[0] - 16.0), SIZE[1] - EDGE[1] - t[1] * (SIZE[1] - EDGE[1] - 12.0)]
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        SIZE[0], SIZE[1]
    );
    for axis in 0..2 {
        for decade in range[axis][0] as i32..=range[axis][1] as i32 {
            let at = |other: f64| if axis == 0 { [f64::from(decade), other] } else { [other, f64::from(decade)] };
            let [a, b] = range[1 - axis].map(|end| place(at(end)));
            let _ = writeln!(svg, "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#ddd\"/>", a[0], a[1], b[0], b[1]);
            let label = if (-2..=3).contains(&decade) && axis == 0 {
                format!("{}", libm::pow(10.0, f64::from(decade)))
            } else {
                format!("1e{decade}")
            };
            let (x, y, anchor) =
                if axis == 0 { (a[0], a[1] + 14.0, "middle") } else { (a[0] - 5.0, a[1] + 4.0, "end") };
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{label}</text>");
        }
    }
    for (i, (name, points)) in lines.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let corners: Vec<[f64; 2]> = points.iter().map(|p| place(p.map(libm::log10))).collect();
        let path: Vec<String> = corners.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            path.join(" ")
        );
        for p in &corners {
            let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>", p[0], p[1]);
        }
        let y = 24.0 + 14.0 * i as f64;
        let _ = writeln!(
            svg,
            "<text x=\"{:.0}\" y=\"{y}\" text-anchor=\"end\" fill=\"{colour}\">{name}</text>",
            SIZE[0] - 22.0
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">seconds, {} x {}</text>\n\
         <text x=\"12\" y=\"{:.0}\" text-anchor=\"middle\" transform=\"rotate(-90 12 {:.0})\">relMSE</text>\n</svg>",
        SIZE[0] / 2.0,
        SIZE[1] - 8.0,
        result["size"],
        result["size"],
        SIZE[1] / 2.0,
        SIZE[1] / 2.0
    );
    svg
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
        assert!(!svg.contains("NaN") && svg.ends_with("</svg>\n") || svg.ends_with("</svg>"));
    }

    #[test]
    fn numbers_have_three_digits() {
        assert_eq!([0.01234, 1.2345, 123.45, 12345.6].map(three), ["0.0123", "1.23", "123", "12346"]);
    }

    #[test]
    fn the_page_has_its_marks() {
        let page = fs::read_to_string(root().join("docs/performance.md")).unwrap();
        assert!(MARKS.iter().all(|mark| page.matches(mark).count() == 1));
    }
}
