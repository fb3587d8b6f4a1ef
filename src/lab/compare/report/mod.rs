//! The page that shows a comparison: one file that opens from disk, without a network.

const TEMPLATE: &str = include_str!("report.html");
const STYLE: &str = include_str!("report.css");

/// One module script in the order of use: a `const` is not there before its line.
const SCRIPT: &str = concat!(
    include_str!("data.js"),
    include_str!("summary.js"),
    include_str!("matrix.js"),
    include_str!("gallery.js"),
    include_str!("charts.js"),
    include_str!("table.js"),
    include_str!("picture.js"),
    include_str!("view.js"),
    include_str!("viewer.js"),
    include_str!("controls.js"),
    include_str!("main.js"),
);

/// The page for results as they stand in `results.json`.
///
/// Every `<` becomes `\u003c`, which in JSON can only stand within a string and means the same there: nothing in the
/// results ends the element that holds them.
pub fn page(results_json: &str) -> String {
    let results = results_json.replace('<', "\\u003c");
    // The results last: whatever they say is not searched.
    let dressed = TEMPLATE.replacen("/*{style}*/", STYLE, 1).replacen("/*{script}*/", SCRIPT, 1);
    dressed.replacen("/*{results}*/", &results, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_page_and_cannot_leave_their_element() {
        let results = r#"{"title":"</script><!-- /*{script}*/ /*{style}*/"}"#;
        let page = page(results);
        let (_, rest) = page.split_once(r#"<script id="results" type="application/json">"#).unwrap();
        let (held, _) = rest.split_once("</script>").unwrap();
        assert!(!held.contains('<'));
        let (read, wanted) = (serde_json::from_str(held), serde_json::from_str(results));
        let (read, wanted): (serde_json::Value, serde_json::Value) = (read.unwrap(), wanted.unwrap());
        assert_eq!(read, wanted);
    }

    #[test]
    fn page_is_filled_and_asks_for_nothing_from_elsewhere() {
        let page = page("{}");
        assert!(!page.contains("/*{"), "a place of the template is empty");
        assert!(page.contains(STYLE) && page.contains(SCRIPT));
        let outside = ["http:", "https:", "//cdn", "@import", "url(", " src="];
        outside.iter().for_each(|address| assert!(!page.contains(address), "the page holds {address}"));
    }
}
