//! What stands beside the surface: its files, distances and names.

use super::resolver::Resolver;
use super::surface::MESH_FORMATS;
use crate::job::avoid::Avoid;

impl Resolver<'_> {
    /// `clearance`: the distance that is kept where a table gives none, mm.
    pub(super) fn avoid(&mut self, clearance: f64) -> Vec<Avoid> {
        let mut all: Vec<Avoid> = Vec::new();
        for (i, table) in self.file.avoid.iter().flatten().enumerate() {
            // What has no file has its fault already.
            let Some(file) = table.file.clone() else { continue };
            self.check_file(&format!("avoid[{i}].file"), &file, &MESH_FORMATS);
            let name = table.name.clone().unwrap_or_else(|| stem(&file));
            self.check_name(i, &name, &all);
            let distance = self.length(table.distance, clearance);
            all.push(Avoid { file, distance, name });
        }
        all
    }

    fn check_name(&mut self, index: usize, name: &str, before: &[Avoid]) {
        let key = format!("avoid[{index}].name");
        if name.chars().any(char::is_control) {
            let help = "give a name without line breaks and the like";
            self.fault(&key, "contains a control character", help);
        } else if before.iter().any(|b| b.name == name) {
            let message = format!("an earlier table is called {name:?}, too");
            self.fault(&key, message, "give each another `name`, by which reports tell them apart");
        }
    }
}

/// A file's name without folders and extension.
fn stem(file: &str) -> String {
    let last = file.rsplit(['/', '\\']).next().unwrap_or_default();
    let stem = last.rsplit_once('.').map_or(last, |(stem, _)| stem);
    if stem.is_empty() { "mesh".to_owned() } else { stem.chars().take(40).collect() }
}
