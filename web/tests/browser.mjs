// A headless Chromium with the page, and what all tests of the page need.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--enable-unsafe-swiftshader",
];
/** What Chromium says of its own software renderer. */
const OWN = /GL Driver Message/;
const axe = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

export const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** Starts Chromium: CHROMIUM, or where systems put it. */
export function launch(...flags) {
  const executablePath = [process.env.CHROMIUM, ...PLACES].find((path) => path && existsSync(path));
  return chromium.launch({ executablePath, headless: true, args: [...FLAGS, ...flags] });
}

/** An example that shows everything the page can show: rates, removal, cusps. */
export const QUICK = "crown";

/** Its job, coarser: planned in a second instead of ten, which most tests here wait for. */
export function quickJob() {
  const coarser = [[/kind = "flat"/, 'kind = "ball"'], [/stepover = 1.8 .*/, "stepover = 3.6"], [/tolerance = 0.005/, "tolerance = 0.02"]];
  return coarser.reduce((text, [from, to]) => {
    assert.match(text, from);
    return text.replace(from, to);
  }, readFileSync(`jobs/${QUICK}.toml`, "utf8"));
}

/**
 * A page that is ready, with all that it complained about and all that it asked the network for. `init`:
 * a script that runs before the page's own, and its argument. `shipped`: with `QUICK` as it is shipped.
 */
export async function open(browser, url, { init, shipped = false, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, colorScheme: "light", ...options });
  if (!shipped) await context.route(`**/examples/${QUICK}.toml`, (route) => route.fulfill({ body: quickJob() }));
  const page = await context.newPage();
  const complaints = [];
  const requests = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !OWN.test(message.text())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => requests.push(request.url()));
  page.setDefaultTimeout(60_000);
  if (init) await page.addInitScript(...init);
  await page.goto(url);
  await ready(page);
  return { page, context, complaints, requests };
}

/** Waits until the planner is there and the job is checked. */
export const ready = (page) => page.locator("body[data-checked]").waitFor();

/** Against planning that never ends; how long it may take is no matter of these tests, which run on machines of any speed. */
const PLANNING = 600_000;

/** Presses Plan and waits for the plan, not for an earlier one. */
export async function plan(page) {
  await page.evaluate(() => delete document.body.dataset.planned);
  await page.locator("#plan:enabled").click();
  await page.locator("body[data-state=planned][data-planned]").waitFor({ timeout: PLANNING });
}

/** Drops files, given as {name, bytes}, on the page. */
export async function drop(page, files) {
  const coded = files.map(({ name, bytes }) => ({ name, text: Buffer.from(bytes).toString("base64") }));
  const transfer = await page.evaluateHandle((all) => {
    const made = new DataTransfer();
    for (const { name, text } of all) {
      made.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
    }
    return made;
  }, coded);
  await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
}

/** Replaces the editor's text by pasting over it. */
export async function type(page, text) {
  const content = page.locator("#editor .cm-content");
  await content.click();
  await page.keyboard.press("Control+a");
  await content.evaluate((element, pasted) => {
    const clipboardData = new DataTransfer();
    clipboardData.setData("text/plain", pasted);
    element.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true, composed: true }));
  }, text);
}

/** Fails where axe finds somebody kept out. */
export async function accessible(page, where) {
  if (!(await page.evaluate(() => "axe" in globalThis))) {
    // The page's own policy keeps scripts of others out; the test's comes through the debugger.
    await page.evaluate(readFileSync(axe, "utf8"));
  }
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  const told = violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => `${node.target} ${node.failureSummary}`).join("; ")}`);
  assert.deepEqual(told, [], where);
}
