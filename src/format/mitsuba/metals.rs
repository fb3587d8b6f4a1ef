//! What materials are called.

use crate::Result;
use crate::document::suggest::unknown;
use crate::format::xml::object::Object;
use crate::math::Rgb;

/// Complex indices of refraction of conductors, which Mitsuba 3.9 makes of its measured spectra for linear sRGB (variant `scalar_rgb`).
/// A real part outside of the gamut is 0.0001. Names that end in `_palik` and are not here mean the same as without.
const METALS: &[(&str, [f32; 3], [f32; 3])] = &[
    ("a-C", [2.944, 2.2271, 1.9682], [0.8875, 0.7993, 0.8153]),
    ("Ag", [0.1553, 0.1167, 0.1384], [4.8284, 3.1222, 2.1469]),
    ("Al", [1.6575, 0.8804, 0.5212], [9.2238, 6.2695, 4.837]),
    ("AlAs", [3.6053, 3.2329, 2.2163], [0.0007, 0.0, 0.0075]),
    ("AlSb", [0.0001, 4.1394, 4.6693], [0.0, 0.094, 1.3006]),
    ("Au", [0.143, 0.3753, 1.442], [3.983, 2.3856, 1.6034]),
    ("Be", [4.185, 3.185, 2.7841], [3.8355, 3.0101, 2.869]),
    ("Cr", [4.3697, 2.9165, 1.6549], [5.2065, 4.2313, 3.7547]),
    ("CsI", [2.1449, 1.7023, 1.6624], [0.0, 0.0, 0.0]),
    ("Cu", [0.201, 0.9237, 1.1022], [3.9133, 2.453, 2.1421]),
    ("Cu2O", [3.5518, 2.9499, 2.7519], [0.1142, 0.1939, 0.6061]),
    ("Cu_palik", [0.2132, 0.9197, 1.1024], [3.9219, 2.4573, 2.1366]),
    ("CuO", [3.2475, 2.4478, 2.2102], [0.5211, 0.57, 0.7222]),
    ("d-C", [2.7087, 2.3188, 2.2289], [0.0, 0.0, 0.0]),
    ("Hg", [2.3989, 1.44, 0.9096], [6.3276, 4.3719, 3.4218]),
    ("HgTe", [4.779, 3.2312, 2.6599], [1.6316, 1.5808, 1.7293]),
    ("Ir", [3.0863, 2.0822, 1.6179], [5.5922, 4.0671, 3.2673]),
    ("K", [0.064, 0.0464, 0.0382], [2.1042, 1.3489, 0.9131]),
    ("Li", [0.2658, 0.1956, 0.2209], [3.5402, 2.3111, 1.6686]),
    ("MgO", [2.0896, 1.6507, 1.5949], [0.0, 0.0, 0.0]),
    ("Mo", [4.484, 3.5251, 2.7763], [4.1114, 3.4208, 3.1506]),
    ("Na_palik", [0.0603, 0.0561, 0.062], [3.1793, 2.1125, 1.579]),
    ("Nb", [3.4201, 2.7901, 2.3956], [3.4414, 2.7377, 2.5797]),
    ("Ni_palik", [2.3673, 1.6634, 1.4671], [4.4988, 3.0502, 2.3454]),
    ("Rh", [2.5858, 1.8602, 1.5543], [6.7823, 4.703, 3.9761]),
    ("Se", [4.0583, 2.8429, 2.8209], [0.754, 0.6384, 0.5218]),
    ("Se-e", [5.7228, 4.1657, 4.0813], [0.8711, 1.1052, 1.5653]),
    ("SiC", [3.1723, 2.526, 2.4794], [0.0, 0.0, 0.0]),
    ("SnTe", [4.5242, 1.9816, 1.2816], [0.0, 0.0, 0.0]),
    ("Ta", [2.0627, 2.3929, 2.6279], [2.4084, 1.7415, 1.947]),
    ("Te", [7.3902, 4.4821, 2.6371], [3.256, 3.5271, 3.2921]),
    ("Te-e", [7.5089, 4.2964, 2.37], [5.5839, 4.9472, 3.9976]),
    ("ThF4", [1.8307, 1.4422, 1.3876], [0.0, 0.0, 0.0]),
    ("TiC", [3.7005, 2.8374, 2.5823], [3.2656, 2.3516, 2.1728]),
    ("TiN", [1.6484, 1.1505, 1.3798], [3.3683, 1.9435, 1.1021]),
    ("TiO2", [3.4566, 2.8017, 2.9052], [0.0001, 0.0, 0.0007]),
    ("TiO2-e", [3.1066, 2.5132, 2.5824], [0.0, 0.0, 0.0002]),
    ("V_palik", [4.2776, 3.5129, 2.7611], [3.4913, 2.8895, 3.1115]),
    ("VC", [3.6576, 2.7527, 2.5327], [3.0683, 2.1987, 1.9632]),
    ("VN", [2.8656, 2.1192, 1.9401], [3.0322, 2.0561, 1.6163]),
    ("W", [4.3708, 3.3002, 2.9984], [3.5006, 2.6049, 2.2732]),
];

/// Indices of refraction of dielectrics, as Mitsuba names them.
const DIELECTRICS: &[(&str, f32)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.3330),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.470),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.5750),
    ("diamond", 2.419),
];

/// η and k of the metal of this name; `None` for `none`, which reflects all.
pub(crate) fn metal(object: &Object, name: &str) -> Result<Option<(Rgb, Rgb)>> {
    if name == "none" {
        return Ok(None);
    }
    let find = |name: &str| METALS.iter().find(|(known, ..)| *known == name);
    match find(name).or_else(|| find(name.strip_suffix("_palik")?)) {
        Some((_, eta, k)) => Ok(Some((Rgb::from(*eta), Rgb::from(*k)))),
        None => {
            let subject = format!("unknown metal `{name}`");
            Err(object.error(unknown(&subject, name, METALS.iter().map(|(name, ..)| *name))))
        }
    }
}

/// The index of refraction that `key` says, as a number or a name.
pub(crate) fn index(object: &Object, key: &str, default: &str) -> Result<f32> {
    let find = |name: &str| DIELECTRICS.iter().find(|(known, _)| *known == name).map(|(_, index)| *index);
    if let Some(item) = object.find(key)
        && let crate::format::xml::object::Value::Text(name) = &item.value
    {
        let name = name.to_lowercase();
        let subject = format!("unknown material `{name}`");
        let names = DIELECTRICS.iter().map(|(name, _)| *name);
        return find(&name).ok_or_else(|| item.at.error(unknown(&subject, &name, names)));
    }
    let index = object.maybe_number(key)?.map_or_else(|| find(default).unwrap_or(1.0), |index| index as f32);
    if index > 0.0 { Ok(index) } else { Err(object.error(format!("`{key}` must be greater than 0"))) }
}
