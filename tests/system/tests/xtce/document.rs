//! An XML document as a tree: elements, attributes and text; whatever is not as written here panics.

use std::collections::BTreeMap;

/// An element.
#[derive(Debug, Default)]
pub struct Element {
    pub name: String,
    pub attributes: BTreeMap<String, String>,
    pub children: Vec<Element>,
    pub text: String,
}

impl Element {
    /// Reads a document.
    pub fn read(text: &str) -> Self {
        let mut rest = text.split_once("?>").expect("a declaration").1;
        let mut open = vec![Self::default()];
        while let Some((before, tag)) = rest.split_once('<') {
            let (tag, behind) = tag.split_once('>').expect("a tag ends");
            rest = behind;
            open.last_mut().unwrap().text += &plain(before.trim());
            if let Some(name) = tag.strip_prefix('/') {
                let closed = open.pop().unwrap();
                assert_eq!(closed.name, name);
                open.last_mut().unwrap().children.push(closed);
                continue;
            }
            let (tag, is_leaf) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
            let element = Self::of_tag(tag);
            if is_leaf {
                open.last_mut().unwrap().children.push(element);
            } else {
                open.push(element);
            }
        }
        assert_eq!(open.len(), 1, "all are closed");
        open.remove(0).children.remove(0)
    }

    fn of_tag(tag: &str) -> Self {
        let (name, mut rest) = tag.split_once(' ').unwrap_or((tag, ""));
        let mut attributes = BTreeMap::new();
        while let Some((key, value)) = rest.split_once("=\"") {
            let (value, behind) = value.split_once('"').expect("a value ends");
            attributes.insert(key.trim().to_owned(), plain(value));
            rest = behind;
        }
        Self { name: name.into(), attributes, ..Self::default() }
    }

    /// An attribute.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.attributes.get(key).map(String::as_str)
    }

    /// An attribute that must be there.
    pub fn at(&self, key: &str) -> &str {
        self.get(key).unwrap_or_else(|| panic!("{} has no {key}", self.name))
    }

    /// The first child of a name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// What lies on a path.
    pub fn on(&self, path: &[&str]) -> &Self {
        path.iter()
            .fold(self, |at, name| at.child(name).unwrap_or_else(|| panic!("{name} is not in {}", at.name)))
    }

    /// Children by their names.
    pub fn named(&self) -> BTreeMap<&str, &Self> {
        self.children.iter().map(|child| (child.at("name"), child)).collect()
    }
}

fn plain(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}
