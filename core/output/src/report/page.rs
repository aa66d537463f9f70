//! The report as a page.

use super::path::{ByKind, PathFigures};
use super::plan::Report;
use super::record::FileRecord;
use super::summary::{compared, comparison, facts};
use std::fmt::Write;

pub(super) const STYLE: &str = "\
:root { color-scheme: light dark; --ink: #22262b; --ground: #fff; --line: #d9dce0; --warn: #a84300 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e8ea; --ground: #16181b; --line: #3a3f45; --warn: #ff9a4d }
}
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--ground);
  max-width: 1000px; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem }
table { border-collapse: collapse }
th, td { padding: .25rem .9rem .25rem 0; border-bottom: 1px solid var(--line); text-align: left;
  font-weight: normal; vertical-align: top }
thead th, .delivered { font-weight: 600 }
.number { text-align: right; font-variant-numeric: tabular-nums }
.scroll { overflow-x: auto }
.warning { border-left: 4px solid var(--warn); padding-left: .8rem }
figure { margin: 1rem 0 } figure svg { width: 100%; height: auto; border-radius: 6px }
code { font-size: 12px; overflow-wrap: anywhere }
.setup { display: flex; flex-wrap: wrap; gap: 1rem 2rem } .setup table { flex: 3 1 20rem }
.setup figure { flex: 1 1 14rem; max-width: 20rem; margin: 0 }
@media print {
  :root { color-scheme: light; --ink: #000; --ground: #fff; --line: #bbb; --warn: #000 }
  body { margin: 0; max-width: none; font-size: 10pt }
  h2, tr, figure, .warning { break-inside: avoid } h2 { break-after: avoid }
}
";

/// Heading of the picture of the tool, which stands in the setup.
const TOOL: &str = "Tool";

/// The whole page; `pictures`: heading and SVG text of each.
pub fn page(report: &Report, pictures: &[(&str, &str)]) -> String {
    let name = escaped(&report.job);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
    );
    warnings(&mut html, report);
    broken(&mut html, report);
    setup(&mut html, report, pictures);
    fact_table(&mut html, report);
    comparison_table(&mut html, report);
    verification(&mut html, report);
    for (heading, svg) in pictures.iter().filter(|(heading, _)| *heading != TOOL) {
        // Writing to a string cannot fail.
        let _ = write!(html, "<h2>{}</h2>\n<figure>\n{svg}</figure>\n", escaped(heading));
    }
    hub(&mut html, report);
    texture(&mut html, report);
    kind_table(&mut html, &report.delivered);
    lifted_table(&mut html, report);
    repairs(&mut html, report);
    file_table(&mut html, "Files read", &report.inputs);
    file_table(&mut html, "Files written", &report.outputs);
    let version = escaped(&report.versions.evencut);
    let _ = write!(html, "<p>Made by evencut {version}.</p>\n</body>\n</html>\n");
    html
}

fn warnings(html: &mut String, report: &Report) {
    for w in &report.warnings {
        let (stage, message) = (escaped(&w.stage), escaped(&w.message));
        let remedy = match w.remedy.as_str() {
            "" => String::new(),
            remedy => format!("<br>Remedy: {}", escaped(remedy)),
        };
        let _ =
            writeln!(html, "<p class=\"warning\"><strong>{stage}:</strong> {message}{remedy}</p>");
    }
}

/// Said before the setup: a program that breaks a limit is not to be run.
fn broken(html: &mut String, report: &Report) {
    let count = report.verification.as_ref().map_or(0, |v| v.broken.len());
    if count > 0 {
        let limits = if count == 1 { "limit is" } else { "limits are" };
        let _ = writeln!(
            html,
            "<p class=\"warning\"><strong>Do not run this program:</strong> {count} {limits} broken; see Measured.</p>"
        );
    }
}

/// What is to be set up at the machine, with the drawing of the tool beside it.
fn setup(html: &mut String, report: &Report, pictures: &[(&str, &str)]) {
    let Some(setup) = &report.setup else { return };
    html.push_str("<h2>Setup</h2>\n<div class=\"setup\">\n<table>\n");
    for (label, value) in setup.lines() {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&value));
    }
    html.push_str("</table>\n");
    if let Some((_, svg)) = pictures.iter().find(|(heading, _)| *heading == TOOL) {
        let _ = write!(html, "<figure>\n{svg}</figure>\n");
    }
    html.push_str("</div>\n<h2>Plan</h2>\n");
}

fn fact_table(html: &mut String, report: &Report) {
    html.push_str("<table>\n");
    for (label, value) in facts(report) {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&value));
    }
    html.push_str("</table>\n");
}

fn verification(html: &mut String, report: &Report) {
    let Some(v) = &report.verification else { return };
    html.push_str("<h2>Measured</h2>\n<p>By a simulation of the finished path.</p>\n");
    for sentence in &v.broken {
        let sentence = escaped(sentence);
        let _ = writeln!(html, "<p class=\"warning\"><strong>broken:</strong> {sentence}</p>");
    }
    for remedy in &v.remedies {
        let _ = writeln!(html, "<p>Remedy: {}</p>", escaped(&remedy.replace('`', "")));
    }
    html.push_str("<table>\n");
    for (label, line) in v.short() {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&line));
    }
    html.push_str("</table>\n");
}

/// The channels of a hub.
fn hub(html: &mut String, report: &Report) {
    let Some(hub) = &report.hub else { return };
    html.push_str("<h2>Channels of the hub</h2>\n<table>\n");
    for (label, value) in hub.lines() {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&value));
    }
    html.push_str("</table>\n");
}

/// What its picture, the last one, is captioned with.
fn texture(html: &mut String, report: &Report) {
    let Some(texture) = &report.texture else { return };
    html.push_str("<table>\n");
    for (label, value) in texture.lines() {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&value));
    }
    html.push_str("</table>\n");
}

fn comparison_table(html: &mut String, report: &Report) {
    html.push_str(match report.plain {
        Some(_) => {
            "<h2>Plain passes and what is delivered</h2>\n<p>Plain: the passes at the full feed. Slowed \
             throughout: the same at the one feed that keeps the limits on rate, power and force. Slowed locally: \
             only where one of them would be exceeded.</p>\n"
        }
        None => "<h2>Delivered path</h2>\n",
    });
    html.push_str("<div class=\"scroll\"><table>\n<thead><tr><th></th>");
    for (name, _) in compared(report) {
        let _ = write!(html, "<th class=\"number\">{name}</th>");
    }
    html.push_str("</tr></thead>\n");
    for (label, values) in comparison(report) {
        let _ = write!(html, "<tr><th>{label}</th>");
        for (i, value) in values.iter().enumerate() {
            let class = if i + 1 == values.len() { "number delivered" } else { "number" };
            let _ = write!(html, "<td class=\"{class}\">{value}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}

fn kind_table(html: &mut String, path: &PathFigures) {
    html.push_str(
        "<h2>Delivered path by kind of move</h2>\n<div class=\"scroll\"><table>\n<thead><tr>\
         <th></th><th class=\"number\">length, mm</th><th class=\"number\">time, s</th>\
         <th class=\"number\">on the machine, s</th></tr></thead>\n",
    );
    let [lengths, times, machine_times] =
        [&path.length_mm, &path.time_s, &path.machine_time_s].map(ByKind::rows);
    for ((&(label, length), (_, time)), (_, machine_time)) in
        lengths.iter().zip(times).zip(machine_times)
    {
        let _ = write!(html, "<tr><th>{label}</th>");
        for value in [length, time, machine_time] {
            let _ = write!(html, "<td class=\"number\">{value:.1}</td>");
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</table></div>\n");
}

fn lifted_table(html: &mut String, report: &Report) {
    if report.gouge.lifted.is_empty() {
        return;
    }
    html.push_str(
        "<h2>Where the cutter was lifted</h2>\n<div class=\"scroll\"><table>\n<thead><tr>\
         <th>from, mm</th><th class=\"number\">length, mm</th><th class=\"number\">by, mm</th>\
         </tr></thead>\n",
    );
    for span in &report.gouge.lifted {
        let [x, y, z] = span.from_mm;
        let (length, by) = (span.length_mm, span.lifted_by_mm);
        let _ = writeln!(
            html,
            "<tr><td>({x:.2}, {y:.2}, {z:.2})</td><td class=\"number\">{length:.2}</td>\
             <td class=\"number\">{by:.3}</td></tr>"
        );
    }
    html.push_str("</table></div>\n");
}

fn repairs(html: &mut String, report: &Report) {
    if report.repairs.is_empty() {
        return;
    }
    html.push_str("<h2>Mended in the mesh</h2>\n<ul>\n");
    for repair in &report.repairs {
        let _ = writeln!(html, "<li>{}</li>", escaped(repair));
    }
    html.push_str("</ul>\n");
}

fn file_table(html: &mut String, heading: &str, files: &[FileRecord]) {
    let _ = write!(
        html,
        "<h2>{heading}</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th>name</th>\
         <th class=\"number\">bytes</th><th>SHA-256</th></tr></thead>\n"
    );
    for file in files {
        let (name, bytes, digest) = (escaped(&file.name), file.bytes, &file.sha256);
        let _ = writeln!(
            html,
            "<tr><td>{name}</td><td class=\"number\">{bytes}</td><td><code>{digest}</code></td></tr>"
        );
    }
    html.push_str("</table></div>\n");
}

/// Text with the characters that mean something to HTML and XML replaced.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use crate::report::samples;

    #[test]
    fn page_asks_for_nothing_and_escapes() {
        let mut report = samples::report();
        report.job = "<script>x</script>".to_owned();
        let html = report.to_html(&[("Flat map", "<svg></svg>")]);
        assert!(!html.contains("<script>") && !html.contains("src=") && !html.contains("http"));
        assert!(html.contains("<h2>Flat map</h2>\n<figure>\n<svg></svg>"));
    }

    #[test]
    fn same_report_same_bytes() {
        let report = samples::report();
        assert_eq!(report.to_html(&[]), report.clone().to_html(&[]));
        assert_eq!(report.to_json(), report.clone().to_json());
    }
}
