//! Contenders take turns at the same work, so that what else the machine does hits all of them alike.

use rustix::time::{ClockId, clock_gettime};
use std::ops::Range;
use std::sync::Mutex;
use std::time::Instant;

/// What time is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Clock {
    /// Time that passes.
    Wall,
    /// Time that processors spend, divided by threads: for machines that do other things meanwhile.
    Cpu,
}

/// Rays that a thread takes at once.
const CHUNK: usize = 1 << 14;

/// One way to do the work.
pub struct Contender<'a> {
    pub name: String,
    /// Does it once and gives the seconds.
    pub run: Box<dyn Fn() -> f64 + 'a>,
}

impl<'a> Contender<'a> {
    pub fn new(name: impl Into<String>, run: impl Fn() -> f64 + 'a) -> Self {
        Self { name: name.into(), run: Box::new(run) }
    }
}

/// The seconds of every contender's turns. The first turn is not counted.
pub fn take(contenders: &[Contender<'_>], turns: usize) -> Vec<Vec<f64>> {
    let mut seconds = vec![Vec::with_capacity(turns); contenders.len()];
    for turn in 0..=turns {
        for (contender, seconds) in contenders.iter().zip(&mut seconds) {
            let time = (contender.run)();
            if turn > 0 {
                seconds.push(time);
            }
        }
    }
    seconds
}

/// Seconds in which threads fill a slice chunk by chunk.
pub fn fill<T: Send>(clock: Clock, threads: usize, out: &mut [T], work: impl Fn(Range<usize>, &mut [T]) + Sync) -> f64 {
    let chunks = Mutex::new(out.chunks_mut(CHUNK).enumerate());
    let spent = Mutex::new(0.0);
    let start = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let before = thread_seconds();
                loop {
                    let next = chunks.lock().map(|mut chunks| chunks.next());
                    let Ok(Some((index, chunk))) = next else { break };
                    let first = index * CHUNK;
                    work(first..first + chunk.len(), chunk);
                }
                if let Ok(mut spent) = spent.lock() {
                    *spent += thread_seconds() - before;
                }
            });
        }
    });
    match clock {
        Clock::Wall => start.elapsed().as_secs_f64(),
        Clock::Cpu => spent.into_inner().unwrap_or(f64::NAN) / threads as f64,
    }
}

/// Seconds that a piece of work takes, with all threads that it starts.
pub fn timed<T>(clock: Clock, work: impl FnOnce() -> T) -> (f64, T) {
    let before = (Instant::now(), seconds_of(ClockId::ProcessCPUTime));
    let result = work();
    let seconds = match clock {
        Clock::Wall => before.0.elapsed().as_secs_f64(),
        Clock::Cpu => seconds_of(ClockId::ProcessCPUTime) - before.1,
    };
    (seconds, result)
}

fn thread_seconds() -> f64 {
    seconds_of(ClockId::ThreadCPUTime)
}

fn seconds_of(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
