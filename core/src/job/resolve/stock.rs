//! The material before the first operation.

use super::resolver::Resolver;
use super::surface::MESH_FORMATS;
use crate::job::stock::StockShape;

impl Resolver<'_> {
    pub(super) fn stock(&mut self) -> Option<StockShape> {
        let (file, corners) = (self.file.stock.file.clone(), self.file.stock.corners);
        let [has_file, has_box] = ["stock.file", "stock.box"].map(|key| self.places.has(key));
        if has_file && has_box {
            let message = format!("a box beside {}", self.named("stock.file"));
            self.fault("stock.box", message, "keep one of the two");
        } else if !has_file && !has_box && self.places.found("stock") {
            let help = "give `box = [[x, y, z], [x, y, z]]`, or `file = \"stock.stl\"`";
            self.fault("stock", "neither `box` nor `file` is given", help);
        }
        if let Some(file) = &file {
            self.check_file("stock.file", file, &MESH_FORMATS);
        }
        if let Some(corners) = corners {
            self.check_box("stock.box", corners);
            return Some(StockShape::Box(corners.map(|corner| self.point(corner))));
        }
        file.map(StockShape::File)
    }
}
