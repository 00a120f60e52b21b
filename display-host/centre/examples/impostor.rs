//! A station that sends under the name of another station, and prints what it receives from others.
//! A test of the rights of certificates starts it: `impostor ADDRESS KEYS OTHER`.

use std::time::Duration;

use centre::keys::Keys;
use centre::network;
use centre::topic::Topic;

fn main() {
    network::on_one_thread().expect("it starts again");
    speak();
}

#[tokio::main]
async fn speak() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [address, folder, other] = words.as_slice() else {
        panic!("impostor ADDRESS KEYS OTHER");
    };
    let keys = Keys::read(folder.as_ref()).expect("keys");
    let session = network::join(address, &keys).await.expect("the centre");
    // A session receives its own messages, so a second session listens.
    let listening = network::join(address, &keys).await.expect("the centre");
    for names in ["*", other, &keys.name] {
        let heard = |sample: zenoh::sample::Sample| println!("heard {}", sample.key_expr());
        let names = listening.declare_subscriber(format!("calot/{names}/**"));
        names
            .callback(heard)
            .background()
            .await
            .expect("a subscriber");
    }
    let token = session.liveliness();
    let token = token.declare_token(Topic::Presence.of(other));
    let _token = token.await.expect("a token");
    let state = serde_json::json!({
        "operation": 1, "trainee": "impostor", "running": true, "paused": false, "realtime": true,
        "ticks": 1, "missed": 0, "late": 0, "device": "live", "task": null,
        "alarms": 0, "newest_alarms": [],
    });
    loop {
        for name in [other, &keys.name] {
            let sent = session.put(Topic::State.of(name), state.to_string()).await;
            sent.expect("put");
        }
        let result = session.get(Topic::Result.of(other)).payload("{}");
        let result = result.timeout(Duration::from_secs(1)).await.expect("asked");
        while let Ok(reply) = result.recv_async().await {
            if reply.result().is_ok() {
                println!("heard an answer to {other}");
            }
        }
        println!("spoke");
    }
}
