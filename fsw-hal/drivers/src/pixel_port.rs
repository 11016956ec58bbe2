//! What takes the pixels of a detector in, while the processor does something else.
//!
//! A detector with a free-running readout gives its pixels once, in the order of its rows, at tens of MHz. A
//! receiver (the camera interface of a microcontroller, an FPGA behind the detector's LVDS lines) writes them
//! into a frame memory by DMA. A [`PixelPort`] is that receiver with its memory: armed before the detector is
//! asked for a frame, waited for afterwards, and then lent pixel by pixel as often as one likes. So all
//! windows of a second are of one image, whatever their number and order.
//!
//! Pixels are numbered in the order in which they come, from 0. A frame of 2048 x 2048 px in 16 bits needs 8
//! MiB: memory outside of the processor, mapped into its addresses or read through a bus line by line.
//!
//! # The shape of one with DMA
//!
//! The interrupt at the end of the transfer sets a flag; the port looks at it until its time is over.
//!
//! ```
//! use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
//! use fsw_drivers::PixelPort;
//!
//! /// Set by the interrupt of the DMA channel.
//! static COMPLETE: AtomicBool = AtomicBool::new(false);
//! /// Set by the same interrupt: pixels that came before the frame ended.
//! static CAME: AtomicUsize = AtomicUsize::new(0);
//!
//! struct CameraInterface<'m, D> {
//!     memory: &'m mut [u16],
//!     delay: D,
//! }
//!
//! impl<D: embedded_hal::delay::DelayNs> PixelPort for CameraInterface<'_, D> {
//!     type Error = ();
//!
//!     fn start(&mut self, pixels: usize) -> Result<(), ()> {
//!         let _frame = self.memory.get_mut(..pixels).ok_or(())?;
//!         COMPLETE.store(false, Ordering::Release);
//!         // Here: address and length of `_frame` into the DMA channel, channel on, receiver on.
//!         Ok(())
//!     }
//!
//!     fn wait(&mut self, timeout_us: u32) -> Result<Option<usize>, ()> {
//!         for _ in 0..timeout_us / 10 + 1 {
//!             if COMPLETE.load(Ordering::Acquire) {
//!                 return Ok(Some(CAME.load(Ordering::Acquire)));
//!             }
//!             self.delay.delay_us(10);
//!         }
//!         // Here: channel off, so that a late frame does not run into the next.
//!         Ok(None)
//!     }
//!
//!     fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], ()> {
//!         // Here: on a processor with a data cache, the lines of this range invalidated.
//!         self.memory.get(first..).and_then(|rest| rest.get(..count)).ok_or(())
//!     }
//! }
//! ```

use core::fmt::Debug;

/// A receiver of pixels with its frame memory.
pub trait PixelPort {
    /// What can go wrong in it.
    type Error: Debug;

    /// Makes ready for the next `pixels` pixels and returns at once. What an earlier frame left is lost.
    ///
    /// # Errors
    /// Where the memory is too small or the receiver does not answer.
    fn start(&mut self, pixels: usize) -> Result<(), Self::Error>;

    /// Waits until the frame has ended, `timeout_us` microseconds at most, and gives the number of pixels
    /// that came; `None` where it has not ended by then, and then the receiver is off.
    ///
    /// # Errors
    /// What the receiver reports: an overrun of its queue, an error on the memory's bus.
    fn wait(&mut self, timeout_us: u32) -> Result<Option<usize>, Self::Error>;

    /// Lends `count` pixels from number `first` on, right-aligned; never more than a row of the detector.
    ///
    /// # Errors
    /// Where they are not there, or the memory cannot be read.
    fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], Self::Error>;
}

impl<P: PixelPort + ?Sized> PixelPort for &mut P {
    type Error = P::Error;

    fn start(&mut self, pixels: usize) -> Result<(), Self::Error> {
        P::start(self, pixels)
    }

    fn wait(&mut self, timeout_us: u32) -> Result<Option<usize>, Self::Error> {
        P::wait(self, timeout_us)
    }

    fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], Self::Error> {
        P::lend(self, first, count)
    }
}
