//! `[gallery]` and `[[why]]` of a comparison's file.

use super::{Bounds, Check, Gallery, Why};
use crate::document::{Bounds as Range, Fault, Node, Reader, suggest};
use crate::lab::compare::file::{SHARE, number, strings};

const FACTOR: Range = Range::new(|x| x >= 1.0, "at least 1");

/// What both say together; `None` without `[gallery]`. `scenes` and `methods` are the names that sentences may have.
///
/// # Errors
/// What is malformed, a sentence about a scene or a method that is not there, and sentences without `[gallery]`.
pub(in crate::lab::compare) fn gallery(
    bounds: Option<Node>,
    whys: Option<Node>,
    scenes: &[String],
    methods: &[String],
) -> Result<Option<Gallery>, Fault> {
    let Some(node) = bounds else {
        return whys.map_or(Ok(None), |node| Err(Fault::new(node.at, "[[why]] belongs to a [gallery]")));
    };
    let bounds = read_bounds(node)?;
    let nodes = whys.map_or(Ok(vec![]), |node| node.tables("why"))?;
    let whys = nodes.into_iter().map(|node| why(node, scenes, methods)).collect::<Result<_, _>>()?;
    Ok(Some(Gallery { bounds, whys }))
}

fn read_bounds(node: Node) -> Result<Bounds, Fault> {
    let mut t = Reader::new("[gallery]", node)?;
    let mut bounds = Bounds::default();
    let keys: [(&'static str, &mut f64, Range); 4] = [
        ("alarm", &mut bounds.alarm, SHARE),
        ("slower", &mut bounds.slower, FACTOR),
        ("fireflies", &mut bounds.fireflies, SHARE),
        ("explosion", &mut bounds.explosion, FACTOR),
    ];
    for (key, slot, range) in keys {
        *slot = number(&mut t, key, range)?.unwrap_or(*slot);
    }
    t.integer("repeat", 1..=1 << 16, &mut bounds.repeat)?;
    t.finish()?;
    Ok(bounds)
}

fn why(node: Node, scenes: &[String], methods: &[String]) -> Result<Why, Fault> {
    let mut t = Reader::new("[[why]]", node)?;
    let checks: Vec<String> = Check::NAMES.iter().map(|(name, _)| name.to_string()).collect();
    let says = t.require("says")?.string("says")?.to_owned();
    let scenes = known(&mut t, "scenes", scenes)?;
    let methods = known(&mut t, "methods", methods)?;
    let fails = known(&mut t, "fails", &checks)?;
    t.finish()?;
    let check = |name: &String| Check::NAMES.iter().find(|(known, _)| known == name).map(|(_, check)| *check);
    Ok(Why { scenes, methods, fails: fails.iter().filter_map(check).collect(), says })
}

/// Names, all of which are among those that are there.
fn known(t: &mut Reader, key: &'static str, there: &[String]) -> Result<Vec<String>, Fault> {
    let Some(node) = t.take(key) else { return Ok(vec![]) };
    let at = node.at;
    let names = strings(key, node)?;
    match names.iter().find(|name| !there.contains(name)) {
        None => Ok(names),
        Some(name) => {
            let what = format!("`{name}` in `{key}` is not there");
            Err(Fault::new(at, suggest::unknown(&what, name, there.iter().map(String::as_str))))
        }
    }
}
