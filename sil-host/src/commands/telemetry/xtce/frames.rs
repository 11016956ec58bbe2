//! The body of a telemetry frame in XTCE: types, parameters and containers, from the layout.
//!
//! A parameter is called by the names of the fields on the way to it, joined by hyphens. An option `x` is the
//! byte `x-present` and, where that is 1, `x`; a list `x` the byte `x-count` and the container `x` so many
//! times; a variant that holds something is followed by it, `x-VARIANT`, or `x-VARIANT-0` and so on. Counts
//! and numbers of variants are below 128, hence bytes.
//!
//! A whole number of seven bits a byte has no encoding in XTCE. Its bytes are described one by one,
//! `x-more-K` (a bit) and `x-bits-K` (seven bits, calibrated to their weight), each there where all before
//! say that more follow, and `x` is made of them by the standard's own operators, `bits-0 + more-0 (bits-1 +
//! more-1 (...))`: the byte that is not there is multiplied by 0.

use super::xml::Xml;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The container of a frame's body.
pub const BODY: &str = "Body";
/// The type of counts and of what says whether an option is there.
const BYTE: &str = "u8";

/// Parameters and the values that they must have, all of them, for an entry to be there.
type Condition = Vec<(String, String)>;

/// What is at a place of a container.
enum What {
    Parameter(String),
    Array(String),
    Container(String),
    /// A container as often as a parameter says.
    List(String, String),
}

/// A place of a container.
struct Entry {
    what: What,
    condition: Condition,
}

/// A parameter.
struct Parameter {
    name: String,
    kind: String,
    about: String,
    /// Whether an algorithm makes it.
    derived: bool,
}

/// A whole number made of groups of seven bits.
struct Groups {
    name: String,
    count: usize,
    signed: bool,
    /// The container in which it comes.
    container: String,
}

/// The description of a body.
pub struct Body<'a> {
    layout: &'a Value,
    /// Types of numbers: kind and unit by their name.
    numbers: BTreeMap<String, (&'a str, &'static str)>,
    /// Types of arrays: the elements' type and how many by their name.
    arrays: BTreeMap<String, (String, u64)>,
    enumerations: BTreeSet<&'a str>,
    parameters: Vec<Parameter>,
    containers: Vec<(String, Vec<Entry>)>,
    groups: Vec<Groups>,
}

/// The unit that the end of a field's name says; empty where there is none.
fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 8] = [
        ("km_s", "km/s"),
        ("rad_s", "rad/s"),
        ("rad", "rad"),
        ("km", "km"),
        ("deg", "deg"),
        ("px", "px"),
        ("us", "us"),
        ("s", "s"),
    ];
    let ends = |end: &str| name.strip_suffix(end).is_some_and(|rest| rest.is_empty() || rest.ends_with('_'));
    UNITS.iter().find(|(end, _)| ends(end)).map_or("", |(_, unit)| unit)
}

/// Groups of seven bits that a whole number of this kind has at most, and whether it has a sign.
fn groups(kind: &str) -> Option<(usize, bool)> {
    let bits: usize = kind.get(1..)?.parse().ok().filter(|bits| *bits > 8)?;
    match kind.get(..1)? {
        "u" => Some((bits.div_ceil(7), false)),
        "i" => Some((bits.div_ceil(7), true)),
        _ => None,
    }
}

impl<'a> Body<'a> {
    /// Of the layout's root.
    pub fn new(layout: &'a Value) -> Self {
        let mut body = Self {
            layout,
            numbers: BTreeMap::from([(BYTE.into(), (BYTE, ""))]),
            arrays: BTreeMap::new(),
            enumerations: BTreeSet::new(),
            parameters: Vec::new(),
            containers: Vec::new(),
            groups: Vec::new(),
        };
        let fields = body.fields("", body.described(layout["root"].as_str().unwrap_or_default()), BODY);
        body.containers.push((BODY.into(), fields));
        body
    }

    fn described(&self, name: &str) -> &'a Value {
        &self.layout["types"][name]
    }

    /// The entries of a compound's fields.
    fn fields(&mut self, path: &str, described: &'a Value, container: &str) -> Vec<Entry> {
        let mut entries = Vec::new();
        for field in described["fields"].as_array().into_iter().flatten() {
            let name = super::super::text(field, "name");
            let path = if path.is_empty() { name.into() } else { format!("{path}-{name}") };
            let about = super::super::text(field, "about");
            entries.extend(self.value(&path, &field["type"], about, container));
        }
        entries
    }

    /// The entries of a value.
    fn value(&mut self, path: &str, kind: &'a Value, about: &str, container: &str) -> Vec<Entry> {
        if let Some(inner) = kind.get("option") {
            let present = self.parameter(format!("{path}-present"), BYTE, "1: it follows; 0: there is none.");
            let condition = vec![(format!("{path}-present"), "1".into())];
            return vec![present, self.conditional(path, inner, about, condition)];
        }
        if let Some(inner) = kind.get("list") {
            let count = format!("{path}-count");
            let counted = self.parameter(count.clone(), BYTE, "How many follow.");
            let element = self.value(path, inner, about, path);
            // A compound has made its container itself.
            if !matches!(&element[..], [Entry { what: What::Container(_), .. }]) {
                self.containers.push((path.into(), element));
            }
            return vec![counted, Entry { what: What::List(path.into(), count), condition: Vec::new() }];
        }
        if let Some(array) = kind["array"].as_array() {
            let (of, count) = (array[0].as_str().unwrap_or_default(), array[1].as_u64().unwrap_or(0));
            let of = self.number(of, path);
            let name = format!("{of}-{count}");
            self.arrays.insert(name.clone(), (of, count));
            self.parameter(path.into(), &name, about);
            return vec![Entry { what: What::Array(path.into()), condition: Vec::new() }];
        }
        let kind = kind.as_str().unwrap_or_default();
        if let Some((count, signed)) = groups(kind) {
            return self.whole(path, (kind, count, signed), about, container);
        }
        let described = self.described(kind);
        if described.get("fields").is_some() {
            let fields = self.fields(path, described, path);
            self.containers.push((path.into(), fields));
            return vec![Entry { what: What::Container(path.into()), condition: Vec::new() }];
        }
        if described.get("variants").is_some() {
            return self.variants(path, (kind, described), about);
        }
        let of = self.number(kind, path);
        vec![self.parameter(path.into(), &of, about)]
    }

    /// The entry of a value that is there on a condition: where it is more than one entry, a container.
    fn conditional(&mut self, path: &str, kind: &'a Value, about: &str, condition: Condition) -> Entry {
        let mut entries = self.value(path, kind, about, path);
        if entries.len() == 1 && entries[0].condition.is_empty() {
            return Entry { condition, ..entries.remove(0) };
        }
        self.containers.push((path.into(), entries));
        Entry { what: What::Container(path.into()), condition }
    }

    /// An enumeration, and what its variants hold.
    fn variants(&mut self, path: &str, (kind, described): (&'a str, &'a Value), about: &str) -> Vec<Entry> {
        self.enumerations.insert(kind);
        let mut entries = vec![self.parameter(path.into(), kind, about)];
        for variant in described["variants"].as_array().into_iter().flatten() {
            let label = super::super::text(variant, "name");
            let held = variant["types"].as_array().map_or(&[][..], Vec::as_slice);
            for (number, of) in held.iter().enumerate() {
                let numbered = if held.len() > 1 { format!("-{number}") } else { String::new() };
                let condition = vec![(path.to_owned(), label.to_owned())];
                let about = format!("What {label} holds.");
                entries.push(self.conditional(&format!("{path}-{label}{numbered}"), of, &about, condition));
            }
        }
        entries
    }

    /// A whole number's bytes, and it itself.
    fn whole(
        &mut self,
        path: &str,
        (kind, count, signed): (&'a str, usize, bool),
        about: &str,
        container: &str,
    ) -> Vec<Entry> {
        let mut entries = Vec::new();
        for number in 0..count {
            let more = |number: usize| format!("{path}-more-{number}");
            let condition: Condition = (0..number).map(|before| (more(before), "1".into())).collect();
            let bits = format!("Bits {} to {} of {path}.", 7 * number, 7 * number + 6);
            for (name, kind, about) in [
                (more(number), "more".to_owned(), "1: another byte follows."),
                (format!("{path}-bits-{number}"), format!("bits-{number}"), &bits[..]),
            ] {
                let entry = self.parameter(name, &kind, about);
                entries.push(Entry { condition: condition.clone(), ..entry });
            }
        }
        let name = path.to_owned();
        let of = self.number(kind, path);
        self.parameters.push(Parameter { name, kind: of, about: about.into(), derived: true });
        self.groups.push(Groups { name: path.into(), count, signed, container: container.into() });
        entries
    }

    /// Takes a parameter in, and gives its place.
    fn parameter(&mut self, name: String, kind: &str, about: &str) -> Entry {
        let what = What::Parameter(name.clone());
        self.parameters.push(Parameter { name, kind: kind.into(), about: about.into(), derived: false });
        Entry { what, condition: Vec::new() }
    }

    /// The type of a number in the unit that its name says.
    fn number(&mut self, kind: &'a str, path: &str) -> String {
        let unit = unit(path.rsplit('-').next().unwrap_or_default());
        let name = match unit {
            "" => kind.to_owned(),
            unit => format!("{kind}-{}", unit.replace('/', "_")),
        };
        self.numbers.insert(name.clone(), (kind, unit));
        name
    }

    /// The types of the parameters.
    pub fn types(&self, xml: &mut Xml) {
        for (name, (kind, unit)) in &self.numbers {
            number_type(xml, name, kind, unit);
        }
        bits_type(xml, "more", 1, None);
        for number in 0..self.groups.iter().map(|groups| groups.count).max().unwrap_or(0) {
            bits_type(xml, &format!("bits-{number}"), 7, Some(128f64.powi(number as i32)));
        }
        for name in &self.enumerations {
            let variants = self.described(name)["variants"].as_array().into_iter().flatten();
            let variants =
                variants.map(|of| (super::super::text(of, "name"), super::super::text(of, "about")));
            let numbered = variants.enumerate().map(|(number, (name, about))| (number as u64, name, about));
            enumeration_type(xml, name, 8, numbered);
        }
        for (name, (of, count)) in &self.arrays {
            xml.element("ArrayParameterType", &[("name", name), ("arrayTypeRef", of)], |xml| {
                xml.element("DimensionList", &[], |xml| {
                    xml.element("Dimension", &[], |xml| {
                        xml.element("StartingIndex", &[], |xml| xml.text("FixedValue", "0"));
                        let last = count.saturating_sub(1).to_string();
                        xml.element("EndingIndex", &[], |xml| xml.text("FixedValue", &last));
                    });
                });
            });
        }
    }

    /// The parameters.
    pub fn parameters(&self, xml: &mut Xml) {
        for Parameter { name, kind, about, derived } in &self.parameters {
            let mut attributes = vec![("name", &name[..]), ("parameterTypeRef", &kind[..])];
            // An algorithm asks for it before the first one has come.
            if *kind == "more" || kind.starts_with("bits-") {
                attributes.push(("initialValue", "0"));
            }
            xml.element("Parameter", &attributes, |xml| {
                xml.text("LongDescription", about);
                let source = if *derived { "derived" } else { "telemetered" };
                xml.leaf("ParameterProperties", &[("dataSource", source)]);
            });
        }
    }

    /// The containers, each behind those that it holds.
    pub fn containers(&self, xml: &mut Xml) {
        for (name, entries) in &self.containers {
            xml.element("SequenceContainer", &[("name", name)], |xml| {
                xml.element("EntryList", &[], |xml| entries.iter().for_each(|entry| entry.write(xml)));
            });
        }
    }

    /// What makes whole numbers of their groups.
    pub fn algorithms(&self, xml: &mut Xml) {
        for groups in &self.groups {
            xml.element("MathAlgorithm", &[("name", &format!("{}-value", groups.name))], |xml| {
                xml.element("MathOperation", &[("outputParameterRef", &groups.name)], |xml| {
                    groups.operation(xml);
                    xml.element("TriggerSet", &[], |xml| {
                        xml.leaf("OnContainerUpdateTrigger", &[("containerRef", &groups.container)]);
                    });
                });
            });
        }
    }
}

impl Entry {
    fn write(&self, xml: &mut Xml) {
        let (element, attributes) = match &self.what {
            What::Parameter(name) => ("ParameterRefEntry", [("parameterRef", &name[..])]),
            What::Array(name) => ("ArrayParameterRefEntry", [("parameterRef", &name[..])]),
            What::Container(name) | What::List(name, _) => {
                ("ContainerRefEntry", [("containerRef", &name[..])])
            }
        };
        if self.condition.is_empty() && !matches!(self.what, What::List(..)) {
            return xml.leaf(element, &attributes);
        }
        xml.element(element, &attributes, |xml| {
            if let What::List(_, count) = &self.what {
                xml.element("RepeatEntry", &[], |xml| {
                    xml.element("Count", &[], |xml| {
                        xml.element("DynamicValue", &[], |xml| {
                            xml.leaf("ParameterInstanceRef", &[("parameterRef", count)]);
                        });
                    });
                });
            }
            if !self.condition.is_empty() {
                xml.element("IncludeCondition", &[], |xml| comparisons(xml, &self.condition));
            }
        });
    }
}

impl Groups {
    /// The value of the groups in postfix notation; of a signed number 2 n stands for n, 2 n + 1 for -n - 1.
    fn operation(&self, xml: &mut Xml) {
        let of = |part: &str, number: usize| format!("{}-{part}-{number}", self.name);
        let operator = |xml: &mut Xml, operators: &[&str]| {
            for operator in operators {
                match operator.parse::<u8>() {
                    Ok(_) => xml.text("ValueOperand", operator),
                    Err(_) => xml.text("Operator", operator),
                }
            }
        };
        for number in 0..self.count {
            xml.leaf("ParameterInstanceRefOperand", &[("parameterRef", &of("bits", number))]);
            if number + 1 < self.count {
                xml.leaf("ParameterInstanceRefOperand", &[("parameterRef", &of("more", number))]);
            }
        }
        for _ in 1..self.count {
            operator(xml, &["*", "+"]);
        }
        if self.signed {
            // Of u: its last bit l and the rest h; h - l (2 h + 1).
            operator(xml, &["dup", "2", "%", "swap", "over", "-", "2", "/", "swap", "over"]);
            operator(xml, &["2", "*", "1", "+", "*", "-"]);
        }
    }
}

/// Comparisons that must all hold.
pub fn comparisons(xml: &mut Xml, condition: &[(String, String)]) {
    let comparison = |xml: &mut Xml, (name, value): &(String, String)| {
        xml.leaf("Comparison", &[("parameterRef", name), ("value", value)]);
    };
    match condition {
        [one] => comparison(xml, one),
        several => {
            xml.element("ComparisonList", &[], |xml| several.iter().for_each(|one| comparison(xml, one)));
        }
    }
}

/// The type of a number: reals with the low byte first, bytes; a longer whole number is made by an algorithm
/// and has no encoding.
fn number_type(xml: &mut Xml, name: &str, kind: &str, unit: &str) {
    let units = |xml: &mut Xml| {
        if !unit.is_empty() {
            xml.element("UnitSet", &[], |xml| xml.text("Unit", unit));
        }
    };
    let bits = kind.get(1..).unwrap_or_default();
    let size = ("sizeInBits", bits);
    match kind {
        "bool" => xml.element("BooleanParameterType", &[("name", name)], |xml| {
            xml.leaf("IntegerDataEncoding", &[("sizeInBits", "8")]);
        }),
        "f32" | "f64" => xml.element("FloatParameterType", &[("name", name), size], |xml| {
            units(xml);
            xml.leaf("FloatDataEncoding", &[size, ("byteOrder", "leastSignificantByteFirst")]);
        }),
        _ => {
            let signed = if kind.starts_with('i') { "true" } else { "false" };
            xml.element("IntegerParameterType", &[("name", name), size, ("signed", signed)], |xml| {
                units(xml);
                if bits == "8" {
                    xml.leaf("IntegerDataEncoding", &[size]);
                }
            });
        }
    }
}

/// The type of an unsigned number of some bits, high byte first, calibrated by a factor where there is one.
pub fn bits_type(xml: &mut Xml, name: &str, bits: u32, factor: Option<f64>) {
    let attributes = [("name", name), ("sizeInBits", "64"), ("signed", "false")];
    xml.element("IntegerParameterType", &attributes, |xml| {
        let size = bits.to_string();
        let encoding = [("sizeInBits", &size[..])];
        let Some(factor) = factor else { return xml.leaf("IntegerDataEncoding", &encoding) };
        xml.element("IntegerDataEncoding", &encoding, |xml| {
            xml.element("DefaultCalibrator", &[], |xml| {
                xml.element("PolynomialCalibrator", &[], |xml| {
                    xml.leaf("Term", &[("exponent", "1"), ("coefficient", &factor.to_string())]);
                });
            });
        });
    });
}

/// The type of an enumeration of some bits: numbers, labels and what they mean.
pub fn enumeration_type<'t>(
    xml: &mut Xml,
    name: &str,
    bits: u32,
    values: impl Iterator<Item = (u64, &'t str, &'t str)>,
) {
    xml.element("EnumeratedParameterType", &[("name", name)], |xml| {
        xml.leaf("IntegerDataEncoding", &[("sizeInBits", &bits.to_string())]);
        xml.element("EnumerationList", &[], |xml| {
            for (value, label, about) in values {
                let value = value.to_string();
                let attributes = [("value", &value[..]), ("label", label), ("shortDescription", about)];
                xml.leaf("Enumeration", &attributes);
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::telemetry::{MAX_EVENTS, MAX_LIMB_POINTS, MAX_STARS};

    #[test]
    fn the_end_of_a_name_is_its_unit() {
        let names = ["sigma_velocity_km_s", "rad_s", "yaw_rad", "arc_deg", "age_s", "local_us", "limb_px"];
        assert_eq!(names.map(unit), ["km/s", "rad/s", "rad", "deg", "s", "us", "px"]);
        assert_eq!(["quaternion", "stars", "inliers", "focal_ratio", "class"].map(unit), [""; 5]);
    }

    #[test]
    fn counts_and_numbers_of_variants_are_bytes() {
        assert!(MAX_STARS.max(MAX_LIMB_POINTS).max(MAX_EVENTS) < 128);
        let layout = super::super::super::layout();
        for (name, described) in layout["types"].as_object().unwrap() {
            assert!(described["variants"].as_array().is_none_or(|variants| variants.len() < 128), "{name}");
        }
    }

    #[test]
    fn names_are_unique() {
        let layout = super::super::super::layout();
        let body = Body::new(&layout);
        let names: BTreeSet<&str> = body.parameters.iter().map(|of| &of.name[..]).collect();
        assert_eq!(names.len(), body.parameters.len());
        let containers: BTreeSet<&str> = body.containers.iter().map(|(name, _)| &name[..]).collect();
        assert_eq!(containers.len(), body.containers.len());
    }
}
