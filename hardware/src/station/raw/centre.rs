//! The section `[centre]`.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::File;
use crate::HardwareError;
use crate::station::CentreSpec;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCentre {
    address: Spanned<String>,
    keys: Option<PathBuf>,
}

impl File<'_> {
    pub(super) fn centre(&self, raw: RawCentre) -> Result<CentreSpec, HardwareError> {
        let address = raw.address.get_ref();
        let parts = address.rsplit_once(':');
        let is_whole = |(host, port): (&str, &str)| !host.is_empty() && port.parse::<u16>().is_ok();
        if !parts.is_some_and(is_whole) {
            let what = format!(
                "centre.address is '{address}', allowed is HOST:PORT, for example 10.0.0.2:7448"
            );
            return Err(self.error(raw.address.span().start, what));
        }
        Ok(CentreSpec {
            address: raw.address.into_inner(),
            keys: raw.keys,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    #[test]
    fn a_centre_has_an_address_and_a_wrong_one_is_named_with_its_line() {
        let read = |lines: &str| {
            let file = parse(&format!("[centre]\n{lines}"), "station.toml".as_ref());
            file.map_err(|error| error.to_string())
        };
        let found = read("address = \"centre.example:7448\"\nkeys = \"/etc/calot/keys\"\n");
        let centre = CentreSpec {
            address: "centre.example:7448".to_owned(),
            keys: Some("/etc/calot/keys".into()),
        };
        assert_eq!(found.unwrap().centre, Some(centre));
        for wrong in ["centre", ":7448", "centre:https", "centre:70000"] {
            let said = read(&format!("address = \"{wrong}\"")).unwrap_err();
            let words = format!(":2: centre.address is '{wrong}', allowed is HOST:PORT");
            assert!(said.contains(&words), "{said}");
        }
        assert!(read("").is_err(), "the address is missing");
    }
}
