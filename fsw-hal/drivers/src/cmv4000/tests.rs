use super::simulated::{Fault, FrameRequest, Port, ResetN, Simulated, Spi};
use super::*;
use core::cell::RefCell;
use core::convert::Infallible;
use embedded_hal::spi::{self, Operation};
use fsw_hal::{ClockError, DetectorError, Instant};
use proptest::prelude::*;
use std::vec::Vec;

/// What a picture of position shows: every pixel has its own value.
fn shade(x: u16, y: u16) -> u16 {
    (x ^ y.rotate_left(3)) & 0x3FF
}

/// Light whose every pixel says where it is; remembers the exposures.
#[derive(Debug, Default)]
struct Light {
    exposures_us: Vec<u32>,
}

impl ErrorType for Light {
    type Error = DetectorError;
}

impl Detector for Light {
    fn geometry(&self) -> DetectorGeometry {
        DetectorGeometry { width_px: SIZE_PX, height_px: SIZE_PX, bits: 10 }
    }

    fn start_exposure(&mut self, exposure_us: u32) -> Result<(), DetectorError> {
        self.exposures_us.push(exposure_us);
        Ok(())
    }

    fn finish_exposure(&mut self) -> Result<LocalTime, DetectorError> {
        Ok(LocalTime::default())
    }

    fn read(&mut self, window: Window, pixels: &mut [u16]) -> Result<(), DetectorError> {
        for (at, pixel) in pixels.iter_mut().enumerate() {
            let (row, column) = (at / usize::from(window.width), at % usize::from(window.width));
            *pixel = shade(window.x + column as u16, window.y + row as u16);
        }
        Ok(())
    }
}

/// What happened on the board, in its order.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Event {
    Spi(Vec<u8>),
    Reset(bool),
    Request(bool),
    Delay(u32),
    PortStarted(usize),
    PortWaited(u32),
}
use Event::*;

/// What is to fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Failing {
    Nothing,
    /// The transaction with this number on the bus.
    Transaction(usize),
    /// The frame does not end.
    NoFrame,
    /// This many pixels do not come.
    Short(usize),
    /// The port reports an error while it waits.
    Receiver,
    /// The memory lends a pixel less.
    Lent,
}

struct Board {
    events: RefCell<Vec<Event>>,
    failing: RefCell<Failing>,
}

impl Board {
    fn new() -> Self {
        Self { events: RefCell::new(Vec::new()), failing: RefCell::new(Failing::Nothing) }
    }

    fn note(&self, event: Event) {
        self.events.borrow_mut().push(event);
    }

    fn transactions(&self) -> usize {
        self.events.borrow().iter().filter(|event| matches!(event, Spi(_))).count()
    }
}

struct Watched<'b, T>(&'b Board, T);

impl<T: spi::ErrorType> spi::ErrorType for Watched<'_, T> {
    type Error = T::Error;
}

impl<T: SpiDevice<Error = Fault>> SpiDevice for Watched<'_, T> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Fault> {
        let words = operations.iter().flat_map(|operation| match operation {
            Operation::Write(bytes) => bytes.to_vec(),
            Operation::TransferInPlace(bytes) => bytes.to_vec(),
            _ => panic!("not one of the driver's operations"),
        });
        let number = self.0.transactions();
        self.0.note(Spi(words.collect()));
        if *self.0.failing.borrow() == Failing::Transaction(number) {
            return Err(Fault::Word);
        }
        self.1.transaction(operations)
    }
}

impl embedded_hal::digital::ErrorType for Watched<'_, ResetN<'_, Light>> {
    type Error = Infallible;
}

impl OutputPin for Watched<'_, ResetN<'_, Light>> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.note(Event::Reset(false));
        self.1.set_low()
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.note(Event::Reset(true));
        self.1.set_high()
    }
}

impl embedded_hal::digital::ErrorType for Watched<'_, FrameRequest<'_, Light>> {
    type Error = Infallible;
}

impl OutputPin for Watched<'_, FrameRequest<'_, Light>> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.note(Event::Request(false));
        self.1.set_low()
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.note(Event::Request(true));
        self.1.set_high()
    }
}

impl DelayNs for Watched<'_, ()> {
    fn delay_ns(&mut self, ns: u32) {
        self.0.note(Delay(ns));
    }
}

impl PixelPort for Watched<'_, Port<'_, Light>> {
    type Error = Fault;

    fn start(&mut self, pixels: usize) -> Result<(), Fault> {
        self.0.note(PortStarted(pixels));
        self.1.start(pixels)
    }

    fn wait(&mut self, timeout_us: u32) -> Result<Option<usize>, Fault> {
        self.0.note(PortWaited(timeout_us));
        let came = self.1.wait(timeout_us)?;
        match *self.0.failing.borrow() {
            Failing::NoFrame => Ok(None),
            Failing::Short(missing) => Ok(came.map(|came| came - missing)),
            Failing::Receiver => Err(Fault::Frame),
            _ => Ok(came),
        }
    }

    fn lend(&mut self, first: usize, count: usize) -> Result<&[u16], Fault> {
        let missing = usize::from(*self.0.failing.borrow() == Failing::Lent);
        self.1.lend(first, count - missing)
    }
}

const CLOCK: u32 = 10_000_000;
const REQUESTED: i64 = 7_000_000;
const BOARD: Settings<'static> = Settings {
    clock_hz: CLOCK,
    outputs: Outputs::Two,
    rows: (512, 1024),
    analogue: &[(116, 0x19), (103, 40)],
};

type Driver<'b> = Cmv4000<
    'static,
    Watched<'b, Spi<'b, Light>>,
    Watched<'b, ResetN<'b, Light>>,
    Watched<'b, FrameRequest<'b, Light>>,
    Watched<'b, ()>,
    Instant,
    Watched<'b, Port<'b, Light>>,
>;

fn driver<'b>(
    board: &'b Board,
    part: &'b Simulated<Light>,
    memory: &'b mut [u16],
    settings: Settings<'static>,
) -> Driver<'b> {
    let parts = Parts {
        spi: Watched(board, part.spi()),
        reset_n: Watched(board, part.reset_n()),
        frame_request: Watched(board, part.frame_request()),
        delay: Watched(board, ()),
        clock: Instant::new(LocalTime::from_us(REQUESTED), 0),
        port: Watched(board, part.port(memory)),
    };
    Cmv4000::new(parts, settings).unwrap()
}

/// Flies `test` with a board, the part and the driver.
fn on_board(settings: Settings<'static>, test: impl FnOnce(&Board, &Simulated<Light>, &mut Driver)) {
    let (board, part) = (Board::new(), Simulated::new(Light::default(), CLOCK));
    let mut memory = std::vec![0; usize::from(SIZE_PX) * usize::from(settings.rows.1)];
    test(&board, &part, &mut driver(&board, &part, &mut memory, settings));
}

fn written(words: &[(u8, u8)]) -> impl Iterator<Item = Event> {
    words.iter().map(|(address, value)| Spi([address | 0x80, *value].to_vec()))
}

fn compared(addresses: impl IntoIterator<Item = u8>) -> impl Iterator<Item = Event> {
    addresses.into_iter().map(|address| Spi([address, 0].to_vec()))
}

/// Addresses that are compared before each frame, in their order.
const ALL: [u8; 16] = [116, 103, 1, 2, 3, 4, 40, 41, 70, 71, 72, 111, 112, 42, 43, 44];

#[test]
fn the_first_exposure_starts_the_detector_with_these_bytes_in_this_order() {
    on_board(BOARD, |board, part, detector| {
        detector.start_exposure(100_000).unwrap();
        // 100 ms are 7751.94 row times of 12.9 us; the overhead exposes 4.3; the nearest is 7748, 0x1E44.
        let fixed = [(116, 0x19), (103, 40), (1, 0), (2, 4), (3, 0), (4, 2), (40, 0), (41, 0)];
        let fixed = [&fixed[..], &[(70, 1), (71, 0), (72, 3), (111, 1), (112, 0)]].concat();
        let expected = [Reset(false), Request(false), Delay(10_000), Reset(true), Delay(10_000)]
            .into_iter()
            .chain(written(&fixed))
            .chain(compared([73]))
            .chain([Delay(20_000_000)])
            .chain(written(&[(42, 0x44), (43, 0x1E), (44, 0)]))
            .chain(compared(ALL))
            .chain([PortStarted(2048 * 1024), Request(true), Delay(1_000), Request(false)]);
        assert_eq!(*board.events.borrow(), expected.collect::<Vec<_>>());
        assert_eq!(part.with_source(|light| light.exposures_us.clone()), [100_004]);
    });
}

#[test]
fn a_second_exposure_writes_the_exposure_alone_and_compares_all() {
    on_board(BOARD, |board, _, detector| {
        detector.expose(100_000).unwrap();
        board.events.borrow_mut().clear();
        detector.start_exposure(200).unwrap();
        // 200 us are 15.5 row times, 11.2 of them beside the overhead.
        let expected = written(&[(42, 11), (43, 0), (44, 0)]).chain(compared(ALL)).chain([
            PortStarted(2048 * 1024),
            Request(true),
            Delay(1_000),
            Request(false),
        ]);
        assert_eq!(*board.events.borrow(), expected.collect::<Vec<_>>());
    });
}

#[test]
fn the_instant_is_the_middle_of_the_exposure_and_the_wait_a_quarter_over_the_frame() {
    on_board(BOARD, |board, _, detector| {
        let middle = LocalTime::from_us(REQUESTED + 100_004 / 2);
        assert_eq!(detector.expose(100_000).unwrap(), middle);
        // 1024 rows of 8 row times, an overhead of 10 + 16: 8218 x 12.9 us.
        let frame_us = 100_004 + 106_012;
        assert_eq!(board.events.borrow().last(), Some(&PortWaited(frame_us * 5 / 4)));
        // The image stays.
        assert_eq!(detector.finish_exposure().unwrap(), middle);
    });
}

#[test]
fn a_window_of_the_frame_is_that_of_the_detector() {
    on_board(BOARD, |_, _, detector| {
        detector.expose(50_000).unwrap();
        for window in [
            Window { x: 0, y: 0, width: 2048, height: 2 },
            Window { x: 2047, y: 1023, width: 1, height: 1 },
            Window { x: 613, y: 400, width: 16, height: 27 },
            Window { x: 7, y: 9, width: 0, height: 5 },
        ] {
            let mut pixels = std::vec![u16::MAX; window.area()];
            detector.read(window, &mut pixels).unwrap();
            for (at, pixel) in pixels.iter().enumerate() {
                let (row, column) = (at as u16 / window.width, at as u16 % window.width);
                assert_eq!(*pixel, shade(window.x + column, 512 + window.y + row), "{window:?}");
            }
        }
    });
}

#[test]
fn wrong_requests_are_refused_and_change_nothing() {
    on_board(BOARD, |board, _, detector| {
        let mut pixels = [0; 4];
        let window = Window { x: 0, y: 0, width: 2, height: 2 };
        assert_eq!(detector.read(window, &mut pixels), Err(Error::NotExposed));
        assert_eq!(detector.finish_exposure(), Err(Error::NotExposed));
        detector.start_exposure(20_000).unwrap();
        assert_eq!(detector.read(window, &mut pixels), Err(Error::NotExposed));
        detector.finish_exposure().unwrap();
        board.events.borrow_mut().clear();
        assert_eq!(detector.read(window, &mut pixels[..3]), Err(Error::BufferLength));
        let outside = Window { y: 1023, ..window };
        assert_eq!(detector.read(outside, &mut pixels), Err(Error::OutsideDetector));
        for impossible_us in [0, 60, u32::MAX] {
            assert_eq!(detector.start_exposure(impossible_us), Err(Error::Exposure), "{impossible_us}");
        }
        assert_eq!(pixels, [0; 4]);
        assert_eq!(*board.events.borrow(), []);
        detector.read(window, &mut pixels).unwrap();
        assert_eq!(detector.geometry(), DetectorGeometry { width_px: 2048, height_px: 1024, bits: 10 });
    });
}

#[test]
fn every_transaction_that_fails_is_told_and_the_next_exposure_starts_anew() {
    let mut transactions = 0;
    on_board(BOARD, |board, _, detector| {
        detector.expose(20_000).unwrap();
        transactions = board.transactions();
    });
    assert_eq!(transactions, 13 + 1 + 3 + ALL.len());
    for number in 0..transactions {
        on_board(BOARD, |board, _, detector| {
            *board.failing.borrow_mut() = Failing::Transaction(number);
            let error = detector.expose(20_000).unwrap_err();
            assert_eq!((error, error.kind()), (Error::Spi(Fault::Word), DetectorError::Bus));
            assert!(!board.events.borrow().contains(&Request(true)), "{number}");
            assert_eq!(detector.finish_exposure(), Err(Error::NotExposed));
            *board.failing.borrow_mut() = Failing::Nothing;
            board.events.borrow_mut().clear();
            detector.expose(20_000).unwrap();
            assert_eq!(board.events.borrow().first(), Some(&Reset(false)));
        });
    }
}

#[test]
fn a_frame_that_does_not_come_whole_is_told_and_the_image_is_gone() {
    let frame = 2048 * 1024;
    for (failing, expected, kind) in [
        (Failing::NoFrame, Error::NoFrame, DetectorError::Timeout),
        (Failing::Short(1), Error::Short { came: frame - 1, expected: frame }, DetectorError::Bus),
        (Failing::Short(frame), Error::Short { came: 0, expected: frame }, DetectorError::Bus),
        (Failing::Receiver, Error::Port(Fault::Frame), DetectorError::Bus),
    ] {
        on_board(BOARD, |board, _, detector| {
            detector.expose(20_000).unwrap();
            *board.failing.borrow_mut() = failing;
            let error = detector.expose(20_000).unwrap_err();
            assert_eq!((error, error.kind()), (expected, kind));
            let window = Window { x: 0, y: 0, width: 1, height: 1 };
            assert_eq!(detector.read(window, &mut [0]), Err(Error::NotExposed));
            *board.failing.borrow_mut() = Failing::Nothing;
            detector.expose(20_000).unwrap();
            detector.read(window, &mut [0]).unwrap();
        });
    }
}

#[test]
fn a_memory_that_lends_less_is_told() {
    on_board(BOARD, |board, _, detector| {
        detector.expose(20_000).unwrap();
        *board.failing.borrow_mut() = Failing::Lent;
        let window = Window { x: 5, y: 0, width: 4, height: 3 };
        assert_eq!(detector.read(window, &mut [0; 12]), Err(Error::Short { came: 3, expected: 4 }));
        assert_eq!(detector.read(window, &mut [0; 12]), Err(Error::NotExposed));
    });
}

#[test]
fn an_upset_register_is_told_and_written_anew() {
    for address in ALL.into_iter().filter(|address| !(42..=44).contains(address)) {
        on_board(BOARD, |_, part, detector| {
            detector.expose(20_000).unwrap();
            let wrote = part.register(address).unwrap();
            part.upset(address, 0x20);
            let error = detector.start_exposure(20_000).unwrap_err();
            assert_eq!(error, Error::Readback { address, wrote, read: wrote ^ 0x20 });
            assert_eq!(error.kind(), DetectorError::Bus);
            detector.expose(20_000).unwrap();
            assert_eq!(part.register(address), Some(wrote));
        });
    }
}

#[test]
fn a_part_that_is_held_in_reset_is_told() {
    let (board, part) = (Board::new(), Simulated::new(Light::default(), CLOCK));
    let mut memory = std::vec![0; 2048 * 1024];
    let parts = driver(&board, &part, &mut memory, BOARD).release();
    let dead = Parts {
        spi: parts.spi,
        reset_n: Nowhere,
        frame_request: Nowhere,
        delay: parts.delay,
        clock: parts.clock,
        port: parts.port,
    };
    let mut detector = Cmv4000::new(dead, BOARD).unwrap();
    let error = detector.start_exposure(20_000).unwrap_err();
    assert_eq!(error, Error::Readback { address: 116, wrote: 0x19, read: 0 });
}

/// A pin that leads nowhere.
struct Nowhere;

impl embedded_hal::digital::ErrorType for Nowhere {
    type Error = Infallible;
}

impl OutputPin for Nowhere {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A clock that does not answer.
struct Silent(ClockError);

impl ErrorType for Silent {
    type Error = ClockError;
}

impl Clock for Silent {
    fn local_time(&mut self) -> Result<LocalTime, ClockError> {
        Err(self.0)
    }

    fn terrestrial_us(&mut self, _: LocalTime) -> Result<i64, ClockError> {
        Err(self.0)
    }
}

#[test]
fn no_frame_is_asked_for_without_a_time() {
    for (clock, kind) in
        [(ClockError::Timeout, DetectorError::Timeout), (ClockError::Bus, DetectorError::Bus)]
    {
        let (board, part) = (Board::new(), Simulated::new(Light::default(), CLOCK));
        let mut memory = std::vec![0; 2048 * 1024];
        let Parts { spi, reset_n, frame_request, delay, port, .. } =
            driver(&board, &part, &mut memory, BOARD).release();
        let silent = Parts { spi, reset_n, frame_request, delay, clock: Silent(clock), port };
        let mut detector = Cmv4000::new(silent, BOARD).unwrap();
        let error = detector.start_exposure(20_000).unwrap_err();
        assert_eq!((error, error.kind()), (Error::Clock(clock), kind));
        assert!(!board.events.borrow().contains(&Request(true)));
    }
}

#[test]
fn settings_that_the_detector_cannot_do_are_refused() {
    let refused = |settings| {
        let (board, part) = (Board::new(), Simulated::new(Light::default(), CLOCK));
        let parts = driver(&board, &part, &mut [], BOARD).release();
        Cmv4000::new(parts, settings).err()
    };
    assert_eq!(refused(BOARD), None);
    assert_eq!(refused(Settings { rows: (0, 2048), ..BOARD }), None);
    for clock_hz in [0, 4_999_999, 48_000_001] {
        assert_eq!(refused(Settings { clock_hz, ..BOARD }), Some(SettingsError::Clock));
    }
    for rows in [(0, 0), (0, 2049), (2047, 2), (u16::MAX, u16::MAX)] {
        assert_eq!(refused(Settings { rows, ..BOARD }), Some(SettingsError::Rows));
    }
    for analogue in [&[(42, 1)], &[(1, 1)], &[(112, 0)], &[(128, 0)]] {
        assert_eq!(refused(Settings { analogue, ..BOARD }), Some(SettingsError::Analogue));
    }
}

proptest! {
    #[test]
    fn an_exposure_is_within_half_a_row_time_of_what_was_asked(
        exposure_us in 0..=u32::MAX,
        clock_hz in 5_000_000..=48_000_000u32,
        fot_length in any::<u8>(),
    ) {
        let timing = Timing { clock_hz, outputs: Outputs::Sixteen, rows: 2048, fot_length };
        let row_us = 129e6 / f64::from(clock_hz);
        let overhead_us = 0.43 * f64::from(fot_length) * row_us;
        match timing.exposure_units(exposure_us) {
            Some(units) => {
                let made_us = overhead_us + f64::from(units) * row_us;
                prop_assert!((made_us - f64::from(exposure_us)).abs() <= 0.51 * row_us);
                prop_assert!((timing.exposure_us(units) as f64 - made_us).abs() <= 1.0);
            }
            None => {
                let shortest_us = overhead_us + 0.5 * row_us;
                let longest_us = overhead_us + f64::from(EXPOSURE_MAX) * row_us;
                let us = f64::from(exposure_us);
                prop_assert!(us < shortest_us + 0.01 * row_us || us > longest_us + 0.49 * row_us);
            }
        }
    }

    #[test]
    fn any_window_is_read_or_refused(
        (x, y) in (0..2060u16, 0..40u16),
        (width, height) in (0..2060u16, 0..40u16),
    ) {
        let settings = Settings { rows: (100, 32), ..BOARD };
        on_board(settings, |_, _, detector| {
            detector.expose(1_000).unwrap();
            let window = Window { x, y, width, height };
            let mut pixels = std::vec![0; window.area()];
            let fits = window.fits(&detector.geometry());
            assert_eq!(detector.read(window, &mut pixels).is_ok(), fits);
            if let (true, Some(last)) = (fits, pixels.last()) {
                assert_eq!(*last, shade(x + width - 1, 100 + y + height - 1));
            }
        });
    }
}
