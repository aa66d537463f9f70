// Plans jobs natively on one thread and in the page, in turn, and prints the ratio of the times, and
// how long the page takes until it shows the laid path, the planned one, and all.
//
//   PAGE=address EVENCUT=command [RUNS=3] node speed.mjs JOB...
//
// The first two times are of planning, simulating and writing; the command's holds starting and files
// too. All are the least of the runs.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { drop, launch, open, plan } from "./browser.mjs";

const { PAGE, EVENCUT } = process.env;
const RUNS = Number(process.env.RUNS ?? 3);
const scratch = mkdtempSync(join(tmpdir(), "evencut-speed-"));
const least = (values) => Math.min(...values);
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];

function native(job) {
  const start = performance.now();
  const { status } = spawnSync(EVENCUT, ["plan", "--quiet", "--threads", "1", "-o", join(scratch, "out"), job]);
  if (status !== 0 && status !== 5) throw new Error(`${job}: exit code ${status}`);
  return (performance.now() - start) / 1000;
}

/** Seconds in the planner, and from the click until each part of the result is on the screen. */
async function inPage(page) {
  const phases = ["laid", "planned", "judged"];
  await page.evaluate(() => {
    const shown = {};
    let began = false;
    const start = performance.now();
    const note = () => {
      const { state, shown: phase, planned } = document.body.dataset;
      // What an earlier plan left does not count.
      began ||= state === "working";
      if (!began) return;
      if (phase) shown[phase] ??= 0;
      // After the next frame it is drawn.
      if (shown[phase] === 0) requestAnimationFrame(() => setTimeout(() => (shown[phase] ||= (performance.now() - start) / 1000)));
      if (planned && phase === "judged") observer.disconnect();
    };
    const observer = new MutationObserver(note);
    observer.observe(document.body, { attributes: true });
    globalThis.shownAt = shown;
  });
  await plan(page);
  await page.waitForFunction(() => globalThis.shownAt.judged > 0);
  const shown = await page.evaluate(() => globalThis.shownAt);
  const told = await page.locator("#report .faint").textContent();
  return { planner: Number(told.match(/([\d.]+) s/)[1]), shown: phases.map((phase) => shown[phase] || shown.judged) };
}

async function load(page, job) {
  const text = readFileSync(job, "utf8");
  const surface = text.match(/^file\s*=\s*"([^"\\]+)"/m)?.[1];
  const files = [{ name: basename(job), bytes: Buffer.from(text) }];
  if (surface) files.push({ name: basename(surface), bytes: readFileSync(join(dirname(job), surface)) });
  await drop(page, files);
  await page.locator("#job-name", { hasText: basename(job) }).waitFor();
  await page.locator("body[data-checked=good]").waitFor();
}

const browser = await launch();
const ratios = [];
console.log(`${"job".padEnd(24)}${["native, s", "page, s", "ratio", "laid, s", "planned, s", "all, s"].map((t) => t.padStart(11)).join("")}`);
for (const job of process.argv.slice(2)) {
  const { page, context } = await open(browser, PAGE);
  await load(page, job);
  const [there, here] = [[], []];
  for (let run = 0; run < RUNS; run++) {
    there.push(native(job));
    here.push(await inPage(page));
  }
  await context.close();
  const [a, b] = [least(there), least(here.map((run) => run.planner))];
  ratios.push(b / a);
  const shown = [0, 1, 2].map((phase) => least(here.map((run) => run.shown[phase])));
  console.log(`${basename(job, ".toml").padEnd(24)}${[a, b, b / a, ...shown].map((x) => x.toFixed(2).padStart(11)).join("")}`);
}
console.log(`median ratio ${median(ratios).toFixed(2)}, best of ${RUNS} runs each`);
await browser.close();
rmSync(scratch, { recursive: true });
