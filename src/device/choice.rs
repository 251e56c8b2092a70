//! What the user asks for: `auto`, `cpu`, `gpu` or `gpu:N`.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A device, as it is named on the command line and in a configuration file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum DeviceChoice {
    /// A graphics card if there is one that computes, or else the processor. Never a software
    /// adapter.
    #[default]
    Auto,
    /// The processor.
    Cpu,
    /// The first graphics card, or the one of that number. A software adapter too, if it is all
    /// there is or it is named.
    Gpu(Option<u32>),
}

/// A device was named in no known way.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected auto, cpu, gpu or gpu:N (N = 0, 1, …), not {0:?}")]
pub struct DeviceChoiceError(String);

impl FromStr for DeviceChoice {
    type Err = DeviceChoiceError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "gpu" => Ok(Self::Gpu(None)),
            _ => text
                .strip_prefix("gpu:")
                .filter(|n| n.bytes().all(|b| b.is_ascii_digit()))
                .and_then(|n| n.parse().ok())
                .map(|n| Self::Gpu(Some(n)))
                .ok_or_else(|| DeviceChoiceError(text.to_owned())),
        }
    }
}

impl fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Cpu => f.write_str("cpu"),
            Self::Gpu(None) => f.write_str("gpu"),
            Self::Gpu(Some(n)) => write!(f, "gpu:{n}"),
        }
    }
}

impl TryFrom<String> for DeviceChoice {
    type Error = DeviceChoiceError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<DeviceChoice> for String {
    fn from(choice: DeviceChoice) -> Self {
        choice.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for text in ["auto", "cpu", "gpu", "gpu:0", "gpu:17"] {
            assert_eq!(text.parse::<DeviceChoice>().unwrap().to_string(), text);
        }
        assert_eq!(DeviceChoice::default(), DeviceChoice::Auto);
    }

    #[test]
    fn other_names_are_refused() {
        for text in ["", "GPU", "cuda", "gpu:", "gpu:-1", "gpu:+1", "gpu:99999999999", "cpu:0"] {
            let error = text.parse::<DeviceChoice>().unwrap_err();
            assert!(error.to_string().contains("gpu:N"), "{error}");
        }
    }

    #[test]
    fn clap_reads_it() {
        #[derive(clap::Parser)]
        struct Flags {
            #[arg(long, default_value_t)]
            device: DeviceChoice,
        }
        use clap::Parser;
        assert_eq!(Flags::parse_from(["x"]).device, DeviceChoice::Auto);
        assert_eq!(
            Flags::parse_from(["x", "--device", "gpu:2"]).device,
            DeviceChoice::Gpu(Some(2))
        );
        assert!(Flags::try_parse_from(["x", "--device", "tpu"]).is_err());
    }
}
