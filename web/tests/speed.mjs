// Plans jobs natively on one thread and in the page, in turn, and prints the ratio of the times.
//
//   PAGE=address EVENCUT=command [RUNS=3] node speed.mjs JOB...
//
// Both times are of planning, simulating and writing; the command's holds starting and files too.
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

/** Seconds in the planner, and until the result is on the screen. */
async function inPage(page) {
  const start = performance.now();
  await plan(page);
  const shown = (performance.now() - start) / 1000;
  const told = await page.locator("#report .faint").textContent();
  return { planner: Number(told.match(/([\d.]+) s/)[1]), shown };
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
console.log(`${"job".padEnd(24)}${["native, s", "page, s", "ratio", "shown, s"].map((t) => t.padStart(11)).join("")}`);
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
  const shown = least(here.map((run) => run.shown));
  console.log(`${basename(job, ".toml").padEnd(24)}${[a, b, b / a, shown].map((x) => x.toFixed(2).padStart(11)).join("")}`);
}
console.log(`median ratio ${median(ratios).toFixed(2)}, best of ${RUNS} runs each`);
await browser.close();
rmSync(scratch, { recursive: true });
