// Starts a headless Chromium through playwright-core, which tests/browser/run installs under target/.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const require = createRequire(new URL('../../target/ci-browser/', import.meta.url));

/** Runs `work` with a browser and closes it afterwards, whatever happens. */
export async function withBrowser(work) {
  const { chromium } = require('playwright-core');
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  if (!existsSync(executablePath)) throw new Error(`${executablePath} does not exist; set CHROMIUM to a Chromium or Chrome`);
  const browser = await chromium.launch({
    executablePath,
    args: [
      '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
      '--disable-background-networking', '--disable-component-update', '--disable-sync',
    ],
  });
  try {
    return await work(browser);
  } finally {
    await browser.close();
  }
}

/** Opens a file in a page of its own, with the options of a browser context; `listen` is called before it loads. */
export async function open(browser, file, options, listen = () => {}) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  listen(page, file);
  await page.goto(pathToFileURL(file).href);
  return page;
}

/** Ticks the box that opens everything that is folded away, and returns how many parts stay closed. */
export async function openEverything(page) {
  const boxes = page.locator('label.everything input:visible');
  if (await boxes.count() > 0) await boxes.first().check();
  return page.locator('main details:not([open])').count();
}

export const DESKTOP = { viewport: { width: 1400, height: 900 } };
export const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
/** Width of A4 between the margins of the page, in CSS pixels. */
export const PAPER_PX = Math.floor((210 - 2 * 14) / 25.4 * 96);
