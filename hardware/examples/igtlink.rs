//! Serves a circling tool over OpenIGTLink: `cargo run -p hardware --example igtlink`, then
//! connect 3D Slicer (OpenIGTLinkIF, client) or any other client to the port that it prints.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use hardware::igtlink::Server;
use hardware::igtlink::message::Message;
use nalgebra::{Isometry3, Translation3};

fn main() -> std::io::Result<()> {
    let mut server = Server::bind(("127.0.0.1", Server::PORT), "Circle", "ras")?;
    println!(
        "serving ToolToReference at {}; Ctrl-C ends it",
        server.address()?
    );
    // Someone may set the wall clock while the example runs, but time stamps must not run
    // backwards.
    let began = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let start = Instant::now();
    loop {
        let now = began + start.elapsed();
        let (sin, cos) = (now.as_secs_f64() % std::f64::consts::TAU).sin_cos();
        let pose: Isometry3<f32> =
            Translation3::new(0.05 * cos as f32, 0.05 * sin as f32, 0.01).into();
        let unix_ns = now.as_nanos() as u64;
        server.attend(unix_ns);
        if let Some(message) = Message::transform("ToolToReference", &pose, unix_ns) {
            server.send(&[message]);
        }
        std::thread::sleep(Duration::from_millis(16));
    }
}
