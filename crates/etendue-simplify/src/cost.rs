//! What collapsing an edge costs, and where its vertex goes: one formula for one edge and for lanes of them.

use etendue_accel::{Isa, Kernel, run};

use crate::quadric::Quadric;
use crate::vector::{Vec3, add, dot, scale};

/// Where the vertex of a collapsed edge may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Rule {
    /// Where it costs least.
    Anywhere,
    /// The first end.
    First,
    /// The second end.
    Second,
    /// The end that costs less.
    Ends,
    /// The middle.
    Middle,
}

/// What an edge costs for its length: little, over its square and its weight. Measured: more is seen beside what is bent little, less is
/// not seen beside rounding.
const TIE: f32 = 1e-8;

#[inline(always)]
fn select(condition: bool, yes: Vec3, no: Vec3) -> Vec3 {
    [
        if condition { yes[0] } else { no[0] },
        if condition { yes[1] } else { no[1] },
        if condition { yes[2] } else { no[2] },
    ]
}

/// Place relative to the first end, and rank by cost, of an edge whose second end is at `d` from the first. No branches, for lanes.
#[inline(always)]
pub(crate) fn place(first: &Quadric, second: &Quadric, d: Vec3, rule: u32, by_mean: bool) -> (Vec3, f32) {
    let sum = second.moved([-d[0], -d[1], -d[2]]).plus(first);
    let middle = scale(d, 0.5);
    let (away, good) = sum.minimum_near(middle);
    // A minimum that is far from the edge is one of planes that are almost parallel.
    let near = dot(away, away) <= 4.0 * dot(d, d);
    let least = select(good & near, add(middle, away), middle);
    let (at_first, at_second, at_middle, at_least) = (sum.c, sum.at(d), sum.at(middle), sum.at(least));
    let end = at_second < at_first;
    let ends = select(end, d, [0.0; 3]);
    let ends_cost = if end { at_second } else { at_first };
    let mut x = select(rule == Rule::First as u32, [0.0; 3], d);
    let mut cost = if rule == Rule::First as u32 { at_first } else { at_second };
    x = select(rule == Rule::Ends as u32, ends, x);
    cost = if rule == Rule::Ends as u32 { ends_cost } else { cost };
    x = select(rule == Rule::Middle as u32, middle, x);
    cost = if rule == Rule::Middle as u32 { at_middle } else { cost };
    x = select(rule == Rule::Anywhere as u32, least, x);
    cost = if rule == Rule::Anywhere as u32 { at_least } else { cost };
    // Where nothing bends, short edges go first.
    let cost = if cost > 0.0 { cost } else { 0.0 };
    let cost = cost + TIE * sum.w * dot(d, d);
    // By the square root of the area that is answered for: without, what is thin and small may go far off at little cost; all of it
    // would be the mean distance, whose sum is larger.
    let weight = if by_mean { sum.w } else { sum.w.sqrt() };
    (x, if weight > 0.0 { cost / weight } else { cost })
}

/// How many edges go at once.
pub(crate) const LANES: usize = 16;

type Lane = [f32; LANES];

#[derive(Clone, Copy, Default)]
struct Quadrics {
    a: [Lane; 6],
    b: [Lane; 3],
    c: Lane,
    w: Lane,
}

impl Quadrics {
    #[inline(always)]
    fn set(&mut self, lane: usize, quadric: &Quadric) {
        for i in 0..6 {
            self.a[i][lane] = quadric.a[i];
        }
        for i in 0..3 {
            self.b[i][lane] = quadric.b[i];
        }
        self.c[lane] = quadric.c;
        self.w[lane] = quadric.w;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Quadric {
        Quadric {
            a: [self.a[0][lane], self.a[1][lane], self.a[2][lane], self.a[3][lane], self.a[4][lane], self.a[5][lane]],
            b: [self.b[0][lane], self.b[1][lane], self.b[2][lane]],
            c: self.c[lane],
            w: self.w[lane],
        }
    }
}

/// Edges whose costs are wanted.
#[derive(Clone, Copy, Default)]
pub(crate) struct Batch {
    first: Quadrics,
    second: Quadrics,
    d: [Lane; 3],
    rule: [u32; LANES],
    costs: Lane,
}

impl Batch {
    /// Sets an edge.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, first: &Quadric, second: &Quadric, d: Vec3, rule: Rule) {
        self.first.set(lane, first);
        self.second.set(lane, second);
        for (to, from) in self.d.iter_mut().zip(d) {
            to[lane] = from;
        }
        self.rule[lane] = rule as u32;
    }

    /// The costs of all edges; those never set have some cost.
    pub fn costs(&mut self, isa: Isa, by_mean: bool) -> &Lane {
        run(isa, Costs(self, by_mean));
        &self.costs
    }
}

struct Costs<'a>(&'a mut Batch, bool);

impl Kernel for Costs<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // On the stack, where the compiler knows that stores do not change what is still to be read.
        let batch = *self.0;
        let mut costs = [0.0; LANES];
        for (lane, cost) in costs.iter_mut().enumerate() {
            let d = [batch.d[0][lane], batch.d[1][lane], batch.d[2][lane]];
            *cost = place(&batch.first.get(lane), &batch.second.get(lane), d, batch.rule[lane], self.1).1;
        }
        self.0.costs = costs;
    }
}
