//! The description of telemetry and telecommands in XTCE 1.2 (OMG formal/2018-10-02, CCSDS 660.0-B-2), which
//! ground systems load.
//!
//! In: the layout of the frames ([`super::layout`]) and the list of telecommands. Out: a document of one
//! space system. `frames` says how the frame's encoding is put into the standard's terms, `packets` what
//! space packets there are.
//!
//! | container | bytes |
//! |---|---|
//! | `StreamFrame` | a frame as it leaves the sensor, led by its length |
//! | `FramePacket` | a frame in a space packet without a secondary header |
//! | `Frame` | version, body, CRC-32 |
//! | `Accepted`, `NotAccepted`, `Completed`, `NotCompleted`, `TablePart` | a report of the command link |

mod frames;
mod packets;
mod xml;

use fsw_core::telemetry::VERSION;
use xml::Xml;

/// The space system.
const NAME: &str = "Sextant";
const FRAME: &str = "Frame";
const SCHEMA: &str =
    "http://www.omg.org/spec/XTCE/20180204 https://www.omg.org/spec/XTCE/20180204/SpaceSystem.xsd";

/// The document.
pub fn document() -> String {
    let layout = super::layout();
    let body = frames::Body::new(&layout);
    let mut xml = Xml::new();
    let attributes = [
        ("name", NAME),
        ("xmlns", "http://www.omg.org/spec/XTCE/20180204"),
        ("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"),
        ("xsi:schemaLocation", SCHEMA),
    ];
    xml.element("SpaceSystem", &attributes, |xml| {
        let about = format!(
            "Written by `sil-host telemetry --xtce`: telemetry frames of version {VERSION} and telecommands of \
             the Sextant Earth and star sensor."
        );
        xml.text("LongDescription", &about);
        let version = VERSION.to_string();
        xml.leaf("Header", &[("version", &version), ("validationStatus", "Working")]);
        xml.element("TelemetryMetaData", &[], |xml| {
            xml.element("ParameterTypeSet", &[], |xml| {
                frame_types(xml);
                body.types(xml);
                packets::types(xml);
            });
            xml.element("ParameterSet", &[], |xml| {
                for (name, kind, about) in [
                    ("frame-bytes", "frame-length", "Bytes of the frame that follows."),
                    ("frame-version", "u8", "Version of the layout."),
                    ("frame-checksum", "crc32", "CRC-32 (ISO-HDLC) of version and body."),
                ] {
                    packets::parameter(xml, name, kind, about);
                }
                body.parameters(xml);
                packets::parameters(xml);
            });
            xml.element("ContainerSet", &[], |xml| {
                body.containers(xml);
                packets::containers(xml);
                frame_containers(xml);
            });
            xml.element("AlgorithmSet", &[], |xml| body.algorithms(xml));
        });
        packets::commands(xml);
    });
    xml.finish()
}

fn frame_types(xml: &mut Xml) {
    let low_first = ("byteOrder", "leastSignificantByteFirst");
    let attributes = |name| [("name", name), ("signed", "false")];
    xml.element("IntegerParameterType", &attributes("frame-length"), |xml| {
        xml.leaf("IntegerDataEncoding", &[("sizeInBits", "16"), low_first]);
    });
    xml.element("IntegerParameterType", &attributes("crc32"), |xml| {
        xml.element("IntegerDataEncoding", &[("sizeInBits", "32"), low_first], |xml| {
            packets::crc(xml, ("32", "04C11DB7", "FFFFFFFF", "FFFFFFFF"), "true");
        });
    });
}

fn frame_containers(xml: &mut Xml) {
    let frame = |xml: &mut Xml| xml.leaf("ContainerRefEntry", &[("containerRef", FRAME)]);
    let parameter = |xml: &mut Xml, name| xml.leaf("ParameterRefEntry", &[("parameterRef", name)]);
    xml.element("SequenceContainer", &[("name", FRAME)], |xml| {
        xml.text("LongDescription", "A telemetry frame: its checksum counts from the version on.");
        xml.element("EntryList", &[], |xml| {
            parameter(xml, "frame-version");
            xml.element("ContainerRefEntry", &[("containerRef", frames::BODY)], |xml| {
                let version = ("frame-version".to_owned(), VERSION.to_string());
                xml.element("IncludeCondition", &[], |xml| frames::comparisons(xml, &[version]));
            });
            parameter(xml, "frame-checksum");
        });
    });
    xml.element("SequenceContainer", &[("name", "StreamFrame")], |xml| {
        xml.text("LongDescription", "A frame as it leaves the sensor.");
        xml.element("EntryList", &[], |xml| {
            parameter(xml, "frame-bytes");
            frame(xml);
        });
    });
    xml.element("SequenceContainer", &[("name", "FramePacket")], |xml| {
        xml.text("LongDescription", "A frame in a space packet; the spacecraft makes it.");
        xml.element("EntryList", &[], frame);
        packets::base(xml, packets::PACKET, &[("ccsds-type", 0), ("ccsds-secondary_header", 0)]);
    });
}
