//! What is told after a render: one JSON object for programs, a table for people.

use crate::progress::with_prefix;
use etendue::scene::SceneStats;
use serde::Serialize;

/// Wall-clock time of each part, seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading files.
    pub load: f64,
    /// Building the scene and the accelerator.
    pub build: f64,
    /// Rendering, refreshes of files included.
    pub render: f64,
    /// Developing and writing at the end.
    pub write: f64,
}

/// The object that `--json` prints.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Files written.
    pub outputs: Vec<String>,
    /// Files of labels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<String>,
    /// Pixels across what was rendered.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel that were taken, on average over the pixels: below what was asked for after an interruption.
    pub spp: f64,
    /// Fewest samples of any pixel.
    pub spp_min: u32,
    /// Most samples of any pixel.
    pub spp_max: u32,
    /// Times.
    pub seconds: Seconds,
    /// Rays traced.
    pub rays: u64,
    /// Camera paths started.
    pub paths: u64,
    /// Samples left out because they were not finite.
    pub nonfinite: u64,
    /// Whether a signal ended the render before its time.
    pub interrupted: bool,
    /// Hash of the developed linear channels.
    pub film_hash: String,
}

impl Summary {
    /// One line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The table of `--stats`.
    pub fn table(&self, scene: &SceneStats, accelerator: &str, isa: &str, threads: usize) -> String {
        let seconds = self.seconds;
        let rate = |count: u64| with_prefix(count as f64 / seconds.render.max(1e-9));
        let rows = [
            ("triangles", scene.triangles.to_string()),
            ("spheres", scene.spheres.to_string()),
            ("objects", scene.objects.to_string()),
            ("lights", scene.lights.to_string()),
            ("materials", scene.materials.to_string()),
            ("accelerator", format!("{accelerator}, {isa}")),
            ("nodes", format!("{}, {}B", scene.accelerator_nodes, with_prefix(scene.accelerator_bytes as f64))),
            ("threads", threads.to_string()),
            ("load", format!("{:.3} s", seconds.load)),
            ("build", format!("{:.3} s", seconds.build)),
            ("render", format!("{:.3} s", seconds.render)),
            ("write", format!("{:.3} s", seconds.write)),
            ("paths", format!("{}, {}/s", self.paths, rate(self.paths))),
            ("rays", format!("{}, {}/s", self.rays, rate(self.rays))),
            ("rays per path", format!("{:.2}", self.rays as f64 / self.paths.max(1) as f64)),
            ("not finite", self.nonfinite.to_string()),
        ];
        rows.map(|(name, value)| format!("{name:14} {value}")).join("\n")
    }
}
