// Where in a job file a place is, and what the schema says of it.

/** Tables that hold the place, and what stands there: a header, a key or a value. */
export function placeOf(lines, column) {
  const last = lines[lines.length - 1].slice(0, column);
  let table = [];
  for (const line of lines.slice(0, -1)) {
    const header = line.match(/^\s*\[\s*([\w.\s-]+?)\s*\]/);
    if (header) table = split(header[1]);
  }
  const header = last.match(/^\s*\[\s*([\w.-]*)$/);
  if (header) return { at: "header", path: split(header[1]), word: header[1] };
  return within(last, table);
}

const split = (dotted) => dotted.split(".").map((part) => part.trim()).filter(Boolean);

/** Walks a line through strings, arrays and inline tables to its end. */
function within(text, table) {
  const stack = [];
  let path = table;
  let key = null;
  let word = "";
  let quote = "";
  let array = 0;
  for (const c of text) {
    if (quote) {
      word += c;
      if (c === quote) quote = "";
    } else if (c === "#") {
      return { at: "comment", path: [], word: "" };
    } else if (c === '"' || c === "'") {
      quote = c;
      word += c;
    } else if (c === "=" && key === null) {
      key = split(word);
      word = "";
    } else if (c === "{" && key) {
      stack.push([path, key]);
      [path, key, word] = [[...path, ...key], null, ""];
    } else if (c === "}" && stack.length > 0) {
      [path, key] = stack.pop();
      word = "";
    } else if (c === "[") {
      array += 1;
      word = "";
    } else if (c === "]") {
      array -= 1;
    } else if (c === ",") {
      if (array === 0) key = null;
      word = "";
    } else if (!/\s/.test(c)) {
      word += c;
    }
  }
  if (key === null) return { at: "key", path: [...path, ...split(word.replace(/[^.]*$/, ""))], word: word.replace(/^.*\./, "") };
  return { at: "value", path: [...path, ...key], word };
}

/** The part of the schema under dotted keys; undefined if there is none. */
export function under(schema, path) {
  let here = schema;
  for (const key of path) {
    const branches = [here, ...(here?.anyOf ?? []), ...(here?.oneOf ?? [])];
    here = branches.map((branch) => branch?.properties?.[key]).find(Boolean);
  }
  return here;
}

/** Values that may be written, as TOML, each with what it means. */
export function values(schema) {
  if (!schema) return [];
  const branches = [...(schema.oneOf ?? []), ...(schema.anyOf ?? [])].flatMap(values);
  const own = [];
  if ("const" in schema) own.push({ text: JSON.stringify(schema.const), about: schema.description });
  for (const value of schema.enum ?? []) own.push({ text: JSON.stringify(value) });
  if (schema.type === "boolean") own.push({ text: "true" }, { text: "false" });
  if (schema.items) own.push(...values(schema.items));
  const known = [...own, ...branches];
  if (known.length === 0 && schema.default !== undefined) {
    known.push({ text: JSON.stringify(schema.default), about: "the default" });
  }
  return known;
}

/** What a value may be, in words. */
export function allowed(schema) {
  const consts = values(schema).map((value) => value.text);
  const of = schema.items ? { ...schema.items, array: true } : schema;
  const range = [
    of.minimum !== undefined ? `from ${of.minimum}` : "",
    of.exclusiveMinimum !== undefined ? `above ${of.exclusiveMinimum}` : "",
    of.maximum !== undefined ? `to ${of.maximum}` : "",
  ].filter(Boolean).join(" ");
  const type = [of.type].flat().filter(Boolean).join(" or ");
  if (schema.oneOf || schema.enum) return consts.join(", ");
  if (schema.type === "object") return "table";
  return [of.array ? "array of" : "", type, range].filter(Boolean).join(" ");
}
