//! Telecommands out of a file of the host, and the reports about them into another.
//!
//! In: packets by rising second, each led by its second (u32) and its length (u16), little-endian. Out: the
//! command of each second; report packets one after the other. The key is the one of RFC 4493: this image
//! flies in an emulator only.

use crate::host::{File, HostError, Mode};
use fsw_core::command::{Command, CommandLink, Downlink, Key, MAX_REPORT_BYTES, MAX_TELECOMMAND_BYTES};
use fsw_core::telemetry::Report;
use fsw_hal::LocalTime;
use static_cell::StaticCell;

/// APID of the sensor.
const APID: u16 = 0x2A5;
const KEY: Key = Key::new([
    0x2b, 0x7e, 0x15, 0x16, 0x28, 0xae, 0xd2, 0xa6, 0xab, 0xf7, 0x15, 0x88, 0x09, 0xcf, 0x4f, 0x3c,
]);

static LINK: StaticCell<CommandLink> = StaticCell::new();

/// The link between its two files.
pub struct Commands {
    packets: File,
    reports: File,
    link: &'static mut CommandLink,
    /// Second and length of the next packet.
    next: Option<(u32, usize)>,
}

/// The head of the next packet; `None` at the end of the file.
fn head(packets: &mut File) -> Option<(u32, usize)> {
    let mut head = [0; 6];
    packets.read(&mut head).ok()?;
    let [a, b, c, d, e, f] = head;
    Some((u32::from_le_bytes([a, b, c, d]), u16::from_le_bytes([e, f]).into()))
}

impl Commands {
    /// Opens the files of packets and of reports.
    ///
    /// # Errors
    /// [`HostError`] where one cannot be opened, and the second time.
    pub fn open(packets: &[u8], reports: &[u8]) -> Result<Self, HostError> {
        let mut packets = File::open(packets, Mode::Read)?;
        let next = head(&mut packets);
        let link = LINK.try_init(CommandLink::new(APID, Some(KEY), 0)).ok_or(HostError)?;
        Ok(Self { packets, reports: File::open(reports, Mode::Write)?, link, next })
    }

    /// Hands the packets of a second to the link.
    #[inline(never)]
    pub fn receive(&mut self, second: u32) {
        // Each turn reads a packet of the file.
        while let Some((_, length)) = self.next.take_if(|(due, _)| *due <= second) {
            let mut packet = [0; MAX_TELECOMMAND_BYTES];
            // A packet that is too long, or a file that breaks off, ends the commands.
            let Some(packet) = packet.get_mut(..length) else { return };
            if self.packets.read(packet).is_err() {
                return;
            }
            let _ = self.link.receive(packet);
            self.next = head(&mut self.packets);
        }
    }

    /// The command of the second.
    pub fn command(&self) -> Command<'_> {
        self.link.command()
    }

    /// Tells the link what came of the second, and writes the link's reports; whether all could be written.
    #[inline(never)]
    pub fn conclude(&mut self, report: &Report, told: &Downlink) -> bool {
        self.link.conclude(report.command);
        self.link.log(report.cycle, &report.events);
        let now = LocalTime::from_us(report.local_us);
        let (mut buffer, mut written) = ([0; MAX_REPORT_BYTES], true);
        // Each turn takes a report off the link.
        while let Some(report) = self.link.next_report(now, told, &mut buffer) {
            written &= self.reports.write(report).is_ok();
        }
        written
    }
}
