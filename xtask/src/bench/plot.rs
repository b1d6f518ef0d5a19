//! Lines through points as SVG, both axes logarithmic.

use std::fmt::Write;

/// Colours of the lines.
const COLOURS: [&str; 4] = ["#c0392b", "#2471a3", "#229954", "#7d3c98"];
/// Of the picture, and what is left for labels at its left and bottom.
const SIZE: [f64; 2] = [480.0, 300.0];
const EDGE: [f64; 2] = [56.0, 40.0];

/// Named lines over two axes with names.
pub struct Plot<'a> {
    pub axes: [&'a str; 2],
    pub lines: Vec<(&'a str, Vec<[f64; 2]>)>,
}

impl Plot<'_> {
    /// The picture. Points with a coordinate that has no logarithm are left out, the others joined from left to right.
    pub fn svg(mut self) -> String {
        for (_, points) in &mut self.lines {
            points.retain(|p| p.iter().all(|v| *v > 0.0 && v.is_finite()));
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        let range = [self.decades(0), self.decades(1)];
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"11\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            SIZE[0], SIZE[1]
        );
        svg += &grid(range);
        for (i, (name, points)) in self.lines.iter().enumerate() {
            svg += &line(i, name, points, range);
        }
        let middle = SIZE.map(|length| length / 2.0);
        let _ = write!(
            svg,
            "<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{}</text>\n\
             <text x=\"12\" y=\"{:.0}\" text-anchor=\"middle\" transform=\"rotate(-90 12 {:.0})\">{}</text>\n</svg>\n",
            middle[0],
            SIZE[1] - 8.0,
            self.axes[0],
            middle[1],
            middle[1],
            self.axes[1]
        );
        svg
    }

    /// The whole decades that hold all points.
    fn decades(&self, axis: usize) -> [f64; 2] {
        let all = self.lines.iter().flat_map(|(_, points)| points).map(|p| libm::log10(p[axis]));
        let [low, high] = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        if low > high { [0.0, 1.0] } else { [low.floor(), high.ceil().max(low.floor() + 1.0)] }
    }
}

/// Where a point is drawn, given by its logarithms.
fn place(p: [f64; 2], range: [[f64; 2]; 2]) -> [f64; 2] {
    let t = [0, 1].map(|i| (p[i] - range[i][0]) / (range[i][1] - range[i][0]));
    [EDGE[0] + t[0] * (SIZE[0] - EDGE[0] - 16.0), SIZE[1] - EDGE[1] - t[1] * (SIZE[1] - EDGE[1] - 12.0)]
}

/// A line at each power of ten, with its label.
fn grid(range: [[f64; 2]; 2]) -> String {
    let mut svg = String::new();
    for axis in 0..2 {
        for decade in range[axis][0] as i32..=range[axis][1] as i32 {
            let at = |other: f64| if axis == 0 { [f64::from(decade), other] } else { [other, f64::from(decade)] };
            let [a, b] = range[1 - axis].map(|end| place(at(end), range));
            let _ = writeln!(svg, "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"#ddd\"/>", a[0], a[1], b[0], b[1]);
            let label = if (-2..=4).contains(&decade) {
                format!("{}", libm::pow(10.0, f64::from(decade)))
            } else {
                format!("1e{decade}")
            };
            let (x, y, anchor) =
                if axis == 0 { (a[0], a[1] + 14.0, "middle") } else { (a[0] - 5.0, a[1] + 4.0, "end") };
            let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{label}</text>");
        }
    }
    svg
}

fn line(i: usize, name: &str, points: &[[f64; 2]], range: [[f64; 2]; 2]) -> String {
    let mut svg = String::new();
    let colour = COLOURS[i % COLOURS.len()];
    let corners: Vec<[f64; 2]> = points.iter().map(|p| place(p.map(libm::log10), range)).collect();
    let path: Vec<String> = corners.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
    let _ =
        writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>", path.join(" "));
    for p in &corners {
        let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>", p[0], p[1]);
    }
    let (x, y) = (SIZE[0] - 22.0, 24.0 + 14.0 * i as f64);
    let _ = writeln!(svg, "<text x=\"{x:.0}\" y=\"{y}\" text-anchor=\"end\" fill=\"{colour}\">{name}</text>");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_without_a_logarithm_are_left_out() {
        let lines = vec![("a", vec![[10.0, 1e-3], [1.0, 1e-2], [0.0, 1.0]]), ("b", vec![[f64::NAN, 1.0]])];
        let svg = Plot { axes: ["x", "y"], lines }.svg();
        assert_eq!((svg.matches("<polyline").count(), svg.matches("<circle").count()), (2, 2));
        assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.ends_with("</svg>\n"));
    }
}
