//! The thesis's visual survey (section 5.5, appendix A) as two pages without a server: one shows the pictures in random
//! order and saves a person's answers as CSV, the other adds the answers of all people up, like figures 5.5 to 5.9.
//! Nothing is loaded from elsewhere: pictures are part of the page.

use serde::Serialize;

use crate::error::{Error, Kind, Result};
use crate::report::data_url;

/// The page that adds answers up.
pub const TALLY: &str = include_str!("tally.html");

/// A part of the survey: the same detail in several ways.
#[derive(Serialize)]
pub struct Part {
    pub name: String,
    pub pictures: Vec<Choice>,
}

/// A picture to rank.
#[derive(Serialize)]
pub struct Choice {
    pub configuration: &'static str,
    /// A `data:` address.
    image: String,
}

impl Choice {
    /// Of an encoded picture.
    pub fn new(configuration: &'static str, png: &[u8]) -> Choice {
        Choice { configuration, image: data_url(png) }
    }
}

/// The page that asks.
pub fn page(parts: &[Part]) -> Result<String> {
    #[derive(Serialize)]
    struct Data<'a> {
        scenes: &'a [Part],
    }
    let data = serde_json::to_string(&Data { scenes: parts }).map_err(|e| Error::new(Kind::Failure, e))?;
    // No name can end the script element that the data stands in.
    Ok(include_str!("survey.html").replace("__DATA__", &data.replace('<', "\\u003c")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_can_leave_the_data() {
        let part = Part { name: "</script><b>__DATA__".to_owned(), pictures: vec![Choice::new("plane1", b"png")] };
        let page = page(&[part]).unwrap();
        assert!(!page.contains("</script><b>") && page.contains("\\u003c/script>\\u003cb>"));
        assert!(page.contains("data:image/png;base64,cG5n"));
    }
}
