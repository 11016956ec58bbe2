//! An Embassy application: the flight is a task beside the downlink.
//!
//! The flight code is one blocking call a second, so its task waits for the second's tick and then keeps the
//! thread for as long as the second takes. What may not wait so long (the bus of the
//! spacecraft) goes into interrupts or into an `InterruptExecutor`, which interrupt the flight.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod program {
    use board_image::board::{self, Bridge};
    use board_image::flight::Flight;
    use core::panic::PanicInfo;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_rt::{entry, exception};
    use defmt as _;
    use embassy_executor::{Executor, Spawner};
    use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
    use embassy_sync::signal::Signal;
    use embassy_sync::zerocopy_channel::{Channel, Receiver, Sender};
    use fsw_core::telemetry::MAX_FRAME_BYTES;
    use static_cell::StaticCell;

    /// Ticks of SysTick a second.
    const TICKS: u32 = 100;

    /// The second has come.
    static SECOND: Signal<CriticalSectionRawMutex, ()> = Signal::new();

    /// A telemetry frame on its way to the downlink.
    struct Frame {
        bytes: [u8; MAX_FRAME_BYTES],
        length: usize,
    }

    type Frames = Channel<'static, CriticalSectionRawMutex, Frame>;
    static FRAMES: StaticCell<[Frame; 2]> = StaticCell::new();
    static CHANNEL: StaticCell<Frames> = StaticCell::new();
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();

    /// One call a second, its frame to the downlink; where the downlink is late the frame is dropped.
    #[embassy_executor::task]
    async fn fly(mut flight: Flight, mut frames: Sender<'static, CriticalSectionRawMutex, Frame>) {
        loop {
            SECOND.wait().await;
            match frames.try_send() {
                Some(frame) => {
                    frame.length = flight.second(&mut frame.bytes);
                    frames.send_done();
                }
                None => {
                    let _ = flight.second(&mut []);
                }
            }
            // A report a second where there is room; the others wait in the link.
            if let Some(frame) = frames.try_send()
                && let Some(buffer) = frame.bytes.first_chunk_mut()
            {
                frame.length = flight.report(buffer);
                frames.send_done();
            }
            board::housekeeping(flight.temperature_c());
        }
    }

    /// Sends frames byte by byte, and lets the others run while the line is busy.
    #[embassy_executor::task]
    async fn downlink(mut frames: Receiver<'static, CriticalSectionRawMutex, Frame>) {
        loop {
            let frame = frames.receive().await;
            for byte in frame.bytes.iter().take(frame.length) {
                while !board::send(*byte) {
                    embassy_yield().await;
                }
            }
            frames.receive_done();
        }
    }

    /// Gives way once.
    async fn embassy_yield() {
        let mut gave_way = false;
        core::future::poll_fn(|context| {
            if core::mem::replace(&mut gave_way, true) {
                return core::task::Poll::Ready(());
            }
            context.waker().wake_by_ref();
            core::task::Poll::Pending
        })
        .await;
    }

    fn spawn(spawner: Spawner) -> Option<()> {
        let empty = || Frame { bytes: [0; MAX_FRAME_BYTES], length: 0 };
        let frames = FRAMES.try_init([empty(), empty()])?;
        let (sender, receiver) = CHANNEL.try_init(Channel::new(frames))?.split();
        let mut core = cortex_m::Peripherals::take()?;
        spawner.spawn(fly(Flight::new(Bridge)?, sender).ok()?);
        spawner.spawn(downlink(receiver).ok()?);
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(board::CORE_HZ / TICKS - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        core.SYST.enable_interrupt();
        Some(())
    }

    #[entry]
    fn main() -> ! {
        if let Some(executor) = EXECUTOR.try_init(Executor::new()) {
            executor.run(|spawner| {
                if spawn(spawner).is_none() {
                    board::give_up();
                }
            });
        }
        board::give_up()
    }

    /// A panic, which only Embassy's own bookkeeping could reach: a warm restart.
    #[panic_handler]
    fn restart(_: &PanicInfo) -> ! {
        cortex_m::peripheral::SCB::sys_reset()
    }

    #[exception]
    fn SysTick() {
        static mut TICK: u32 = 0;
        *TICK += 1;
        if *TICK == TICKS {
            *TICK = 0;
            SECOND.signal(());
        }
    }
}

/// Where there is an operating system there is nothing to fly.
#[cfg(not(target_os = "none"))]
fn main() {}
