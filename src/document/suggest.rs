//! "Did you mean": the nearest of the names that would have been right.

/// `subject` ("unknown key `widht`") and either the nearest candidate or all of them.
pub(crate) fn unknown<'a>(subject: &str, name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    match nearest(name, &candidates) {
        Some(best) => format!("{subject}: did you mean `{best}`?"),
        None => format!("{subject}: known are {}", list(&candidates)),
    }
}

/// The candidate that is fewest typing errors away, if they are at most a third of the letters.
pub(crate) fn nearest<'a>(name: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let name = name.to_lowercase();
    let distance = |c: &str| strsim::damerau_levenshtein(&name, &c.to_lowercase());
    let (best, errors) = candidates.iter().map(|c| (*c, distance(c))).min_by_key(|(_, errors)| *errors)?;
    (errors <= best.chars().count().max(name.chars().count()) / 3).then_some(best)
}

/// "`a`, `b` and `c`".
pub(crate) fn list(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}
