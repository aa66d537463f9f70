use super::*;
use crate::engagement::{Cutting, Stock};
use crate::flat_path::Terrain;
use crate::job::FeedComponent;
use crate::outline::Outline;

struct Plane;
impl Terrain for Plane {
    fn scale(&self, _: DVec2) -> Option<f64> {
        Some(1.0)
    }
    fn room(&self, _: DVec2) -> Option<f64> {
        Some(1.0)
    }
    fn joins(&self, _: DVec2, _: DVec2) -> bool {
        true
    }
}

#[test]
fn probe() {
    for (r, s) in [(0.8, 0.65), (0.8, 1.0), (0.8, 1.317), (0.4, 0.5)] {
        for sides in [12usize, 16, 24, 48] {
            let loop_: Vec<DVec2> = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)]
                .map(|(x, y)| DVec2::new(x, y))
                .to_vec();
            let stock = Stock::new(&Outline::from_loops(vec![loop_]));
            let cutting = Cutting {
                radius: 2.4,
                depth: 1.0,
                feed: 1.0,
                vfc: FeedComponent::Mean,
                limit: 1e9,
            };
            let mut sim = Simulation::new(cutting, &Plane, stock);
            sim.arrive(DVec2::new(-r, 0.0), 0.0, MoveKind::Link);
            let mut peak = 0.0;
            let mut alpha = 0.0;
            let mut engaged = (0.0, 0.0);
            let mut at = 0.0;
            for k in 0..8 {
                let n = sim.points().len();
                for i in 0..=sides {
                    let t = i as f64 / sides as f64;
                    let a = PI + TAU * t;
                    let c = DVec2::new(s * (k as f64 + t), 0.0);
                    sim.cut(c + r * DVec2::new(math::cos(a), math::sin(a)), MoveKind::Trochoid);
                }
                let pts = &sim.points()[n..];
                let m = pts.iter().max_by(|a, b| a.mrr.total_cmp(&b.mrr)).unwrap();
                peak = m.mrr / 2.4;
                alpha = m.alpha;
                let q = m.at - DVec2::new(s * (k as f64 + 0.5), 0.0);
                at = math::atan2(q.y, q.x);
                engaged = (
                    pts.iter().filter(|p| p.mrr > 1e-6).map(|p| p.length).sum::<f64>(),
                    pts.iter().map(|p| p.length).sum::<f64>(),
                );
                if k == 7 && sides == 48 {
                    for p in pts {
                        let q = p.at - DVec2::new(s * (k as f64 + 0.5), 0.0);
                        print!("{:.0}:{:.2} ", math::atan2(q.y, q.x).to_degrees(), p.mrr / 2.4);
                    }
                    println!();
                }
            }
            println!(
                "r {r} s {s} sides {sides} peak {peak:.3} alpha {:.1} at {:.0} engaged {engaged:?}",
                alpha.to_degrees(),
                at.to_degrees()
            );
        }
    }
}
