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
        rate: Some(RateFigures {
            peak_mm3_per_min: peak,
            mean_mm3_per_min: 0.6 * peak,
            variation: 0.21,
            peak_over_limit: peak / 2880.0,
            near_limit: 0.42,
            engagement_deg: 108.0,
            feed_per_tooth_mm: 0.0208,
            power_w: None,
            force_n: None,
        }),
    }
}

fn tensor() -> TensorFigures {
    TensorFigures {
        points: vec![PointFigures {
            kind: "trisector".to_owned(),
            at_mm: [4.0, -3.0, 0.0],
            delta: -2.4e-8,
            divides: true,
        }],
        separatrices: 3,
        cancelled_pairs: 0,
        doubtful: 0,
        free_mm2: 0.0,
        smoothing_mm: 0.0,
    }
}

fn division() -> DivisionFigures {
    let spacing = SpacingFigures { mean: 0.93, deviation: 0.04, max: 1.0 };
    DivisionFigures {
        method: "distortion".to_owned(),
        count: 2,
        uniformity_min: 0.88,
        uniformity_mean: 0.9,
        spacing,
        length_mm: 6_800.0,
        undivided: UndividedFigures {
            uniformity: 0.61,
            stretch_min: 0.7,
            stretch_max: 1.4,
            spacing: SpacingFigures { deviation: 0.15, ..spacing },
            length_mm: 9_100.0,
        },
        pieces: vec![PieceFigures {
            area_mm2: 5_300.0,
            uniformity: 0.88,
            stretch_min: 0.93,
            stretch_max: 1.04,
            passes: 31,
            length_mm: 3_300.0,
            spacing,
        }],
    }
}

fn setup() -> SetupFigures {
    SetupFigures {
        program: Some(ProgramFigures {
            file: "program.ngc".to_owned(),
            post: "linuxcnc".to_owned(),
            number: 1,
            blocks: 12_345,
            bytes: 345_678,
        }),
        tool: SetupTool {
            number: 3,
            length_offset: 3,
            diameter_offset: 3,
            kind: "ball".to_owned(),
            diameter_mm: 6.0,
            corner_radius_mm: 3.0,
            flutes: 2,
            length_mm: Some(12.0),
            shank_diameter_mm: Some(6.0),
            stickout_mm: Some(30.0),
            gauge_length_mm: Some(90.0),
        },
        spindle_per_min: 8000.0,
        spindle_direction: "clockwise".to_owned(),
        coolant: "flood".to_owned(),
        feed_mm_per_min: 1200.0,
        axial_depth_mm: Some(0.5),
        allowance_mm: 0.1,
        work_offset: Some("G54".to_owned()),
        rotary_axes: vec!["table C at (0.000, 0.000, 0.000)".to_owned()],
        stock: Some("box from (-1.000, -1.000, 0.000) to (31.000, 31.000, 9.000)".to_owned()),
        avoid: vec!["clamp by 0.500 mm".to_owned()],
        rapid_plane_mm: 34.4,
        reach: vec![ReachFigures {
            axis: "X".to_owned(),
            least: -1.0,
            greatest: 101.0,
            unit: "mm".to_owned(),
        }],
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
            smallest_concave_at_mm: Some([1.0, 2.0, 3.0]),
            too_concave_mm2: 0.0,
            set_aside: Some(AsideFigures {
                selected_mm2: 12_000.0,
                away_mm2: 800.0,
                steep_mm2: 400.0,
                shadowed_mm2: 80.0,
                small_mm2: 6.8,
                bridged_mm2: 30.0,
                deepest_bridged_mm: 1.2,
            }),
        },
        repairs: vec!["2 duplicate faces dropped, one at (1.00, 2.00, 3.00)".to_owned()],
        warnings: vec![Warning {
            stage: "cutter location".to_owned(),
            message: "the cutter was lifted by up to 0.031 mm at (44.1, 77.9, 3.2)".to_owned(),
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
        passes: PassFigures {
            pattern: "contour".into(),
            count: 34,
            tree_depth: 33,
            closed_cores: 1,
            branches: 130,
            branch_length_mm: 86.5,
            widest_gap_passes: 0.508,
            length_floor_mm: 9_500.0,
            length_mm: 9_975.0,
            length_over_floor: 1.05,
            retracts: 3,
            even_share: 0.97,
            tilted: Some(TiltFigures {
                largest_deg: 31.4,
                largest_at_mm: [24.2, -3.5, 3.9],
                length_mm: 412.0,
            }),
        },
        setup: Some(setup()),
        hub: Some(hub()),
        regions: Some(division()),
        tensor: Some(tensor()),
        stepover: StepoverFigures { nominal_mm: 1.6, over_radius: 0.4 },
        force: ForceFigures {
            control: "trochoid".to_owned(),
            limit_mm3_per_min: 2880.0,
            straight_pass_mm3_per_min: 1920.0,
            max_engagement_deg: Some(110.0),
            min_chip_mm: Some(0.01),
            preferred_chip_mm: None,
            power_w: Some(400.0),
            cutting_force_n: Some(150.0),
            over_limit_intervals: Some(17),
            trochoid_loops: 412,
            plane: Some(PlaneFigures {
                rms_difference_mm3_per_min: 130.0,
                rms_difference_over_limit: 0.045,
                largest_difference_mm3_per_min: -900.0,
                largest_difference_at_mm: [12.0, 3.5, -1.0],
            }),
        },
        plain: Some(figures(1500.0, 9_600.0, 296.0)),
        slowed: Some(figures(450.0, 2_880.0, 987.0)),
        slowed_locally: Some(figures(1500.0, 2_860.0, 350.0)),
        delivered: figures(1500.0, 2_879.0, 402.0),
        coverage: CoverageFigures {
            cusp_limit_mm: 0.0125,
            area_mm2: 10_713.2,
            never_covered_mm2: 0.0,
            never_covered_percent: 0.0,
            inaccessible_mm2: 12.5,
            inaccessible_at_mm: Some([44.1, 77.9, 3.2]),
            inaccessible_places: vec![[44.1, 77.9, 3.2, 0.8], [45.5, 78.0, 3.1, 0.6]],
        },
        gouge: GougeFigures {
            lifted: vec![LiftedSpan {
                from_mm: [43.0, 77.0, 3.3],
                length_mm: 8.4,
                lifted_by_mm: 0.031,
            }],
        },
        verification: Some(verification()),
        texture: Some(texture()),
        outputs: vec![file("toolpath.csv"), file("program.ngc")],
    }
}

/// A report of several operations with every key.
pub fn operations() -> OperationsReport {
    let report = report();
    OperationsReport {
        format: FORMAT,
        job: "mould".to_owned(),
        versions: report.versions.clone(),
        inputs: report.inputs.clone(),
        operations: vec![OperationFigures::of(("rest", 2), true, &report, "2-report.json")],
        program: report.setup.and_then(|setup| setup.program),
        length_mm: 8_400.0,
        machine_time_s: 390.0,
        tool_changes: 1,
        passed: Some(true),
        findings: vec!["a finding".to_owned()],
        skipped: vec!["operation 3: nothing is left".to_owned()],
        outputs: report.outputs,
    }
}

fn hub() -> HubFigures {
    HubFigures {
        channels: 20,
        spacing: "strips".into(),
        strips_length_mm: 612.5,
        equal_parameter_length_mm: 843.1,
        map: "coons".into(),
        least_jacobian: 0.41,
        edge_deviation_mm: 0.0004,
        narrowest_mm: 4.2,
        narrowest_at_mm: [88.0, 12.0, 3.5],
        axis_turn_deg_per_mm: 1.2,
        axis_turn_deg_per_s: 24.0,
        clearance_mm: 0.12,
        shortened_extensions: 2,
        shortest_extension_mm: 1.5,
        retracts_in_channel: 0,
        measured: Some(MeasuredClearance {
            cutter_mm: 0.131,
            shank_mm: Some(0.8),
            holder_mm: Some(9.5),
            at_mm: [88.1, 12.2, 5.1],
            part: "cutter".into(),
        }),
    }
}

fn texture() -> TextureFigures {
    let profile = || ProfileFigures { ra_um: 0.5, rq_um: 0.6, rz_um: 2.0, rt_um: 2.5 };
    TextureFigures {
        window: WindowFigures {
            middle_mm: [1.0, 2.0, 3.0],
            feed: [1.0, 0.0, 0.0],
            nodes: [51, 251],
            spacing_mm: [0.01, 0.01],
            cells_mm: [0.0099, 0.0101],
            start_mm: 0.2,
            beyond: 0,
            uncut: 0,
            facets_um: 0.0,
        },
        cutting: CuttingFigures {
            feed_per_tooth_mm: 0.1,
            side_step_mm: 0.5,
            spindle_rpm: 6000.0,
            flutes: 2,
            least_concave_radius_mm: None,
        },
        areal: ArealFigures { sa_um: 1.0, sq_um: 1.2, sz_um: 5.0, ssk: 0.4, sku: 2.1 },
        along: profile(),
        across: profile(),
        work: WorkFigures { steps: 1000, edge_points: 40, quads: 5000, tests: 9000 },
        notes: vec!["the window is narrow".into()],
    }
}

fn verification() -> VerificationFigures {
    let at = [44.1, 77.9, 3.2];
    let fault = || vec![FaultFigures { line: Some(12), at_mm: at, depth_mm: 0.1 }];
    VerificationFigures {
        passed: false,
        broken: vec!["gouge of 20.0 µm at (44.10, 77.90, 3.20), line 12".to_owned()],
        remedies: vec!["use a smaller cutter".to_owned()],
        area_mm2: 10_713.2,
        samples: 412_000,
        spacing_mm: 0.16,
        scallop: ScallopFigures {
            limit_mm: Some(0.11),
            tolerance_mm: 0.005,
            largest_mm: 0.108,
            largest_at_mm: Some(at),
            sampling_bound_mm: 0.001,
            kept_within_sampling_bound: false,
            p99_mm: 0.1,
            p50_mm: 0.03,
            mean_mm: 0.035,
            above_mm2: 0.5,
            above_percent: 0.005,
            spots: vec![SpotFigures { height_mm: 0.13, at_mm: at, line: Some(12) }],
        },
        cusps: Some(CuspFigures {
            count: 540,
            share_left_out: 0.1,
            p5_mm: 0.08,
            p50_mm: 0.1,
            p95_mm: 0.108,
            largest_mm: 0.112,
            largest_at_mm: Some(at),
            share_within: Some(0.6),
            share_above: Some(0.01),
        }),
        by_slope: [0.0, 15.0, 30.0, 45.0, 60.0]
            .map(|from_deg| SlopeFigures {
                from_deg,
                area_mm2: 2_000.0,
                above_percent: 0.01,
                largest_mm: 0.1,
            })
            .to_vec(),
        by_region: vec![RegionFigures {
            region: 0,
            area_mm2: 10_713.2,
            above_percent: 0.01,
            largest_mm: 0.1,
        }],
        gouge_mm: -0.02,
        gouge_at_mm: Some(at),
        gouge_by_line: Some(12),
        gouge_may_be_deeper: false,
        gouged_mm2: 0.2,
        walls: Some(WallCutFigures {
            area_mm2: 2_900.0,
            deepest_mm: 2.83,
            deepest_at_mm: Some(at),
            deepest_by_line: Some(12),
            may_be_deeper: false,
            cut_mm2: 30.0,
        }),
        stock: Some(StockCutFigures {
            allowed_mm: 0.51,
            deepest_mm: 0.502,
            deepest_at_mm: Some(at),
            deepest_by_line: Some(76),
            may_be_deeper: false,
        }),
        untouched_mm2: 0.3,
        untouched_at_mm: Some(at),
        inaccessible_mm2: 12.5,
        inaccessible_residual_mm: 0.4,
        rest_mm2: 1.5,
        rest_height_mm: 0.4,
        above_cutter: vec![AboveCutterFigures {
            part: "holder".into(),
            clearance_mm: 3.25,
            is_at_least: false,
            asked_mm: 0.5,
            at_mm: [10.0, 4.0, 22.5],
            line: Some(77),
        }],
        avoided: vec![AvoidedFigures {
            name: "clamp beside the left end of the slot".into(),
            asked_mm: 0.5,
            clearance_mm: 0.512,
            is_at_least: true,
            part: "cutter".into(),
            at_mm: [-15.0, 4.0, 12.0],
            line: Some(78),
        }],
        load: Some(LoadFigures {
            engagement_deg: 108.0,
            engagement_limit_deg: Some(110.0),
            feed_per_tooth_mm: 0.0208,
            feed_per_tooth_limit_mm: Some(0.01),
            power_w: Some(210.0),
            power_limit_w: Some(400.0),
            force_n: Some(95.0),
            force_limit_n: Some(150.0),
        }),
        mrr: Some(MrrFigures {
            limit_mm3_per_min: Some(2880.0),
            peak_mm3_per_min: 2870.0,
            peak_at_mm: Some(at),
            peak_line: Some(40),
            peak_time_s: 8.1,
            peak_over_limit: Some(0.9965),
            removed_mm3: 8_000.0,
            predicted_peak_mm3_per_min: Some(2878.0),
            rms_difference_mm3_per_min: Some(40.0),
            rms_difference_over_limit: Some(0.0139),
            largest_difference_mm3_per_min: Some(-210.0),
            largest_difference_at_mm: Some(at),
        }),
        rapids_in_stock: 1,
        rapids: fault(),
        moves_without_feed: 1,
        without_feed: fault(),
        program: vec!["line 3: a move at feed without an F word".to_owned()],
    }
}
