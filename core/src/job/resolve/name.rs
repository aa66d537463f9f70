//! The job's name.

use super::resolver::Resolver;
use super::surface::kind_name;
use crate::job::file::AnalyticTable;

impl Resolver<'_> {
    pub(super) fn name(&mut self) -> String {
        let Some(name) = &self.file.name else { return self.default_name() };
        if let Some(bad) = name.chars().find(|c| !fits_name(*c)) {
            let help = "any characters but control characters and ( ) ; %";
            self.fault(
                "name",
                format!("contains {bad:?}, which ends a comment in a program"),
                help,
            );
        } else if name.trim() != name {
            self.fault("name", "begins or ends with a space", "remove it");
        }
        name.clone()
    }

    fn default_name(&self) -> String {
        let surface = &self.file.surface;
        let stem = match (&surface.file, &surface.analytic) {
            (Some(file), _) => {
                let last = file.rsplit(['/', '\\']).next().unwrap_or_default();
                last.rsplit_once('.').map_or(last, |(stem, _)| stem).to_owned()
            }
            (None, Some(AnalyticTable { kind: Some(kind), .. })) => kind_name(*kind),
            _ => String::new(),
        };
        let stem: String = stem.chars().filter(|c| fits_name(*c)).take(100).collect();
        let stem = stem.trim();
        if stem.is_empty() { "job".to_owned() } else { stem.to_owned() }
    }
}

fn fits_name(c: char) -> bool {
    !c.is_control() && !"();%".contains(c)
}
