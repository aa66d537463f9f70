// What the editor needs only while someone writes in it: completions, search, brackets.
import { autocompletion, closeBrackets, completionKeymap } from "@codemirror/autocomplete";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { keymap } from "@codemirror/view";

/** `complete` answers what may be written at a place. */
export const editing = (complete) => [
  closeBrackets(),
  highlightSelectionMatches(),
  autocompletion({ override: [complete] }),
  keymap.of([...completionKeymap, ...searchKeymap]),
];
