//! Measures the cost of a frame in every quality tier, and with `--views` of every picture of the
//! gallery: `cargo run --release -p display-host --example frame_cost -- [SCENE.calot] [--size
//! WxH]... [--frames N] [--views] [--csv FILE]`. The docs of `display_host::render::cost` say what
//! is timed. Without a scene the example draws the round organs of the tests. Without `--frames` it
//! times 200 frames on a graphics card and 3 on a software driver.

#[path = "../tests/support/mod.rs"]
mod support;

use std::fmt::Write as _;
use std::path::PathBuf;

use display_host::effects::{Effect, Flow, Kind};
use display_host::gallery;
use display_host::render::cost::{FrameCost, measure, read_back_ms, tiers};
use display_host::render::gpu::Gpu;
use display_host::render::timing::PASSES;
use display_host::render::{Quality, Renderer};
use glam::Vec3;
use shared_mem::scene::SceneFile;

type Error = Box<dyn std::error::Error>;

struct Asked {
    scene: SceneFile,
    sizes: Vec<[u32; 2]>,
    frames: Option<usize>,
    views: bool,
    csv: Option<PathBuf>,
}

/// Cost of a frame in one quality tier, or of one picture of the gallery.
struct Row {
    what: String,
    frame: FrameCost,
    /// Time to read the picture back from the graphics device, ms; not measured for the gallery.
    back_ms: Option<f32>,
}

fn main() -> Result<(), Error> {
    let asked = asked()?;
    let scene = &asked.scene;
    let gpu = Gpu::open()?;
    let usual = if gpu.is_software() { 3 } else { 200 };
    let frames = asked.frames.unwrap_or(usual);
    println!(
        "{}; {}, {} spheres, {} vertices, {} triangles; medians of {frames} frames, ms",
        gpu.describe(),
        scene.name(),
        scene.spheres().len(),
        scene.vertices().len(),
        scene.triangles().len(),
    );
    let mut rows = Vec::new();
    for &size in &asked.sizes {
        rows.extend(every_tier(&gpu, scene, size, frames)?);
    }
    if let (true, Some(&size)) = (asked.views, asked.sizes.first()) {
        rows.extend(every_view(&gpu, scene, size, frames)?);
    }
    if let Some(path) = asked.csv {
        std::fs::write(path, table(&gpu, scene, &rows)?)?;
    }
    Ok(())
}

fn asked() -> Result<Asked, Error> {
    let (mut scene, mut sizes, mut frames) = (None, Vec::new(), None);
    let (mut views, mut csv) = (false, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--size" => {
                let text = value()?;
                let (w, h) = text.split_once('x').ok_or("--size is WxH")?;
                sizes.push([w.parse()?, h.parse()?]);
            }
            "--frames" => frames = Some(value()?.parse()?),
            "--views" => views = true,
            "--csv" => csv = Some(value()?.into()),
            path => scene = Some(SceneFile::open(path.as_ref())?),
        }
    }
    if sizes.is_empty() {
        sizes.push([1920, 1080]);
    }
    Ok(Asked {
        scene: scene.unwrap_or_else(|| support::scene(72)),
        sizes,
        frames,
        views,
        csv,
    })
}

/// Measures every quality tier, while the target smokes and bleeds.
fn every_tier(
    gpu: &Gpu,
    scene: &SceneFile,
    size: [u32; 2],
    frames: usize,
) -> Result<Vec<Row>, Error> {
    let tiers = tiers(gpu, size);
    let mut renderer = Renderer::new(gpu, scene, tiers[0])?;
    let tools = support::tools(scene, 0.0, 0.5);
    let state = support::state(scene, 0.0);
    let spheres = state.spheres().ok_or("state is malformed")?;
    for kind in [Kind::Smoke, Kind::Blood] {
        let effect = Effect {
            kind,
            at_m: Vec3::from(scene.room().target_m),
            along: Vec3::from(scene.room().target_normal),
            strength: 1.0,
            lasts_s: Effect::LEAK_S,
            flow: Flow {
                ml_min: if kind == Kind::Blood { 30.0 } else { 0.0 },
                pulses: true,
            },
        };
        renderer.play(spheres, &[effect], 0.0);
    }
    let mut rows = Vec::new();
    for (tier, quality) in tiers.into_iter().enumerate() {
        renderer.set_quality(gpu, quality)?;
        renderer.play(spheres, &[], 0.5);
        let frame = measure(gpu, &mut renderer, spheres, &tools, frames)?;
        let back_ms = read_back_ms(gpu, &renderer, frames.min(20))?;
        say(&format!("tier {tier}"), &frame);
        println!("{:>44}{back_ms:>8.2} ms to read it back", "");
        rows.push(Row {
            what: format!("tier {tier}"),
            frame,
            back_ms: Some(back_ms),
        });
    }
    Ok(rows)
}

/// Measures every picture of the gallery in the best tier.
fn every_view(
    gpu: &Gpu,
    scene: &SceneFile,
    size: [u32; 2],
    frames: usize,
) -> Result<Vec<Row>, Error> {
    let best = Quality {
        size,
        ..tiers(gpu, size)[0]
    };
    let costs = gallery::cost(gpu, scene, best, frames, &mut |_, _| {})?;
    let mut rows = Vec::new();
    for cost in costs {
        say(&cost.title, &cost.frame);
        rows.push(Row {
            what: format!("{}: {}", cost.chapter, cost.title),
            frame: cost.frame,
            back_ms: None,
        });
    }
    Ok(rows)
}

fn table(gpu: &Gpu, scene: &SceneFile, rows: &[Row]) -> Result<String, Error> {
    let mut text = "card,driver,scene,what,width,height,drawn_ms,drawn_p99_ms,submitted_ms,\
                    computed_ms,per_second,read_back_ms"
        .to_owned();
    for pass in PASSES {
        write!(text, ",{pass}_ms")?;
    }
    text.push('\n');
    for Row {
        what,
        frame,
        back_ms,
    } in rows
    {
        let (card, driver, scene) = (&gpu.info.name, &gpu.info.driver_info, scene.name());
        let [width, height] = frame.size;
        write!(
            text,
            "\"{card}\",\"{driver}\",\"{scene}\",\"{what}\",{width},{height}"
        )?;
        for ms in [
            frame.drawn_ms,
            frame.drawn_p99_ms,
            frame.submitted_ms,
            frame.computed_ms,
        ] {
            write!(text, ",{ms:.3}")?;
        }
        let back_ms = back_ms.map_or(String::new(), |ms| format!("{ms:.3}"));
        write!(text, ",{:.1},{back_ms}", frame.per_second)?;
        for pass in PASSES {
            let ms = frame.passes_ms.iter().find(|(name, _)| *name == pass);
            write!(
                text,
                ",{}",
                ms.map_or(String::new(), |(_, ms)| format!("{ms:.3}"))
            )?;
        }
        text.push('\n');
    }
    Ok(text)
}

fn say(what: &str, frame: &FrameCost) {
    let [w, h] = frame.size;
    print!(
        "{what:<34}{:>10}{:>8.2} drawn, {:.2} p99, {:.2} of them submitting, {:.2} computed; {:.0} a second;",
        format!("{w}x{h}"),
        frame.drawn_ms,
        frame.drawn_p99_ms,
        frame.submitted_ms,
        frame.computed_ms,
        frame.per_second
    );
    for (pass, ms) in &frame.passes_ms {
        print!(" {pass} {ms:.3}");
    }
    println!();
}
