//! The report on one screen.

use super::path::{PathFigures, RateFigures};
use super::plan::{Report, Warning};
use std::fmt::Write;

/// Warnings shown at most; the report itself has all.
const WARNINGS: usize = 4;
/// Lines that warnings may fill: those of a screen.
const LINES: usize = 38;

/// Rows of the comparison that only the page has.
const IN_THE_REPORT: [&str; 4] =
    ["feed, mm/min", "peak, mm³/min", "mean cut, mm³/min", "time, min:s"];

/// Compact, aligned text: what was planned, how the three paths compare, what to mind.
pub fn summary(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}", report.job);
    for (label, value) in facts(report) {
        let _ = writeln!(text, "  {label:<9} {value}");
    }
    text.push('\n');
    let headings = compared(report).into_iter().map(|(name, _)| name.to_owned()).collect();
    let rows = comparison(report).into_iter().filter(|(label, _)| !IN_THE_REPORT.contains(label));
    for (label, values) in core::iter::once(("", headings)).chain(rows) {
        let values: String = values.iter().map(|value| format!("{value:>18}")).collect();
        let _ = writeln!(text, "  {label:<22}{values}");
    }
    if let Some(verification) = &report.verification {
        let _ = writeln!(text, "\n  measured by simulation");
        for (label, line) in verification.short() {
            let _ = writeln!(text, "  {label:<10}{line}");
        }
    }
    if let Some(hub) = &report.hub {
        let _ = writeln!(text, "  {:<10}{}", "hub", hub.caption());
    }
    if let Some(texture) = &report.texture {
        let _ = writeln!(text, "  {:<10}{}", "texture", texture.caption());
    }
    let notes = report.texture.as_ref().map_or(&[][..], |texture| &texture.notes);
    warnings(&mut text, &report.warnings, notes);
    text
}

/// A label and what is written under it.
pub fn facts(report: &Report) -> Vec<(&'static str, String)> {
    let (s, f, r, c) = (&report.surface, &report.flatten, &report.passes, &report.coverage);
    let holes = s.boundary_loops.saturating_sub(1);
    let mut facts = vec![
        (
            "surface",
            format!("{:.0} mm², {} faces, {}", s.area_mm2, s.faces, counted(holes, "hole")),
        ),
        (
            "flattened",
            format!(
                "{}, scale {:.3} to {:.3}, conformal error up to {:.3}, {}",
                f.method,
                f.scale_min,
                f.scale_max,
                f.quasi_conformal_max,
                counted(f.flips, "flip")
            ),
        ),
        (
            "passes",
            format!(
                "{} {}, side step {:.3} mm ({:.2} R), {:.3} of the shortest length",
                r.count,
                r.pattern,
                report.stepover.nominal_mm,
                report.stepover.over_radius,
                r.length_over_floor
            ),
        ),
    ];
    facts.extend(regions(report));
    facts.extend([
        ("limit", limit(report)),
        ("uncovered", format!("{:.2} mm² ({:.3} %)", c.never_covered_mm2, c.never_covered_percent)),
    ]);
    if c.inaccessible_mm2 > 0.0 {
        facts.push((
            "inaccessible",
            format!("{:.2} mm²{}", c.inaccessible_mm2, place(c.inaccessible_at_mm)),
        ));
    }
    facts.extend(moved(report));
    facts
}

/// Where the cutter is lifted off the surface, and its axis off the lead.
fn moved(report: &Report) -> Option<(&'static str, String)> {
    let spans = &report.gouge.lifted;
    let highest = spans.iter().map(|r| r.lifted_by_mm).reduce(f64::max);
    let lifted = highest.map(|highest| {
        format!("{}, by up to {highest:.3} mm", counted(spans.len() as u64, "span"))
    });
    let tilted = report.passes.tilted.as_ref().map(|t| {
        format!(
            "up to {:.1}° from the normal, off the lead over {:.0} mm",
            t.largest_deg, t.length_mm
        )
    });
    match (lifted, tilted) {
        (Some(lifted), Some(tilted)) => Some(("lifted", format!("{lifted}; axis {tilted}"))),
        (Some(lifted), None) => Some(("lifted", lifted)),
        (None, tilted) => tilted.map(|tilted| ("axis", tilted)),
    }
}

/// The regions, and how even passes are in them.
fn regions(report: &Report) -> Vec<(&'static str, String)> {
    let Some(r) = &report.regions else { return Vec::new() };
    let whole = &r.undivided;
    vec![
        (
            "regions",
            format!(
                "{} by {}, uniformity {:.2} at least, {:.2} on average; {:.2} undivided",
                r.count, r.method, r.uniformity_min, r.uniformity_mean, whole.uniformity
            ),
        ),
        (
            "spacing",
            format!(
                "{:.3} ± {:.3} of what is allowed; {:.3} ± {:.3} by one stepover for the whole map",
                r.spacing.mean, r.spacing.deviation, whole.spacing.mean, whole.spacing.deviation
            ),
        ),
    ]
}

fn limit(report: &Report) -> String {
    let f = &report.force;
    let ratio = f.limit_mm3_per_min / f.straight_pass_mm3_per_min;
    let Some(intervals) = f.over_limit_intervals else {
        return "the removal rate is not limited (force.control = \"off\")".into();
    };
    let further = [
        f.power_w.map(|w| format!(", {w:.0} W")),
        f.cutting_force_n.map(|n| format!(", {n:.0} N")),
        f.max_engagement_deg.map(|d| format!(", {d:.0}°")),
        f.min_chip_mm.map(|c| format!(", {c:.4} mm/tooth")),
    ];
    let further: String = further.into_iter().flatten().collect();
    let above = match &further[..] {
        "" => format!(", {} above it", counted(intervals, "interval")),
        _ => String::new(),
    };
    format!(
        "{:.0} mm³/min ({ratio:.2} x straight pass){further}{above}; {}",
        f.limit_mm3_per_min,
        counted(f.trochoid_loops, "loop"),
    )
}

fn place(at: Option<[f64; 3]>) -> String {
    at.map_or_else(String::new, |[x, y, z]| format!(", highest at ({x:.2}, {y:.2}, {z:.2})"))
}

fn counted(count: u64, noun: &str) -> String {
    let plural = if noun.ends_with("ch") { "es" } else { "s" };
    format!("{count} {noun}{}", if count == 1 { "" } else { plural })
}

/// Headings of the paths that are compared: plain passes, these slowed throughout and where it takes that, and what is
/// delivered; or the last alone.
pub fn compared(report: &Report) -> Vec<(&'static str, &PathFigures)> {
    let all = [
        ("plain", report.plain.as_ref()),
        ("slowed throughout", report.slowed.as_ref()),
        ("slowed locally", report.slowed_locally.as_ref()),
        ("delivered", Some(&report.delivered)),
    ];
    all.into_iter().filter_map(|(name, path)| Some((name, path?))).collect()
}

/// A label with its unit and the values of the paths that are [`compared`].
pub fn comparison(report: &Report) -> Vec<(&'static str, Vec<String>)> {
    let paths = compared(report);
    let row = |value: fn(&PathFigures) -> String| paths.iter().map(|(_, p)| value(p)).collect();
    let rate = |value: fn(&RateFigures) -> String| {
        paths.iter().map(|(_, p)| p.rate.as_ref().map(value)).collect::<Option<Vec<String>>>()
    };
    let mut rows = vec![("feed, mm/min", row(|p| format!("{:.0}", p.feed_mm_per_min)))];
    let rates = [
        ("peak / limit", rate(|r| format!("{:.3}", r.peak_over_limit))),
        ("peak, mm³/min", rate(|r| format!("{:.0}", r.peak_mm3_per_min))),
        ("mean cut, mm³/min", rate(|r| format!("{:.0}", r.mean_mm3_per_min))),
        ("variation", rate(|r| format!("{:.3}", r.variation))),
        ("0.8 to 1 of the limit", rate(|r| format!("{:.0} %", 100.0 * r.near_limit))),
        ("engaged over, degrees", rate(|r| format!("{:.0}", r.engagement_deg))),
        ("least mm per tooth", rate(|r| format!("{:.4}", r.feed_per_tooth_mm))),
    ];
    rows.extend(rates.into_iter().filter_map(|(label, values)| Some((label, values?))));
    rows.extend([
        ("length, m", row(|p| format!("{:.3}", p.length_mm.total / 1000.0))),
        ("time, min:s", row(|p| clock(p.time_s.total))),
        ("on the machine, min:s", row(|p| clock(p.machine_time_s.total))),
    ]);
    rows
}

fn clock(seconds: f64) -> String {
    let whole = seconds.round().max(0.0) as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}

/// The first warnings, and the texture's notes where they leave room.
fn warnings(text: &mut String, warnings: &[Warning], notes: &[String]) {
    let count = warnings.len() + notes.len();
    if count == 0 {
        return;
    }
    text.push('\n');
    // One line says how many there are more.
    let mut room = LINES.saturating_sub(text.lines().count() + 1);
    let mut shown = 0;
    for Warning { stage, message, remedy } in warnings.iter().take(WARNINGS) {
        let lines = 1 + usize::from(!remedy.is_empty());
        if lines > room {
            break;
        }
        (room, shown) = (room - lines, shown + 1);
        let _ = writeln!(text, "  warning: {stage}: {message}");
        if !remedy.is_empty() {
            let _ = writeln!(text, "    remedy: {remedy}");
        }
    }
    let notes = &notes[..notes.len().min(WARNINGS.saturating_sub(warnings.len())).min(room)];
    for note in notes {
        let _ = writeln!(text, "  note: texture: {note}");
    }
    let more = count - shown - notes.len();
    if more > 0 {
        let _ = writeln!(text, "  and {more} more in report.json");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples;

    #[test]
    fn fits_a_screen() {
        let mut report = samples::report();
        report.warnings = vec![report.warnings[0].clone(); 9];
        // Hubs are not divided into regions.
        let (mut divided, mut hub) = (report.clone(), report.clone());
        divided.hub = None;
        (hub.regions, hub.tensor) = (None, None);
        // Nor do they know what stands beside them.
        let avoids_nothing = |report: &mut Report| {
            let verification = report.verification.as_mut().unwrap();
            verification.avoided.clear();
            verification.stock = None;
        };
        avoids_nothing(&mut hub);
        let mut plain = divided.clone();
        avoids_nothing(&mut plain);
        for (report, more) in
            [(plain, "and 6 more"), (divided, "more in report.json"), (hub, "and 6 more")]
        {
            let text = report.summary();
            assert!(text.lines().count() <= 38);
            assert!(text.lines().all(|line| line.chars().count() <= 104));
            assert!(text.contains(more), "{text}");
        }
        report.warnings.truncate(2);
        assert!(report.summary().contains("note: texture: the window is narrow"));
    }

    #[test]
    fn columns_are_aligned() {
        let text = samples::report().summary();
        let rows: Vec<&str> = text
            .lines()
            .skip_while(|l| !l.contains("delivered"))
            .take_while(|l| !l.is_empty())
            .collect();
        assert_eq!(rows.len(), 8);
        assert!(rows.iter().all(|r| r.chars().count() == 96));
    }
}
