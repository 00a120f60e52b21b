//! The network: zenoh over TLS, with certificates on both sides.
//!
//! The centre is zenoh's router. Stations connect to it and to nobody else, and do not learn of
//! each other. zenoh lets a station do everything below its own certificate's name, and nothing
//! elsewhere; a certificate that is not on the list may do nothing.

use serde_json::{Value, json};
use zenoh::{Config, Session};

use crate::error::{CentreError, network};
use crate::keys::Keys;
use crate::roster::Roster;

/// All kinds of messages that zenoh can allow.
const MESSAGES: [&str; 9] = [
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "reply",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
];

/// Opens the centre's end: listens for the stations of the list.
///
/// # Errors
/// [`CentreError::Listen`], or what the library refuses.
pub async fn listen(address: &str, keys: &Keys, roster: &Roster) -> Result<Session, CentreError> {
    let mut config = common(json!({
        "listen_certificate": keys.certificate,
        "listen_private_key": keys.key,
        "root_ca_certificate": keys.authority,
        "enable_mtls": true,
        "close_link_on_expiration": true,
    }))?;
    set(&mut config, "mode", &json!("router"))?;
    set(
        &mut config,
        "listen/endpoints",
        &json!([format!("tls/{address}")]),
    )?;
    set(&mut config, "access_control", &rights(roster))?;
    zenoh::open(config)
        .await
        .map_err(|error| CentreError::Listen {
            address: address.to_owned(),
            problem: error.to_string(),
        })
}

/// Opens a station's end. The library connects again whenever the line is lost.
///
/// # Errors
/// If the centre is not reached, or refuses the certificate.
pub async fn join(address: &str, keys: &Keys) -> Result<Session, CentreError> {
    let mut config = common(json!({
        "connect_certificate": keys.certificate,
        "connect_private_key": keys.key,
        "root_ca_certificate": keys.authority,
        "enable_mtls": true,
        "verify_name_on_connect": true,
        "close_link_on_expiration": true,
    }))?;
    set(&mut config, "mode", &json!("client"))?;
    set(
        &mut config,
        "connect/endpoints",
        &json!([format!("tls/{address}")]),
    )?;
    zenoh::open(config)
        .await
        .map_err(network("connecting to the centre"))
}

/// Settings of both ends: TLS only, nobody is searched for or told of.
fn common(tls: Value) -> Result<Config, CentreError> {
    let mut config = Config::default();
    for (key, value) in [
        ("scouting/multicast/enabled", json!(false)),
        ("scouting/gossip/enabled", json!(false)),
        ("transport/link/protocols", json!(["tls"])),
        ("transport/link/tls", tls),
    ] {
        set(&mut config, key, &value)?;
    }
    Ok(config)
}

fn set(config: &mut Config, key: &'static str, value: &Value) -> Result<(), CentreError> {
    let set = config.insert_json5(key, &value.to_string());
    set.map_err(|error| network(key)(error))
}

/// Rights of the stations, as zenoh's configuration has them.
fn rights(roster: &Roster) -> Value {
    let names = || roster.stations.keys();
    let rules = names().map(|name| {
        json!({
            "id": name, "messages": MESSAGES, "flows": ["ingress", "egress"], "permission": "allow",
            "key_exprs": [format!("calot/{name}/**")],
        })
    });
    let subjects = names().map(|name| json!({"id": name, "cert_common_names": [name]}));
    let policies = names().map(|name| json!({"rules": [name], "subjects": [name]}));
    json!({
        "enabled": true,
        "default_permission": "deny",
        "rules": rules.collect::<Vec<_>>(),
        "subjects": subjects.collect::<Vec<_>>(),
        "policies": policies.collect::<Vec<_>>(),
    })
}
