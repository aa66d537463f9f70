//! Plans a job file and prints the time and the measures of every stage, for work on the planner.

use std::time::Instant;
fn main() {
    let path = std::path::PathBuf::from(std::env::args().nth(1).unwrap());
    let job = evencut_core::job::read(&std::fs::read(&path).unwrap());
    let job = match job {
        Ok(j) => j.job,
        Err(e) => {
            eprintln!("{e:?}");
            return;
        }
    };
    let evencut_core::job::SurfaceSource::File(f) = &job.surface.source else { panic!() };
    let bytes = std::fs::read(path.parent().unwrap().join(f)).unwrap();
    let t = Instant::now();
    let mut last = None;
    let p = evencut_core::plan::plan(&job, Some(&bytes), 2, &mut |s, f| {
        if last != Some(s) {
            last = Some(s);
            eprintln!("{:?} {f} at {:.3}", s, t.elapsed().as_secs_f64());
        }
    });
    eprintln!("total {:.3}", t.elapsed().as_secs_f64());
    let p = match p {
        Ok(p) => p,
        Err(e) => {
            eprintln!("{e}");
            return;
        }
    };
    for w in &p.warnings {
        eprintln!("warn {w}");
    }
    let lim = job.mrr_limit();
    let stat = |n: &str, t: &evencut_core::toolpath::Toolpath| {
        use evencut_core::toolpath::MoveKind::*;
        let mut len = [0.0; 5];
        let mut peak: f64 = 0.0;
        let mut tm = [0.0; 5];
        for w in t.points.windows(2) {
            let k = match w[1].kind {
                Cut => 0,
                Trochoid => 1,
                Return => 2,
                Link => 3,
                Rapid => 4,
            };
            len[k] += (w[1].tip - w[0].tip).length();
            tm[k] += w[1].time - w[0].time;
            peak = peak.max(w[1].mrr);
        }
        eprintln!(
            "{n}: points {} len {len:.0?} time {tm:.0?} peak/limit {:.4}",
            t.points.len(),
            peak / lim
        );
    };
    let mut r: Vec<f64> = p.raised.iter().map(|r| r.raise).collect();
    r.sort_by(f64::total_cmp);
    eprintln!(
        "raise: n {} total length {:.1} median {:?} max {:?}",
        r.len(),
        p.raised.iter().map(|r| r.length).sum::<f64>(),
        r.get(r.len() / 2),
        r.last()
    );
    stat("plain", &p.plain);
    stat("delivered", &p.toolpath);
    let flat = p.toolpath.points.iter().filter(|q| q.feed < 0.9 * job.cut.feed).count();
    eprintln!(
        "rings {} depth {} counts {:?} slowed points {flat} raised {} cov {:?} q {:?}",
        p.rings.len(),
        p.ring_depth,
        p.counts,
        p.raised.len(),
        p.coverage,
        p.quality
    );
}
