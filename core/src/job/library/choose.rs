//! The tool of a library that a job means.

use super::entry::LibraryTool;
use crate::geometry::OrderBy;
use crate::job::fault::Fault;

/// Most tools that a message lists.
const LISTED: usize = 20;
/// Longest name that is compared with others, characters.
const COMPARED: usize = 60;

/// What a job gives of a tool in a library.
#[derive(Copy, Clone)]
pub(super) struct Asked<'a> {
    /// The library's name in the job.
    pub library: &'a str,
    pub name: Option<&'a str>,
    pub number: Option<u32>,
}

impl Asked<'_> {
    /// The key by which the tool is chosen.
    pub fn key(&self) -> &'static str {
        match (self.name, self.number) {
            (Some(_), _) => "tool.name",
            (None, Some(_)) => "tool.number",
            (None, None) => "tool.library",
        }
    }

    /// The tool that is meant, or why none is.
    pub fn choose<'a>(&self, tools: &'a [LibraryTool]) -> Result<&'a LibraryTool, Fault> {
        let Self { library, .. } = self;
        let all = tools.iter().collect::<Vec<_>>();
        let (found, said) = match (self.name, self.number) {
            (Some(name), number) => {
                let named: Vec<_> = all.iter().copied().filter(|t| is_called(t, name)).collect();
                // Of several with one name the number tells.
                let numbered = || named.iter().copied().filter(|t| t.number() == number).collect();
                let is_other = |t: &&LibraryTool| t.number() == number && !is_called(t, name);
                if let (Some(number), Some(other)) = (number, tools.iter().find(is_other)) {
                    let message =
                        format!("in {library} T{number} is {}, not {name:?}", told(other));
                    let help = "leave out the name or the number, or give the number of that tool";
                    return Err(Fault::new("tool.number", message).help(help));
                }
                let found = if named.len() > 1 && number.is_some() { numbered() } else { named };
                (found, format!("{name:?}"))
            }
            // A tool that has no number takes that of the job.
            (None, Some(_)) if matches!(tools, [only] if only.number().is_none()) => {
                (all, String::new())
            }
            (None, Some(number)) => {
                let numbered = all.iter().copied().filter(|t| t.number() == Some(number)).collect();
                (numbered, format!("T{number}"))
            }
            (None, None) => (all, "a tool".to_owned()),
        };
        match found.as_slice() {
            [only] => Ok(only),
            [] => Err(self.none(&said, tools)),
            several => {
                let message = match said.as_str() {
                    "a tool" => format!("{library} has {} tools", several.len()),
                    said => format!("{} tools of {library} are {said}", several.len()),
                };
                let missing = match (self.name, self.number) {
                    (None, None) => "give `tool.number` or `tool.name`",
                    (None, Some(_)) => "give `tool.name` as well",
                    _ => "give the right `tool.number` as well",
                };
                Err(Fault::new(self.key(), message)
                    .help(missing)
                    .help(format!("they are: {}", listed(several.iter().map(|t| told(t))))))
            }
        }
    }

    fn none(&self, said: &str, tools: &[LibraryTool]) -> Fault {
        let mut fault = Fault::new(self.key(), format!("{} has no tool {said}", self.library));
        if let Some(name) = self.name
            && let Some((near, tool)) = nearest(name, tools)
        {
            let number = tool.number().map_or_else(String::new, |n| format!(" (T{n})"));
            fault = fault.help(format!("the nearest name is {near:?}{number}"));
        }
        let mut numbers: Vec<u32> = tools.iter().filter_map(LibraryTool::number).collect();
        numbers.order_by_key(|number| *number);
        numbers.dedup();
        let known = listed(numbers.iter().map(u32::to_string));
        fault.help(match numbers.is_empty() {
            true => "its tools have no numbers: give `tool.name`".to_owned(),
            false => format!("its numbers are: {known}"),
        })
    }
}

fn is_called(tool: &LibraryTool, name: &str) -> bool {
    tool.names.iter().any(|known| known == name.trim())
}

/// A tool in messages: number and name.
pub(super) fn told(tool: &LibraryTool) -> String {
    let name: String = tool.name().chars().take(COMPARED).collect();
    match tool.number() {
        Some(number) => format!("T{number} {name:?}"),
        None => format!("{name:?}"),
    }
}

/// The first ones of a list, and how many follow.
fn listed(all: impl ExactSizeIterator<Item = String>) -> String {
    let more = all.len().saturating_sub(LISTED);
    let shown = all.take(LISTED).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// The name that differs least, letters' case apart.
fn nearest<'a>(name: &str, tools: &'a [LibraryTool]) -> Option<(&'a str, &'a LibraryTool)> {
    let plain = |name: &str| name.chars().take(COMPARED).collect::<String>().to_lowercase();
    let wanted = plain(name);
    let names = tools.iter().flat_map(|tool| tool.names.iter().map(move |n| (n.as_str(), tool)));
    names.min_by_key(|(name, _)| strsim::osa_distance(&wanted, &plain(name)))
}
