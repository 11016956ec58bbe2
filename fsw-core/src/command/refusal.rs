//! Why a command was refused: the reason codes of the reports (1, 2) and (1, 8).

use serde::{Deserialize, Serialize};

/// Declares the reasons, each with its code and its words, which the page of commands shows.
macro_rules! refusals {
    ($($name:ident = $code:literal, $words:literal;)*) => {
        /// Why a command was refused. Its code, [`Refusal::code`], keeps its meaning in all versions.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Refusal {
            $(#[doc = $words] $name,)*
        }

        /// All reasons, in the order of their codes.
        pub const ALL: &[Refusal] = &[$(Refusal::$name),*];

        impl Refusal {
            /// The code by which a report tells it.
            pub const fn code(self) -> u16 {
                match self {
                    $(Self::$name => $code,)*
                }
            }

            /// The same in words.
            pub const fn words(self) -> &'static str {
                match self {
                    $(Self::$name => $words,)*
                }
            }
        }
    };
}

refusals! {
    Length = 1, "the packet is shorter or longer than its header says, or than any telecommand";
    Checksum = 2, "the packet error control is wrong";
    Header = 3, "no unsegmented telecommand with a secondary header of version 2";
    Apid = 4, "another APID; not reported";
    Tag = 5, "the authentication tag is wrong or missing";
    Counter = 6, "the authentication counter is not greater than the last one";
    Sequence = 7, "the sequence count is that of the last packet or before it";
    Version = 8, "another version of the list of commands";
    Unknown = 9, "no such service or subservice";
    Fields = 10, "the fields are shorter or longer than those of the command";
    Busy = 11, "the command before waits for its second, a dump or the check of an area goes on, or reports \
                wait to be sent";
    Part = 12, "the part does not begin where the last one ended, is empty, goes beyond the longest table or \
                the room of the area, or begins where no word of its memory begins";
    Incomplete = 13, "the parts so far are not as long as the table or file, or of another area";
    TableChecksum = 14, "the parts so far do not have the CRC of the table";
    TableDamaged = 32, "the table is none, or of another version";
    TableRange = 33, "a value of the table is outside its range";
    TableCalibration = 34, "the table names another calibration than the one in force";
    Exposure = 35, "the exposure is outside its range";
    Orbit = 36, "the state is no orbit about the body of the parameters, or a sigma is out of bounds";
    Epoch = 37, "the orbit is of the future or older than 100 minutes, or Terrestrial Time is not known";
    ClockServes = 38, "the clock gives Terrestrial Time itself";
    Correlation = 39, "the instant is of the future, older than a day, or outside the years 2000 to 2100";
    ParametersLost = 40, "the parameters and their copy are damaged: load a table first";
    Shutter = 41, "no such paths, or one is to be shut that has no shutter";
    Area = 42, "no such area, or none on board";
    Memory = 43, "the memory of the area failed: the file is to be sent anew";
    AreaChecksum = 44, "what the memory holds has not the CRC of the file";
    AreaContent = 45, "the file is none of the area's kind, of another version or damaged";
    AreaDetector = 46, "the file is of a detector of another size than that of the parameters in force, or \
                        of another optical centre";
}
