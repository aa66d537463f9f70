//! The material before the first operation.

use super::resolver::Resolver;
use super::surface::MESH_FORMATS;
use crate::job::stock::StockShape;

impl Resolver<'_> {
    pub(super) fn stock(&mut self) -> Option<StockShape> {
        let table = &self.file.stock;
        match (&table.file, table.corners) {
            (Some(_), Some(_)) => {
                let message = format!("a box beside {}", self.named("stock.file"));
                self.fault("stock.box", message, "keep one of the two");
                None
            }
            (Some(file), None) => {
                self.check_file("stock.file", file, &MESH_FORMATS);
                Some(StockShape::File(file.clone()))
            }
            (None, Some(corners)) => {
                self.check_box("stock.box", corners);
                Some(StockShape::Box(corners.map(|corner| self.point(corner))))
            }
            (None, None) => {
                let has_none = !self.places.has("stock.file") && !self.places.has("stock.box");
                if has_none && self.places.found("stock") {
                    let help = "give `box = [[x, y, z], [x, y, z]]`, or `file = \"stock.stl\"`";
                    self.fault("stock", "neither `box` nor `file` is given", help);
                }
                None
            }
        }
    }
}
