//! Compiles `proto/calot.proto` to Rust, and to the description that each session embeds.

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=proto");
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    let mut compiler = protox::Compiler::new(["proto"])?;
    compiler.open_file("calot.proto")?;
    std::fs::write(out.join("calot.bin"), compiler.encode_file_descriptor_set())?;
    // The comments become documentation.
    compiler.include_source_info(true);
    let described = compiler.file_descriptor_set();
    prost_build::Config::new().compile_fds(described)?;
    Ok(())
}
