//! A piece of the surface whose edges are collapsed one after another, cheapest first.

use etendue_accel::prefetch;

use crate::cost::{Batch, LANES, Rule, place};
use crate::faces::{Faces, GONE};
use crate::metric::Metric;
use crate::quadric::Quadric;
use crate::queue::{Entry, Queue};
use crate::report::Stopped;
use crate::rings::Rings;
use crate::vector::{Vec3, add, dot, sub};
use crate::vertex::{Kind, Vertex};
use crate::wedges::{Wedge, edge_quadric, merge};
use crate::{Method, SimplifyError};

/// Vertices with more faces wait until they have fewer: what a collapse costs in time grows with them.
const MOST_FACES: usize = 512;
/// Edges that were refused are asked again when this part of the faces is gone.
const AGAIN: usize = 6;

/// Edges that are fetched ahead: the next, and two more levels of the heap.
const SOON: usize = 7;
/// By so many vertices faces are fetched ahead where all vertices are passed.
const AHEAD: usize = 4;

/// The source of a vertex that has moved from where all vertices of the input are.
pub(crate) const MOVED: u32 = u32::MAX;

/// Why an edge is not collapsed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    Flip,
    Topology,
    /// Two sheets would become one at an edge to this vertex, which is next to both ends.
    Joins(u32),
    Fixed,
    Border,
}

/// A face that stays at a collapse: its corners other than the end of the edge, and the end.
#[derive(Clone, Copy)]
pub(crate) struct Kept {
    pub next: u32,
    pub last: u32,
    pub face: u32,
}

/// Where the vertex of an edge goes.
struct Goal {
    /// Relative to the first end, before rounding.
    place: Vec3,
    position: Vec3,
}

/// A piece of the surface: consecutive vertices, and the faces among them.
pub(crate) struct Block<'a> {
    pub(super) metric: &'a Metric,
    pub(super) vertices: &'a mut [Vertex],
    /// Per vertex, the sum of the normals of the original's faces at all that was merged into it, as long as their areas.
    pub(super) facing: &'a mut [Vec3],
    /// Per vertex, that of the input whose place it has; [`MOVED`] if it has another.
    pub(super) sources: &'a mut [u32],
    pub(super) wedges: &'a mut [Wedge],
    pub(super) faces: Faces,
    /// Where in `rings` the faces of each vertex are, and how many.
    pub(super) spans: Vec<[u32; 2]>,
    /// Faces of vertices; some are gone already.
    pub(super) rings: Vec<u32>,
    queue: Queue,
    pub(super) marks: Vec<u32>,
    epoch: u32,
    batch: Box<Batch>,
    pub(super) kept: [Vec<Kept>; 2],
    pub(super) shared: Vec<[u32; 2]>,
    pub(super) around: Vec<u32>,
    /// Wedges that become one, of the first end and of the second.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Vertices that were merged into others: places for new ones.
    pub(super) graves: Vec<u32>,
    /// Edges that were refused: asked again when their surroundings may have changed.
    parked: Vec<Entry>,
    pub live: usize,
    pub collapses: usize,
    pub refused: usize,
    pub cuts: usize,
    /// The largest quadric of a vertex over its weight: a squared distance.
    pub worst: f32,
}

/// What a block is made of: consecutive vertices with their wedges, and the faces among them.
pub(crate) struct Piece<'a> {
    pub vertices: &'a mut [Vertex],
    pub facing: &'a mut [Vec3],
    pub sources: &'a mut [u32],
    pub wedges: &'a mut [Wedge],
    pub faces: Faces,
}

/// Which place of an edge is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
enum Attempt {
    /// What the rule says.
    Best,
    /// The end that costs less.
    End,
    /// The other.
    OtherEnd,
}

impl Attempt {
    fn of(entry: Entry) -> Self {
        match entry.stamp() & 3 {
            0 => Self::Best,
            1 => Self::End,
            _ => Self::OtherEnd,
        }
    }
}

impl<'a> Block<'a> {
    pub fn new(metric: &'a Metric, piece: Piece<'a>) -> Self {
        let Piece { vertices, facing, sources, wedges, faces } = piece;
        let (starts, rings) = Rings::new(vertices.len(), &faces.corners).into_parts();
        let spans = starts.windows(2).map(|pair| [pair[0], pair[1] - pair[0]]).collect();
        let live = faces.corners.len();
        let marks = vec![0; vertices.len()];
        let mut block = Self {
            metric,
            vertices,
            facing,
            sources,
            wedges,
            faces,
            spans,
            rings,
            queue: Queue::default(),
            marks,
            epoch: 0,
            batch: Box::default(),
            kept: Default::default(),
            shared: Vec::new(),
            around: Vec::new(),
            pairs: Vec::new(),
            graves: Vec::new(),
            parked: Vec::new(),
            live,
            collapses: 0,
            refused: 0,
            cuts: 0,
            worst: 0.0,
        };
        block.queue = Queue::new(&block.all_edges());
        block
    }

    /// How many faces have no corner that is held.
    pub fn free_faces(&self) -> usize {
        let held = |&v: &u32| self.vertices[v as usize].held;
        self.faces.corners.iter().filter(|&&face| face != GONE && !face.iter().any(held)).count()
    }

    /// Faces that are left, and what belongs to them.
    pub fn into_faces(mut self) -> Faces {
        self.faces.clean();
        self.faces
    }

    /// Collapses until `floor` faces are left or what is left is in no bucket of costs below `limit`. `tick` is called now and then.
    pub fn run(
        &mut self,
        limit: usize,
        floor: usize,
        mut tick: impl FnMut(usize) -> Result<(), SimplifyError>,
    ) -> Result<(), SimplifyError> {
        if self.live <= floor {
            return Ok(());
        }
        let vertices = &*self.vertices;
        self.queue.raise(limit, |entry| current(vertices, entry));
        let mut turns = 0usize;
        let mut again = self.live - self.live / AGAIN;
        while self.live > floor {
            if self.live < again {
                again = self.live - self.live / AGAIN;
                for entry in std::mem::take(&mut self.parked) {
                    self.queue.push(entry);
                }
            }
            turns += 1;
            if turns.is_multiple_of(4096) {
                tick(self.live)?;
            }
            let Some(entry) = self.queue.pop() else { break };
            self.fetch_ahead();
            if !current(self.vertices, entry) {
                continue;
            }
            let [a, b] = entry.ends();
            match self.plan(a, b, Attempt::of(entry)) {
                Ok(goal) => self.collapse(a, b, goal),
                Err(Refusal::Joins(c)) if self.cut([a, b, c]) => {}
                Err(refusal) => {
                    self.refused += 1;
                    self.retry(entry, refusal);
                }
            }
        }
        Ok(())
    }

    /// Asks memory for what the next edges are judged by, one step of each chain of indices at a time: while one edge is worked on,
    /// what the next ones need is on its way.
    #[inline(always)]
    fn fetch_ahead(&self) {
        for (i, entry) in self.queue.soon().iter().take(SOON).enumerate() {
            for v in entry.0.ends() {
                match i {
                    0 => self.ring(v).iter().for_each(|&face| prefetch(&self.faces.corners[face as usize])),
                    1 | 2 => self.ring(v).iter().take(1).for_each(prefetch),
                    _ => {
                        prefetch(&self.spans[v as usize]);
                        prefetch(&self.vertices[v as usize]);
                    }
                }
            }
        }
    }

    /// Adds how many edges wait in each bucket of costs, for choosing a limit.
    pub fn count(&self, counts: &mut [usize]) {
        self.queue.count(counts);
    }

    /// Why the edges that are left stay.
    pub fn reasons(&mut self) -> Stopped {
        let mut stopped = Stopped::default();
        for a in 0..self.vertices.len() as u32 {
            if self.vertices[a as usize].dead {
                continue;
            }
            self.neighbours(a);
            let around = std::mem::take(&mut self.around);
            for &b in around.iter().filter(|&&b| b > a) {
                let rule = self.metric.rule(&self.vertices[a as usize], &self.vertices[b as usize]);
                let mut refusal = self.plan(a, b, Attempt::Best).err();
                for attempt in [Attempt::End, Attempt::OtherEnd] {
                    if refusal == Some(Refusal::Flip) && rule == Some(Rule::Anywhere) {
                        refusal = self.plan(a, b, attempt).err();
                    }
                }
                match refusal {
                    Some(Refusal::Flip) => stopped.flips += 1,
                    Some(Refusal::Topology | Refusal::Joins(_)) => stopped.topology += 1,
                    Some(Refusal::Fixed) => stopped.fixed += 1,
                    Some(Refusal::Border) => stopped.borders += 1,
                    None => {}
                }
            }
            self.around = around;
        }
        stopped
    }

    /// An edge whose best place turns a face over may go to one of its ends instead, when that is its turn.
    fn retry(&mut self, entry: Entry, refusal: Refusal) {
        let attempt = match Attempt::of(entry) {
            Attempt::Best => Attempt::End,
            Attempt::End => Attempt::OtherEnd,
            Attempt::OtherEnd => {
                self.parked.push(Entry::new(entry.cost(), entry.ends(), entry.stamp() & !3));
                return;
            }
        };
        let [a, b] = entry.ends();
        let (first, second) = (&self.vertices[a as usize], &self.vertices[b as usize]);
        if refusal != Refusal::Flip || self.metric.rule(first, second) != Some(Rule::Anywhere) {
            self.parked.push(entry);
            return;
        }
        let (_, cost) = self.end(a, b, attempt);
        self.queue.push(Entry::new(cost.max(entry.cost()), [a, b], entry.stamp() & !3 | attempt as u32));
    }

    /// The place and the cost of one of an edge's ends.
    fn end(&self, a: u32, b: u32, attempt: Attempt) -> (Vec3, f32) {
        let (first, second) = self.edge_quadrics(a, b);
        let d = sub(self.vertices[b as usize].position, self.vertices[a as usize].position);
        let [x, y] =
            [Rule::First, Rule::Second].map(|rule| place(&first, &second, d, rule as u32, self.metric.by_mean));
        if (y.1 < x.1) == (attempt == Attempt::End) { y } else { x }
    }

    /// Edges of all vertices with their costs.
    fn all_edges(&mut self) -> Vec<Entry> {
        let mut entries = Vec::with_capacity(self.live * 3 / 2 + 16);
        let mut pending = [[0; 2]; LANES];
        let mut count = 0;
        for a in 0..self.vertices.len() as u32 {
            let vertex = &self.vertices[a as usize];
            if vertex.dead || vertex.held {
                continue;
            }
            if let Some(&[start, len]) = self.spans.get(a as usize + AHEAD) {
                let soon = &self.rings[start as usize..(start + len) as usize];
                soon.iter().for_each(|&face| prefetch(&self.faces.corners[face as usize]));
            }
            self.neighbours(a);
            for i in 0..self.around.len() {
                let b = self.around[i];
                if b < a {
                    continue;
                }
                if self.set_lane(count, a, b) {
                    pending[count] = [a, b];
                    count += 1;
                    if count == LANES {
                        self.flush(&pending, |entry| entries.push(entry));
                        count = 0;
                    }
                }
            }
        }
        self.flush(&pending[..count], |entry| entries.push(entry));
        entries
    }

    fn flush(&mut self, pending: &[[u32; 2]], mut push: impl FnMut(Entry)) {
        if pending.is_empty() {
            return;
        }
        let costs = *self.batch.costs(self.metric.isa, self.metric.by_mean);
        for (&ends, cost) in pending.iter().zip(costs) {
            push(Entry::new(cost, ends, stamp(self.vertices, ends)));
        }
    }

    /// Puts an edge into the batch; false if it stays anyway.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, a: u32, b: u32) -> bool {
        let (first, second) = (&self.vertices[a as usize], &self.vertices[b as usize]);
        if second.held {
            return false;
        }
        let Some(rule) = self.metric.rule(first, second) else { return false };
        let d = sub(second.position, first.position);
        if self.metric.method == Method::Quadric && self.wedges.is_empty() {
            self.batch.set(lane, &first.quadric, &second.quadric, d, rule);
        } else {
            let (first, second) = self.edge_quadrics(a, b);
            self.batch.set(lane, &first, &second, d, rule);
        }
        true
    }

    /// What the ends of an edge weigh, each relative to itself.
    #[inline(always)]
    fn edge_quadrics(&self, a: u32, b: u32) -> (Quadric, Quadric) {
        let (first, second) = (&self.vertices[a as usize], &self.vertices[b as usize]);
        let d = sub(second.position, first.position);
        match self.metric.method {
            Method::Quadric if self.wedges.is_empty() => (first.quadric, second.quadric),
            Method::Quadric => {
                let pairs = self.pairs_of(a, b);
                (edge_quadric(&first.quadric, &second.quadric, d, self.wedges, &pairs), Quadric::default())
            }
            Method::ShortestEdge => (Quadric { c: dot(d, d), ..Quadric::default() }, Quadric::default()),
            Method::QuadricUnion => (self.union(a, b), Quadric::default()),
        }
    }

    /// The wedges at an edge that its collapse makes one.
    pub(super) fn pairs_of(&self, a: u32, b: u32) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        let Some(wedges) = &self.faces.wedges else { return pairs };
        for &face in self.ring(a) {
            let corners = self.faces.corners[face as usize];
            if let Some(j) = corners.iter().position(|&v| v == b) {
                let i = corners.iter().position(|&v| v == a).unwrap_or(0);
                let pair = [wedges[face as usize][i], wedges[face as usize][j]];
                if !pairs.contains(&pair) {
                    pairs.push(pair);
                }
            }
        }
        pairs
    }

    /// The wedge of a face at one of its corners; 0 without wedges.
    #[inline(always)]
    pub(super) fn wedge(&self, face: u32, v: u32) -> u32 {
        let Some(wedges) = &self.faces.wedges else { return 0 };
        let corner = self.faces.corners[face as usize].iter().position(|&corner| corner == v).unwrap_or(0);
        wedges[face as usize][corner]
    }

    /// The faces at either end, each counted once, relative to the first end.
    fn union(&self, a: u32, b: u32) -> Quadric {
        let origin = self.vertices[a as usize].position;
        let mut sum = Quadric::default();
        for (v, other) in [(a, u32::MAX), (b, a)] {
            for &face in self.ring(v) {
                let corners = self.faces.corners[face as usize];
                if corners != GONE && !corners.contains(&other) {
                    let positions = corners.map(|v| self.vertices[v as usize].position);
                    sum = sum.plus(&self.metric.triangle(corners, positions, origin));
                }
            }
        }
        sum
    }

    #[inline(always)]
    pub(super) fn ring(&self, v: u32) -> &[u32] {
        let [start, len] = self.spans[v as usize];
        &self.rings[start as usize..(start + len) as usize]
    }

    pub(super) fn next_epoch(&mut self) -> u32 {
        if self.epoch > u32::MAX - 4 {
            self.marks.fill(0);
            self.epoch = 0;
        }
        self.epoch += 2;
        self.epoch
    }

    /// Sets `around` to the neighbours of `v`.
    pub(super) fn neighbours(&mut self, v: u32) {
        let epoch = self.next_epoch();
        self.around.clear();
        let [start, len] = self.spans[v as usize];
        for &face in &self.rings[start as usize..(start + len) as usize] {
            let corners = self.faces.corners[face as usize];
            if corners == GONE {
                continue;
            }
            for n in corners {
                let mark = &mut self.marks[n as usize];
                if n != v && *mark != epoch {
                    *mark = epoch;
                    self.around.push(n);
                }
            }
        }
    }

    /// Whether the edge may be collapsed, and where its vertex goes: to its best place, or to an end.
    fn plan(&mut self, a: u32, b: u32, attempt: Attempt) -> Result<Goal, Refusal> {
        let rule = self.metric.rule(&self.vertices[a as usize], &self.vertices[b as usize]).ok_or(Refusal::Fixed)?;
        if self.ring(a).len() + self.ring(b).len() > MOST_FACES {
            return Err(Refusal::Topology);
        }
        self.check_topology(a, b)?;
        self.check_wedges(a, b)?;
        let [origin, end] = [a, b].map(|v| self.vertices[v as usize].position);
        let d = sub(end, origin);
        let (place, _) = if attempt == Attempt::Best {
            let (first, second) = self.edge_quadrics(a, b);
            place(&first, &second, d, rule as u32, self.metric.by_mean)
        } else {
            self.end(a, b, attempt)
        };
        // An end is met exactly, which the sum of differences need not do.
        let position = if place == d { end } else { add(origin, place) };
        if self.turns_none(a, b, position) { Ok(Goal { place, position }) } else { Err(Refusal::Flip) }
    }

    /// Merges the ends of an edge.
    fn collapse(&mut self, a: u32, b: u32, Goal { place, position }: Goal) {
        // The one that stays where it is stays.
        let (a, b, place, [kept_first, kept_second]) =
            if self.vertices[b as usize].kind > self.vertices[a as usize].kind {
                let d = sub(self.vertices[b as usize].position, self.vertices[a as usize].position);
                (b, a, sub(place, d), [1, 0])
            } else {
                (a, b, place, [0, 1])
            };
        let (first, second) = (self.vertices[a as usize], self.vertices[b as usize]);
        let d = sub(second.position, first.position);
        if kept_first == 1 {
            self.pairs.iter_mut().for_each(|pair| pair.swap(0, 1));
        }
        let keeps = first.kind > second.kind;
        let mut merged = merge(&first.quadric, &second.quadric, d, place, keeps, self.wedges, &self.pairs);
        merged.c = merged.c.max(0.0);
        let vertex = &mut self.vertices[a as usize];
        vertex.quadric = merged;
        if first.kind != Kind::Fixed {
            vertex.position = position;
            if position != first.position {
                self.sources[a as usize] = if position == second.position { self.sources[b as usize] } else { MOVED };
            }
        }
        vertex.stamp = first.stamp.wrapping_add(second.stamp).wrapping_add(1);
        self.facing[a as usize] = add(self.facing[a as usize], self.facing[b as usize]);
        let gone = &mut self.vertices[b as usize];
        gone.dead = true;
        for &[face, _] in &self.shared {
            self.faces.corners[face as usize] = GONE;
        }
        self.live -= self.shared.len();
        for kept in &self.kept[kept_second] {
            let corners = &mut self.faces.corners[kept.face as usize];
            let corner = corners.iter().position(|&v| v == b).unwrap_or(0);
            corners[corner] = a;
            if let Some(wedges) = &mut self.faces.wedges {
                let wedge = &mut wedges[kept.face as usize][corner];
                if let Some(pair) = self.pairs.iter().find(|pair| pair[1] == *wedge) {
                    *wedge = pair[0];
                }
            }
        }
        self.graves.push(b);
        let mut ring = std::mem::take(&mut self.around);
        ring.clear();
        ring.extend(self.kept[kept_first].iter().chain(&self.kept[kept_second]).map(|kept| kept.face));
        self.set_ring(a, &ring);
        self.around = ring;
        self.collapses += 1;
        if merged.w > 0.0 {
            self.worst = self.worst.max(merged.c / merged.w);
        }
        self.requeue(a);
    }

    /// Replaces the faces at a vertex.
    pub(super) fn set_ring(&mut self, v: u32, ring: &[u32]) {
        let span = &mut self.spans[v as usize];
        if ring.len() > span[1] as usize {
            span[0] = self.rings.len() as u32;
            self.rings.resize(self.rings.len() + ring.len(), 0);
        }
        span[1] = ring.len() as u32;
        self.rings[span[0] as usize..][..ring.len()].copy_from_slice(ring);
    }

    /// Puts the edges of a changed vertex into the queue.
    pub(super) fn requeue(&mut self, a: u32) {
        self.neighbours(a);
        let mut pending = [[0; 2]; LANES];
        let mut count = 0;
        for i in 0..self.around.len() {
            let b = self.around[i];
            if self.set_lane(count, a, b) {
                pending[count] = [a, b];
                count += 1;
            }
            if count == LANES || (count > 0 && i + 1 == self.around.len()) {
                let costs = *self.batch.costs(self.metric.isa, self.metric.by_mean);
                for (&ends, cost) in pending[..count].iter().zip(costs) {
                    self.queue.push(Entry::new(cost, ends, stamp(self.vertices, ends)));
                }
                count = 0;
            }
        }
    }
}

/// The state of an edge's ends; the two lowest bits are free.
#[inline(always)]
fn stamp(vertices: &[Vertex], ends: [u32; 2]) -> u32 {
    let [a, b] = ends.map(|v| vertices[v as usize].stamp);
    a.wrapping_add(b) << 2
}

/// True if both ends are as they were when the entry was made.
#[inline(always)]
fn current(vertices: &[Vertex], entry: Entry) -> bool {
    let ends = entry.ends();
    let dead = ends.iter().any(|&v| vertices[v as usize].dead);
    !dead && stamp(vertices, ends) == entry.stamp() & !3
}
