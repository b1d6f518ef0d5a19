//! Progress of a film on standard error: a bar on a terminal, else nothing.

use etendue::render::RenderControl;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicU64, Ordering};

/// Shows how far a film is. Dropping it takes the bar away.
pub struct FilmView {
    bar: ProgressBar,
    frames: u64,
    samples: u64,
    done: AtomicU64,
}

impl FilmView {
    /// A bar over frames of so many samples each; hidden if `quiet`, and where standard error is no terminal.
    pub fn new(frames: u64, samples: u64, quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(8) };
        let bar = ProgressBar::with_draw_target(Some(frames.saturating_mul(samples)), target);
        if let Ok(style) = ProgressStyle::with_template("{msg} {percent:>3}% [{wide_bar}] left {eta}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, frames, samples, done: AtomicU64::new(0) }
    }

    /// Shows the state of the frame in work, which is number `frame`.
    pub fn update(&self, frame: u32, control: &RenderControl) {
        let done = self.done.load(Ordering::Relaxed);
        self.bar.set_message(format!("frame {frame}, {} of {}", done + 1, self.frames));
        self.bar.set_position(done.saturating_mul(self.samples).saturating_add(control.progress().done));
    }

    /// Shows what is done at the end.
    pub fn say(&self, message: &'static str) {
        self.bar.set_message(message);
    }

    /// One frame more is done.
    pub fn finish_frame(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.bar.set_position(done.saturating_mul(self.samples));
    }
}

impl Drop for FilmView {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
