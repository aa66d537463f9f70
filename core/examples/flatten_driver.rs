//! Flattens one mesh file and prints time and memory, for comparison with other programs.
//!
//! `flatten_driver METHOD MESH UV` with `METHOD` one of `bff`, `abf`; writes the raw `f64` flat
//! points, `#V` by 2, to `UV` and one line of JSON to standard output.

use std::fs;
use std::time::Instant;

use evencut_core::flatten;
use evencut_core::mesh::{Connectivity, MeshFormat, TriangleSoup, VertexId, read};
use evencut_core::surface::Surface;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [method, mesh, uv] = &arguments[..] else {
        return Err("usage: flatten_driver bff|abf MESH UV".into());
    };
    let surface = load(mesh)?;
    reset_peak();
    let base = status_mb("VmRSS");
    let (start, cpu, system) = (Instant::now(), cpu_seconds(), system_seconds());
    let (chart, angles) = match method.as_str() {
        "bff" => (flatten::bff_unchecked(&surface)?, None),
        "abf" => {
            let result = flatten::abf_unchecked(&surface)?;
            (result.chart.clone(), Some(result))
        }
        other => return Err(format!("no method {other}").into()),
    };
    let wall = start.elapsed().as_secs_f64();
    let sys = system_seconds() - system;
    let user = (cpu_seconds() - cpu - sys).max(0.0);
    let peak = status_mb("VmHWM");
    let valid = match chart.validate(&surface) {
        Ok(()) => "true".to_owned(),
        Err(fault) => format!("{:?}", fault.to_string()),
    };
    let quality = chart.quality(&surface);
    let extra = angles.map_or(String::new(), |result| {
        format!(
            ", \"steps\": {}, \"residual\": {:e}, \"corner_error\": {:e}",
            result.steps,
            result.residual,
            corner_error(&surface, &result)
        )
    });
    println!(
        "{{\"wall_s\": {wall}, \"user_s\": {user}, \"sys_s\": {sys}, \"base_mb\": {base}, \
         \"peak_mb\": {peak}, \"valid\": {valid}, \
         \"min_s\": {:e}, \"max_s\": {:e}{extra}}}",
        quality.min_s, quality.max_s
    );
    let bytes: Vec<u8> =
        chart.uv().iter().flat_map(|p| [p.x, p.y]).flat_map(f64::to_le_bytes).collect();
    fs::write(uv, bytes)?;
    Ok(())
}

/// Largest difference between the solved angles and those of the flat points, rad.
fn corner_error(surface: &Surface, result: &flatten::AngleBased) -> f64 {
    let faces = surface.connectivity().faces().iter();
    let error = |(face, angles): (&[VertexId; 3], &[f64; 3])| {
        let p = face.map(|v| result.chart.uv()[v.index()]);
        let angle = |c: usize| (p[(c + 1) % 3] - p[c]).angle_to(p[(c + 2) % 3] - p[c]);
        (0..3).map(|c| (angle(c) - angles[c]).abs()).fold(0.0, f64::max)
    };
    faces.zip(&result.angles).map(error).fold(0.0, f64::max)
}

fn load(path: &str) -> Result<Surface, Box<dyn std::error::Error>> {
    // As the file numbers them: the flat points are written in that order.
    let format = MeshFormat::from_name(path).ok_or("the name must end in .obj, .off or .ply")?;
    let TriangleSoup { positions, faces, .. } = read(&fs::read(path)?, format)?;
    let faces = faces.into_iter().map(|f| f.map(VertexId)).collect();
    Ok(Surface::new(Connectivity::new(positions.len(), faces)?, positions))
}

/// Resets the kernel's memory high-water mark where it allows that.
fn reset_peak() {
    if fs::write("/proc/self/clear_refs", "5").is_err() {
        eprintln!("peak_mb counts from the start of the program");
    }
}

/// A line of `/proc/self/status` in MB, 0 where there is none.
fn status_mb(key: &str) -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with(key));
    let kb = line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok());
    kb.unwrap_or(0.0) / 1024.0
}

/// CPU time of this thread, user and system.
fn cpu_seconds() -> f64 {
    let text = fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|n| n.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}

/// System time of this process, in steps of 10 ms.
fn system_seconds() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = text.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().nth(12).and_then(|n| n.parse::<f64>().ok());
    ticks.unwrap_or(0.0) * 0.01
}
