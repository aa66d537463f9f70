//! What is written.

use super::resolver::Resolver;
use crate::job::file::PostKey;
use crate::job::output::{OutputOptions, Picture, Post};
use crate::job::regions::RegionMethod;

impl Resolver<'_> {
    pub(super) fn output(&self) -> OutputOptions {
        let table = &self.file.output;
        let division = match self.file.regions.method {
            None | Some(RegionMethod::Single) => None,
            Some(RegionMethod::Distortion) => Some(Picture::Regions),
            Some(RegionMethod::Tensor) => Some(Picture::Tensor),
        };
        let all = || {
            use Picture::{Channel, Clearance, Flat, Mrr, Removal, Scallop, Surface};
            let mut all = vec![Flat, Surface, Mrr, Scallop, Removal];
            if self.is_hub() {
                all.insert(2, Channel);
                all.push(Clearance);
            }
            division.into_iter().for_each(|picture| all.insert(2, picture));
            all
        };
        OutputOptions {
            gcode: match table.gcode.as_ref().and_then(|g| g.post) {
                Some(PostKey::None) => None,
                Some(PostKey::LinuxCnc) | None => Some(Post::LinuxCnc),
            },
            pictures: table.svg.clone().unwrap_or_else(all),
        }
    }
}
