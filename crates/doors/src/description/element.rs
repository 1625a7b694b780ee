//! Elements of XML, and their text.

use std::fmt::{Display, Write};

/// An element with its attributes and children in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
}

impl Element {
    pub(super) fn new(name: &'static str) -> Self {
        Self { name, ..Self::default() }
    }

    /// Adds an attribute.
    pub(super) fn with(mut self, name: &'static str, value: impl Display) -> Self {
        self.attributes.push((name, value.to_string()));
        self
    }

    /// Adds an attribute if it has a value.
    pub(super) fn maybe(self, name: &'static str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// Adds children.
    pub(super) fn children(mut self, children: impl IntoIterator<Item = Element>) -> Self {
        self.children.extend(children);
        self
    }

    /// The element as a document, each element on its own line.
    pub(super) fn document(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        self.write(&mut text, 0);
        text
    }

    fn write(&self, text: &mut String, depth: usize) {
        // Writing to a String cannot fail.
        let indent = 2 * depth;
        let _ = write!(text, "{:indent$}<{}", "", self.name);
        for (name, value) in &self.attributes {
            let _ = write!(text, " {name}=\"");
            value.chars().for_each(|c| escape(text, c));
            text.push('"');
        }
        if self.children.is_empty() {
            text.push_str("/>\n");
            return;
        }
        text.push_str(">\n");
        self.children.iter().for_each(|child| child.write(text, depth + 1));
        let _ = writeln!(text, "{:indent$}</{}>", "", self.name);
    }
}

/// Writes a character of an attribute's value. Characters with a meaning in XML, and white space
/// that XML would turn into blanks, are written by number or name. Characters that XML 1.0 does
/// not allow become a question mark.
fn escape(text: &mut String, c: char) {
    match c {
        '<' => text.push_str("&lt;"),
        '>' => text.push_str("&gt;"),
        '&' => text.push_str("&amp;"),
        '"' => text.push_str("&quot;"),
        '\t' | '\n' | '\r' => {
            let _ = write!(text, "&#{};", u32::from(c));
        }
        '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => text.push('?'),
        c => text.push(c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_an_element() {
        let inner = Element::new("B").with("x", "1 < 2 & \"3\"\n\u{1}").maybe("y", None::<f64>);
        let text = Element::new("A").with("n", 0.1).children([inner]).document();
        let head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
        let body = "<A n=\"0.1\">\n  <B x=\"1 &lt; 2 &amp; &quot;3&quot;&#10;?\"/>\n</A>\n";
        assert_eq!(text, format!("{head}{body}"));
    }
}
