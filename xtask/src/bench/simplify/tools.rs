//! Simplifiers that take turns: ours as a program, others as processes that stay warm.

use super::{SIMPLIFIERS, meshoptimizer};
use crate::bench::peers::Conversation;
use serde_json::{Value, json};
use std::{
    cell::RefCell,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    rc::Rc,
};

/// A simplifier, or a way to use one.
pub struct Tool {
    pub name: String,
    kind: Kind,
}

enum Kind {
    Ours {
        program: PathBuf,
        options: Vec<String>,
        model: PathBuf,
    },
    /// Several tools may share a process.
    Theirs(Rc<RefCell<Conversation>>),
}

/// Ours: the default and the fast way; where the paper's claim is measured, its second form, and the first without polish.
pub fn ours(program: &Path, with_union: bool) -> Vec<Tool> {
    let mut tools = vec![Tool::own(program, "Etendue", &[]), Tool::own(program, "Etendue --fast", &["--fast"])];
    if with_union {
        tools.push(Tool::own(program, "Etendue --no-polish", &["--no-polish"]));
        let options = ["--no-polish", "--method", "quadric-union"];
        tools.push(Tool::own(program, "Etendue --no-polish --method quadric-union", &options));
    }
    tools
}

/// Both forms of the quadric with each placement, without polish, so that nothing but the form differs.
pub fn both_forms(program: &Path) -> Vec<Tool> {
    let placements = ["probabilistic", "perturbed", "endpoint"];
    let tool = |placement: &str, method: &str| {
        let options = ["--no-polish", "--placement", placement, "--method", method];
        Tool::own(program, &format!("{method}, {placement}"), &options)
    };
    placements.iter().flat_map(|placement| ["quadric", "quadric-union"].map(|method| tool(placement, method))).collect()
}

/// The others, built and installed if they are not there.
pub fn theirs() -> Result<Vec<Tool>, String> {
    let mut all = fastest()?;
    SIMPLIFIERS.install()?;
    all.extend(of_conversation(SIMPLIFIERS.start()?, &["fast-simplification", "pyfqmr", MESHLAB, "open3d"]));
    Ok(all)
}

/// The fastest of the others, both ways.
pub fn fastest() -> Result<Vec<Tool>, String> {
    let compiled = Conversation::start("meshoptimizer", &mut Command::new(meshoptimizer()?), "")?;
    Ok(of_conversation(compiled, &["meshoptimizer", "meshoptimizer, positions updated"]))
}

/// Tools that share a process.
fn of_conversation(conversation: Conversation, names: &[&str]) -> Vec<Tool> {
    let shared = Rc::new(RefCell::new(conversation));
    let tool = |name: &&str| Tool { name: (*name).to_owned(), kind: Kind::Theirs(shared.clone()) };
    names.iter().map(tool).collect()
}

/// The one that measures too.
const MESHLAB: &str = "pymeshlab";

impl Tool {
    /// Ours with some options.
    pub fn own(program: &Path, name: &str, options: &[&str]) -> Self {
        let options = options.iter().map(|&option| option.to_owned()).collect();
        Self { name: name.to_owned(), kind: Kind::Ours { program: program.to_owned(), options, model: PathBuf::new() } }
    }

    pub fn is_ours(&self) -> bool {
        matches!(self.kind, Kind::Ours { .. })
    }

    pub fn measures(&self) -> bool {
        self.name == MESHLAB
    }

    /// Takes another model.
    pub fn open(&mut self, path: &Path) -> Result<(), String> {
        match &mut self.kind {
            Kind::Ours { model, .. } => {
                *model = path.to_owned();
                Ok(())
            }
            Kind::Theirs(conversation) => conversation.borrow_mut().ask(&json!({ "mesh": path })).map(drop),
        }
    }

    /// Simplifies to so many faces; the seconds that it takes in memory.
    pub fn simplify(&mut self, faces: usize, output: &Path) -> Result<f64, String> {
        let seconds = match &mut self.kind {
            Kind::Ours { program, options, model } => {
                let mut command = Command::new(&*program);
                command.arg("simplify").arg(&*model).arg("--output").arg(output).args(["--quiet", "--json"]);
                command.args(["--faces", &faces.to_string()]).args(&*options);
                let done = command.stderr(Stdio::inherit()).output();
                let done = done.map_err(|e| format!("{}: {e}", program.display()))?;
                let answer: Value = serde_json::from_slice(&done.stdout)
                    .map_err(|_| format!("{} ended with {}", program.display(), done.status))?;
                let seconds = |key: &str| answer["seconds"][key].as_f64();
                seconds("simplify").zip(seconds("polish")).map(|(a, b)| a + b)
            }
            Kind::Theirs(conversation) => {
                let request = json!({ "tool": self.name, "faces": faces, "output": output });
                conversation.borrow_mut().ask(&request)?["seconds"].as_f64()
            }
        };
        seconds.ok_or_else(|| format!("{} tells no time", self.name))
    }

    /// Root mean square and largest distance of two files, as `rms` and `largest`.
    pub fn measure(&mut self, a: &Path, b: &Path, samples: usize) -> Result<Value, String> {
        match &mut self.kind {
            Kind::Theirs(conversation) => {
                conversation.borrow_mut().ask(&json!({ "measure": [a, b], "samples": samples }))
            }
            Kind::Ours { .. } => Err("ours measures by itself".to_owned()),
        }
    }
}
