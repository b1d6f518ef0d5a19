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
    /// Watches SIGINT, SIGTERM and SIGHUP from now on. If one of them was ignored when the program started (`nohup`, jobs in
    /// the background of a script), all keep the meaning they had.
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
        // Without a handler a signal ends the program at once, and what was refreshed last stays.
        let _ = ctrlc::try_set_handler(handler);
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
