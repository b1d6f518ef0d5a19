//! How pictures of 8 bits are made.

use super::{finite_in, names};
use clap::Args;
use etendue::{
    spectrum::Spectrum,
    tonemap::{DisplayTransform, Encoding, ToneCurve},
};

/// What lies between linear light and bytes.
#[derive(Clone, Debug, Default, Args)]
pub struct DisplayArgs {
    /// Brighten 8 bit pictures by this many stops
    #[arg(long, value_name = "STOPS", value_parser = parse_exposure)]
    pub exposure: Option<f32>,

    /// Multiply 8 bit pictures by a number, or red, green and blue by three
    #[arg(long, value_name = "R,G,B", value_parser = parse_balance)]
    pub balance: Option<Spectrum>,

    /// Tone curve of 8 bit pictures
    #[arg(long, value_name = "T", value_parser = names(&ToneCurve::ALL, ToneCurve::name))]
    pub tonemap: Option<ToneCurve>,

    /// How 8 bit pictures are stored: for screens, or in proportion to the light
    #[arg(long, value_name = "E", value_parser = names(&Encoding::ALL, Encoding::name))]
    pub encoding: Option<Encoding>,
}

impl DisplayArgs {
    /// Puts what was given in the place of what is there.
    pub fn replace_in(&self, display: &mut DisplayTransform) {
        *display = DisplayTransform {
            exposure: self.exposure.unwrap_or(display.exposure),
            balance: self.balance.unwrap_or(display.balance),
            curve: self.tonemap.unwrap_or(display.curve),
            encoding: self.encoding.unwrap_or(display.encoding),
        };
    }

    /// The first option given, as it is spelt.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--exposure", self.exposure.is_some()),
            ("--balance", self.balance.is_some()),
            ("--tonemap", self.tonemap.is_some()),
            ("--encoding", self.encoding.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }
}

fn parse_exposure(text: &str) -> Result<f32, String> {
    finite_in(text, -64.0, 64.0)
}

fn parse_balance(text: &str) -> Result<Spectrum, String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|n| finite_in(n.trim(), 0.0, 1e30).ok()).collect();
    match numbers.as_deref() {
        Some(&[grey]) => Ok(Spectrum::splat(grey)),
        Some(&[red, green, blue]) => Ok(Spectrum([red, green, blue])),
        _ => Err("expected a number, or R,G,B such as 1.1,1,0.9, from 0 to 1e30".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values() {
        assert_eq!(parse_exposure("-1.5"), Ok(-1.5));
        for bad in ["nan", "inf", "65", "x"] {
            assert!(parse_exposure(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_balance("2"), Ok(Spectrum::splat(2.0)));
        assert_eq!(parse_balance("1.5, 1,0.25"), Ok(Spectrum([1.5, 1.0, 0.25])));
        for bad in ["", "1,2", "1,2,3,4", "-1", "1,2,nan", "x"] {
            assert!(parse_balance(bad).is_err(), "{bad}");
        }
    }
}
