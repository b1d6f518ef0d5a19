//! Ctrl-C and its like: the first asks the render to stop, the second stops the program.

use crate::{exit::Exit, report};
use etendue::render::RenderControl;
use std::{
    process,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering},
    },
};

/// What has been received since [`Signals::install`].
#[derive(Clone, Debug, Default)]
pub struct Signals {
    received: Arc<AtomicU32>,
    rendering: Arc<AtomicBool>,
}

impl Signals {
    /// Watches SIGINT, SIGTERM and SIGHUP from now on; under `nohup` they keep the meaning they had, so that a render outlives
    /// its terminal. Without a handler a signal ends the program at once, and what was refreshed last stays.
    pub fn install(control: Arc<RenderControl>) -> Self {
        let signals = Self::default();
        let Self { received, rendering } = signals.clone();
        let handler = move || {
            let first = received.fetch_add(1, Ordering::SeqCst) == 0;
            if first && rendering.load(Ordering::SeqCst) {
                control.cancel();
                report::say("stopping after the tiles in work; once more to stop at once");
            } else {
                process::exit(Exit::Interrupted as i32);
            }
        };
        if !hangup_is_ignored() {
            let _ = ctrlc::set_handler(handler);
        }
        signals
    }

    /// From here on there is something worth keeping: the first signal stops the render, not the program.
    pub fn start_rendering(&self) {
        self.rendering.store(true, Ordering::SeqCst);
    }

    /// True once a signal came.
    pub fn interrupted(&self) -> bool {
        self.received.load(Ordering::SeqCst) > 0
    }
}

/// Whether the program was started with SIGHUP ignored, where the system tells (Linux).
fn hangup_is_ignored() -> bool {
    const SIGHUP: u64 = 1;
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|status| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    ignored.is_some_and(|mask| mask & SIGHUP != 0)
}
