//! Light that brushed metal gathers: lights sampled along the circle of directions that it scatters into.

use super::{
    paths::Paths,
    shade::{Strategy, Vertex, power_heuristic, send_light},
    shadow::ShadowQueue,
    wave::Context,
};
use crate::{bsdf::Circle, light::LightCircle, sampling::Slot};

/// Samples a light on the `circle` of the vertex, and keeps the circle for what the next ray may find.
pub(super) fn sample_light<const MEDIA: bool>(
    context: &Context,
    strategy: Strategy,
    paths: &mut Paths,
    path: usize,
    vertex: &Vertex,
    circle: &Circle,
    shadows: &mut ShadowQueue,
) {
    let in_world = LightCircle::new(vertex.gathers_at(), &vertex.frame, circle);
    paths.keep_circle(path, in_world);
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let select = context.sampler.fine(key, number, Slot::LightSelect);
    let position = context.sampler.two_d(key, number, Slot::LightPosition);
    let Some(light) = context.scene.sample_light_circle(&in_world, select, position) else { return };
    let shadowing = vertex.shadowing(light.wi, vertex.frame.to_local(light.wi));
    if shadowing == 0.0 {
        return;
    }
    let own = light.density.value();
    let eval = circle.eval(in_world.angle(light.wi));
    let weight = match strategy {
        Strategy::Both => power_heuristic(own, eval.pdf) / own,
        Strategy::Light | Strategy::Bsdf => 1.0 / own,
    };
    let contribution = paths.throughput[path] * eval.value * light.radiance * (weight * shadowing);
    send_light::<MEDIA>(context, paths, path, vertex, &light, contribution, shadows);
}
