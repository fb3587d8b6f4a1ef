//! Methods by the dozen: the cross product of some keys' values.

use super::plan::{Method, Origin, Override};
use crate::{Error, Result};

/// What tells a sweep from a method's name.
pub(crate) const PREFIX: &str = "sweep:";

/// Methods that a sweep has at most.
const MOST: usize = 256;

/// One method for each combination in `key=a,b;key=c`, the last key varying fastest. Names are made of the keys that
/// vary, shortened to their last part where that tells them apart.
///
/// # Errors
/// [`Error::Scene`] for what is not of that form, and for more than 256 methods.
pub(crate) fn expand(text: &str) -> Result<Vec<Method>> {
    let keys: Vec<(&str, Vec<&str>)> = text.split(';').map(|part| key(text, part)).collect::<Result<_>>()?;
    let count = keys.iter().try_fold(1usize, |n, (_, values)| n.checked_mul(values.len()));
    if count.is_none_or(|n| n > MOST) {
        return Err(fault(text, &format!("that is more than {MOST} methods")));
    }
    let mut combinations: Vec<Vec<(&str, &str)>> = vec![vec![]];
    for (key, values) in &keys {
        let with = |c: &Vec<(_, _)>, value| [&c[..], &[(*key, value)]].concat();
        combinations = combinations.iter().flat_map(|c| values.iter().map(move |&value| with(c, value))).collect();
    }
    let varying: Vec<&str> = keys.iter().filter(|(_, values)| values.len() > 1).map(|(key, _)| *key).collect();
    Ok(combinations.iter().map(|c| method(c, &varying)).collect())
}

/// A key and its values.
fn key<'a>(text: &str, part: &'a str) -> Result<(&'a str, Vec<&'a str>)> {
    let (key, values) = part.split_once('=').ok_or_else(|| fault(text, "expected key=value,value;key=value"))?;
    let values: Vec<&str> = values.split(',').map(str::trim).collect();
    if key.trim().is_empty() || values.iter().any(|value| value.is_empty()) {
        return Err(fault(text, "a key or a value is missing"));
    }
    Ok((key.trim(), values))
}

fn method(combination: &[(&str, &str)], varying: &[&str]) -> Method {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    let short = |key: &str| {
        let alike = varying.iter().filter(|other| last(other) == last(key)).count();
        if alike <= 1 { last(key) } else { key.to_string() }
    };
    let named = combination.iter().filter(|(key, _)| varying.is_empty() || varying.contains(key));
    let name: Vec<String> = named.map(|(key, value)| format!("{}={value}", short(key))).collect();
    let origin = Origin::Argument("--methods sweep:");
    let set = |(key, value): &(&str, &str)| Override {
        key: key.to_string(),
        value: value.to_string(),
        origin: origin.clone(),
    };
    Method { name: name.join(" "), overrides: combination.iter().map(set).collect() }
}

fn fault(text: &str, message: &str) -> Error {
    Error::Scene(format!("{PREFIX}{text}: {message}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_is_a_cross_product_named_by_what_varies() {
        let methods = expand("guiding.method=grid;guiding.resolution=4,8;guiding.strata=4,8,16").unwrap();
        let names: Vec<&str> = methods.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names.len(), 6);
        assert_eq!(names[..2], ["resolution=4 strata=4", "resolution=4 strata=8"]);
        assert_eq!(names[5], "resolution=8 strata=16");
        let texts: Vec<String> = methods[3].overrides.iter().map(Override::text).collect();
        assert_eq!(texts, ["guiding.method=grid", "guiding.resolution=8", "guiding.strata=4"]);
    }

    #[test]
    fn keys_that_end_alike_are_written_out() {
        let methods = expand("material.A.alpha=0.1,0.2;material.B.alpha=0.3,0.4").unwrap();
        assert_eq!(methods[0].name, "material.A.alpha=0.1 material.B.alpha=0.3");
        assert_eq!(expand("guiding.method=grid").unwrap()[0].name, "method=grid");
    }

    #[test]
    fn what_is_no_sweep_is_refused() {
        for text in ["", "guiding.strata", "guiding.strata=4,,8", "=4", "a=1;"] {
            let message = expand(text).unwrap_err().to_string();
            assert!(message.starts_with(&format!("sweep:{text}: ")), "{message}");
        }
        let many = vec!["1"; 20].join(",");
        assert!(expand(&format!("a={many};b={many}")).unwrap_err().to_string().contains("more than 256"));
    }
}
