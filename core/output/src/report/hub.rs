//! What is reported of the channels of a hub.

use serde::Serialize;

/// The channels of a hub.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct HubFigures {
    /// Number of channels in the path. One is planned, and simulated; the others are turned.
    pub channels: u64,
    /// How passes are spaced: strips or equal-parameter.
    pub spacing: String,
    /// Length of the passes of a channel, spaced by strips, mm.
    pub strips_length_mm: f64,
    /// Length of the passes of a channel at equal parts of the way across, mm.
    pub equal_parameter_length_mm: f64,
    /// Which map the channel has: coons or harmonic.
    pub map: String,
    /// Least Jacobian of that map over its mean; a map with a negative one folds.
    pub least_jacobian: f64,
    /// Largest deviation of the curves fitted to the edges of the blades, mm.
    pub edge_deviation_mm: f64,
    /// Narrowest width of the channel between its outermost passes, mm.
    pub narrowest_mm: f64,
    /// Where that is, mm.
    pub narrowest_at_mm: [f64; 3],
    /// Fastest turn of the tool axis on passes, degrees per mm of the contact's way.
    pub axis_turn_deg_per_mm: f64,
    /// Fastest turn of the tool axis on passes at the feed as commanded, degrees per s.
    pub axis_turn_deg_per_s: f64,
    /// Distance that the job wants between the tool and the blades, mm.
    pub clearance_mm: f64,
    /// Extensions in a channel that are shorter than the job asks for, since the tool would come too near to a blade.
    pub shortened_extensions: u64,
    /// What is left of the shortest extension, mm; that of the job where none is shorter.
    pub shortest_extension_mm: f64,
    /// Times that the cutter is lifted off within a channel.
    pub retracts_in_channel: u64,
    /// What the simulation measured of it; null where it was not run.
    pub measured: Option<MeasuredClearance>,
}

/// Distances between the tool and what stands beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeasuredClearance {
    /// Smallest distance of the cutter from the blades, mm; distances above both ten times the wanted one and the
    /// cutter's radius are not measured.
    pub cutter_mm: f64,
    /// Smallest distance of the shank from blades and hub, mm.
    pub shank_mm: Option<f64>,
    /// Smallest distance of the holder from blades and hub, mm.
    pub holder_mm: Option<f64>,
    /// Where the smallest of them is, mm.
    pub at_mm: [f64; 3],
    /// Which part of the tool it is.
    pub part: String,
}

impl MeasuredClearance {
    /// The smallest of the distances, mm.
    pub fn smallest(&self) -> f64 {
        let others = [self.shank_mm, self.holder_mm];
        others.into_iter().flatten().fold(self.cutter_mm, f64::min)
    }

    fn line(&self, wanted: f64) -> String {
        let ([x, y, z], part, smallest) = (self.at_mm, &self.part, self.smallest());
        format!(
            "{part} at least {smallest:.3} mm off the blades (wanted {wanted:.3} mm), at ({x:.2}, {y:.2}, {z:.2})"
        )
    }

    /// The sentence about a clearance that is less than wanted.
    fn broken(&self, wanted: f64) -> Option<String> {
        let ([x, y, z], part, smallest) = (self.at_mm, &self.part, self.smallest());
        let way = if smallest < 0.0 { "cuts into" } else { "comes too near to" };
        (smallest < wanted).then(|| {
            format!(
                "the {part} {way} what stands beside the channel, at ({x:.2}, {y:.2}, {z:.2}): clearance {smallest:.4} mm, \
                 hub.clearance is {wanted:.4} mm"
            )
        })
    }
}

impl HubFigures {
    /// Label and value of the lines of the report page.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = vec![
            (
                "channels",
                format!(
                    "{} in the path; one is planned and simulated, the others are turned",
                    self.channels
                ),
            ),
            (
                "passes",
                format!(
                    "{}; a channel takes {:.0} mm by strips, {:.0} mm at equal parts",
                    self.spacing, self.strips_length_mm, self.equal_parameter_length_mm
                ),
            ),
            ("map", format!("{}, least Jacobian {:.3} of its mean", self.map, self.least_jacobian)),
            ("narrowest", format!("{:.3} mm between the outermost passes", self.narrowest_mm)),
            (
                "axis",
                format!(
                    "turns by at most {:.2} degrees per mm, {:.1} degrees per s",
                    self.axis_turn_deg_per_mm, self.axis_turn_deg_per_s
                ),
            ),
        ];
        if let Some(measured) = &self.measured {
            lines.push(("clearance", measured.line(self.clearance_mm)));
        }
        lines
    }

    /// One line about channels and clearance.
    pub fn caption(&self) -> String {
        let clearance = self.measured.as_ref().map(|m| {
            let (part, smallest, wanted) = (&m.part, m.smallest(), self.clearance_mm);
            format!("; {part} at least {smallest:.3} mm off the blades (wanted {wanted:.3} mm)")
        });
        format!("{} channels{}", self.channels, clearance.unwrap_or_default())
    }

    /// The sentence about a clearance that is not kept.
    pub fn broken(&self) -> Option<String> {
        self.measured.as_ref()?.broken(self.clearance_mm)
    }
}

/// Distances between the tool and what stands beside it in a channel, measured on a path that was judged by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct HubVerdict {
    /// Distance that the job wants between the tool and the blades, mm.
    pub clearance_mm: f64,
    /// What was measured.
    pub measured: MeasuredClearance,
}

impl HubVerdict {
    /// The line about it.
    pub fn line(&self) -> String {
        self.measured.line(self.clearance_mm)
    }

    /// The sentence about a clearance that is not kept.
    pub fn broken(&self) -> Option<String> {
        self.measured.broken(self.clearance_mm)
    }
}
