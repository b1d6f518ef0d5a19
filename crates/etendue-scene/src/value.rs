//! Input as a tree of values with their origins, whatever the syntax it was written in.

use crate::{FileId, Origin, Span};

/// A value and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// What it is.
    pub data: Data,
    /// Where it is.
    pub origin: Origin,
}

/// The kinds of values.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Keys and values in the order of the file.
    Table(Vec<Entry>),
    /// Values in order.
    Array(Vec<Value>),
    /// Text.
    String(String),
    /// A whole number.
    Integer(i64),
    /// Any other number, also NaN and infinities.
    Float(f64),
    /// True or false.
    Boolean(bool),
    /// A date, a time, or both, as in RFC 3339.
    Moment(String),
    /// Could not be read; already reported.
    Broken,
}

/// One key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key is; [`Value::origin`] is where its value is.
    pub origin: Origin,
    /// Its value.
    pub value: Value,
}

impl Data {
    /// The kind with its article, for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Data::Table(_) => "a table",
            Data::Array(_) => "an array",
            Data::String(_) => "a string",
            Data::Integer(_) => "an integer",
            Data::Float(_) => "a number",
            Data::Boolean(_) => "a boolean",
            Data::Moment(_) => "a date or time",
            Data::Broken => "something unreadable",
        }
    }
}

impl Value {
    /// A value at bytes `start..end` of `file`.
    pub fn at(data: Data, file: FileId, range: std::ops::Range<usize>) -> Self {
        Self { data, origin: Span::new(file, range).into() }
    }
}
