//! What the manual says of a key.

const MANUAL: &str = include_str!("../../../../docs/scene-format.md");

/// The last column of the key's row in the first table under the section's heading, without marks.
pub fn meaning(section: &str, key: &str) -> Option<String> {
    let heading = |line: &str| line.trim_start_matches('#').trim().replace('`', "").eq_ignore_ascii_case(section);
    let mut lines = MANUAL.lines().skip_while(|line| !(line.starts_with('#') && heading(line))).skip(1);
    let table =
        lines.by_ref().take_while(|line| !line.starts_with('#')).skip_while(|line| !line.starts_with("| key |"));
    let mut rows = table.take_while(|line| line.starts_with('|'));
    let names = columns(rows.next()?);
    let column = names.iter().position(|name| name == "meaning" || name == "what")?;
    let row = rows.find(|row| columns(row).first().is_some_and(|name| name.trim_matches('`') == key))?;
    let words = columns(row).get(column)?.replace('`', "");
    (!words.is_empty()).then_some(words)
}

/// The cells of a row; a bar in a cell is written `\|`.
fn columns(row: &str) -> Vec<String> {
    let row = row.trim().trim_matches('|').replace("\\|", "\u{0}");
    row.split('|').map(|cell| cell.trim().replace('\u{0}', "|")).collect()
}
