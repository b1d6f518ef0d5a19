//! Ctrl-C and its like: the first asks the work to stop, the second stops the program.

use crate::{exit::Exit, report};
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
    working: Arc<AtomicBool>,
}

impl Signals {
    /// Watches SIGINT, SIGTERM and SIGHUP from now on; the last not under `nohup`, so that a render outlives its terminal.
    /// Without a handler a signal ends the program at once, and what was refreshed last stays. The first signal at work calls
    /// `stop`, and says `message`.
    pub fn install(stop: impl Fn() + Send + 'static, message: &'static str) -> Self {
        let signals = Self::default();
        let Self { received, working } = signals.clone();
        let handler = move || {
            let first = received.fetch_add(1, Ordering::SeqCst) == 0;
            if first && working.load(Ordering::SeqCst) {
                stop();
                report::say(message);
            } else {
                process::exit(Exit::Interrupted as i32);
            }
        };
        watch(handler);
        signals
    }

    /// From here on there is something worth ending in order: the first signal stops the work, not the program.
    pub fn start_work(&self) {
        self.working.store(true, Ordering::SeqCst);
    }

    /// True once a signal came.
    pub fn interrupted(&self) -> bool {
        self.received.load(Ordering::SeqCst) > 0
    }
}

/// Calls `handler` for each signal. Where the system refuses, signals end the program at once.
#[cfg(unix)]
fn watch(handler: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let hangup = (!hangup_is_ignored()).then_some(SIGHUP);
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup)) {
        std::thread::spawn(move || signals.forever().for_each(|_| handler()));
    }
}

/// Calls `handler` for each Ctrl-C.
#[cfg(not(unix))]
fn watch(handler: impl FnMut() + Send + 'static) {
    let _ = ctrlc::set_handler(handler);
}

/// Whether the program was started with SIGHUP ignored, where the system tells (Linux).
#[cfg(unix)]
fn hangup_is_ignored() -> bool {
    const SIGHUP: u64 = 1;
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|status| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    ignored.is_some_and(|mask| mask & SIGHUP != 0)
}
