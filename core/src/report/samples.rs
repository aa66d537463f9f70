//! A report with every key, for the tests.

use super::*;

fn figures(feed: f64, peak: f64, time: f64) -> PathFigures {
    let by_kind = |total: f64| ByKind {
        cut: 0.6 * total,
        trochoid: 0.2 * total,
        return_: 0.1 * total,
        link: 0.06 * total,
        rapid: 0.04 * total,
        total,
    };
    PathFigures {
        feed_mm_per_min: feed,
        length_mm: by_kind(7_400.0),
        time_s: by_kind(time),
        machine_time_s: by_kind(1.08 * time),
        peak_mm3_per_min: peak,
        mean_mm3_per_min: 0.6 * peak,
        variation: 0.21,
        peak_over_limit: peak / 2880.0,
    }
}

pub(super) fn report() -> Report {
    let file = |name: &str| FileRecord::of(name, name.as_bytes());
    Report {
        format: FORMAT,
        job: "franke mould, semi-finish".to_owned(),
        versions: Versions { evencut: "0.1.0".to_owned(), job_file: 1 },
        inputs: vec![file("mould.toml"), file("surfaces/franke-mould.ply")],
        surface: SurfaceFigures {
            area_mm2: 10_713.2,
            faces: 17_400,
            vertices: 8_900,
            boundary_loops: 2,
            box_low_mm: [0.0, 0.0, 0.1],
            box_high_mm: [100.0, 100.0, 24.4],
            smallest_concave_radius_mm: Some(15.4),
        },
        repairs: vec!["2 duplicate faces dropped, one at (1.00, 2.00, 3.00)".to_owned()],
        warnings: vec![Warning {
            stage: "cutter location".to_owned(),
            message: "the cutter was raised by up to 0.031 mm at (44.1, 77.9, 3.2)".to_owned(),
            remedy: "use a cutter with a larger corner radius or a ball".to_owned(),
        }],
        flatten: FlattenFigures {
            method: "bff".to_owned(),
            iterations: 1,
            constraint_residual: 2.0e-13,
            quasi_conformal_mean: 1.002,
            quasi_conformal_max: 1.031,
            scale_min: 0.91,
            scale_max: 1.124,
            flips: 0,
        },
        rings: RingFigures {
            count: 34,
            tree_depth: 33,
            closed_cores: 1,
            spurs: 130,
            spur_length_mm: 86.5,
            widest_gap_passes: 0.508,
        },
        stepover: StepoverFigures { nominal_mm: 1.6, over_radius: 0.4 },
        force: ForceFigures {
            control: "trochoid".to_owned(),
            limit_mm3_per_min: 2880.0,
            straight_pass_mm3_per_min: 1920.0,
            over_limit_intervals: 17,
            trochoid_loops: 412,
        },
        plain: figures(1500.0, 9_600.0, 296.0),
        slowed: figures(450.0, 2_880.0, 987.0),
        delivered: figures(1500.0, 2_879.0, 402.0),
        coverage: CoverageFigures {
            flat_area_mm2: 10_713.2,
            never_covered_mm2: 0.0,
            never_covered_percent: 0.0,
            too_tight_mm2: 12.5,
            too_tight_at_mm: Some([44.1, 77.9, 3.2]),
        },
        gouge: GougeFigures {
            raised: vec![RaisedStretch {
                from_mm: [43.0, 77.0, 3.3],
                length_mm: 8.4,
                raised_by_mm: 0.031,
            }],
        },
        outputs: vec![file("toolpath.csv"), file("program.ngc")],
    }
}
