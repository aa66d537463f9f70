//! Names of the stages of planning.

use evencut_core::plan::Stage;

/// The name of a stage.
pub fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Surface => "reading the surface",
        Stage::Flatten => "flattening the surface",
        Stage::Rings => "laying out the passes",
        Stage::Cut => "keeping to the limit on the removal rate",
        Stage::Locate => "locating the cutter",
        Stage::Loops => "laying smaller loops, since larger ones break a limit",
        Stage::Rest => "machining what the passes leave",
        Stage::Verify => "simulating the path",
        Stage::Texture => "simulating the texture",
        Stage::Write => "writing the results",
    }
}

/// The approximate fraction of the whole work that is done at a fraction of a stage.
///
/// Stages may be repeated for material that earlier passes left: the greatest value so far counts.
pub fn done(stage: Stage, part: f64) -> f64 {
    let [from, to] = match stage {
        Stage::Surface => [0.0, 0.02],
        Stage::Flatten => [0.02, 0.04],
        Stage::Rings => [0.04, 0.12],
        Stage::Cut => [0.12, 0.18],
        Stage::Locate => [0.18, 0.32],
        Stage::Loops => [0.32, 0.38],
        Stage::Rest => [0.38, 0.58],
        Stage::Verify => [0.58, 0.92],
        Stage::Texture => [0.92, 0.98],
        Stage::Write => [0.98, 1.0],
    };
    from + part.clamp(0.0, 1.0) * (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stage_goes_on_where_the_one_before_ends() {
        let stages = [
            Stage::Surface,
            Stage::Flatten,
            Stage::Rings,
            Stage::Cut,
            Stage::Locate,
            Stage::Loops,
            Stage::Rest,
            Stage::Verify,
            Stage::Texture,
            Stage::Write,
        ];
        assert_eq!(done(Stage::Surface, -1.0), 0.0);
        assert_eq!(done(Stage::Write, 2.0), 1.0);
        assert!(stages.windows(2).all(|pair| done(pair[0], 1.0) == done(pair[1], 0.0)));
    }
}
