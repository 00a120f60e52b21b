//! Finding about the graphics card. Without one, the display may draw too few pictures to train
//! with.

use display_host::render::gpu::Gpu;

use super::finding::{Finding, Verdict, finding};

/// Device that draws the pictures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Adapter {
    /// A graphics card.
    Card(String),
    /// A driver that draws on the processor.
    Software(String),
    /// Nothing, for this reason.
    None(String),
}

impl Adapter {
    /// Opens the adapter that the display would use.
    pub(super) fn open() -> Self {
        match Gpu::open() {
            Ok(gpu) if gpu.is_software() => Self::Software(gpu.describe()),
            Ok(gpu) => Self::Card(gpu.describe()),
            Err(error) => Self::None(error.to_string()),
        }
    }
}

pub(super) fn graphics(adapter: &Adapter) -> Finding {
    let (verdict, is, mend) = match adapter {
        Adapter::Card(name) => (Verdict::Good, name.clone(), ""),
        Adapter::Software(name) => (Verdict::Better, format!("none; drawn by {name}"), ""),
        Adapter::None(why) => (
            Verdict::Better,
            format!("none: {why}"),
            "sudo apt-get install mesa-vulkan-drivers",
        ),
    };
    let should = "a graphics card: a processor alone often draws fewer than 10 pictures a second, \
                  too few to train with; the window tells the number";
    finding("graphics card", verdict, is, should, mend)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_graphics_card_the_finding_warns_of_too_few_pictures() {
        let card = graphics(&Adapter::Card("Radeon".to_owned()));
        assert_eq!((card.verdict, &*card.is), (Verdict::Good, "Radeon"));
        let software = graphics(&Adapter::Software("llvmpipe".to_owned()));
        assert_eq!((software.verdict, software.mend), (Verdict::Better, None));
        assert!(software.is.contains("llvmpipe"), "{}", software.is);
        assert!(software.should.contains("too few to train with"));
        let none = graphics(&Adapter::None("no driver".to_owned()));
        assert!(none.is.contains("no driver") && none.mend.is_some());
    }
}
