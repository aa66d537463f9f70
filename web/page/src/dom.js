// Small helpers for elements and numbers.

export const $ = (id) => document.getElementById(id);

/** An element with properties and children; strings become text. */
export function make(name, properties = {}, ...children) {
  const { data, ...plain } = properties;
  const element = Object.assign(document.createElement(name), plain);
  for (const [key, value] of Object.entries(data ?? {})) element.dataset[key] = value;
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** min:s, with hours only where there are any. */
export function clock(seconds) {
  const whole = Math.round(seconds);
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  return h > 0 ? `${h}:${pad(m)}:${pad(s)}` : `${m}:${pad(s)}`;
}

const pad = (n) => String(n).padStart(2, "0");

export function bytes(count) {
  if (count < 1000) return `${count} B`;
  return count < 1e6 ? `${(count / 1e3).toFixed(count < 1e4 ? 1 : 0)} kB` : `${(count / 1e6).toFixed(1)} MB`;
}

/** A number with as many digits as are of use. */
export function short(value) {
  const size = Math.abs(value);
  const fixed = value.toFixed(size >= 100 || size === 0 ? 0 : size >= 10 ? 1 : 2);
  const plain = fixed.includes(".") ? fixed.replace(/\.?0+$/, "") : fixed;
  return plain.replace("-", "−");
}
