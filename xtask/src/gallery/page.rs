//! How each picture was made: gallery/records.json, and the table of docs/gallery.md that is written from it.

use crate::disk::{read, write};
use crate::root;
use serde_json::{Map, Value, json};
use std::{io::Cursor, path::Path, process::Command};

/// The table stands between these lines.
const BEGIN: &str = "<!-- made by cargo xtask gallery -->";
const END: &str = "<!-- end -->";

/// How a figure was rendered.
pub struct Record {
    number: u32,
    values: Value,
}

impl Record {
    /// From what the program told and wrote.
    pub fn new(number: u32, rendered: &Value, picture: &Path) -> Result<Self, String> {
        let bytes = read(picture)?;
        let seed = text(&bytes, "seed").ok_or_else(|| format!("{}: tells no seed", picture.display()))?;
        let values = json!({
            "width": rendered["width"],
            "height": rendered["height"],
            "spp": rendered["spp_max"],
            "seed": seed,
            "seconds": rendered["seconds"]["render"].as_f64().map(f64::round),
            "rays": rendered["rays"],
            "film_hash": rendered["film_hash"],
            "commit": commit(),
        });
        Ok(Self { number, values })
    }
}

/// A text of a PNG file.
fn text(file: &[u8], keyword: &str) -> Option<String> {
    let reader = png::Decoder::new(Cursor::new(file)).read_info().ok()?;
    let info = reader.info();
    let latin = info.uncompressed_latin1_text.iter().find(|t| t.keyword == keyword).map(|t| t.text.clone());
    latin.or_else(|| info.utf8_text.iter().find(|t| t.keyword == keyword)?.get_text().ok())
}

/// The commit that is checked out, with a `+` if what makes pictures has been changed since.
fn commit() -> String {
    let git = |arguments: &[&str]| Command::new("git").current_dir(root()).args(arguments).output();
    let Ok(head) = git(&["rev-parse", "--short=10", "HEAD"]) else { return "unknown".to_owned() };
    let changed = git(&["status", "--porcelain", "--", "crates", "gallery/*.toml", "gallery/inputs", "Cargo.lock"]);
    let changed = changed.is_ok_and(|output| !output.stdout.is_empty());
    format!("{}{}", String::from_utf8_lossy(&head.stdout).trim(), if changed { "+" } else { "" })
}

/// Adds a record to the file, or replaces the one of that figure, and writes the table again.
pub fn record(record: Record) -> Result<(), String> {
    let file = root().join("gallery/records.json");
    let mut records: Map<String, Value> = match read(&file) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", file.display()))?,
        Err(_) => Map::new(),
    };
    records.insert(record.number.to_string(), record.values);
    let text = serde_json::to_string_pretty(&records).map_err(|e| e.to_string())?;
    write(&file, format!("{text}\n").as_bytes())?;
    let page = root().join("docs/gallery.md");
    let old = String::from_utf8(read(&page)?).map_err(|e| format!("{}: {e}", page.display()))?;
    let new = with_table(&old, &table(&records))
        .ok_or_else(|| format!("{}: no table between `{BEGIN}` and `{END}`", page.display()))?;
    write(&page, new.as_bytes())
}

fn table(records: &Map<String, Value>) -> String {
    let mut numbers: Vec<(u32, &Value)> =
        records.iter().filter_map(|(n, record)| Some((n.parse().ok()?, record))).collect();
    numbers.sort_by_key(|(n, _)| *n);
    let mut table =
        String::from("| figure | size | samples | seed | rays | seconds | commit |\n|---|---|---|---|---|---|---|\n");
    for (number, r) in numbers {
        let plain = |key: &str| r[key].as_str().map_or_else(|| r[key].to_string(), str::to_owned);
        let millions = r["rays"].as_f64().unwrap_or(0.0) / 1e6;
        let seconds = r["seconds"].as_f64().unwrap_or(0.0);
        table += &format!(
            "| {number} | {}x{} | {} | {} | {millions:.0} million | {seconds:.0} | `{}` |\n",
            r["width"],
            r["height"],
            r["spp"],
            plain("seed"),
            plain("commit")
        );
    }
    table
}

/// The page with another table.
fn with_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_table_is_replaced() {
        let records = json!({
            "10": { "width": 8, "height": 6, "spp": 4, "seed": "0", "seconds": 1.0, "rays": 2_000_000, "commit": "abc" },
            "2": { "width": 8, "height": 6, "spp": 4, "seed": "7", "seconds": 9.0, "rays": 0, "commit": "def+" },
        });
        let table = table(records.as_object().unwrap());
        let rows: Vec<&str> = table.lines().skip(2).collect();
        assert_eq!(
            rows,
            ["| 2 | 8x6 | 4 | 7 | 0 million | 9 | `def+` |", "| 10 | 8x6 | 4 | 0 | 2 million | 1 | `abc` |"]
        );
        let page = format!("a\n{BEGIN}\nold\n{END}\nb\n");
        let new = with_table(&page, &table).unwrap();
        assert_eq!(new, format!("a\n{BEGIN}\n{table}{END}\nb\n"));
        assert_eq!(with_table(&new, &table).unwrap(), new);
        assert_eq!(with_table("no table", &table), None);
    }

    #[test]
    fn the_page_has_a_place_for_the_table_and_every_figure() {
        let page = fs::read_to_string(root().join("docs/gallery.md")).unwrap();
        assert!(with_table(&page, "").is_some());
        for number in (1..=8).chain([10, 11]) {
            assert!(
                page.contains(&format!("## Figure {number}")) && page.contains(&format!("images/figure-{number}.png"))
            );
        }
    }
}
