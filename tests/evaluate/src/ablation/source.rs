//! Finds the tuned values in the core's sources, and makes them variable: `GAIN` becomes
//! `crate::varied::of(17, GAIN)`, which multiplies by a factor that the program sets.

use std::fmt::Write as _;

/// A tuned value: a constant with a number that is no capacity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Parameter {
    /// Path of the module, with `::`.
    pub(super) module: String,
    /// Name of the constant.
    pub(super) name: String,
    /// Its value, as it is written.
    pub(super) value: String,
    /// True if only its own file can read it.
    is_private: bool,
}

/// Types of tuned values. `usize` is left out: these constants are capacities.
const TYPES: [&str; 3] = ["f32", "u32", "u16"];
/// Start of the tests in a file, at its end. They keep the usual values.
const TESTS: &str = "\n#[cfg(test)]\nmod tests {";

/// The tuned values of a file. `module` is its path in the crate, with `::`.
pub(super) fn parameters(module: &str, text: &str) -> Vec<Parameter> {
    let of = |line: (usize, &str)| {
        let (at, line) = line;
        let declared = line.trim_start_matches("pub(crate) ");
        let declared = declared.trim_start_matches("pub(super) ");
        let declared = declared.trim_start_matches("pub ");
        let (name, rest) = declared.strip_prefix("const ")?.split_once(": ")?;
        let (kind, _) = rest.split_once(" =")?;
        let item = &text[at..];
        let value = item[..item.find(';')?].split_once('=')?.1;
        TYPES.contains(&kind).then(|| Parameter {
            module: module.to_owned(),
            name: name.to_owned(),
            value: value.split_whitespace().collect::<Vec<_>>().join(" "),
            is_private: !line.starts_with("pub"),
        })
    };
    let product = product(text);
    let mut at = 0;
    let lines = product.split_inclusive('\n').map(|line| {
        let from = at;
        at += line.len();
        (from, line)
    });
    lines.filter_map(of).collect()
}

/// The file without the tests at its end.
fn product(text: &str) -> &str {
    &text[..text.find(TESTS).map_or(text.len(), |at| at + 1)]
}

/// The file with every use of a tuned value made variable. A use in another constant stays as it
/// is. A `const fn` that uses one is no longer constant.
pub(super) fn varied(module: &str, text: &str, all: &[Parameter]) -> String {
    let product = product(text);
    let mut out = String::with_capacity(2 * text.len());
    let mut rest = product;
    while !rest.is_empty() {
        if let Some(function) = rest.strip_prefix("const fn ") {
            let body = &function[..function.find("\n    }\n").unwrap_or(function.len())];
            if uses_one(module, product, body, all) {
                rest = &rest["const ".len()..];
            }
        }
        let fixed = fixed(rest, out.chars().next_back());
        let (kept, path) = match fixed {
            0 => (0, path(rest)),
            length => (length, 0),
        };
        if kept > 0 {
            out += &rest[..kept];
            rest = &rest[kept..];
            continue;
        }
        if path == 0 {
            let one = rest.chars().next().map_or(1, char::len_utf8);
            out += &rest[..one];
            rest = &rest[one..];
            continue;
        }
        let word = &rest[..path];
        match index(module, product, word, all) {
            Some(index) if out.ends_with("..") || !out.ends_with('.') => {
                let _ = write!(out, "crate::varied::of({index}, {word})");
            }
            _ => out += word,
        }
        rest = &rest[path..];
    }
    out + &text[product.len()..]
}

/// True if a function of this module uses a tuned value.
fn uses_one(module: &str, text: &str, body: &str, all: &[Parameter]) -> bool {
    let is_break = |c: char| !c.is_alphanumeric() && c != '_' && c != ':';
    body.split(is_break)
        .any(|word| index(module, text, word, all).is_some())
}

/// Length of the text at the start that stays: a comment, a text, an import, another constant.
fn fixed(rest: &str, before: Option<char>) -> usize {
    let to = |end: &str| rest.find(end).map_or(rest.len(), |at| at + end.len());
    let starts_word = before.is_none_or(|c| !c.is_alphanumeric() && c != '_');
    if rest.starts_with("//") {
        return to("\n");
    }
    if let Some(inside) = rest.strip_prefix('"') {
        return inside.find('"').map_or(rest.len(), |at| at + 2);
    }
    if !starts_word {
        return 0;
    }
    if rest.starts_with("use ") || rest.starts_with("static ") {
        return to(";");
    }
    // A constant with an array's type has a `;` in its brackets.
    if rest.starts_with("const ") && !rest.starts_with("const fn ") {
        return to(";\n");
    }
    0
}

/// Length of the path at the start: names with `::` between them.
fn path(rest: &str) -> usize {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut length = 0;
    loop {
        let here = &rest[length..];
        let name = here.find(|c| !is_part(c)).unwrap_or(here.len());
        if name == 0 {
            return length;
        }
        length += name;
        let more = rest[length..].strip_prefix("::");
        match more {
            Some(more) if more.starts_with(is_part) => length += 2,
            _ => return length,
        }
    }
}

/// Place of the tuned value that a path names in a file of this module.
fn index(module: &str, text: &str, path: &str, all: &[Parameter]) -> Option<usize> {
    let (prefix, name) = path.rsplit_once("::").unwrap_or(("", path));
    let from = prefix.rsplit("::").next().unwrap_or_default();
    let is_it = |it: &Parameter| {
        if it.name != name {
            return false;
        }
        let stem = it.module.rsplit("::").next().unwrap_or_default();
        match (it.module == module, prefix.is_empty()) {
            (true, is_bare) => is_bare,
            (false, _) if it.is_private => false,
            (false, false) => from == stem,
            (false, true) => imports(text, stem, name),
        }
    };
    all.iter().position(is_it)
}

/// True if a file imports the name from a module with this last name.
fn imports(text: &str, stem: &str, name: &str) -> bool {
    let items = text.split("\nuse ").skip(1);
    let mut items = items.filter_map(|item| item.split(';').next());
    items.any(|item| {
        let mut words = item.split(|c: char| !c.is_alphanumeric() && c != '_');
        item.contains(&format!("{stem}::")) && words.any(|word| word == name)
    })
}

/// The module `varied` of the core, for these values.
pub(super) fn core_module(all: &[Parameter]) -> String {
    let count = all.len();
    let mut text = format!(
        "//! Tuned values that a program varies.\n\n\
         use core::sync::atomic::{{AtomicBool, AtomicU32, Ordering::Relaxed}};\n\n\
         /// Names and values.\n\
         pub const NAMES: [(&str, &str); {count}] = [\n"
    );
    for it in all {
        let _ = writeln!(text, "    ({:?}, {:?}),", it.path(), it.value);
    }
    let _ = write!(
        text,
        "];\n\nconst ONE: u32 = 1.0_f32.to_bits();\n\
         static FACTORS: [AtomicU32; {count}] = [const {{ AtomicU32::new(ONE) }}; {count}];\n\
         static READ: [AtomicBool; {count}] = [const {{ AtomicBool::new(false) }}; {count}];\n{BODY}"
    );
    text
}

/// The rest of [`core_module`], the same for any values.
const BODY: &str = "
/// A number that a factor can change.
pub trait Number: Copy {
    /// The number times a factor, rounded away from the number.
    fn times(self, factor: f32) -> Self;
}

impl Number for f32 {
    fn times(self, factor: f32) -> Self {
        self * factor
    }
}

fn rounded(usual: f32, factor: f32) -> f32 {
    let x = usual * factor;
    let whole = x as u32 as f32;
    if factor > 1.0 && whole < x { whole + 1.0 } else { whole }
}

impl Number for u32 {
    fn times(self, factor: f32) -> Self {
        rounded(self as f32, factor) as Self
    }
}

impl Number for u16 {
    fn times(self, factor: f32) -> Self {
        rounded(f32::from(self), factor) as Self
    }
}

/// The value with this number.
#[inline]
pub fn of<T: Number>(index: usize, usual: T) -> T {
    READ[index].store(true, Relaxed);
    match FACTORS[index].load(Relaxed) {
        ONE => usual,
        factor => usual.times(f32::from_bits(factor)),
    }
}

/// Multiplies a value by a factor.
pub fn vary(index: usize, factor: f32) {
    FACTORS[index].store(factor.to_bits(), Relaxed);
}

/// True if a value was read since [`forget_reads`].
pub fn was_read(index: usize) -> bool {
    READ[index].load(Relaxed)
}

/// Forgets which values were read.
pub fn forget_reads() {
    for it in &READ {
        it.store(false, Relaxed);
    }
}
";

impl Parameter {
    /// Module and name.
    pub(super) fn path(&self) -> String {
        format!("{}::{}", self.module, self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "//! A file.\n\
        use super::law::{self, WIDE};\n\
        /// A gain of 0.25: GAIN.\n\
        const GAIN: f32 = 0.25;\n\
        pub(crate) const STEPS: u32 = 4;\n\
        const ROWS: usize = 8;\n\
        const HALF: f32 = GAIN / 2.0;\n\
        fn f(x: f32) -> f32 {\n    \
            let y = GAIN * x + law::DEEP + WIDE; // GAIN\n    \
            (0..STEPS).for_each(drop);\n    \
            y.max(Self::GAIN) + HALF\n\
        }\n\
        const fn g() -> f32 {\n    GAIN\n}\n\
        impl A {\n    const fn k() -> f32 {\n        AGAIN\n    }\n}\n\
        \n\
        #[cfg(test)]\nmod tests {\n    fn h() -> f32 { GAIN }\n}\n";

    fn known() -> Vec<Parameter> {
        let law = "pub(super) const DEEP: f32 = 1.0;\npub const WIDE: f32 = 2.0;\n";
        let mut all = parameters("contact::law", law);
        all.extend(parameters("contact::skin", FILE));
        all
    }

    #[test]
    fn numbers_are_found_and_capacities_are_not() {
        let paths: Vec<_> = known().iter().map(Parameter::path).collect();
        let own = [
            "contact::skin::GAIN",
            "contact::skin::STEPS",
            "contact::skin::HALF",
        ];
        assert_eq!(paths[..2], ["contact::law::DEEP", "contact::law::WIDE"]);
        assert_eq!(paths[2..], own);
        assert_eq!(known()[4].value, "GAIN / 2.0");
    }

    #[test]
    fn uses_vary_but_not_other_constants_comments_imports_and_tests() {
        let text = varied("contact::skin", FILE, &known());
        let line = "    let y = crate::varied::of(2, GAIN) * x + crate::varied::of(0, law::DEEP) \
                    + crate::varied::of(1, WIDE); // GAIN\n";
        assert!(text.contains(line), "{text}");
        for made in [
            "    y.max(Self::GAIN) + crate::varied::of(4, HALF)\n",
            "(0..crate::varied::of(3, STEPS))",
            "\nfn g() -> f32 {\n    crate::varied::of(2, GAIN)\n}\n",
        ] {
            assert!(text.contains(made), "{made}: {text}");
        }
        for kept in [
            "use super::law::{self, WIDE};\n",
            "const HALF: f32 = GAIN / 2.0;\n",
            "fn h() -> f32 { GAIN }",
            "    const fn k() -> f32 {\n        AGAIN\n    }\n",
        ] {
            assert!(text.contains(kept), "{kept}: {text}");
        }
    }

    #[test]
    fn the_core_module_names_every_value() {
        let text = core_module(&known());
        assert!(
            text.contains("(\"contact::skin::HALF\", \"GAIN / 2.0\"),"),
            "{text}"
        );
        assert!(text.contains("[AtomicU32; 5]"), "{text}");
    }
}
