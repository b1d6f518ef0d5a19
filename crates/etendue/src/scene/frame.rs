//! From one frame to the next: what has changed is made anew, all else stays.

use super::{
    DeltaLight, Environment, Scene, SceneError,
    build::{is_moving, places, validate_material},
    distant,
    interiors::Interiors,
};
use crate::{light::Light, material::Material, motion::Motion};

/// What another frame changes of a scene. Whatever is not named stays as it is.
#[derive(Clone, Debug, Default)]
pub struct FrameChanges {
    /// New motions, by index into [`SceneParts::objects`](super::SceneParts::objects); only of objects that were built with
    /// one. What is to rest gets a motion whose keys are equal.
    pub motions: Vec<(usize, Motion)>,
    /// New materials, by index into [`SceneParts::materials`](super::SceneParts::materials).
    pub materials: Vec<(usize, Material)>,
    /// The lights that no ray can meet, all of them.
    pub delta_lights: Option<Vec<DeltaLight>>,
    /// With these, the [motions](super::SceneParts::light_motions) of some of them.
    pub light_motions: Vec<(usize, Motion)>,
    /// The light from all around; `Some(None)` for none.
    pub environment: Option<Option<Environment>>,
}

impl Scene {
    /// The scene in another frame: rays and pictures are, to the bit, those of a fresh build of all parts with these changes.
    /// Geometries and their structures, textures, the scene's centre and, where nothing that shines has changed, the table of
    /// lights are kept; the top of the accelerator is fitted or built anew, on `threads` threads. A failed call loses the
    /// scene.
    ///
    /// # Errors
    /// As [`Scene::build`]; and [`SceneError::Reference`] or [`SceneError::Motion`] where an index is out of range or an object
    /// was built as one that never moves.
    pub fn with_frame(mut self, changes: FrameChanges, threads: usize) -> Result<Self, SceneError> {
        let FrameChanges { motions, materials, delta_lights, light_motions, environment } = changes;
        let radius = self.radius();
        let mut shining = delta_lights.is_some() || environment.is_some();
        if !motions.is_empty() {
            shining |= self.set_motions(motions)?;
            let all = self.placements.iter().map(|placement| placement.place.clone()).collect();
            self.accelerator = self.accelerator.with_places(all, threads)?;
        }
        shining |= self.set_materials(materials)?;
        if let Some(lights) = delta_lights {
            distant::validate_delta_lights(&lights, &light_motions)?;
            (self.parts.delta_lights, self.parts.light_motions) = (lights, light_motions);
        }
        self.is_moving = is_moving(&self.placements) || distant::is_moving(&self.parts.light_motions);
        // Light from infinity goes by the size of the scene.
        shining |= self.radius() != radius && self.lights.lights().iter().any(Light::is_infinite);
        let light = match environment {
            None => self.lights.environment().map(|index| self.lights.lights()[index as usize].clone()),
            Some(environment) => {
                if let Some(environment) = &environment {
                    distant::validate_environment(environment).map_err(SceneError::Environment)?;
                }
                self.parts.environment = environment;
                self.parts.environment.as_ref().and_then(distant::environment_light)
            }
        };
        if shining {
            self.list_lights(light)?;
        }
        self.count();
        Ok(self)
    }

    /// True if lights have moved, or stopped.
    fn set_motions(&mut self, motions: Vec<(usize, Motion)>) -> Result<bool, SceneError> {
        let mut shining = false;
        for (index, motion) in motions {
            let count = self.parts.objects.len();
            let object = self.parts.objects.get_mut(index).ok_or_else(|| {
                let object = "(of another frame)".to_owned();
                SceneError::Reference { object, what: "object", index, count }
            })?;
            if object.motion.is_none() {
                return Err(SceneError::Motion(
                    object.name.clone(),
                    "comes too late: it was built as one that never moves",
                ));
            }
            let placement = &mut self.placements[index];
            [placement.place, placement.pose] = places(object, &motion, placement.inner, self.center)?;
            object.motion = Some(motion);
            shining |= !matches!(placement.lights, super::FaceLights::None);
        }
        Ok(shining)
    }

    /// True if lights may have changed.
    fn set_materials(&mut self, materials: Vec<(usize, Material)>) -> Result<bool, SceneError> {
        if materials.is_empty() {
            return Ok(false);
        }
        let mut shining = false;
        for (index, material) in materials {
            validate_material(&material)?;
            let count = self.parts.materials.len();
            let place = self.parts.materials.get_mut(index).ok_or_else(|| {
                let object = "(of another frame)".to_owned();
                SceneError::Reference { object, what: "material", index, count }
            })?;
            shining |= place.emission.is_some() || material.emission.is_some();
            *place = material;
        }
        self.interiors = Interiors::new(&self.parts, self.center)?;
        self.prepare_materials();
        Ok(shining)
    }
}
