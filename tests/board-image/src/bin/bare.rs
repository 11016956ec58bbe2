//! A program without an executor: each second the flight, then its frame and the link's reports down.
//!
//! Linked with `panic-never`: no panic can be reached, neither in the flight code nor in the drivers.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod program {
    use board_image::board::{self, Bridge};
    use board_image::flight::Flight;
    // Each brings something to the link: the interrupts' critical section, defmt's linker script, no panic.
    use cortex_m as _;
    use defmt as _;
    use fsw_core::command::MAX_REPORT_BYTES;
    use fsw_core::telemetry::MAX_FRAME_BYTES;
    use fsw_hal::{Clock, LocalTime};
    use panic_never as _;
    use static_cell::ConstStaticCell;

    static FRAME: ConstStaticCell<[u8; MAX_FRAME_BYTES]> = ConstStaticCell::new([0; MAX_FRAME_BYTES]);

    static REPORTS: ConstStaticCell<[u8; MAX_REPORT_BYTES]> = ConstStaticCell::new([0; MAX_REPORT_BYTES]);

    /// Waits for the next second of the counter.
    fn wait_after(second: i64) -> i64 {
        loop {
            let now = Bridge.local_time().map_or(0, LocalTime::as_us) / 1_000_000;
            if now != second {
                return now;
            }
        }
    }

    fn fly() -> Option<()> {
        let (mut flight, frame, reports) = (Flight::new(Bridge)?, FRAME.try_take()?, REPORTS.try_take()?);
        let mut second = 0;
        loop {
            second = wait_after(second);
            let length = flight.second(frame);
            for byte in frame.iter().take(length) {
                while !board::send(*byte) {}
            }
            // The link holds a few reports.
            while let length @ 1.. = flight.report(reports) {
                for byte in reports.iter().take(length) {
                    while !board::send(*byte) {}
                }
            }
            board::housekeeping(flight.temperature_c());
        }
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        fly();
        board::give_up()
    }
}

/// Where there is an operating system there is nothing to fly.
#[cfg(not(target_os = "none"))]
fn main() {}
