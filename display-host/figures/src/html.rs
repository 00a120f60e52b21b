//! Parts of HTML pages that need no network.

use crate::Machine;

/// Style sheet of the reports. On a narrow screen wide tables and charts scroll; on paper, folded
/// parts are open.
pub const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;\
padding:0 1rem;color:#282c34;background:#fff}h1{font-size:1.6rem;margin-bottom:0}h2{margin-top:2rem;\
font-size:1.15rem}table{border-collapse:collapse;margin:.5rem 0}td,th{padding:.25rem .8rem;text-align:\
right;border-bottom:1px solid #ddd}th:first-child,td:first-child{text-align:left}.lead{color:#555;\
margin-top:.2rem}.bad{background:#fbe9e7;border-left:4px solid #9e2a2b;padding:.5rem 1rem}.good{\
background:#e8f3ec;border-left:4px solid #2e7d4f;padding:.5rem 1rem}figure{margin:1rem 0}figcaption{\
color:#555;font-size:.9rem}svg{max-width:100%;height:auto}.frames{display:grid;grid-template-columns:\
repeat(auto-fill,minmax(min(17rem,100%),1fr));gap:.8rem}.frames img{width:100%;border-radius:4px}\
@media(max-width:45rem){table{display:block;overflow-x:auto}figure{overflow-x:auto}figure>svg{max-width:none}}\
@media print{details::details-content{content-visibility:visible;block-size:auto}}\
@media screen and (prefers-color-scheme:dark){html{background:#000}body,img{filter:invert(1) hue-rotate(180deg)}}";

/// Table that describes the machine of a page's figures, followed by other rows.
#[must_use]
pub fn machine_table(m: &Machine, more: &[(&str, &str)]) -> String {
    let (cores, memory) = (m.cores.to_string(), format!("{} MiB", m.memory_mib));
    let kernel = format!("{} {}", m.kernel, m.kernel_version);
    let rows = [
        ("processor", m.processor.as_str()),
        ("cores", &cores),
        ("memory", &memory),
        ("kernel", &kernel),
        (
            "virtual machine",
            if m.virtual_machine { "yes" } else { "no" },
        ),
        ("clock source", &m.clock_source),
        ("governor", &m.governor),
        ("microcode", &m.microcode),
        ("kernel's command line", &m.command_line),
        ("load average", &m.load_average),
    ];
    let rows = rows.iter().chain(more);
    let rows = rows.map(|(name, value)| format!("<tr><td>{name}<td>{}</tr>", escape(value)));
    format!(
        "<h2>Machine</h2><table>{}</table>",
        rows.collect::<String>()
    )
}

/// Escapes text for use between tags and in attributes.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_outside_cannot_become_markup() {
        assert_eq!(escape("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
    }
}
