//! Compiles patients to `DIR/patient-NAME.calot`, and prints each report.
//!
//! ```text
//! cargo run -p scene-prepare --example patients -- DIR ada 17 …
//! ```
#![allow(clippy::print_stdout)] // what it prints is its result

use std::path::Path;
use std::time::Instant;

use scene_prepare::patient::Patient;
use scene_prepare::prepare;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, names @ ..] = words.as_slice() else {
        println!("patients DIR NAME…");
        return;
    };
    for name in names {
        let began = Instant::now();
        let patient = Patient::of_word(name).expect("a patient");
        println!("{patient}");
        let prepared = match prepare(&patient.recipe().expect("a recipe"), &mut |_| {}) {
            Ok(prepared) => prepared,
            Err(problem) => {
                println!("{problem}");
                continue;
            }
        };
        println!("{}{:.2?}", prepared.report, began.elapsed());
        let path = Path::new(folder).join(format!("patient-{name}.calot"));
        let bytes = prepared.scene.to_bytes().expect("a sound scene");
        std::fs::write(path, bytes).expect("it can be written");
    }
}
