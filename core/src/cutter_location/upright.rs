//! An upright cutter that comes down onto facets from above.

use super::check_mesh::CheckMesh;
use super::drop::Profile;
use crate::geometry::{DVec2, DVec3};
use crate::tool::Tool;

/// A cutter whose axis is +Z.
#[derive(Copy, Clone, Debug)]
pub struct Upright {
    tool: Tool,
    profile: Profile,
}

/// Where an upright cutter comes to stand.
#[derive(Copy, Clone, Debug)]
pub struct Landing {
    /// Height of the tip, mm.
    pub tip: f64,
    /// The corners of the facet that it touches, mm.
    pub facet: [DVec3; 3],
}

impl Upright {
    /// A cutter.
    pub fn new(tool: Tool) -> Self {
        Self { tool, profile: Profile::new(&tool) }
    }

    /// Distance from the axis beyond which nothing is under the cutter, mm.
    pub fn radius(&self) -> f64 {
        self.profile.radius
    }

    /// The cutter.
    pub fn tool(&self) -> &Tool {
        &self.tool
    }

    /// Height of the lower side over the tip, mm, at a distance from the axis up to [`radius`](Self::radius), mm.
    pub fn lower_side(&self, distance: f64) -> f64 {
        self.profile.height(distance)
    }

    /// Unit normal, toward the cutter, of the lower side at a place across the axis, mm from it.
    pub fn normal(&self, across: DVec2) -> DVec3 {
        let distance = across.length();
        let out = distance - self.profile.bottom;
        if out <= 0.0 {
            return DVec3::Z;
        }
        let sine =
            if self.profile.corner > 0.0 { (out / self.profile.corner).min(1.0) } else { 1.0 };
        (across * (-sine / distance)).extend((1.0 - sine * sine).sqrt())
    }

    /// Where the tip over `at` is when the cutter stands on a facet, mm, or `floor` if it is not higher.
    pub fn tip_on(&self, facet: [DVec3; 3], at: DVec2, floor: f64) -> f64 {
        self.profile.triangle(facet.map(|p| p - at.extend(0.0)), floor)
    }

    /// Where the cutter, coming from above over `at`, stands on a part if that holds it above the height `from`, mm.
    pub fn lands(&self, part: &CheckMesh, at: DVec2, from: f64) -> Option<Landing> {
        let (raise, facet) = part.raise_onto(&self.tool, at.extend(from), DVec3::Z);
        facet.map(|facet| Landing { tip: from + raise, facet })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_over_an_edge_stands_as_circle_and_edge_say() {
        let corners =
            [DVec3::new(0.0, -9.0, 2.0), DVec3::new(9.0, 0.0, 2.0), DVec3::new(0.0, 9.0, 2.0)];
        let part = CheckMesh::new(corners.to_vec(), vec![[0, 1, 2]]);
        let ball = Upright::new(Tool::new(5.0, 5.0).unwrap());
        for (x, expected) in [(1.0, 2.0), (-3.0, 2.0 - 1.0), (-4.0, 2.0 - 2.0)] {
            let at = DVec2::new(x, 0.0);
            let landing = ball.lands(&part, at, -50.0).unwrap();
            assert!((landing.tip - expected).abs() < 1e-5, "{}", landing.tip);
            assert_eq!(landing.facet, corners);
            assert!((ball.tip_on(corners, at, -50.0) - expected).abs() < 1e-5);
        }
        assert!(ball.lands(&part, DVec2::new(-5.1, 0.0), -50.0).is_none());
    }

    #[test]
    fn the_normal_is_that_of_the_ball() {
        let ball = Upright::new(Tool::new(5.0, 5.0).unwrap());
        assert!((ball.normal(DVec2::new(3.0, 0.0)) - DVec3::new(-0.6, 0.0, 0.8)).length() < 1e-6);
        let bull = Upright::new(Tool::new(5.0, 1.0).unwrap());
        assert_eq!(bull.normal(DVec2::new(3.9, 0.0)), DVec3::Z);
    }
}
