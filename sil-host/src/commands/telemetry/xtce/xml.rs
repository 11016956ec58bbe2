//! XML written element by element.

use std::fmt::Write as _;

/// A document under way.
#[derive(Debug, Default)]
pub struct Xml {
    text: String,
    /// Elements that are open.
    open: Vec<&'static str>,
}

/// Attributes of an element, in their order.
pub type Attributes<'a> = &'a [(&'a str, &'a str)];

impl Xml {
    /// A document with its declaration.
    pub fn new() -> Self {
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".into(), open: Vec::new() }
    }

    fn begin(&mut self, name: &str, attributes: Attributes) {
        let _ = write!(self.text, "{:1$}<{name}", "", 2 * self.open.len());
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escaped(value));
        }
    }

    /// An element with what `content` writes into it.
    pub fn element(&mut self, name: &'static str, attributes: Attributes, content: impl FnOnce(&mut Self)) {
        self.begin(name, attributes);
        self.text += ">\n";
        self.open.push(name);
        content(self);
        self.open.pop();
        let _ = writeln!(self.text, "{:1$}</{name}>", "", 2 * self.open.len());
    }

    /// An element without content.
    pub fn leaf(&mut self, name: &str, attributes: Attributes) {
        self.begin(name, attributes);
        self.text += "/>\n";
    }

    /// An element with text.
    pub fn text(&mut self, name: &str, text: &str) {
        self.begin(name, &[]);
        let _ = writeln!(self.text, ">{}</{name}>", escaped(text));
    }

    /// The document.
    pub fn finish(self) -> String {
        self.text
    }
}

/// Text without the characters that XML reserves.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_indented_and_closed_and_reserved_characters_written_otherwise() {
        let mut xml = Xml::new();
        xml.element("A", &[("b", "1 < \"2\"")], |xml| {
            xml.leaf("C", &[]);
            xml.text("D", "e & f");
        });
        let expected = "<A b=\"1 &lt; &quot;2&quot;\">\n  <C/>\n  <D>e &amp; f</D>\n</A>\n";
        assert_eq!(xml.finish().split_once('\n').unwrap().1, expected);
    }
}
