//! A drawing for a page, made a file of its own.
//!
//! In: SVG whose elements have the classes of `RULES`. Out: the same with what these say as attributes, in
//! the light colours of the page, which every viewer draws; a browser in dark mode takes the dark ones from a
//! style element.

use super::page::PALETTE;

/// What elements look like: an element's name, or classes that it must all have, each led by a dot;
/// properties with a value or, led by `--`, a colour of the page. Of two rules for an element the later one
/// counts.
const RULES: [(&str, &[(&str, &str)]); 25] = [
    // DejaVu Sans: viewers that know neither of the general names.
    (
        "text",
        &[("font-family", "system-ui, 'DejaVu Sans', sans-serif"), ("font-size", "12"), ("fill", "--ink")],
    ),
    (".tick", &[("fill", "--soft")]),
    (".name", &[("font-size", "14"), ("font-weight", "600")]),
    (".paper", &[("fill", "--card")]),
    (".ground", &[("fill", "none"), ("stroke", "--rule")]),
    (".grid", &[("fill", "none"), ("stroke", "--grid")]),
    (".box", &[("fill", "--card"), ("stroke", "--line")]),
    (".arrow", &[("fill", "none"), ("stroke", "--soft")]),
    (".head", &[("fill", "--soft")]),
    (".curve", &[("stroke-width", "1.8"), ("stroke-linejoin", "round")]),
    (".others.t0", &[("stroke-dasharray", "7 4")]),
    (".others.t1", &[("stroke-dasharray", "2 3")]),
    (".others.t2", &[("stroke-dasharray", "12 3 2 3")]),
    (".flown", &[("fill", "--line")]),
    (".expected", &[("fill", "--pale")]),
    (".c0", &[("fill", "--line"), ("stroke", "--line")]),
    (".c1", &[("fill", "--good"), ("stroke", "--good")]),
    (".c2", &[("fill", "--restart"), ("stroke", "--restart")]),
    (".c3", &[("fill", "--bad"), ("stroke", "--bad")]),
    (".c4", &[("fill", "--soft"), ("stroke", "--soft")]),
    (".c5", &[("fill", "--way-dark"), ("stroke", "--way-dark")]),
    (".c6", &[("fill", "--way-sun"), ("stroke", "--way-sun")]),
    (".thesis", &[("fill", "--level"), ("stroke", "--level")]),
    (".curve", &[("fill", "none")]),
    (".area", &[("stroke", "none"), ("opacity", ".16")]),
];

/// The value of a property: itself, or the page's colour of this name, light or dark.
fn value(value: &str, dark: bool) -> &str {
    let (light_ones, dark_ones) = PALETTE.split_once("@media").unwrap_or((PALETTE, ""));
    let colours = if dark { dark_ones } else { light_ones };
    let found = value.strip_prefix("--").and_then(|_| colours.split_once(&format!("{value}: ")));
    found.and_then(|(_, rest)| rest.split(';').next()).unwrap_or(value)
}

/// Whether a rule is for an element of this name with these classes.
fn applies(selector: &str, name: &str, classes: &[&str]) -> bool {
    match selector.strip_prefix('.') {
        Some(needed) => needed.split('.').all(|class| classes.contains(&class)),
        None => selector == name,
    }
}

/// A property with its value as attributes; a colour with an alpha is a colour and an opacity, which older
/// viewers know too.
fn attribute(property: &str, value: &str) -> String {
    let parts = value.strip_prefix("rgba(").and_then(|rest| rest.strip_suffix(')')?.rsplit_once(','));
    match parts {
        Some((colour, alpha)) => {
            format!(" {property}=\"rgb({colour})\" {property}-opacity=\"{}\"", alpha.trim())
        }
        None => format!(" {property}=\"{value}\""),
    }
}

/// The attributes of an element.
fn attributes(name: &str, classes: &[&str]) -> String {
    let mut properties: Vec<(&str, &str)> = Vec::new();
    let rules = RULES.iter().filter(|(selector, _)| applies(selector, name, classes));
    for (property, set) in rules.flat_map(|(_, properties)| properties.iter()) {
        properties.retain(|(before, _)| before != property);
        properties.push((property, set));
    }
    properties.into_iter().map(|(property, set)| attribute(property, value(set, false))).collect()
}

/// The rules of dark mode: all that set a colour, so that their order is that of the attributes.
fn dark() -> String {
    let rule = |(selector, properties): &(&str, &[(&str, &str)])| {
        let colours = properties.iter().filter(|(property, _)| ["fill", "stroke"].contains(property));
        let set: Vec<String> =
            colours.map(|(property, set)| format!("{property}: {}", value(set, true))).collect();
        if set.is_empty() { String::new() } else { format!(" {selector} {{ {} }}", set.join("; ")) }
    };
    format!("@media (prefers-color-scheme: dark) {{{} }}", RULES.iter().map(rule).collect::<String>())
}

/// A drawing for a page, made a file of its own.
pub fn standing_alone(svg: &str) -> String {
    let head = "<svg xmlns=\"http://www.w3.org/2000/svg\" ";
    let ground = format!("><style>{}</style><rect class=\"paper\" width=\"100%\" height=\"100%\"/>", dark());
    let svg = svg.replacen("<svg ", head, 1).replacen('>', &ground, 1);
    let mut alone = String::new();
    for (number, tag) in svg.split('<').enumerate() {
        let (name, rest) = tag.split_at(tag.find([' ', '>', '/']).unwrap_or(tag.len()));
        let within = rest.split('>').next().unwrap_or(rest);
        let classes = within.split_once(" class=\"").and_then(|(_, classes)| classes.split('"').next());
        let classes: Vec<&str> = classes.unwrap_or_default().split(' ').collect();
        if number > 0 {
            alone.push('<');
        }
        alone.extend([name, &attributes(name, &classes), rest]);
    }
    alone
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_colours_are_attributes_and_dark_ones_an_override() {
        let svg = "<svg viewBox=\"0 0 9 9\"><path class=\"curve others thesis t1\" d=\"M0 0\"/><text x=\"1\">a</text>\
                   <rect class=\"expected\"/><circle class=\"c3\"/></svg>";
        let alone = standing_alone(svg);
        for words in [
            "<path stroke-width=\"1.8\" stroke-linejoin=\"round\" stroke-dasharray=\"2 3\" stroke=\"#b4631a\" fill=\"none\" class=",
            "<text font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"12\" fill=\"#1d2430\" x=\"1\">a</text>",
            "<rect fill=\"rgb(31, 95, 168)\" fill-opacity=\".18\" class=\"expected\"/>",
            "<circle fill=\"#c22f2f\" stroke=\"#c22f2f\" class=\"c3\"/>",
            "<rect fill=\"#ffffff\" class=\"paper\"",
            ".c3 { fill: #f07a72; stroke: #f07a72 }",
        ] {
            assert!(alone.contains(words), "{words}: {alone}");
        }
        assert!(!alone.contains("--"), "a variable is left: {alone}");
    }
}
