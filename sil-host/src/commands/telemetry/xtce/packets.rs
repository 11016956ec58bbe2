//! Space packets in XTCE: the primary header (CCSDS 133.0-B-2), the command link's reports and telecommands
//! with the secondary headers of ECSS-E-ST-70-41C, all big-endian, and the checksums.
//!
//! A telecommand is described without the counter and the tag that stand before its checksum where the link
//! has a key.

use super::frames::{bits_type, comparisons, enumeration_type};
use super::xml::Xml;
use fsw_core::command::refusal;
use fsw_core::command::telecommand::{Field, ROWS, Row, VERSION};

/// The container of the primary header.
pub const PACKET: &str = "SpacePacket";
/// The container of a report's headers.
const REPORT: &str = "LinkReport";
/// The command that all have in common.
const COMMAND: &str = "Telecommand";
/// Type of a checksum of packets.
const CHECKSUM: &str = "crc16";

/// A parameter of so many bits: name, bits, meaning.
type Part = (&'static str, u32, &'static str);

const PRIMARY: [Part; 7] = [
    ("ccsds-version", 3, "Version of the packet: 0."),
    ("ccsds-type", 1, "0: telemetry, 1: telecommand."),
    ("ccsds-secondary_header", 1, "Whether there is a secondary header."),
    ("ccsds-apid", 11, "Application of the packet: the sensor's, or the spacecraft's own."),
    ("ccsds-sequence_flags", 2, "3: unsegmented."),
    ("ccsds-sequence_count", 14, "Count of the packets of this application."),
    ("ccsds-length", 16, "Bytes behind the primary header, less one."),
];

const SECONDARY: [Part; 8] = [
    ("report-pus_version", 4, "Version of the secondary header: 2."),
    ("report-time_status", 4, "State of the time's reference: 0."),
    ("report-service", 8, "Service."),
    ("report-subservice", 8, "Subservice."),
    ("report-count", 16, "Count of the reports of this kind."),
    ("report-destination", 16, "Destination: 0."),
    ("report-seconds", 32, "Whole seconds since the on-board counter began."),
    ("report-fraction", 24, "Fraction of the second."),
];

const REQUEST: [Part; 7] = [
    ("request-version", 3, "Of the telecommand that is meant: its version."),
    ("request-type", 1, "Its type."),
    ("request-secondary_header", 1, "Whether it has a secondary header."),
    ("request-apid", 11, "Its application."),
    ("request-sequence_flags", 2, "Its sequence flags."),
    ("request-sequence_count", 14, "Its sequence count."),
    ("request-reason", 16, "Why it is refused."),
];

/// What is sent down in parts: what stands before the bytes of a part; the name of the bytes, their type and
/// meaning.
struct SentDown {
    head: [Part; 2],
    bytes: &'static str,
    kind: &'static str,
    about: &'static str,
}

const TABLE: SentDown = SentDown {
    head: [
        ("table-offset", 16, "Where in the table the part begins, bytes."),
        ("table-length", 16, "Bytes of the table."),
    ],
    bytes: "table-bytes",
    kind: "table",
    about: "The part.",
};

const EVENTS: SentDown = SentDown {
    head: [
        ("events-first", 32, "Number of the first event of this part, counted from the start of the link."),
        ("events-left", 16, "Events that the log holds from that one on."),
    ],
    bytes: "events-bytes",
    kind: "events",
    about: "The events.",
};

const SPOTS: SentDown = SentDown {
    head: [
        ("spots-image", 64, "Local time of the image in which they were found, us."),
        ("spots-left", 16, "Spots that are left from the first of this part on."),
    ],
    bytes: "spots-bytes",
    kind: "spots",
    about: "The spots.",
};

const SENT_DOWN: [&SentDown; 3] = [&TABLE, &EVENTS, &SPOTS];

impl SentDown {
    /// Of the packet's length what is not the bytes: secondary header, head and checksum.
    fn bytes_less(&self) -> i32 {
        let head_bits: u32 = self.head.iter().map(|(_, bits, _)| bits).sum();
        14 + head_bits as i32 / 8 + 2 - 1
    }
}

/// What a report says.
#[derive(Clone, Copy)]
enum Says {
    /// Which telecommand is meant.
    Request,
    /// That, and the reason.
    Refusal,
    /// A part of what is sent down.
    Part(&'static SentDown),
}

/// The reports: container, service, subservice, content, meaning.
const REPORTS: [(&str, u8, u8, Says, &str); 7] = [
    ("Accepted", 1, 1, Says::Request, "A telecommand was accepted."),
    ("NotAccepted", 1, 2, Says::Refusal, "A telecommand was refused when it arrived."),
    ("Completed", 1, 7, Says::Request, "A telecommand was done."),
    ("NotCompleted", 1, 8, Says::Refusal, "A telecommand was refused when it was to be done."),
    ("TablePart", 129, 4, Says::Part(&TABLE), "A part of the parameter table in force."),
    (
        "EventsPart",
        130,
        2,
        Says::Part(&EVENTS),
        "A part of the log of events: of each its second (u32) and its three bytes.",
    ),
    ("SpotsPart", 130, 4, Says::Part(&SPOTS), "Some of the spots that were found last."),
];

/// Of the length of a telecommand with a part of a table what is not its bytes: secondary header, version of
/// the list, area, offset, checksum.
const UP_BYTES_LESS: i32 = 5 + 1 + 1 + 4 + 2 - 1;

fn all_parts() -> impl Iterator<Item = &'static Part> {
    let heads = SENT_DOWN.into_iter().flat_map(|sent| &sent.head);
    PRIMARY.iter().chain(&SECONDARY).chain(&REQUEST).chain(heads)
}

/// The type of a part.
fn type_of((name, bits, _): &Part) -> String {
    match *name {
        "request-reason" => "reason".into(),
        "report-fraction" => "fraction".into(),
        _ => format!("bits{bits}"),
    }
}

/// The types of the packets' parameters.
pub fn types(xml: &mut Xml) {
    let mut sizes: Vec<u32> = all_parts().map(|(_, bits, _)| *bits).filter(|bits| *bits != 24).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes.iter().for_each(|bits| bits_type(xml, &format!("bits{bits}"), *bits, None));
    xml.element("FloatParameterType", &[("name", "fraction"), ("sizeInBits", "64")], |xml| {
        xml.element("UnitSet", &[], |xml| xml.text("Unit", "s"));
        xml.element("IntegerDataEncoding", &[("sizeInBits", "24")], |xml| {
            xml.element("DefaultCalibrator", &[], |xml| {
                xml.element("PolynomialCalibrator", &[], |xml| {
                    let share = 0.5f64.powi(24).to_string();
                    xml.leaf("Term", &[("exponent", "1"), ("coefficient", &share)]);
                });
            });
        });
    });
    let names: Vec<String> = refusal::ALL.iter().map(|reason| format!("{reason:?}")).collect();
    let reasons = refusal::ALL.iter().zip(&names);
    let reasons = reasons.map(|(reason, name)| (reason.code().into(), &name[..], reason.words()));
    enumeration_type(xml, "reason", 16, reasons);
    for sent in SENT_DOWN {
        xml.element("BinaryParameterType", &[("name", sent.kind)], |xml| {
            xml.element("BinaryDataEncoding", &[], |xml| rest_of_packet(xml, sent.bytes_less()));
        });
    }
    checksum_type(xml, "IntegerParameterType");
}

/// As many bits as the packet has bytes, its length field less some.
fn rest_of_packet(xml: &mut Xml, less: i32) {
    xml.element("SizeInBits", &[], |xml| {
        xml.element("DynamicValue", &[], |xml| {
            xml.leaf("ParameterInstanceRef", &[("parameterRef", "ccsds-length")]);
            xml.leaf("LinearAdjustment", &[("slope", "8"), ("intercept", &(-8 * less).to_string())]);
        });
    });
}

/// CRC-16 (CCITT, all ones at first) of all before, from the beginning of the packet.
fn checksum_type(xml: &mut Xml, element: &'static str) {
    let attributes = [("name", CHECKSUM), ("sizeInBits", "16"), ("signed", "false")];
    xml.element(element, &attributes, |xml| {
        xml.element("IntegerDataEncoding", &[("sizeInBits", "16")], |xml| {
            crc(xml, ("16", "1021", "FFFF", "0000"), "false");
        });
    });
}

/// A cyclic redundancy check: width, polynomial, first remainder and final exclusive or in hexadecimal
/// digits; whether bits are reflected.
pub fn crc(xml: &mut Xml, (width, polynomial, first, last): (&str, &str, &str, &str), reflected: &str) {
    xml.element("ErrorDetectCorrect", &[], |xml| {
        let attributes = [
            ("width", width),
            ("reflectData", reflected),
            ("reflectRemainder", reflected),
            ("bitsFromReference", "0"),
            ("reference", "start"),
        ];
        xml.element("CRC", &attributes, |xml| {
            xml.text("Polynomial", polynomial);
            xml.text("InitRemainder", first);
            xml.text("FinalXOR", last);
        });
    });
}

/// A parameter: its name, its type, what it means.
pub fn parameter(xml: &mut Xml, name: &str, kind: &str, about: &str) {
    xml.element("Parameter", &[("name", name), ("parameterTypeRef", kind)], |xml| {
        xml.text("LongDescription", about);
    });
}

/// The packets' parameters.
pub fn parameters(xml: &mut Xml) {
    all_parts().for_each(|part| parameter(xml, part.0, &type_of(part), part.2));
    SENT_DOWN.iter().for_each(|sent| parameter(xml, sent.bytes, sent.kind, sent.about));
    parameter(xml, "packet-checksum", CHECKSUM, "CRC-16 (CCITT, all ones at first) of all before.");
}

fn entries(xml: &mut Xml, names: &[&str]) {
    names.iter().for_each(|name| xml.leaf("ParameterRefEntry", &[("parameterRef", name)]));
}

/// What a container is a kind of, and by which values it is known.
pub fn base(xml: &mut Xml, of: &str, values: &[(&str, u8)]) {
    let values: Vec<(String, String)> =
        values.iter().map(|(name, value)| ((*name).into(), value.to_string())).collect();
    xml.element("BaseContainer", &[("containerRef", of)], |xml| {
        xml.element("RestrictionCriteria", &[], |xml| comparisons(xml, &values));
    });
}

/// The primary header, and the reports of the command link.
pub fn containers(xml: &mut Xml) {
    let names = |parts: &[Part]| parts.iter().map(|(name, ..)| *name).collect::<Vec<_>>();
    xml.element("SequenceContainer", &[("name", PACKET), ("abstract", "true")], |xml| {
        xml.text("LongDescription", "A space packet (CCSDS 133.0-B-2).");
        xml.element("EntryList", &[], |xml| entries(xml, &names(&PRIMARY)));
    });
    xml.element("SequenceContainer", &[("name", REPORT), ("abstract", "true")], |xml| {
        xml.text("LongDescription", "A report of the command link (ECSS-E-ST-70-41C).");
        xml.element("EntryList", &[], |xml| entries(xml, &names(&SECONDARY)));
        base(xml, PACKET, &[("ccsds-type", 0), ("ccsds-secondary_header", 1)]);
    });
    for (name, service, subservice, says, about) in REPORTS {
        xml.element("SequenceContainer", &[("name", name)], |xml| {
            xml.text("LongDescription", about);
            xml.element("EntryList", &[], |xml| {
                match says {
                    Says::Request => entries(xml, &names(&REQUEST[..6])),
                    Says::Refusal => entries(xml, &names(&REQUEST)),
                    Says::Part(sent) => entries(xml, &[&names(&sent.head)[..], &[sent.bytes]].concat()),
                }
                entries(xml, &["packet-checksum"]);
            });
            base(xml, REPORT, &[("report-service", service), ("report-subservice", subservice)]);
        });
    }
}

/// Number and type of a field: `3 f64` are three.
fn parts(kind: &'static str) -> (usize, &'static str) {
    kind.split_once(' ').and_then(|(count, kind)| Some((count.parse().ok()?, kind))).unwrap_or((1, kind))
}

/// Bytes of a field; none of one that takes the rest of the packet.
fn bytes(field: &Field) -> Option<usize> {
    let (count, kind) = parts(field.kind);
    Some(count * kind.get(1..)?.parse::<usize>().ok()? / 8)
}

/// Names of a field's arguments.
fn arguments(field: &Field) -> Vec<(String, &'static str)> {
    match parts(field.kind) {
        (1, kind) => vec![(field.name.into(), kind)],
        (count, kind) => (0..count).map(|number| (format!("{}-{number}", field.name), kind)).collect(),
    }
}

/// Arguments of the headers: name, bits, meaning.
const HEADER_ARGUMENTS: [Part; 7] = [
    ("apid", 11, "APID of the sensor."),
    ("sequence_count", 14, "One more than that of the last packet."),
    ("packet_length", 16, "Bytes behind the primary header, less one."),
    ("acknowledge", 4, "Reports that are wanted: 1 of completion, 8 of acceptance."),
    ("service", 8, "Service."),
    ("subservice", 8, "Subservice."),
    ("source", 16, "Source."),
];

/// The telecommands.
pub fn commands(xml: &mut Xml) {
    xml.element("CommandMetaData", &[], |xml| {
        xml.element("ArgumentTypeSet", &[], argument_types);
        xml.element("MetaCommandSet", &[], |xml| {
            header_command(xml);
            ROWS.iter().for_each(|row| command(xml, row));
        });
    });
}

fn argument_types(xml: &mut Xml) {
    let integer = |xml: &mut Xml, name: &str, bits: &str, signed: bool| {
        let size = ("sizeInBits", bits);
        let attributes = [("name", name), size, ("signed", if signed { "true" } else { "false" })];
        xml.element("IntegerArgumentType", &attributes, |xml| {
            let encoding = if signed { "twosComplement" } else { "unsigned" };
            xml.leaf("IntegerDataEncoding", &[size, ("encoding", encoding)]);
        });
    };
    let mut sizes: Vec<u32> = HEADER_ARGUMENTS.iter().map(|(_, bits, _)| *bits).collect();
    sizes.sort_unstable();
    sizes.dedup();
    sizes.iter().for_each(|bits| integer(xml, &format!("bits{bits}"), &bits.to_string(), false));
    let mut kinds: Vec<&str> =
        ROWS.iter().flat_map(|row| row.fields).map(|field| parts(field.kind).1).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        match kind.split_at(1) {
            ("b", _) => xml.element("BinaryArgumentType", &[("name", kind)], |xml| {
                xml.element("BinaryDataEncoding", &[], |xml| {
                    xml.element("SizeInBits", &[], |xml| {
                        xml.element("DynamicValue", &[], |xml| {
                            xml.leaf("ArgumentInstanceRef", &[("argumentRef", "packet_length")]);
                            let intercept = (-8 * UP_BYTES_LESS).to_string();
                            xml.leaf("LinearAdjustment", &[("slope", "8"), ("intercept", &intercept)]);
                        });
                    });
                });
            }),
            ("f", bits) => {
                xml.element("FloatArgumentType", &[("name", kind), ("sizeInBits", bits)], |xml| {
                    xml.leaf("FloatDataEncoding", &[("sizeInBits", bits)]);
                });
            }
            (sign, bits) => integer(xml, kind, bits, sign == "i"),
        }
    }
    checksum_type(xml, "IntegerArgumentType");
}

/// Headers, version of the list, and what every telecommand's arguments are.
fn header_command(xml: &mut Xml) {
    xml.element("MetaCommand", &[("name", COMMAND), ("abstract", "true")], |xml| {
        let about = "Without a key: where the link has one, counter and tag stand before the checksum.";
        xml.text("LongDescription", about);
        xml.element("ArgumentList", &[], |xml| {
            for (name, bits, about) in HEADER_ARGUMENTS {
                argument(xml, (name, &format!("bits{bits}")), about);
            }
            argument(xml, ("checksum", CHECKSUM), "CRC-16 (CCITT, all ones at first) of all before.");
        });
        xml.element("CommandContainer", &[("name", COMMAND)], |xml| {
            xml.element("EntryList", &[], |xml| {
                // Version 0, telecommand, with a secondary header.
                fixed(xml, 3, 5);
                argument_entries(xml, &["apid"]);
                // Unsegmented.
                fixed(xml, 3, 2);
                argument_entries(xml, &["sequence_count", "packet_length"]);
                // Version of the secondary header.
                fixed(xml, 2, 4);
                argument_entries(xml, &["acknowledge", "service", "subservice", "source"]);
                fixed(xml, VERSION, 8);
            });
        });
    });
}

fn argument(xml: &mut Xml, (name, kind): (&str, &str), about: &str) {
    xml.element("Argument", &[("name", name), ("argumentTypeRef", kind)], |xml| {
        xml.text("LongDescription", about);
    });
}

fn argument_entries(xml: &mut Xml, names: &[&str]) {
    names.iter().for_each(|name| xml.leaf("ArgumentRefEntry", &[("argumentRef", name)]));
}

/// The last bits of a byte.
fn fixed(xml: &mut Xml, value: u8, bits: u32) {
    let value = format!("{value:02X}");
    xml.leaf("FixedValueEntry", &[("binaryValue", &value), ("sizeInBits", &bits.to_string())]);
}

fn command(xml: &mut Xml, row: &Row) {
    xml.element("MetaCommand", &[("name", row.name)], |xml| {
        xml.text("LongDescription", row.about);
        xml.element("BaseMetaCommand", &[("metaCommandRef", COMMAND)], |xml| {
            xml.element("ArgumentAssignmentList", &[], |xml| {
                let assign = |xml: &mut Xml, name: &str, value: String| {
                    let attributes = [("argumentName", name), ("argumentValue", &value)];
                    xml.leaf("ArgumentAssignment", &attributes);
                };
                assign(xml, "service", row.number.0.to_string());
                assign(xml, "subservice", row.number.1.to_string());
                let bytes: Option<usize> = row.fields.iter().map(bytes).sum();
                if let Some(bytes) = bytes {
                    // Secondary header, version of the list, fields, checksum, less one.
                    assign(xml, "packet_length", (5 + 1 + bytes + 2 - 1).to_string());
                }
            });
        });
        if !row.fields.is_empty() {
            xml.element("ArgumentList", &[], |xml| {
                for field in row.fields {
                    arguments(field).iter().for_each(|(name, kind)| argument(xml, (name, kind), field.unit));
                }
            });
        }
        xml.element("CommandContainer", &[("name", row.name)], |xml| {
            xml.element("EntryList", &[], |xml| {
                for field in row.fields {
                    arguments(field).iter().for_each(|(name, _)| argument_entries(xml, &[name]));
                }
                argument_entries(xml, &["checksum"]);
            });
            xml.leaf("BaseContainer", &[("containerRef", COMMAND)]);
        });
    });
}
