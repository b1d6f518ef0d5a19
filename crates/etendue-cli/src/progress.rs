//! What is shown on standard error while rendering: a bar on a terminal, else nothing.

use etendue::render::RenderControl;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

/// Shows how far a render is. Dropping it takes the bar away.
pub struct ProgressView {
    bar: ProgressBar,
}

impl ProgressView {
    /// A bar over `total` samples; hidden if `quiet`, and where standard error is no terminal.
    pub fn new(total: u64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(total), target);
        let template = "{percent:>3}% [{wide_bar}] {per_sec} left {eta}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            let rate = |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}samples/s", with_prefix(state.per_sec()));
            };
            bar.set_style(style.with_key("per_sec", rate).progress_chars("=> "));
        }
        Self { bar }
    }

    /// Shows the state of `control`.
    pub fn update(&self, control: &RenderControl) {
        self.bar.set_position(control.progress().done);
    }
}

impl Drop for ProgressView {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Shows how far work in stages is. Dropping it takes the bar away.
pub struct StageView {
    bar: ProgressBar,
}

/// Steps of the bar of one stage.
const STEPS: f32 = 1000.0;

impl StageView {
    /// A bar; hidden if `quiet`, and where standard error is no terminal.
    pub fn new(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(STEPS as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{msg} {percent:>3}% [{wide_bar}]") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar }
    }

    /// Shows that a stage is done so far, from 0 to 1.
    pub fn update(&self, stage: &'static str, done: f32) {
        if self.bar.message() != stage {
            self.bar.set_message(stage);
        }
        self.bar.set_position((done.clamp(0.0, 1.0) * STEPS) as u64);
    }
}

impl Drop for StageView {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// How long the watcher sleeps between looks.
pub const TICK: Duration = Duration::from_millis(50);

/// A number to three digits with a prefix of the SI and the space before the unit: `1.23 M`.
pub fn with_prefix(value: f64) -> String {
    let (scaled, prefix) = match value {
        v if v >= 1e9 => (v * 1e-9, "G"),
        v if v >= 1e6 => (v * 1e-6, "M"),
        v if v >= 1e3 => (v * 1e-3, "k"),
        v => (v, ""),
    };
    let digits = match scaled {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        _ => 2,
    };
    format!("{scaled:.digits$} {prefix}")
}

#[cfg(test)]
mod tests {
    use super::with_prefix;

    #[test]
    fn prefixes() {
        assert_eq!(with_prefix(1_234_567.0), "1.23 M");
        assert_eq!(with_prefix(98_765.0), "98.8 k");
        assert_eq!(with_prefix(999.0), "999 ");
        assert_eq!(with_prefix(0.0), "0.00 ");
        assert_eq!(with_prefix(2.5e11), "250 G");
    }
}
