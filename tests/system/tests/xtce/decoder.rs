//! Bytes by an XTCE description alone: containers with conditions and repetitions, encodings, calibrators,
//! algorithms, checksums. Of the standard only what the description uses; anything else panics.
//!
//! As a ground system does, it keeps the last value of every parameter from one packet to the next.

use super::document::Element;
use std::collections::BTreeMap;

/// Values by parameter, in the order in which they came.
pub type Values = BTreeMap<String, Vec<String>>;

/// A value: as it is compared and counted with, and as it is shown.
#[derive(Clone, Debug)]
struct Sample {
    number: f64,
    shown: String,
}

/// A description, and what came last.
pub struct Decoder<'a> {
    types: BTreeMap<&'a str, &'a Element>,
    parameters: BTreeMap<&'a str, &'a Element>,
    containers: BTreeMap<&'a str, &'a Element>,
    algorithms: &'a [Element],
    last: BTreeMap<&'a str, Sample>,
}

/// A packet under way.
struct Reading<'a, 'b> {
    bytes: &'b [u8],
    bit: usize,
    /// Where the containers begin that are being read, bits.
    begins: Vec<usize>,
    values: BTreeMap<&'a str, Vec<String>>,
}

impl Reading<'_, '_> {
    fn take(&mut self, bits: usize) -> u64 {
        let value = (self.bit..self.bit + bits).fold(0, |value, bit| {
            let byte = self.bytes.get(bit / 8).expect("enough bytes");
            value << 1 | u64::from(byte >> (7 - bit % 8) & 1)
        });
        self.bit += bits;
        value
    }
}

impl<'a> Decoder<'a> {
    pub fn new(system: &'a Element) -> Self {
        let telemetry = system.on(&["TelemetryMetaData"]);
        let parameters = telemetry.on(&["ParameterSet"]).named();
        let initial = |(name, of): (&&'a str, &&'a Element)| {
            let number = of.get("initialValue")?.parse().ok()?;
            Some((*name, Sample { number, shown: String::new() }))
        };
        Self {
            types: telemetry.on(&["ParameterTypeSet"]).named(),
            last: parameters.iter().filter_map(initial).collect(),
            parameters,
            containers: telemetry.on(&["ContainerSet"]).named(),
            algorithms: &telemetry.on(&["AlgorithmSet"]).children,
        }
    }

    /// Reads a packet as a container or the kind of it that its values say; gives that container and all
    /// values.
    ///
    /// # Errors
    /// A checksum that does not match.
    pub fn decode(&mut self, container: &'a str, bytes: &[u8]) -> Result<(&'a str, Values), String> {
        let mut reading = Reading { bytes, bit: 0, begins: vec![0], values: BTreeMap::new() };
        let mut kind = container;
        self.container(container, &mut reading)?;
        while let Some(special) = self.special(kind) {
            kind = special;
            self.container(kind, &mut reading)?;
        }
        assert_eq!(reading.bit, 8 * bytes.len(), "{kind}: all bits are described");
        Ok((kind, reading.values.into_iter().map(|(name, values)| (name.to_owned(), values)).collect()))
    }

    /// The container whose base this is and whose values are there.
    fn special(&self, base: &str) -> Option<&'a str> {
        let is = |of: &&&'a Element| {
            of.child("BaseContainer").is_some_and(|of| {
                of.at("containerRef") == base && self.holds(of.on(&["RestrictionCriteria"]))
            })
        };
        self.containers.values().find(is).map(|of| of.at("name"))
    }

    fn container(&mut self, name: &str, reading: &mut Reading<'a, '_>) -> Result<(), String> {
        let container = *self.containers.get(name).unwrap_or_else(|| panic!("no container {name}"));
        // A kind of a container begins where that does.
        let begin = if container.child("BaseContainer").is_some() { 0 } else { reading.bit };
        reading.begins.push(begin);
        for entry in &container.on(&["EntryList"]).children {
            if entry.child("IncludeCondition").is_some_and(|condition| !self.holds(condition)) {
                continue;
            }
            let count = entry.child("RepeatEntry").map_or(1, |repeat| {
                let count = repeat.on(&["Count", "DynamicValue", "ParameterInstanceRef"]);
                self.last[count.at("parameterRef")].number as usize
            });
            for _ in 0..count {
                match entry.name.as_str() {
                    "ContainerRefEntry" => self.container(entry.at("containerRef"), reading)?,
                    "ParameterRefEntry" | "ArrayParameterRefEntry" => {
                        self.parameter(entry.at("parameterRef"), reading)?;
                    }
                    other => panic!("{other}"),
                }
            }
        }
        reading.begins.pop();
        for algorithm in self.algorithms {
            let operation = algorithm.on(&["MathOperation"]);
            let trigger = operation.on(&["TriggerSet", "OnContainerUpdateTrigger"]);
            if trigger.at("containerRef") == name {
                let number = self.result(operation);
                let sample = Sample { number, shown: (number as i64).to_string() };
                self.came(operation.at("outputParameterRef"), sample, reading);
            }
        }
        Ok(())
    }

    fn came(&mut self, name: &str, sample: Sample, reading: &mut Reading<'a, '_>) {
        let (name, _) = self.parameters.get_key_value(name).unwrap_or_else(|| panic!("no parameter {name}"));
        reading.values.entry(name).or_default().push(sample.shown.clone());
        self.last.insert(name, sample);
    }

    fn parameter(&mut self, name: &str, reading: &mut Reading<'a, '_>) -> Result<(), String> {
        let of = self.types[self.parameters[name].at("parameterTypeRef")];
        if of.name == "ArrayParameterType" {
            let last = &of.on(&["DimensionList", "Dimension", "EndingIndex", "FixedValue"]).text;
            for _ in 0..=last.parse::<usize>().unwrap() {
                let sample = self.sample(self.types[of.at("arrayTypeRef")], reading)?;
                self.came(name, sample, reading);
            }
            return Ok(());
        }
        let sample = self.sample(of, reading)?;
        self.came(name, sample, reading);
        Ok(())
    }

    fn sample(&self, of: &Element, reading: &mut Reading) -> Result<Sample, String> {
        if let Some(encoding) = of.child("BinaryDataEncoding") {
            let size = encoding.on(&["SizeInBits", "DynamicValue"]);
            let by = self.last[size.on(&["ParameterInstanceRef"]).at("parameterRef")].number;
            let adjusted = size.on(&["LinearAdjustment"]);
            let [slope, intercept] =
                ["slope", "intercept"].map(|key| adjusted.at(key).parse::<f64>().unwrap());
            let bytes = (slope * by + intercept) as usize / 8;
            let shown: String = (0..bytes).map(|_| format!("{:02x}", reading.take(8))).collect();
            return Ok(Sample { number: f64::NAN, shown });
        }
        let is_float = of.child("FloatDataEncoding").is_some();
        let encoding = of.child("FloatDataEncoding").unwrap_or_else(|| of.on(&["IntegerDataEncoding"]));
        let bits: usize = encoding.at("sizeInBits").parse().unwrap();
        let at = reading.bit / 8;
        let mut raw = reading.take(bits);
        if encoding.get("byteOrder") == Some("leastSignificantByteFirst") {
            raw = raw.swap_bytes() >> (64 - bits);
        }
        if let Some(check) = encoding.child("ErrorDetectCorrect") {
            let from = reading.begins.last().unwrap() / 8;
            let expected = crc(check.on(&["CRC"]), &reading.bytes[from..at]);
            if raw != expected {
                return Err(format!("checksum {raw:x} instead of {expected:x}"));
            }
        }
        if is_float {
            return Ok(match bits {
                32 => {
                    let value = f32::from_bits(raw as u32);
                    Sample { number: value.into(), shown: shortest(&serde_json::to_string(&value).unwrap()) }
                }
                _ => {
                    let value = f64::from_bits(raw);
                    Sample { number: value, shown: shortest(&serde_json::to_string(&value).unwrap()) }
                }
            });
        }
        Ok(match of.name.as_str() {
            "EnumeratedParameterType" => {
                let value = |of: &&Element| of.at("value").parse::<u64>().unwrap() == raw;
                let label = of.on(&["EnumerationList"]).children.iter().find(value).expect("a label");
                Sample { number: f64::NAN, shown: label.at("label").to_owned() }
            }
            "BooleanParameterType" => Sample { number: raw as f64, shown: (raw == 1).to_string() },
            _ => {
                let calibrated = |by: &Element| {
                    let term = by.on(&["PolynomialCalibrator", "Term"]);
                    assert_eq!(term.at("exponent"), "1");
                    term.at("coefficient").parse::<f64>().unwrap() * raw as f64
                };
                let number = encoding.child("DefaultCalibrator").map_or(raw as f64, calibrated);
                Sample { number, shown: number.to_string() }
            }
        })
    }

    /// Whether all comparisons hold for what came last.
    fn holds(&self, criteria: &Element) -> bool {
        let all = criteria.child("ComparisonList").unwrap_or(criteria);
        all.children.iter().all(|comparison| {
            assert_eq!(comparison.name, "Comparison");
            let (name, value) = (comparison.at("parameterRef"), comparison.at("value"));
            let last = self.last.get(name).unwrap_or_else(|| panic!("{name} has never come"));
            last.shown == value || value.parse::<f64>().is_ok_and(|value| value == last.number)
        })
    }

    /// The result of an operation in postfix notation.
    fn result(&self, operation: &Element) -> f64 {
        let mut stack: Vec<f64> = Vec::new();
        for part in &operation.children {
            match (part.name.as_str(), part.text.as_str()) {
                ("ParameterInstanceRefOperand", _) => stack.push(self.last[part.at("parameterRef")].number),
                ("ValueOperand", value) => stack.push(value.parse().unwrap()),
                ("Operator", operator) => operate(&mut stack, operator),
                ("TriggerSet", _) => {}
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(stack.len(), 1);
        stack[0]
    }
}

/// The decimals of a number as a reader of JSON writes them again.
fn shortest(number: &str) -> String {
    serde_json::from_str::<serde_json::Value>(number).unwrap().to_string()
}

fn operate(stack: &mut Vec<f64>, operator: &str) {
    let b = stack.pop().unwrap();
    if operator == "dup" {
        return stack.extend([b, b]);
    }
    let a = stack.pop().unwrap();
    match operator {
        "+" => stack.push(a + b),
        "-" => stack.push(a - b),
        "*" => stack.push(a * b),
        "/" => stack.push(a / b),
        "%" => stack.push(a % b),
        "swap" => stack.extend([b, a]),
        "over" => stack.extend([a, b, a]),
        other => panic!("{other}"),
    }
}

/// A cyclic redundancy check as an element describes it, bit by bit.
pub fn crc(of: &Element, bytes: &[u8]) -> u64 {
    let width: u32 = of.at("width").parse().unwrap();
    let hex = |name: &str| u64::from_str_radix(&of.on(&[name]).text, 16).unwrap();
    let reflected = of.at("reflectData") == "true";
    assert_eq!(of.at("reflectRemainder"), of.at("reflectData"));
    let mut remainder = hex("InitRemainder");
    for byte in bytes {
        let byte = if reflected { byte.reverse_bits() } else { *byte };
        for bit in (0..8).rev() {
            let out = remainder >> (width - 1) & 1 ^ u64::from(byte >> bit & 1);
            remainder = (remainder << 1 & ((1 << width) - 1)) ^ (out * hex("Polynomial"));
        }
    }
    if reflected {
        remainder = remainder.reverse_bits() >> (64 - width);
    }
    remainder ^ hex("FinalXOR")
}
