//! Options that say which labels are written beside pictures.

use super::{names, names_of};
use clap::Args;
use etendue::labels::Label;
use etendue_scene::output::labels::LabelFormat;

/// A kind of labels by its name, or every kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelChoice {
    /// Every kind that there is.
    All,
    /// This one.
    One(Label),
}

const CHOICES: [(&str, LabelChoice); Label::ALL.len() + 1] = {
    let mut choices = [("all", LabelChoice::All); Label::ALL.len() + 1];
    let mut i = 0;
    while i < Label::ALL.len() {
        choices[i + 1] = (Label::ALL[i].name(), LabelChoice::One(Label::ALL[i]));
        i += 1;
    }
    choices
};

/// Which labels are written beside a picture.
#[derive(Debug, Args)]
pub struct LabelArgs {
    /// Write labels for data sets beside the picture, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = names_of(&CHOICES))]
    pub labels: Option<Vec<LabelChoice>>,

    /// Files for the arrays of labels
    #[arg(long, value_name = "F", default_value = LabelFormat::Exr.name(), value_parser = names(&LabelFormat::ALL, LabelFormat::name), requires = "labels")]
    pub labels_format: LabelFormat,
}
