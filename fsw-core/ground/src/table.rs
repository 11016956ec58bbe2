//! One declaration a parameter: `parameter_group!` makes of it the field, its default, its check and its
//! row in the table of all parameters.
//!
//! In: a group's name and, for every parameter, what it is, its type, default, range, unit and source. Out: a
//! struct with documented fields, `Default`, `first_out_of_range` and `ROWS`. The flight code uses the first
//! three. Only the host reads `ROWS` (the page `PARAMETERS.md`, the checksum of the table), so the linker
//! leaves their text out of the image.

/// A row of the table of all parameters, as text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Group, as in the names of rejected values: `earth.limb`.
    pub group: &'static str,
    /// Name of the field.
    pub name: &'static str,
    /// Its type.
    pub kind: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// Its default.
    pub default: &'static str,
    /// From where to where it may be set.
    pub range: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Where the default comes from, and what set it.
    pub source: &'static str,
}

/// Name, least and greatest value of a parameter.
pub type Bounds = (&'static str, f32, f32);

/// A value that has a range: a number, or an array of numbers.
pub trait Ranged {
    /// The number that the range is asked about: the value itself; of an array the first that is not within
    /// `low..=high`, else the last. Integers are exact up to 2^24, which no range of this table exceeds but
    /// that of a CRC.
    fn tested(&self, low: f32, high: f32) -> f32;
}

impl Ranged for f32 {
    #[inline]
    fn tested(&self, _: f32, _: f32) -> f32 {
        *self
    }
}

impl Ranged for u16 {
    #[inline]
    fn tested(&self, _: f32, _: f32) -> f32 {
        f32::from(*self)
    }
}

impl Ranged for u32 {
    #[inline]
    fn tested(&self, _: f32, _: f32) -> f32 {
        *self as f32
    }
}

impl<T: Ranged, const LENGTH: usize> Ranged for [T; LENGTH] {
    #[inline]
    fn tested(&self, low: f32, high: f32) -> f32 {
        let mut last = low;
        for value in self {
            last = value.tested(low, high);
            if !(low..=high).contains(&last) {
                break;
            }
        }
        last
    }
}

/// The name of the first value that is not within its bounds; NaN and the infinities never are.
#[inline(never)]
pub fn first_out_of_range(values: &[f32], bounds: &[Bounds]) -> Option<&'static str> {
    let mut all = values.iter().zip(bounds);
    all.find(|(value, (_, low, high))| !(low..=high).contains(value)).map(|(_, (name, ..))| *name)
}

/// Declares a group of parameters, see [the module](crate::table):
///
/// ```text
/// parameter_group! {
///     /// What the group is.
///     pub struct TrackingParameters in "tracking" {
///         /// What the parameter is.
///         gate_px: u16 = 5, 3..=24, "px", "source; what set it";
///         /// A choice between values of a type has no range.
///         observation: Observation = Observation::Position,
///             one of "Position, UnitVector, Combined", "", "source";
///     }
/// }
/// ```
#[macro_export]
macro_rules! parameter_group {
    (
        $(#[doc = $group_doc:literal])*
        $visibility:vis struct $Group:ident in $group:literal {
            $(
                $(#[doc = $doc:literal])*
                $name:ident: $type:ty = $default:expr,
                $($low:literal ..= $high:literal)? $(one of $choices:literal)?,
                $unit:literal, $source:literal;
            )*
        }
    ) => {
        $(#[doc = $group_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        $visibility struct $Group {
            $(
                $(#[doc = $doc])*
                #[doc = concat!(
                    "\n\nDefault ", stringify!($default), " ", $unit, "; ",
                    $(stringify!($low), " to ", stringify!($high))? $("one of ", $choices)?, "."
                )]
                pub $name: $type,
            )*
        }

        impl Default for $Group {
            fn default() -> Self {
                Self { $($name: $default),* }
            }
        }

        impl $Group {
            /// The group's rows in the table of all parameters, for the host.
            pub const ROWS: &'static [$crate::table::Row] = &[
                $(
                    $crate::table::Row {
                        group: $group,
                        name: stringify!($name),
                        kind: stringify!($type),
                        unit: $unit,
                        default: stringify!($default),
                        range: concat!(
                            $(stringify!($low), " to ", stringify!($high))? $("one of ", $choices)?
                        ),
                        about: concat!($($doc),*),
                        source: $source,
                    },
                )*
            ];

            /// Names, least and greatest values of what has a range.
            pub const BOUNDS: &'static [$crate::table::Bounds] = &[
                $($((concat!($group, ".", stringify!($name)), $low as f32, $high as f32),)?)*
            ];

            /// The name of the first value that is outside its range or not finite.
            pub fn first_out_of_range(&self) -> Option<&'static str> {
                use $crate::table::Ranged;
                let values = [$($(Ranged::tested(&self.$name, $low as f32, $high as f32),)?)*];
                $crate::table::first_out_of_range(&values, Self::BOUNDS)
            }
        }
    };
}

#[doc(inline)]
pub use parameter_group;
