//! What holds for every figure: call [`sound`] with it.

use super::*;

/// A figure that is valid XML, refers to nothing outside, names only colours that it
/// defines for light and dark pages, and whose texts lie apart and inside; returns
/// the texts.
pub(crate) fn sound(svg: &str) -> Vec<String> {
    let tree = roxmltree::Document::parse(svg).expect("a figure is well-formed");
    let root = tree.root_element();
    assert_eq!(root.tag_name().name(), "svg");
    assert!(
        root.attribute("aria-label")
            .is_some_and(|label| !label.is_empty())
    );
    for odd in ["NaN", "inf", "href", "url("] {
        assert!(!svg.contains(odd), "{odd} in {svg}");
    }
    assert_eq!(svg.matches("http").count(), 1, "the name space alone");
    let style = tree.descendants().find(|node| node.has_tag_name("style"));
    let (light, dark) = style.unwrap().text().unwrap().split_once("@media").unwrap();
    for class in tree
        .descendants()
        .filter_map(|node| node.attribute("class"))
    {
        for name in class.split(' ') {
            let rule = format!("svg .{name}{{");
            assert!(light.contains(&rule) && dark.contains(&rule), "{name}");
        }
    }
    let is_text = |node: &roxmltree::Node<'_, '_>| {
        let halo = node
            .parent()
            .is_some_and(|group| group.has_attribute("aria-hidden"));
        node.tag_name().name() == "text" && !halo
    };
    let texts: Vec<_> = tree.descendants().filter(is_text).collect();
    let width: f64 = root.attribute("width").unwrap().parse().unwrap();
    let boxes: Vec<_> = texts.iter().map(extent).collect();
    for (k, [left, top, right, bottom]) in boxes.iter().enumerate() {
        assert!(
            *left >= 0.0 && *right <= width + 1.0,
            "{:?} leaves {svg}",
            texts[k].text()
        );
        for (i, other) in boxes[..k].iter().enumerate() {
            let apart =
                other[0] >= *right || other[2] <= *left || other[1] >= *bottom || other[3] <= *top;
            assert!(apart, "{:?} on {:?}", texts[k].text(), texts[i].text());
        }
    }
    let text = |node: roxmltree::Node<'_, '_>| node.text().unwrap_or_default().to_string();
    texts.into_iter().map(text).collect()
}

/// Left, top, right and bottom of a text as a usual font sets it.
fn extent(node: &roxmltree::Node<'_, '_>) -> [f64; 4] {
    let number = |name| node.attribute(name).map(|x| x.parse::<f64>().unwrap());
    let (x, y) = (number("x").unwrap(), number("y").unwrap());
    let size = number("font-size").unwrap_or(SMALL.size);
    // Pages set figures in fonts narrower than the broadest.
    let width = 0.88 * text_width(node.text().unwrap_or_default()) * size / SMALL.size;
    let left = match node.attribute("text-anchor") {
        None => x,
        Some("middle") => x - width / 2.0,
        _ => x - width,
    };
    [left, y - 0.7 * size, left + width, y]
}

#[test]
fn elements_are_written_to_a_tenth_of_a_pixel() {
    let mut figure = Figure::new([40.0, 20.0], "a <label>");
    figure.line([[0.04, -0.04], [f64::NAN, 1.0], [1.26, 2.0]], BLUE, 1.5);
    figure.fill([[3.0, 4.0], [1.0, 2.5]], INK, 0.25);
    figure.dot([1.0, f64::NAN], 2.0, INK);
    figure.note([20.0, 5.0], Anchor::Middle, INK, "a\n&b");
    let svg = figure.finish();
    for part in [
        "aria-label=\"a &lt;label&gt;\"",
        "d=\"M0 0L1.3 2\"",
        "x=\"1\" y=\"2.5\" width=\"2\" height=\"1.5\" fill=\"currentColor\" fill-opacity=\"0.25\"",
        "y=\"9.2\" fill=\"currentColor\" text-anchor=\"middle\">a &amp;b</text>",
    ] {
        assert!(svg.contains(part), "{part} in {svg}");
    }
    assert!(!svg.contains("<circle"));
    sound(&svg);
}

#[test]
#[should_panic(expected = "Some(\"over\") on Some(\"under\")")]
fn texts_on_each_other_are_found() {
    let mut figure = Figure::new([100.0, 20.0], "label");
    figure.note([5.0, 10.0], Anchor::Start, INK, "under");
    figure.note([20.0, 14.0], Anchor::Start, INK, "over");
    sound(&figure.finish());
}
