//! Values of the command line by their names there, in files: `#[serde(with = "by_name")]`.

use clap::ValueEnum;
use serde::{Deserialize, Deserializer, Serializer, de::Error};

pub fn serialize<T: ValueEnum, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    let name = value.to_possible_value();
    to.serialize_str(name.as_ref().map_or("", |name| name.get_name()))
}

pub fn deserialize<'de, T: ValueEnum, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    T::from_str(&String::deserialize(from)?, false).map_err(D::Error::custom)
}
