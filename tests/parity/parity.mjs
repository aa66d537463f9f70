// Compares the results of the native command with those of core in WebAssembly, byte for byte.
//
//   node parity.mjs EVENCUT MODULE JOB...
//
// Exit code 0 if all files of all jobs are the same.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";

const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** Name and digest of every result of the native command. */
function native(evencut, job) {
  const folder = mkdtempSync(join(tmpdir(), "evencut-parity-"));
  try {
    const results = join(folder, "results");
    execFileSync(evencut, ["plan", "--quiet", "-o", results, job], { stdio: "inherit" });
    const names = readdirSync(results).filter((name) => !name.startsWith("."));
    return new Map(names.map((name) => [name, sha256(readFileSync(join(results, name)))]));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The surface that a job names; empty where a formula gives it. */
function surfaceOf(job) {
  const line = readFileSync(job, "utf8").match(/^file\s*=\s*"([^"\\]+)"/m);
  return line ? readFileSync(join(dirname(job), line[1])) : Buffer.alloc(0);
}

/** Names and contents of the surfaces of blades that a job names, one after the other. */
function bladesOf(job) {
  const list = readFileSync(job, "utf8").match(/^blade\s*=\s*\[([^\]]*)\]/m);
  const names = list ? [...list[1].matchAll(/"([^"\\]+)"/g)].map((found) => found[1]) : [];
  return names.flatMap((name) => [Buffer.from(name), readFileSync(join(dirname(job), name))]);
}

/** Name and digest of every result of core in WebAssembly. */
async function wasm(module, job) {
  const { exports: core } = await WebAssembly.instantiate(module, {});
  const blocks = [Buffer.from(basename(job)), readFileSync(job), surfaceOf(job), ...bladesOf(job)];
  for (const bytes of blocks) {
    const address = core.allocate(bytes.length);
    new Uint8Array(core.memory.buffer, address, bytes.length).set(bytes);
  }
  const count = core.plan();
  const view = (part, i) =>
    Buffer.from(core.memory.buffer, core[`${part}_address`](i), core[`${part}_length`](i));
  if (count === 0) throw new Error(`${job}: ${view("content", 0)}`);
  const files = new Map();
  for (let i = 0; i < count; i++) files.set(`${view("name", i)}`, sha256(view("content", i)));
  return files;
}

const [evencut, moduleFile, ...jobs] = process.argv.slice(2);
const module = await WebAssembly.compile(readFileSync(moduleFile));
let different = 0;
for (const job of jobs) {
  const [there, here] = [native(evencut, job), await wasm(module, job)];
  const names = [...new Set([...there.keys(), ...here.keys()])].sort();
  const unlike = names.filter((name) => there.get(name) !== here.get(name));
  unlike.forEach((name) => console.error(`${job}: ${name} differs between native and wasm`));
  different += unlike.length;
  console.log(`parity: ${job}: ${names.length - unlike.length} of ${names.length} files the same`);
}
process.exit(different === 0 && jobs.length > 0 ? 0 : 1);
