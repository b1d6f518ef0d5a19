//! The camera of a script: a window before a point, and how statements move it.

use etendue::math::DVec3;

/// A camera as the old program kept it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptCamera {
    /// Where rays meet.
    pub position: DVec3,
    /// Unit length.
    pub direction: DVec3,
    /// Unit length.
    pub up: DVec3,
    /// `direction` x `up`, at the time that one of them was last changed; shorter than 1 where they are not perpendicular.
    right: DVec3,
    /// Distance of the window from `position`.
    pub distance: f64,
    /// Width and height of the window.
    pub window: [f64; 2],
    /// Side of a pixel on the window.
    pub step: f64,
    /// Absent: everything is in focus.
    pub lens: Option<ScriptLens>,
}

/// What makes a camera blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptLens {
    /// Distance of the plane in focus from the camera's position, beyond the window.
    pub focus: f64,
    /// Side of the square on the window that the rays of a point in focus pass through.
    pub aperture: f64,
}

impl ScriptCamera {
    /// A camera at `position`; `None` if its direction or up is zero, or they are parallel.
    pub fn new(
        position: DVec3,
        direction: DVec3,
        up: DVec3,
        distance: f64,
        window: [f64; 2],
        step: f64,
    ) -> Option<Self> {
        let (direction, up) = (direction.try_normalize()?, up.try_normalize()?);
        let camera = Self { position, direction, up, right: direction.cross(up), distance, window, step, lens: None };
        camera.is_sound().then_some(camera)
    }

    /// True if its numbers can be used.
    pub fn is_sound(&self) -> bool {
        let finite = self.position.is_finite() && self.direction.is_finite() && self.up.is_finite();
        finite && self.direction.cross(self.up).length() > 1e-6
    }

    /// `camera::move F R U`: forward, right, up.
    pub fn shift(&mut self, [forward, right, up]: [f64; 3]) {
        self.position += self.direction * forward + self.right * right + self.up * up;
    }

    /// `camera::move zoomIn D`: forward.
    pub fn zoom_in(&mut self, by: f64) {
        self.position += self.direction * by;
    }

    /// `camera::move tiltUp D`: looks up, by an angle whose tangent is `by`.
    pub fn tilt_up(&mut self, by: f64) {
        self.direction = (self.direction + self.up * by).normalize();
        self.up = self.right.cross(self.direction);
    }

    /// `camera::move tiltRight D`: looks to the right, likewise.
    pub fn tilt_right(&mut self, by: f64) {
        self.direction = (self.direction + self.right * by).normalize();
        self.right = self.direction.cross(self.up);
    }

    /// `camera::move rotate D`: turns about its view, clockwise as the photographer sees it, likewise.
    pub fn rotate(&mut self, by: f64) {
        self.up = (self.up + self.right * by).normalize();
        self.right = self.direction.cross(self.up);
    }

    /// Degrees by which up is not perpendicular to the view; the old program skewed the picture then.
    pub fn skew(&self) -> f64 {
        libm::asin(self.direction.dot(self.up.normalize()).clamp(-1.0, 1.0)).to_degrees().abs()
    }

    /// Pixels that the window holds along each side.
    pub fn pixels(&self) -> [f64; 2] {
        self.window.map(|side| side / self.step)
    }
}

impl ScriptLens {
    /// Side of the square on the plane of the camera's position that the same rays pass through: they meet in the plane in
    /// focus, so their spread there is to that on the window as `focus` is to `focus - distance`.
    pub fn side(&self, distance: f64) -> f64 {
        self.aperture * self.focus / (self.focus - distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: DVec3, b: [f64; 3]) {
        assert!((a - DVec3::from_array(b)).abs().max_element() < 6e-6, "{a} {b:?}");
    }

    fn paper() -> ScriptCamera {
        let direction = DVec3::new(0.621478, 0.466949, -0.629066);
        let up = DVec3::new(0.46311, 0.428683, 0.775732);
        ScriptCamera::new(DVec3::new(-4.81455, -3.35453, 5.45768), direction, up, 2.5, [2.0; 2], 0.0025).unwrap()
    }

    /// The first figure's camera; the numbers were found from the picture's geometry.
    #[test]
    fn tilted_as_in_the_first_figure() {
        let mut camera = paper();
        camera.tilt_right(0.16);
        near(camera.direction, [0.71351, 0.33889, -0.61324]);
        near(camera.up, [0.46311, 0.428683, 0.775732]);
        near(camera.right, [0.52577, -0.83749, 0.14892]);
        assert_eq!(camera.pixels().map(libm::round), [800.0; 2]);
        let lens = ScriptLens { focus: 5.8, aperture: 0.06 };
        assert!((lens.side(2.5) - 0.06 * 5.8 / 3.3).abs() < 1e-15);
    }

    /// Moves keep three perpendicular directions, and turn the way they say.
    #[test]
    fn moves() {
        let level = || ScriptCamera::new(DVec3::ZERO, DVec3::Y, DVec3::Z, 1.0, [1.0; 2], 0.1).unwrap();
        let mut camera = level();
        camera.shift([1.0, 2.0, 3.0]);
        camera.zoom_in(0.5);
        near(camera.position, [2.0, 1.5, 3.0]);
        for (turn, direction, up) in [
            (ScriptCamera::tilt_up as fn(&mut ScriptCamera, f64), [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]),
            (ScriptCamera::tilt_right, [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]),
            (ScriptCamera::rotate, [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]),
        ] {
            let mut camera = level();
            turn(&mut camera, 0.75);
            near(camera.direction, direction);
            near(camera.up, up);
            near(camera.right, camera.direction.cross(camera.up).to_array());
            assert!(camera.skew() < 1e-9);
        }
    }

    /// The rays through the window's square and the plane in focus, continued to the camera's position, are those of the lens.
    #[test]
    fn rays_of_the_lens() {
        let lens = ScriptLens { focus: 5.8, aperture: 0.06 };
        // In the plane of one axis: the point in focus lies at height 1, the ray passes the window at its edge.
        let in_focus = 1.0;
        let on_window = in_focus * 2.5 / 5.8 + 0.5 * lens.aperture;
        let slope = (in_focus - on_window) / (5.8 - 2.5);
        assert!((on_window - 2.5 * slope - 0.5 * lens.side(2.5)).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_a_camera() {
        let new = |direction, up| ScriptCamera::new(DVec3::ZERO, direction, up, 1.0, [1.0; 2], 0.1);
        assert_eq!(new(DVec3::ZERO, DVec3::Z), None);
        assert_eq!(new(DVec3::Z, DVec3::Z * 2.0), None);
        assert!(new(DVec3::X, DVec3::Z + DVec3::X).is_some_and(|c| (c.skew() - 45.0).abs() < 1e-9));
    }
}
