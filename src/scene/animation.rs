//! Cameras that move: keys at frames, and a turn around what is in the middle of the picture.

use super::description::{CameraDescription, CameraKey, Interpolation, Unsaid};
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::TAU;

impl CameraDescription {
    /// The camera at a frame. What no key says stays as it is; before the first key that says it and after the last, it stands
    /// still.
    pub(crate) fn at(&self, frame: f64) -> CameraDescription {
        let keys = Keys { keys: &self.keys, smooth: self.interpolation == Interpolation::Smooth, frame };
        let number = |of: fn(&CameraKey) -> Option<f32>| keys.value(|key| of(key).map(|x| [f64::from(x)]));
        let single = |found: Option<[f64; 1]>, own: f32| found.map_or(own, |[x]| x as f32);
        let place = |of: fn(&CameraKey) -> Option<DVec3>| keys.value(|key| of(key).map(|p| p.to_array()));
        let up = keys.value(|key| key.up.map(|up| up.as_dvec3().to_array()));
        CameraDescription {
            origin: place(|key| key.origin).map_or(self.origin, DVec3::from),
            target: place(|key| key.target).map_or(self.target, DVec3::from),
            up: up.map_or(self.up, |up| DVec3::from(up).as_vec3()),
            vfov: single(number(|key| key.vfov), self.vfov),
            view_height: single(number(|key| key.view_height), self.view_height),
            aperture_radius: single(number(|key| key.aperture_radius), self.aperture_radius),
            focus_distance: number(|key| key.focus_distance).map(|[x]| x as f32).or(self.focus_distance),
            keys: Vec::new(),
            ..self.clone()
        }
    }

    /// What nobody has said of the camera itself is as in the first key that says it.
    pub(crate) fn stand_at_first_keys(&mut self) {
        let first = self.at(f64::NEG_INFINITY);
        let CameraDescription { keys, unsaid, .. } = self;
        let silent = |says: fn(&CameraKey) -> bool| !keys.iter().any(says);
        let to_say = *unsaid;
        unsaid.origin &= silent(|key| key.origin.is_some());
        unsaid.target &= silent(|key| key.target.is_some());
        unsaid.up &= silent(|key| key.up.is_some());
        unsaid.vfov &= silent(|key| key.vfov.is_some());
        unsaid.view_height &= silent(|key| key.view_height.is_some());
        let Unsaid { origin, target, up, vfov, view_height } = to_say;
        self.origin = if origin { first.origin } else { self.origin };
        self.target = if target { first.target } else { self.target };
        self.up = if up { first.up } else { self.up };
        self.vfov = if vfov { first.vfov } else { self.vfov };
        self.view_height = if view_height { first.view_height } else { self.view_height };
    }

    /// The camera after `share` of a turn around its target, counter-clockwise as seen from above; what is up is the axis.
    pub(crate) fn turned(&self, share: f64) -> CameraDescription {
        let share = share.rem_euclid(1.0);
        if share == 0.0 || self.up == Vec3::ZERO {
            return self.clone();
        }
        let turn = DQuat::from_axis_angle(self.up.as_dvec3().normalize(), TAU * share);
        CameraDescription { origin: self.target + turn * (self.origin - self.target), ..self.clone() }
    }
}

/// What keys say at a frame. They are in the order of their frames.
struct Keys<'a> {
    keys: &'a [CameraKey],
    smooth: bool,
    frame: f64,
}

impl Keys<'_> {
    /// `None` where no key says it.
    fn value<const N: usize>(&self, of: impl Fn(&CameraKey) -> Option<[f64; N]>) -> Option<[f64; N]> {
        let said: Vec<(f64, [f64; N])> = self.keys.iter().filter_map(|key| Some((key.frame, of(key)?))).collect();
        let (first, last) = (said.first()?, said.last()?);
        if self.frame <= first.0 {
            return Some(first.1);
        }
        if self.frame >= last.0 {
            return Some(last.1);
        }
        let after = said.partition_point(|(frame, _)| *frame <= self.frame);
        Some(std::array::from_fn(|k| {
            let component: Vec<[f64; 2]> = said.iter().map(|(frame, value)| [*frame, value[k]]).collect();
            between(&component, after - 1, self.frame, self.smooth)
        }))
    }
}

/// Between points `i` and `i + 1` of (frame, value): on a straight line, or on the cubic that has both points' slopes.
fn between(points: &[[f64; 2]], i: usize, frame: f64, smooth: bool) -> f64 {
    let ([from, a], [to, b]) = (points[i], points[i + 1]);
    let (length, t) = (to - from, (frame - from) / (to - from));
    if !smooth {
        return a + (b - a) * t;
    }
    let [u, v] = [slope(points, i), slope(points, i + 1)].map(|slope| slope * length);
    let (t2, t3) = (t * t, t * t * t);
    a + (b - a) * (3.0 * t2 - 2.0 * t3) + u * (t3 - 2.0 * t2 + t) + v * (t3 - t2)
}

/// Of the curve at a point: that of the parabola through it and its neighbours (Catmull & Rom 1974, for frames that are not
/// evenly spaced), but so small that the curve never leaves the range of the two values it is between (Fritsch & Carlson 1980).
/// It is 0 at the ends and at values that both neighbours are above or below.
fn slope(points: &[[f64; 2]], i: usize) -> f64 {
    let (Some([before, a]), [here, b], Some([after, c])) =
        (i.checked_sub(1).map(|i| points[i]), points[i], points.get(i + 1))
    else {
        return 0.0;
    };
    let (left, right) = (here - before, after - here);
    let (from, to) = ((b - a) / left, (c - b) / right);
    if from * to <= 0.0 {
        return 0.0;
    }
    let parabola = (from * right + to * left) / (left + right);
    parabola.signum() * parabola.abs().min(3.0 * from.abs().min(to.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(frame: f64, origin: [f64; 3]) -> CameraKey {
        CameraKey { frame, origin: Some(origin.into()), ..CameraKey::default() }
    }

    fn camera(interpolation: Interpolation) -> CameraDescription {
        let keys = vec![
            key(1.0, [0.0, 0.0, 5.0]),
            CameraKey { vfov: Some(30.0), ..key(11.0, [1.0, 0.0, 5.0]) },
            key(21.0, [1.0, 2.0, 5.0]),
            CameraKey { frame: 31.0, vfov: Some(60.0), ..CameraKey::default() },
            key(61.0, [9.0, 0.0, 5.0]),
        ];
        CameraDescription { keys, interpolation, ..CameraDescription::default() }
    }

    #[test]
    fn a_camera_is_at_its_keys_and_stands_still_outside_of_them() {
        for interpolation in [Interpolation::Smooth, Interpolation::Linear] {
            let camera = camera(interpolation);
            for (frame, x, y, vfov) in [
                (-7.0, 0.0, 0.0, 30.0),
                (1.0, 0.0, 0.0, 30.0),
                (11.0, 1.0, 0.0, 30.0),
                (21.0, 1.0, 2.0, 45.0),
                (99.0, 9.0, 0.0, 60.0),
            ] {
                let at = camera.at(frame);
                assert_eq!((at.origin, at.vfov), (DVec3::new(x, y, 5.0), vfov), "{frame}");
                assert_eq!((at.target, at.up), (camera.target, camera.up));
            }
        }
    }

    #[test]
    fn between_keys_it_moves_steadily_and_leaves_no_range() {
        let (smooth, linear) = (camera(Interpolation::Smooth), camera(Interpolation::Linear));
        assert_eq!(linear.at(6.0).origin.x, 0.5);
        assert_eq!(linear.at(41.0).origin, DVec3::new(5.0, 1.0, 5.0));
        // the slope is 0 at both ends of the first piece of x, and of y: half of the way in the middle
        assert_eq!((smooth.at(6.0).origin.x, smooth.at(16.0).origin), (0.5, DVec3::new(1.0, 1.0, 5.0)));
        let mut before = smooth.at(0.0).origin;
        for step in 0..700 {
            let at = smooth.at(f64::from(step) * 0.1).origin;
            assert!((0.0..=9.0).contains(&at.x) && (0.0..=2.0).contains(&at.y), "{step}: {at}");
            assert!((at - before).length() < 0.05 && at.x >= before.x, "{step}: {before} to {at}");
            before = at;
        }
    }

    #[test]
    fn slopes_are_those_of_catmull_and_rom_where_nothing_is_left() {
        let points = [[0.0, 0.0], [1.0, 1.0], [2.0, 4.0], [3.0, 9.0]];
        assert_eq!((slope(&points, 1), slope(&points, 2)), (2.0, 4.0));
        // a parabola's
        assert!((between(&points, 1, 1.5, true) - 2.25).abs() < 1e-12);
        assert!((slope(&[[0.0, 0.0], [1.0, 0.1], [2.0, 9.0]], 1) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_turn_keeps_distance_and_height_and_ends_where_it_began() {
        let camera = CameraDescription {
            origin: DVec3::new(3.0, 2.0, 5.0),
            target: DVec3::new(1.0, 1.0, 1.0),
            ..CameraDescription::default()
        };
        let at = |share| camera.turned(share).origin;
        assert!(at(0.0) == camera.origin && at(1.0) == camera.origin);
        assert!((at(0.25) - DVec3::new(5.0, 2.0, -1.0)).length() < 1e-12, "{}", at(0.25));
        assert!((at(0.5) - DVec3::new(-1.0, 2.0, -3.0)).length() < 1e-12, "{}", at(0.5));
    }
}
