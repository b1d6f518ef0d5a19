//! Values over time.

use etendue::{math::DVec3, spectrum::Spectrum};

/// What is between keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// Straight lines.
    #[default]
    Linear,
    /// Smooth curves. Points go as parabolas go; numbers and colours stay between their keys (Steffen, "A simple method for monotonic
    /// interpolation in one dimension", 1990).
    Cubic,
    /// The last key's value until the next one's time.
    Step,
}

impl Blend {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Cubic, Self::Step];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
            Self::Step => "step",
        }
    }
}

/// What a curve can be made of.
pub trait Value: Copy {
    /// True if nothing between keys may lie outside of them.
    const BOUNDED: bool;
    /// Its numbers; those that it has not are 0.
    fn components(self) -> [f64; 3];
    /// From its numbers.
    fn from_components(components: [f64; 3]) -> Self;
}

impl Value for f64 {
    const BOUNDED: bool = true;
    fn components(self) -> [f64; 3] {
        [self, 0.0, 0.0]
    }
    fn from_components([x, _, _]: [f64; 3]) -> Self {
        x
    }
}

impl Value for Spectrum {
    const BOUNDED: bool = true;
    fn components(self) -> [f64; 3] {
        self.0.map(f64::from)
    }
    fn from_components(components: [f64; 3]) -> Self {
        Self(components.map(|x| x as f32))
    }
}

impl Value for DVec3 {
    const BOUNDED: bool = false;
    fn components(self) -> [f64; 3] {
        self.to_array()
    }
    fn from_components(components: [f64; 3]) -> Self {
        Self::from_array(components)
    }
}

/// Keys, and a way from one to the next. Before the first key and after the last the value stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve<T> {
    /// Times, seconds, finite and strictly ascending, with their values; at least one.
    pub keys: Vec<(f64, T)>,
    /// What is between.
    pub blend: Blend,
}

impl<T: Value> Curve<T> {
    /// The same value at all times.
    pub fn constant(value: T) -> Self {
        Self { keys: vec![(0.0, value)], blend: Blend::Linear }
    }

    /// True if it is straight between keys.
    pub fn is_straight(&self) -> bool {
        self.blend == Blend::Linear || self.keys.len() == 1
    }

    /// The value at a time, seconds.
    pub fn at(&self, time: f64) -> T {
        let next = self.keys.partition_point(|(t, _)| *t <= time);
        if next == 0 || next == self.keys.len() {
            let end = if next == 0 { self.keys.first() } else { self.keys.last() };
            return end.map_or_else(|| T::from_components([0.0; 3]), |(_, value)| *value);
        }
        let ((t0, from), (t1, to)) = (self.keys[next - 1], self.keys[next]);
        let share = (time - t0) / (t1 - t0);
        if self.blend == Blend::Step || share <= 0.0 {
            return from;
        }
        let (a, b) = (from.components(), to.components());
        T::from_components([0, 1, 2].map(|component| {
            let (a, b) = (a[component], b[component]);
            match self.blend {
                _ if a == b && (T::BOUNDED || self.blend == Blend::Linear) => a,
                Blend::Cubic => {
                    let (h, rest) = (t1 - t0, 1.0 - share);
                    let [begin, end] = [next - 1, next].map(|key| self.slope(key, component) * h);
                    let middle = a + (b - a) * (share * share * (3.0 - 2.0 * share));
                    middle + begin * (share * rest * rest) - end * (share * share * rest)
                }
                Blend::Linear | Blend::Step => a * (1.0 - share) + b * share,
            }
        }))
    }

    /// How fast a component changes at a key.
    fn slope(&self, key: usize, component: usize) -> f64 {
        let length = |i: usize| self.keys[i + 1].0 - self.keys[i].0;
        let value = |i: usize| self.keys[i].1.components()[component];
        let chord = |i: usize| (value(i + 1) - value(i)) / length(i);
        let last = self.keys.len() - 1;
        if last == 1 {
            return chord(0);
        }
        if key == 0 || key == last {
            let (near, far) = if key == 0 { (0, 1) } else { (last - 1, last - 2) };
            let slope = chord(near) + (chord(near) - chord(far)) * (length(near) / (length(near) + length(far)));
            return match T::BOUNDED {
                true if slope * chord(near) <= 0.0 => 0.0,
                true if slope.abs() > 2.0 * chord(near).abs() => 2.0 * chord(near),
                _ => slope,
            };
        }
        let (before, after) = (length(key - 1), length(key));
        let slope = (chord(key - 1) * after + chord(key) * before) / (before + after);
        if !T::BOUNDED {
            return slope;
        }
        let (left, right) = (chord(key - 1), chord(key));
        if left * right <= 0.0 {
            return 0.0;
        }
        let most = 2.0 * left.abs().min(right.abs());
        slope.clamp(-most, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_met_and_ends_stay() {
        for blend in Blend::ALL {
            let curve = Curve { keys: vec![(1.0, 3.0), (2.0, -1.0), (2.5, 0.25)], blend };
            for (time, value) in [(-9.0, 3.0), (1.0, 3.0), (2.0, -1.0), (2.5, 0.25), (100.0, 0.25)] {
                assert_eq!(curve.at(time), value, "{blend:?} {time}");
            }
        }
        let step = Curve { keys: vec![(0.0, 1.0), (1.0, 2.0)], blend: Blend::Step };
        assert_eq!((step.at(0.999), step.at(1.0)), (1.0, 2.0));
        let line = Curve { keys: vec![(0.0, 1.0), (2.0, 2.0)], blend: Blend::Linear };
        assert_eq!(line.at(0.5), 1.25);
    }

    /// Colours stay between their keys, without jumps in value or slope.
    #[test]
    fn numbers_never_leave_their_keys() {
        let values = [0.0, 1.0, 1.0, 0.2, 0.9, 0.0, 0.0, 1.0];
        let keys: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, v)| (1.3 * i as f64, *v)).collect();
        let curve = Curve { keys: keys.clone(), blend: Blend::Cubic };
        for pair in keys.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for i in 0..=100 {
                let value = curve.at(pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(i) / 100.0);
                assert!((low - 1e-12..=high + 1e-12).contains(&value), "{value} of {pair:?}");
            }
        }
        for (time, value) in &keys[1..7] {
            let (left, right) = ((value - curve.at(time - 1e-6)) * 1e6, (curve.at(time + 1e-6) - value) * 1e6);
            assert!((left - right).abs() < 1e-4, "{time}: {left} {right}");
        }
    }

    #[test]
    fn points_follow_parabolas() {
        let place = |t: f64| DVec3::new(t, 1.0 - 4.9 * t * t, 2.0 * t * t - t);
        let curve = Curve { keys: [0.0, 0.3, 1.1, 1.2, 2.0].map(|t| (t, place(t))).to_vec(), blend: Blend::Cubic };
        for i in 0..=200 {
            let time = 0.01 * f64::from(i);
            assert!((curve.at(time) - place(time)).length() < 1e-12, "{time}");
        }
    }
}
