//! From whole batches of paths back to what each vertex should learn.

use crate::guiding::{Recorder, StateKey, Transition};
use crate::math::{Rgb, luminance};

/// A vertex as the backward pass needs it.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The path, by its place in the batch.
    pub slot: u32,
    /// State and action of the direction in which the path went on; `None` where nothing is to be learnt.
    pub action: Option<(StateKey, u16)>,
    /// f·|cosθ|/p of that direction, roulette included; zero where the path ended.
    pub weight: Rgb,
    /// Radiance towards the path's last vertex that this vertex accounts for itself: emission, weighted for
    /// next-event estimation, and next-event estimation.
    pub local: Rgb,
    /// What the frozen table expects of going on, ∫ Q f cosθ dω; `None` where it cannot say.
    pub expected: Option<Rgb>,
}

/// Radiance that arrived at the batch's vertices, computed from the last wave to the first:
///
/// G(x) = local(y) + (1−λ) ∫ Q f cosθ + λ · weight(y) · G(y)
///
/// λ = 0 is the expected SARSA of Dahm & Keller (2017), λ = 1 the Monte Carlo return. Where the table cannot
/// say what to expect (a mirror, glass, a glossy surface, a state not met before), λ is 1 at that vertex.
pub fn record(waves: &[Vec<Vertex>], paths: usize, lambda: f32, returns: &mut Vec<Rgb>, recorder: &mut Recorder) {
    returns.clear();
    returns.resize(paths, Rgb::ZERO);
    for vertex in waves.iter().rev().flatten() {
        let arrived = &mut returns[vertex.slot as usize];
        let target = luminance(*arrived);
        if let Some((key, action)) = vertex.action
            && target.is_finite()
        {
            recorder.push(Transition { key, action, target });
        }
        let followed = vertex.weight * *arrived;
        *arrived = vertex.local
            + match vertex.expected {
                Some(expected) => expected * (1.0 - lambda) + followed * lambda,
                None => followed,
            };
    }
}
