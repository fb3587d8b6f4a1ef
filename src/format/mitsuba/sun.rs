//! Where the sun stands at a place and an hour: the algorithm of Blanco-Muriel et al. 2001, "Computing the Solar Vector" (PSA), as in
//! Mitsuba, with its constants.

use crate::Result;
use crate::format::xml::object::Object;
use glam::DVec3;
use std::f64::consts::TAU;

/// A day and an hour, by the clock of a time zone.
#[derive(Clone, Copy, Debug)]
struct Moment {
    year: i64,
    month: i64,
    day: i64,
    /// With minutes and seconds.
    hour: f64,
    /// Hours before Greenwich.
    zone: f64,
}

/// The unit vector to the sun in the emitter's own frame; where nothing else is said, in Tokyo on the afternoon of 10 July 2010. Before
/// version 2 y is up, x east and −z north; since then z is up, −y east and −x north.
///
/// # Errors
/// What is no date, no hour and no place.
pub(super) fn direction(emitter: &Object, old: bool) -> Result<DVec3> {
    let number = |name: &str, default: f64, low: f64, high: f64| -> Result<f64> {
        let number = emitter.number(name, default)?;
        let fits = (low..=high).contains(&number);
        fits.then_some(number).ok_or_else(|| emitter.error(format!("`{name}` must be between {low} and {high}")))
    };
    let [minute, second] = [number("minute", 0.0, 0.0, 60.0)?, number("second", 0.0, 0.0, 60.0)?];
    let moment = Moment {
        year: number("year", 2010.0, 1.0, 9999.0)? as i64,
        month: number("month", 7.0, 1.0, 12.0)? as i64,
        day: number("day", 10.0, 1.0, 31.0)? as i64,
        hour: number("hour", 15.0, 0.0, 24.0)? + (minute + second / 60.0) / 60.0,
        zone: number("timezone", 9.0, -15.0, 15.0)?,
    };
    let latitude = number("latitude", 35.6894, -90.0, 90.0)?;
    let longitude = number("longitude", 139.6917, -180.0, 180.0)?;
    let (zenith, azimuth) = position(moment, latitude, longitude);
    let (north, east) = (zenith.sin() * azimuth.cos(), zenith.sin() * azimuth.sin());
    Ok(if old { DVec3::new(east, zenith.cos(), -north) } else { DVec3::new(-north, -east, zenith.cos()) })
}

/// Angles from the zenith, and from the north over the east, in radians.
fn position(moment: Moment, latitude: f64, longitude: f64) -> (f64, f64) {
    let Moment { year, month, day, hour, zone } = moment;
    let hour = hour - zone;
    // the Julian day, counted from noon of 1 January 2000
    let before = (month - 14) / 12;
    let julian = 1461 * (year + 4800 + before) / 4 + 367 * (month - 2 - 12 * before) / 12
        - 3 * ((year + 4900 + before) / 100) / 4
        + day
        - 32075;
    let days = julian as f64 - 0.5 + hour / 24.0 - 2_451_545.0;
    // along the ecliptic
    let omega = 2.1429 - 0.001_039_459_4 * days;
    let mean = 4.895_063_0 + 0.017_202_791_698 * days;
    let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
    let along = mean + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
        - 0.000_113_4
        - 0.000_020_3 * omega.sin();
    let tilt = 0.409_092_8 - 6.2140e-9 * days + 0.000_039_6 * omega.cos();
    // on the sky
    let ascension = (tilt.cos() * along.sin()).atan2(along.cos()).rem_euclid(TAU);
    let declination = (tilt.sin() * along.sin()).asin();
    // over the place
    let sidereal = 6.697_424_324_2 + 0.065_709_828_3 * days + hour;
    let turned = (sidereal * 15.0 + longitude).to_radians() - ascension;
    let (sine, cosine) = latitude.to_radians().sin_cos();
    let zenith = (cosine * turned.cos() * declination.cos() + declination.sin() * sine).clamp(-1.0, 1.0).acos();
    let azimuth = (-turned.sin()).atan2(declination.tan() * cosine - sine * turned.cos());
    // the earth's radius over the sun's distance
    (zenith + 6371.01 / 149_597_890.0 * zenith.sin(), azimuth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::SourceLocation;
    use crate::format::xml::object::{Item, Value};

    #[test]
    fn the_sun_stands_where_mitsuba_has_it() {
        let at = SourceLocation { path: "a.xml".into(), line: 1, column: 1 };
        let sun = |said: &[(&str, f64)], old: bool| {
            let mut emitter = Object::new("emitter", "sunsky", at.clone());
            let item = |(name, value): &(&str, f64)| Item::new(name.to_string(), at.clone(), Value::Number(*value));
            emitter.items = said.iter().map(item).collect();
            direction(&emitter, old)
        };
        let south = [("hour", 12.0), ("month", 12.0), ("latitude", -20.0), ("longitude", 10.0), ("timezone", 1.0)];
        // the parameter `sun_direction` of Mitsuba 3.9.1
        for (said, wanted) in [
            (&[][..], DVec3::new(0.051_385_4, 0.691_748, 0.720_308)),
            (&[("hour", 9.0)], DVec3::new(0.095_695_2, -0.614_786, 0.782_867)),
            (&south, DVec3::new(0.051_482_5, -0.051_203, 0.997_36)),
        ] {
            let found = sun(said, false).unwrap();
            assert!((found - wanted).length() < 1e-3, "{said:?}: {found}");
            let old = sun(said, true).unwrap();
            assert!((old - DVec3::new(-found.y, found.z, found.x)).length() < 1e-12, "{old}");
        }
        let message = sun(&[("hour", 25.0)], false).err().unwrap().to_string();
        assert_eq!(message, "a.xml:1:1: `hour` must be between 0 and 24");
    }
}
