//! Passes and links: which keys the pattern uses, and what walls ask for.

use super::resolver::Resolver;
use crate::job::path::{
    Boundary, FirstPass, Links, PathOptions, Pattern, RingOrder, Start, StartKey, Traverse,
};
use crate::job::units::radians;

impl Resolver<'_> {
    pub(super) fn path(&mut self) -> PathOptions {
        let table = &self.file.path;
        let pattern = table.pattern.unwrap_or(Pattern::Contour);
        let boundary = table.boundary.unwrap_or(Boundary::Open);
        let first = match pattern.has_rings() {
            true => FirstPass::Edge,
            false => FirstPass::HalfStrip,
        };
        let start = match (&table.curve, table.start) {
            (Some(points), _) => Start::Curve(points.iter().map(|&p| self.point(p)).collect()),
            (None, Some(StartKey::Boundary)) => Start::Boundary,
            (None, Some(StartKey::Widest)) => Start::Widest,
            (None, Some(StartKey::Shortest) | None) => Start::Shortest,
        };
        let path = PathOptions {
            pattern,
            start,
            along: table.along,
            angle: table.angle.map(radians),
            traverse: table.traverse.unwrap_or(Traverse::Zigzag),
            first: table.first.unwrap_or(first),
            order: table.order.unwrap_or(RingOrder::OutsideIn),
            links: table.links.unwrap_or(Links::Surface),
            entry_radius: self.length(table.entry_radius, 0.0),
            boundary,
            wall_height: self.length(table.wall_height, 0.0),
        };
        self.check_path(&path);
        path
    }

    /// Keys of [path] that say nothing about the pattern chosen are refused.
    fn check_path(&mut self, path: &PathOptions) {
        if self.places.has("path.curve") && self.places.has("path.start") {
            let message = format!("given beside {}", self.named("path.start"));
            self.fault("path.curve", message, "keep one of the two");
        }
        if let Start::Curve(points) = &path.start
            && points.windows(2).all(|pair| pair[0] == pair[1])
        {
            self.fault("path.curve", "all its points are the same", "give two places at least");
        }
        let pattern = self.named("path.pattern");
        for key in Pattern::KEYS {
            let owners = Pattern::ALL.into_iter().filter(|p| p.uses(key));
            let path_key = format!("path.{key}");
            if self.places.has(&path_key) && !path.pattern.uses(key) {
                let names: Vec<_> = owners.map(|p| format!("{:?}", p.name())).collect();
                let message = format!("says nothing about {pattern} = {:?}", path.pattern.name());
                let help = format!("leave it out; it belongs to {}", names.join(", "));
                self.fault(&path_key, message, help);
            }
        }
        let is_wall = path.boundary == Boundary::Wall;
        if !is_wall && self.places.has("path.wall_height") {
            let help = "leave it out, or give `boundary = \"wall\"`";
            self.fault("path.wall_height", "there is no wall", help);
        }
        if is_wall && path.pattern != Pattern::Contour {
            let message = format!("only contour passes keep clear of walls, not {pattern}");
            self.fault("path.boundary", message, "give `boundary = \"open\"` or contour");
        }
        if is_wall && self.file.path.first == Some(FirstPass::HalfStrip) {
            let message = "between walls the first pass runs along the wall";
            self.fault("path.first", message, "leave it out, or give `boundary = \"open\"`");
        }
    }
}
