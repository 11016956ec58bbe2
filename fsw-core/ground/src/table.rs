//! One declaration a parameter: `parameter_group!` makes of it the field, its default, its check and its
//! row in the table of all parameters.
//!
//! In: a group's name and, for every parameter, what it is, its type, default, range, unit and source. Out: a
//! struct with documented fields, `Default`, `first_out_of_range`, the bytes of a table and `ROWS`. Only the
//! host reads `ROWS` (the page `PARAMETERS.md`, the checksum of the table), so the linker leaves their text
//! out of the image.
//!
//! All groups are written and read by one loop over their [`Field`]s: a derived `Serialize` and `Deserialize`
//! for each of eighteen groups took 4 KB more of flash.

use core::fmt;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{SerializeTuple, Serializer};

/// Up to here every integer is an `f32`.
const MOST_EXACT: f32 = 16_777_216.0;

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

impl Row {
    /// The words of a choice in the order of their numbers, for the host; `None` of what is none.
    pub fn choices(&self) -> Option<impl Iterator<Item = &'static str> + use<>> {
        self.range.strip_prefix("one of ").map(|words| words.split(", "))
    }
}

/// Name, least and greatest value of a parameter; those of `f32` where it has no range.
pub type Bounds = (&'static str, f32, f32);

/// A parameter as what is common to all types sees it.
pub enum Field<'a> {
    /// A real number.
    Single(&'a mut f32),
    /// Several.
    Singles(&'a mut [f32]),
    /// A natural number.
    Short(&'a mut u16),
    /// A large one.
    Long(&'a mut u32),
    /// A choice between named values: the number of the chosen one, from 0.
    Choice(&'a mut u8),
}

impl Field<'_> {
    /// How many numbers it is.
    fn count(&self) -> usize {
        if let Self::Singles(values) = self { values.len() } else { 1 }
    }

    /// Takes a value: a number, so many numbers as it has, a whole one where it is one; `false`, and no change,
    /// for others.
    pub fn take(&mut self, values: &[f32]) -> bool {
        let whole = |value: f32| (0.0..=MOST_EXACT).contains(&value) && libm::truncf(value) == value;
        match (self, values) {
            (Self::Single(place), [value]) => **place = *value,
            (Self::Singles(places), _) if places.len() == values.len() => places.copy_from_slice(values),
            (Self::Short(place), [value]) if whole(*value) && *value <= f32::from(u16::MAX) => {
                **place = *value as u16;
            }
            (Self::Long(place), [value]) if whole(*value) => **place = *value as u32,
            (Self::Choice(place), [value]) if whole(*value) && *value <= f32::from(u8::MAX) => {
                **place = *value as u8;
            }
            _ => return false,
        }
        true
    }

    /// Whether it is finite and within `low..=high`, of several numbers each. Integers are exact up to 2^24,
    /// which no range exceeds. A choice has none.
    fn is_within(&self, low: f32, high: f32) -> bool {
        let within = |value: &f32| (low..=high).contains(value);
        match self {
            Self::Single(value) => within(value),
            Self::Singles(values) => values.iter().all(within),
            Self::Short(value) => within(&f32::from(**value)),
            Self::Long(value) => within(&(**value as f32)),
            Self::Choice(_) => true,
        }
    }
}

/// A type that a parameter may have.
pub trait Parameter {
    /// The value; of a choice the place of its number.
    fn field<'a>(&'a mut self, number: &'a mut u8) -> Field<'a>;

    /// The number of a choice.
    #[inline]
    fn number(&self) -> u8 {
        0
    }

    /// Takes the choice of a number; `false` where there is none.
    #[inline]
    fn choose(&mut self, _number: u8) -> bool {
        true
    }
}

impl Parameter for f32 {
    #[inline]
    fn field<'a>(&'a mut self, _: &'a mut u8) -> Field<'a> {
        Field::Single(self)
    }
}

impl Parameter for u16 {
    #[inline]
    fn field<'a>(&'a mut self, _: &'a mut u8) -> Field<'a> {
        Field::Short(self)
    }
}

impl Parameter for u32 {
    #[inline]
    fn field<'a>(&'a mut self, _: &'a mut u8) -> Field<'a> {
        Field::Long(self)
    }
}

impl<const LENGTH: usize> Parameter for [f32; LENGTH] {
    #[inline]
    fn field<'a>(&'a mut self, _: &'a mut u8) -> Field<'a> {
        Field::Singles(self)
    }
}

/// Makes an enum without data a type of parameters: `choice! { Observation: LimbHeights, Position }`, all its
/// values in their order.
#[macro_export]
macro_rules! choice {
    ($Type:ident: $($value:ident),+) => {
        impl $crate::table::Parameter for $Type {
            #[inline]
            fn field<'a>(&'a mut self, number: &'a mut u8) -> $crate::table::Field<'a> {
                $crate::table::Field::Choice(number)
            }

            fn number(&self) -> u8 {
                *self as u8
            }

            fn choose(&mut self, number: u8) -> bool {
                const ALL: &[$Type] = &[$($Type::$value),+];
                ALL.get(usize::from(number)).map(|value| *self = *value).is_some()
            }
        }
    };
}

#[doc(inline)]
pub use choice;

/// The name of the first value that is not within its bounds; NaN and the infinities never are.
#[inline(never)]
pub fn first_out_of_range(fields: &[Field<'_>], bounds: &[Bounds]) -> Option<&'static str> {
    let mut all = fields.iter().zip(bounds);
    all.find(|(field, (_, low, high))| !field.is_within(*low, *high)).map(|(_, (name, ..))| *name)
}

/// Writes the values one after the other, a choice as its number.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer>(fields: &mut [Field<'_>], serializer: S) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(fields.iter().map(Field::count).sum())?;
    for field in fields {
        match field {
            Field::Single(value) => tuple.serialize_element(*value)?,
            Field::Singles(values) => {
                values.iter().try_for_each(|value| tuple.serialize_element(value))?;
            }
            Field::Short(value) => tuple.serialize_element(*value)?,
            Field::Long(value) => tuple.serialize_element(*value)?,
            Field::Choice(value) => tuple.serialize_element(*value)?,
        }
    }
    tuple.end()
}

/// Reads what [`serialize`] has written.
///
/// # Errors
/// Those of the deserializer, fewer values.
pub fn deserialize<'de, D: Deserializer<'de>>(
    fields: &mut [Field<'_>],
    deserializer: D,
) -> Result<(), D::Error> {
    deserializer.deserialize_tuple(fields.iter().map(Field::count).sum(), Values(fields))
}

/// Takes values into fields.
struct Values<'a, 'b>(&'a mut [Field<'b>]);

impl<'de> Visitor<'de> for Values<'_, '_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str("the values of a group of parameters")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<(), A::Error> {
        fn take<'de, A: SeqAccess<'de>, T: serde::Deserialize<'de>>(
            values: &mut A,
            place: &mut T,
        ) -> Result<(), A::Error> {
            *place = values.next_element()?.ok_or_else(|| A::Error::custom("too few values"))?;
            Ok(())
        }
        for field in self.0 {
            match field {
                Field::Single(value) => take(&mut values, *value)?,
                Field::Singles(all) => all.iter_mut().try_for_each(|value| take(&mut values, value))?,
                Field::Short(value) => take(&mut values, *value)?,
                Field::Long(value) => take(&mut values, *value)?,
                Field::Choice(value) => take(&mut values, *value)?,
            }
        }
        Ok(())
    }
}

/// The [`Bounds`] of a name and a range, or of a name alone.
#[doc(hidden)]
#[macro_export]
macro_rules! bounds {
    ($name:expr) => {
        ($name, f32::MIN, f32::MAX)
    };
    ($name:expr, $low:literal, $high:literal) => {
        ($name, $low as f32, $high as f32)
    };
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
        #[derive(Clone, Copy, Debug, PartialEq)]
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

            /// Names, least and greatest values.
            pub const BOUNDS: &'static [$crate::table::Bounds] = &[
                $($crate::bounds!(concat!($group, ".", stringify!($name)) $(, $low, $high)?),)*
            ];

            /// The numbers of its choices, in the order of the rows; 0 for what is none.
            pub fn numbers(&self) -> [u8; $Group::ROWS.len()] {
                [$($crate::table::Parameter::number(&self.$name)),*]
            }

            /// Takes the choices of these numbers; `false` where there is none of a number.
            fn choose(&mut self, numbers: &[u8; $Group::ROWS.len()]) -> bool {
                let [$($name),*] = numbers;
                $($crate::table::Parameter::choose(&mut self.$name, *$name))&&*
            }

            /// Its values, in the order of the rows; those of choices in `numbers`.
            #[inline(never)]
            pub fn fields<'a>(
                &'a mut self,
                numbers: &'a mut [u8; $Group::ROWS.len()],
            ) -> [$crate::table::Field<'a>; $Group::ROWS.len()] {
                let [$($name),*] = numbers;
                [$($crate::table::Parameter::field(&mut self.$name, $name)),*]
            }

            /// Sets the parameter of a name, for the host: a number, several, or the number of a choice.
            /// `false`, and no change, where there is none of this name and kind.
            pub fn set(&mut self, name: &str, values: &[f32]) -> bool {
                let mut numbers = self.numbers();
                let index = Self::ROWS.iter().position(|row| row.name == name);
                let is_taken = index
                    .and_then(|index| self.fields(&mut numbers).into_iter().nth(index))
                    .is_some_and(|mut field| field.take(values));
                is_taken && self.choose(&numbers)
            }

            /// The name of the first value that is outside its range or not finite.
            pub fn first_out_of_range(&self) -> Option<&'static str> {
                let (mut group, mut numbers) = (*self, self.numbers());
                $crate::table::first_out_of_range(&group.fields(&mut numbers), Self::BOUNDS)
            }
        }

        impl serde::Serialize for $Group {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let (mut group, mut numbers) = (*self, self.numbers());
                $crate::table::serialize(&mut group.fields(&mut numbers), serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $Group {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let mut group = Self::default();
                let mut numbers = group.numbers();
                $crate::table::deserialize(&mut group.fields(&mut numbers), deserializer)?;
                let chosen = group.choose(&numbers);
                if chosen { Ok(group) } else { Err(serde::de::Error::custom("no such choice")) }
            }
        }
    };
}

#[doc(inline)]
pub use parameter_group;
