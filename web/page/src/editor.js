// The job editor: highlighting, what may be written and what it means as the planner says, faults at their places.
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { toml } from "@codemirror/legacy-modes/mode/toml";
import { forceLinting, lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import { Compartment, EditorState, Prec } from "@codemirror/state";
import {
  EditorView, drawSelection, highlightActiveLine, highlightActiveLineGutter, hoverTooltip, keymap,
  lineNumbers,
} from "@codemirror/view";
import { tags } from "@lezer/highlight";

const COLOURS = HighlightStyle.define([
  { tag: tags.comment, color: "var(--faint-ink)", fontStyle: "italic" },
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: "var(--key)" },
  { tag: tags.string, color: "var(--string)" },
  { tag: [tags.number, tags.bool], color: "var(--number)" },
  { tag: [tags.atom, tags.bracket, tags.heading, tags.keyword], color: "var(--table)", fontWeight: "600" },
]);

const LOOK = EditorView.theme({
  "&": { height: "100%", fontSize: "13px", color: "var(--ink)", backgroundColor: "var(--sheet)" },
  "&.cm-focused": { outline: "2px solid var(--focus)", outlineOffset: "-2px" },
  ".cm-scroller": { fontFamily: "ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace", lineHeight: "1.55" },
  ".cm-content": { padding: "8px 0", caretColor: "var(--ink)" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { backgroundColor: "transparent", color: "var(--faint-ink)", border: "none" },
  ".cm-activeLine": { backgroundColor: "var(--hover)" },
  ".cm-activeLineGutter": { backgroundColor: "transparent", color: "var(--ink)" },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": { backgroundColor: "var(--selection)" },
  ".cm-selectionMatch": { backgroundColor: "var(--selection)" },
  ".cm-lintRange-error": { backgroundImage: "none", textDecoration: "underline wavy var(--bad) 1.5px", textUnderlineOffset: "3px" },
  ".cm-lintRange-warning": { backgroundImage: "none", textDecoration: "underline wavy var(--warn) 1.5px", textUnderlineOffset: "3px" },
  ".cm-tooltip": { backgroundColor: "var(--sheet)", color: "var(--ink)", border: "1px solid var(--line)", borderRadius: "6px", boxShadow: "var(--shadow)", maxWidth: "26rem", fontSize: "13px" },
  ".cm-tooltip-autocomplete > ul > li[aria-selected]": { backgroundColor: "var(--accent)", color: "var(--on-accent)" },
  ".cm-tooltip.cm-completionInfo": { padding: "6px 10px" },
  ".cm-completionDetail": { color: "inherit", opacity: "0.75", fontStyle: "normal" },
  ".cm-diagnostic": { padding: "6px 10px", whiteSpace: "pre-wrap" },
  ".cm-diagnostic-error": { borderLeftColor: "var(--bad)" },
  ".cm-diagnostic-warning": { borderLeftColor: "var(--warn)" },
  ".cm-doc": { padding: "8px 12px" },
  ".cm-doc b": { fontFamily: "ui-monospace, monospace" },
  ".cm-doc p": { margin: "2px 0 0" },
  ".cm-doc p + p": { color: "var(--faint-ink)" },
  ".cm-panels": { backgroundColor: "var(--ground)", color: "var(--ink)" },
});

export class Editor {
  #planner;
  #quiet = false;
  #extensions;
  #opened;
  #editing = new Compartment();
  #loaded = [];
  #loading = null;

  /** `changed` is called after edits of the user, `plan` on Ctrl+Enter; `planner` knows completions and explanations. */
  constructor(parent, planner, { changed, plan }) {
    this.#planner = planner;
    // In a shadow root the editor's styles need no leave of the page's security policy.
    const root = parent.attachShadow({ mode: "open" });
    const edited = (update) => {
      if (update.docChanged) changed(this.text, !this.#quiet);
    };
    this.#extensions = [
      lineNumbers(), EditorView.lineWrapping, lintGutter(), history(), drawSelection(),
      highlightActiveLine(), highlightActiveLineGutter(),
      StreamLanguage.define(toml),
      syntaxHighlighting(COLOURS),
      EditorView.domEventHandlers({ focus: () => void this.#load() }),
      hoverTooltip((view, at) => this.#hover(view, at)),
      Prec.highest(keymap.of([{ key: "Mod-Enter", run: () => (plan(), true) }])),
      keymap.of([...defaultKeymap, ...historyKeymap, ...lintKeymap]),
      EditorView.contentAttributes.of({ "aria-label": "Job file, TOML", tabindex: "0", spellcheck: "false" }),
      EditorView.updateListener.of(edited),
      LOOK,
    ];
    this.#opened = () => changed(this.text, false);
    this.view = new EditorView({ parent: root, root, state: this.#state("") });
    const style = new CSSStyleSheet();
    style.replaceSync(":host { display: block; min-height: 0 } .cm-editor { height: 100% }");
    root.adoptedStyleSheets = [...root.adoptedStyleSheets, style];
  }

  get text() {
    return this.view.state.doc.toString();
  }

  #state(doc) {
    return EditorState.create({ doc, extensions: [this.#editing.of(this.#loaded), this.#extensions] });
  }

  /** Loads what is needed to write, when someone begins to; without it the text can be edited all the same. */
  async #load() {
    if (this.#loading) return;
    try {
      this.#loading = import("./editing.js");
      const { editing } = await this.#loading;
      this.#loaded = editing((context) => this.#complete(context));
      this.view.dispatch({ effects: this.#editing.reconfigure(this.#loaded) });
    } catch {
      this.#loading = null;
    }
  }

  /** Opens another text, which cannot be undone. */
  open(text) {
    this.view.setState(this.#state(text));
    this.view.scrollDOM.scrollTop = 0;
    this.#opened();
  }

  /** Puts a text between two places, in UTF-16 units, as if it were typed. */
  put(from, to, insert) {
    this.view.dispatch({ changes: { from, to, insert } });
  }

  /** Replaces the text; undo brings the old one back. */
  replace(text) {
    this.#quiet = true;
    this.view.dispatch({
      changes: { from: 0, to: this.view.state.doc.length, insert: text },
      selection: { anchor: 0 },
      scrollIntoView: true,
    });
    this.#quiet = false;
  }

  /** Underlines faults; those without a place are marked at the first line. */
  show(faults) {
    const length = this.view.state.doc.length;
    const first = this.view.state.doc.line(1);
    const diagnostics = faults.map((fault) => ({
      from: Math.min(fault.from ?? first.from, length),
      to: Math.min(Math.max(fault.to ?? first.to, (fault.from ?? 0) + 1), length),
      severity: fault.severity,
      message: [spoken(fault), ...fault.help].join("\n"),
    }));
    this.view.dispatch(setDiagnostics(this.view.state, diagnostics));
    forceLinting(this.view);
  }

  /** Puts the cursor at a place, in UTF-16 units. */
  go(from) {
    const anchor = Math.min(from, this.view.state.doc.length);
    this.view.dispatch({ selection: { anchor }, scrollIntoView: true });
    this.view.focus();
  }

  async #complete(context) {
    const found = await this.#planner.completions(context.state.doc.toString(), context.pos).catch(() => null);
    if (!found || context.aborted || found.options.length === 0) return null;
    const begun = context.pos > found.from;
    const isValue = found.options[0].kind === "value";
    if (!begun && !isValue && !context.explicit) return null;
    const options = found.options.map(({ text, kind, unit, about }) => ({
      label: text,
      type: { table: "class", key: "property", value: "enum" }[kind],
      detail: unit ?? undefined,
      info: about ?? undefined,
      apply: kind === "key" ? `${text} = ` : text,
    }));
    return { from: found.from, options, validFor: isValue ? /^"?[\w.+-]*$/ : /^[\w.-]*$/ };
  }

  async #hover(view, at) {
    const word = view.state.wordAt(at);
    if (!word) return null;
    const found = await this.#planner.explanation(view.state.doc.toString(), word.to).catch(() => null);
    return found && { pos: word.from, end: word.to, create: () => ({ dom: documentation(found) }) };
  }
}

/** A fault as the command tells it: key, then message. */
export const spoken = (fault) => (fault.key ? `${fault.key}: ${fault.message}` : fault.message);

function documentation({ key, about, expected }) {
  const dom = document.createElement("div");
  dom.className = "cm-doc";
  const title = document.createElement("b");
  title.textContent = key;
  const texts = [about, `Expected: ${expected}`].map((text) => {
    const line = document.createElement("p");
    line.textContent = text;
    return line;
  });
  dom.append(title, ...texts);
  return dom;
}
