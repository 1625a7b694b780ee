//! XML as a tree of elements, for reading model descriptions.

use crate::error::{Error, Result};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;

/// An element. Text between elements is left out: descriptions do not have any.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// Its attributes by their names.
    pub attributes: BTreeMap<String, String>,
    /// Its child elements, in their order.
    pub children: Vec<Element>,
}

impl Element {
    /// The root element of a document.
    ///
    /// # Errors
    /// [`Error::Xml`] if the text is not an XML document.
    pub fn parse(text: &str) -> Result<Self> {
        let mut reader = Reader::from_str(text);
        // Stack of open elements, the root's parent first.
        let mut open = vec![Self::default()];
        loop {
            let ended = match reader.read_event().map_err(problem)? {
                Event::Start(start) => {
                    open.push(Self::begun(&start)?);
                    None
                }
                Event::Empty(whole) => Some(Self::begun(&whole)?),
                Event::End(_) => open.pop(),
                Event::Eof => break,
                _ => None,
            };
            if let (Some(element), Some(parent)) = (ended, open.last_mut()) {
                parent.children.push(element);
            }
        }
        let root = open.swap_remove(0).children.pop();
        root.filter(|_| open.is_empty()).ok_or_else(|| problem("no root element that ends"))
    }

    fn begun(start: &BytesStart<'_>) -> Result<Self> {
        let mut attributes = BTreeMap::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(problem)?;
            let value = attribute.normalized_value(quick_xml::XmlVersion::Explicit1_0).map_err(problem)?;
            attributes.insert(attribute.key.as_ref().to_owned(), value.into_owned());
        }
        Ok(Self { name: start.name().as_ref().to_owned(), attributes, children: Vec::new() })
    }

    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.get(name).map(String::as_str)
    }

    /// Its child elements with a name.
    pub fn all<'a>(&'a self, name: &str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The children of the first child with a name; empty without such a child.
    pub fn within(&self, name: &str) -> &[Self] {
        self.children.iter().find(|child| child.name == name).map_or(&[], |list| &list.children)
    }
}

fn problem(problem: impl ToString) -> Error {
    Error::Xml(problem.to_string())
}
