//! Telecommands by an XTCE description alone.

use super::decoder::crc;
use super::document::Element;
use std::collections::BTreeMap;

/// Arguments by name; a vector's parts are named by their number, bytes are hexadecimal digits.
pub type Arguments = BTreeMap<String, String>;

/// Bits, the first one first.
#[derive(Default)]
struct Bits(Vec<bool>);

impl Bits {
    fn put(&mut self, value: u64, bits: u32) {
        self.0.extend((0..bits).rev().map(|bit| value >> bit & 1 == 1));
    }

    fn bytes(&self) -> Vec<u8> {
        assert_eq!(self.0.len() % 8, 0);
        let byte = |bits: &[bool]| bits.iter().fold(0, |byte, bit| byte << 1 | u8::from(*bit));
        self.0.chunks(8).map(byte).collect()
    }
}

/// The packet of a command.
pub fn encode(system: &Element, command: &str, given: &Arguments) -> Vec<u8> {
    let meta = system.on(&["CommandMetaData"]);
    let types = meta.on(&["ArgumentTypeSet"]).named();
    let commands = meta.on(&["MetaCommandSet"]).named();
    let own = commands[command];
    let base = own.on(&["BaseMetaCommand"]);
    let mut values = given.clone();
    for assigned in &base.on(&["ArgumentAssignmentList"]).children {
        values.insert(assigned.at("argumentName").into(), assigned.at("argumentValue").into());
    }
    let of_all = commands[base.at("metaCommandRef")];
    let arguments: BTreeMap<&str, &Element> = [of_all, own]
        .iter()
        .filter_map(|command| command.child("ArgumentList"))
        .flat_map(|list| list.named())
        .collect();
    let mut bits = Bits::default();
    for command in [of_all, own] {
        for entry in &command.on(&["CommandContainer", "EntryList"]).children {
            if entry.name == "FixedValueEntry" {
                let value = u64::from_str_radix(entry.at("binaryValue"), 16).unwrap();
                bits.put(value, entry.at("sizeInBits").parse().unwrap());
                continue;
            }
            assert_eq!(entry.name, "ArgumentRefEntry");
            let name = entry.at("argumentRef");
            let of = types[arguments[name].at("argumentTypeRef")];
            put(&mut bits, of, values.get(name).map(String::as_str));
        }
    }
    bits.bytes()
}

fn put(bits: &mut Bits, of: &Element, value: Option<&str>) {
    if let Some(check) = of.child("IntegerDataEncoding").and_then(|of| of.child("ErrorDetectCorrect")) {
        let value = crc(check.on(&["CRC"]), &bits.bytes());
        return bits.put(value, 16);
    }
    let value = value.expect("every argument is given or assigned");
    match of.name.as_str() {
        "BinaryArgumentType" => {
            let digits = value.as_bytes().chunks(2).map(|pair| std::str::from_utf8(pair).unwrap());
            digits.for_each(|digits| bits.put(u64::from_str_radix(digits, 16).unwrap(), 8));
        }
        "FloatArgumentType" => {
            assert_eq!(of.on(&["FloatDataEncoding"]).at("sizeInBits"), "64");
            bits.put(value.parse::<f64>().unwrap().to_bits(), 64);
        }
        _ => {
            let size = of.on(&["IntegerDataEncoding"]).at("sizeInBits").parse().unwrap();
            bits.put(value.parse::<i64>().unwrap().cast_unsigned(), size);
        }
    }
}
