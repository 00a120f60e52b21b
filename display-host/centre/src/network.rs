//! The network: zenoh over TLS, with certificates on both sides.
//!
//! The centre is zenoh's router. Stations connect to it and to nobody else, and do not learn of
//! each other. zenoh lets a station use the topics below the name in its certificate, and no
//! others. A certificate that is not on the list gives no rights.
//!
//! zenoh's link over TLS (zenoh-link-tls 1.10.2, eclipse-zenoh/zenoh issue 2557) reads and writes
//! one rustls connection without a lock. Two threads that did so broke connections: 4 stations lost
//! 7 in 5 minutes. So one thread does all of zenoh's work here, see [`on_one_thread`]. zenoh's link
//! over QUIC has no such fault. But UDP is blocked in many houses, and the end of a killed process
//! is noticed late.

use std::os::unix::process::CommandExt as _;
use std::process::Command;

use serde_json::{Value, json};
use zenoh::{Config, Session};

use crate::error::{CentreError, network};
use crate::keys::Keys;
use crate::roster::Roster;

/// Environment variable for zenoh's threads, and its value: one thread does the work of all.
const THREADS: (&str, &str) = (
    "ZENOH_RUNTIME",
    "(rx: (handover: tx), acc: (handover: tx), net: (handover: tx), app: (handover: tx), \
     tx: (worker_threads: 1))",
);

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

/// Restarts this program with the setting that gives zenoh one thread, unless the setting is there.
/// zenoh reads it from the environment alone, which a running program cannot change safely.
///
/// # Errors
/// If the program does not start again.
pub fn on_one_thread() -> std::io::Result<()> {
    if has_one_thread() {
        return Ok(());
    }
    let mut again = Command::new(std::env::current_exe()?);
    again.args(std::env::args_os().skip(1));
    Err(again.env(THREADS.0, THREADS.1).exec())
}

fn has_one_thread() -> bool {
    std::env::var(THREADS.0).is_ok_and(|it| it == THREADS.1)
}

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

/// Settings of both ends: TLS only, and no search for other peers.
fn common(tls: Value) -> Result<Config, CentreError> {
    if !has_one_thread() {
        return Err(CentreError::Threads(THREADS.0, THREADS.1));
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_network_is_not_used_with_several_threads() {
        // Test programs are not started with the setting.
        let said = common(json!({})).unwrap_err().to_string();
        assert!(
            said.contains("would use several threads; set ZENOH_RUNTIME=(rx: (handover: tx)"),
            "{said}"
        );
    }

    #[test]
    fn rights_of_a_station_end_at_its_own_name() {
        let mut roster = Roster::default();
        roster
            .stations
            .insert("left-2".to_owned(), "left".to_owned());
        let rights = rights(&roster);
        assert_eq!(rights["default_permission"], "deny");
        assert_eq!(rights["rules"][0]["key_exprs"], json!(["calot/left-2/**"]));
        assert_eq!(
            rights["subjects"][0]["cert_common_names"],
            json!(["left-2"])
        );
        assert_eq!(rights["policies"][0]["subjects"], json!(["left-2"]));
    }
}
