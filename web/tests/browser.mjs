// A headless Chromium with the page, and what all tests of the page need.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--enable-unsafe-swiftshader",
];

/** Where Chromium is: CHROMIUM, or where systems put it; undefined if nowhere. */
export const chromiumPath = () => [process.env.CHROMIUM, ...PLACES].find((path) => path && existsSync(path));

export const launch = () => chromium.launch({ executablePath: chromiumPath(), headless: true, args: FLAGS });

/** A page that is ready, with all that it complained about and all that it asked the network for. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const complaints = [];
  const requests = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => requests.push(request.url()));
  page.setDefaultTimeout(120_000);
  await page.goto(url);
  await page.locator("body[data-checked]").waitFor();
  return { page, context, complaints, requests };
}

/** Presses Plan and waits for the plan. */
export async function plan(page) {
  await page.locator("#plan:enabled").click();
  await page.locator("body[data-state=planned][data-planned]").waitFor();
}
