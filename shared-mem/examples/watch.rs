//! Prints the state of a running station four times a second: `cargo run -p shared-mem --example
//! watch -- [STATION] [SECONDS]`.

use std::error::Error;
use std::time::{Duration, Instant};

use shared_mem::message::{EventMsg, StateFrame, ToolFrame};
use shared_mem::service::{Host, Station};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let station = Station::new(args.next().as_deref().unwrap_or("main"))?;
    let seconds = args.next().map_or(Ok(f64::INFINITY), |text| text.parse())?;
    let host = Host::open(&station)?;
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    let mut first: Option<Vec<[f32; 3]>> = None;
    let start = Instant::now();
    println!("    tick  force N  contacts  jaw  tip (mm)               moved most (mm)");
    while start.elapsed().as_secs_f64() < seconds {
        host.drain_events(|event: &EventMsg| {
            println!(
                "event {} kind {} value {:.2}",
                event.sequence, event.kind, event.value
            );
        });
        let fresh = host.newest_state(&mut state) & host.newest_tools(&mut tools);
        if let Some(spheres) = state.spheres().filter(|_| fresh) {
            let centers: Vec<[f32; 3]> = spheres.iter().map(|s| s.center_m).collect();
            let rest = first.get_or_insert_with(|| centers.clone());
            let moved = centers.iter().zip(rest).map(|(a, b)| distance(*a, *b));
            let most = moved.fold(0.0, f32::max) * 1e3;
            let force = distance(tools.force_n, [0.0; 3]);
            let tip = tools.world_from_instrument.position_m.map(|x| x * 1e3);
            println!(
                "{:8}  {force:7.3}  {:8}  {:3.1}  {:6.1} {:6.1} {:6.1}   {most:6.2}",
                tools.tick, tools.contact_count, tools.jaw, tip[0], tip[1], tip[2],
            );
        }
        std::thread::sleep(Duration::from_millis(250));
    }
    Ok(())
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f32>()
        .sqrt()
}
