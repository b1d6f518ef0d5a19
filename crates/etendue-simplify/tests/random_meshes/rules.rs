//! What must hold of every result, whatever went in.

use std::collections::BTreeSet;

use etendue_simplify::{Findings, Mesh, Options, Placement, Simplified, Target, check};

/// A place: its bits, both zeros as one.
type Place = [u32; 3];

fn place(p: [f32; 3]) -> Place {
    p.map(|x| (x + 0.0).to_bits())
}

/// The input, and what is known of it.
pub struct Input {
    pub mesh: Mesh,
    found: Findings,
    /// Places of vertices of faces that are not left out.
    used: BTreeSet<Place>,
    /// Places at open edges of those.
    open: BTreeSet<Place>,
    /// True if no vertex is so far off that the rest is of the size of rounding beside it, where the shape of faces is not seen.
    even: bool,
}

impl Input {
    pub fn new(mesh: Mesh) -> Self {
        let found = check(&mesh.as_ref());
        let corners = |face: &[u32; 3]| face.map(|v| mesh.positions[v as usize]);
        let is_fine = |corners: &[[f32; 3]; 3]| {
            let [a, b, c] = corners.map(place);
            corners.as_flattened().iter().all(|x| x.is_finite()) && a != b && b != c && c != a
        };
        let mut seen = BTreeSet::new();
        let mut edges = std::collections::BTreeMap::<[Place; 2], usize>::new();
        let mut used = BTreeSet::new();
        for corners in mesh.faces.iter().map(corners).filter(is_fine) {
            let [a, b, c] = corners.map(place);
            // The same in the same sense is left out.
            let least = a.min(b).min(c);
            let turned = if a == least {
                [a, b, c]
            } else if b == least {
                [b, c, a]
            } else {
                [c, a, b]
            };
            if !seen.insert(turned) {
                continue;
            }
            used.extend([a, b, c]);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *edges.entry([p.min(q), p.max(q)]).or_default() += 1;
            }
        }
        let open = edges.into_iter().filter(|(_, faces)| *faces == 1).flat_map(|(ends, _)| ends).collect();
        let size = |place: &Place| place.iter().map(|bits| f32::from_bits(*bits).abs()).fold(0.0, f32::max);
        let mut sizes: Vec<f32> = used.iter().map(size).collect();
        sizes.sort_unstable_by(f32::total_cmp);
        let even = sizes.last().is_none_or(|last| last * 1e-6 <= sizes[sizes.len() / 2]);
        Self { mesh, found, used, open, even }
    }

    /// What the target means in faces; `None` if it is an error.
    fn wanted(&self, options: &Options) -> Option<usize> {
        match options.target {
            Target::Faces(faces) => Some(faces),
            Target::Ratio(ratio) => Some((ratio * self.mesh.faces.len() as f64) as usize),
            Target::Error(_) => None,
        }
    }

    /// What is wrong with a result, if anything is.
    pub fn judge(&self, options: &Options, result: &Simplified) -> Result<(), String> {
        self.counts(options, result)?;
        self.topology(options, result)?;
        self.places(options, result)?;
        self.attributes(options, &result.mesh)
    }

    fn counts(&self, options: &Options, result: &Simplified) -> Result<(), String> {
        let Simplified { mesh, report } = result;
        let dropped = report.dropped.degenerate + report.dropped.duplicate + report.dropped.non_finite;
        holds(report.faces_out == mesh.faces.len() && report.vertices_out == mesh.positions.len(), || {
            format!("counts of {report:?}")
        })?;
        // A cut adds two faces.
        holds(report.faces_out + dropped <= report.faces_in + 2 * report.cuts, || format!("faces of {report:?}"))?;
        if let Some(wanted) = self.wanted(options) {
            let says = report.stopped.is_some();
            holds(says == (report.faces_out > wanted), || format!("wanted {wanted}: {report:?}"))?;
        }
        if let (Target::Error(most), Some(distance)) = (options.target, report.distance) {
            let bound = most + distance.diagonal / f64::from(1 << 30);
            holds(distance.largest() <= bound, || format!("{} beyond {most}", distance.largest()))?;
        }
        Ok(())
    }

    fn topology(&self, options: &Options, result: &Simplified) -> Result<(), String> {
        let (before, after, report) = (&self.found, check(&result.mesh.as_ref()), &result.report);
        let bad = [after.bad_indices.count, after.non_finite.count, after.collapsed.count];
        holds(bad == [0; 3], || format!("faces that are none: {bad:?}"))?;
        let odd = |found: &Findings| found.non_manifold_edges.count + found.misoriented_edges.count;
        for (what, now, was) in [
            ("faces without area", after.flat.count, if self.even { before.flat.count } else { usize::MAX }),
            ("faces twice", after.duplicates.count, before.duplicates.count),
            ("non-manifold edges", after.non_manifold_edges.count, before.non_manifold_edges.count),
            ("non-manifold vertices", after.non_manifold_vertices.count, before.non_manifold_vertices.count),
            // Of an edge of three faces that loses one, two may be left that pass it in one direction.
            ("edges of many faces or passed in one direction", odd(&after), odd(before)),
        ] {
            holds(now <= was, || format!("{what}: {now}, were {was}"))?;
        }
        if before.is_watertight() && before.is_manifold() {
            holds(after.is_watertight() && after.is_manifold(), || "no longer watertight".to_owned())?;
        }
        if before.is_manifold() {
            let (now, was) = (after.boundary_loops, before.boundary_loops);
            holds(now == was, || format!("{now} rims, were {was}"))?;
            holds(after.components == before.components, || format!("{} parts", after.components))?;
            let kept = options.keep_topology || report.cuts == 0;
            let (now, was) = (after.euler_number(), before.euler_number());
            holds(now == was || !kept, || format!("Euler number {now}, was {was}"))?;
        }
        Ok(())
    }

    fn places(&self, options: &Options, result: &Simplified) -> Result<(), String> {
        let now: BTreeSet<Place> = result.mesh.positions.iter().copied().map(place).collect();
        for &v in &options.locked {
            let Some(&p) = self.mesh.positions.get(v as usize) else { continue };
            // One that no face uses may have the place of another that one does.
            let stays = self.used.contains(&place(p)) && self.mesh.faces.as_flattened().contains(&v);
            holds(!stays || now.contains(&place(p)), || format!("locked vertex {v} is gone"))?;
        }
        if options.keep_boundary {
            holds(self.open.is_subset(&now), || "an open edge moved".to_owned())?;
        }
        let moves = options.placement != Placement::Endpoint || options.polish && !options.fast;
        if !moves && result.report.cuts == 0 {
            holds(now.is_subset(&self.used), || "an endpoint is none".to_owned())?;
        }
        Ok(())
    }

    fn attributes(&self, options: &Options, mesh: &Mesh) -> Result<(), String> {
        let (from, keep) = (&self.mesh, options.keep);
        let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
        for (what, had, kept, length, wanted) in [
            ("uvs", from.uvs.is_some(), keep.uvs, mesh.uvs.as_ref().map(Vec::len), vertices),
            ("normals", from.normals.is_some(), keep.normals, mesh.normals.as_ref().map(Vec::len), vertices),
            ("colors", from.colors.is_some(), keep.colors, mesh.colors.as_ref().map(Vec::len), vertices),
            ("materials", from.materials.is_some(), keep.materials, mesh.materials.as_ref().map(Vec::len), faces),
        ] {
            holds(length == (had && kept).then_some(wanted), || format!("{length:?} {what}"))?;
        }
        let uvs = mesh.uvs.iter().flatten().flatten();
        let colors = mesh.colors.iter().flatten().flatten();
        let lengths = mesh.normals.iter().flatten().map(|n| n.iter().map(|x| x * x).sum::<f32>());
        holds(uvs.clone().all(|x| x.is_finite()), || "uvs that are none".to_owned())?;
        holds(colors.clone().all(|x| (0.0..=1.0).contains(x)), || "colours out of range".to_owned())?;
        holds(lengths.clone().all(|l| l == 0.0 || (l - 1.0).abs() < 1e-5), || "normals of odd length".to_owned())?;
        let of = |list: &Option<Vec<u32>>| list.iter().flatten().copied().collect::<BTreeSet<u32>>();
        holds(of(&mesh.materials).is_subset(&of(&from.materials)), || "a material of nowhere".to_owned())
    }
}

fn holds(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}
