// Makes the pictures of reports in docs/images: `node images.mjs REPORT.html SUMMARY.html`.
import { writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';

import { DESKTOP, PAPER_PX, PHONE, open, withBrowser } from './browser.mjs';
import { fewColours } from './palette.mjs';

const folder = new URL('../../docs/images/', import.meta.url);
/** Heights of A4 between the margins, in CSS pixels. */
const PAPER_HEIGHT_PX = Math.floor((297 - 2 * 14) / 25.4 * 96);

const [report, summary] = process.argv.slice(2);
if (!summary) throw new Error('expected a report and a summary of sessions: node images.mjs REPORT.html SUMMARY.html');
const paper = { viewport: { width: PAPER_PX, height: PAPER_HEIGHT_PX }, deviceScaleFactor: 1.25 };
await withBrowser(async browser => {
  const blank = await browser.newPage();
  for (const [name, file, options, media] of [
    ['report', report, DESKTOP, { colorScheme: 'light' }],
    ['report-dark', report, DESKTOP, { colorScheme: 'dark' }],
    ['report-phone', report, { ...PHONE, deviceScaleFactor: 1.5 }, { colorScheme: 'light' }],
    ['report-print', report, paper, { media: 'print' }],
    ['summary', summary, DESKTOP, { colorScheme: 'light' }],
  ]) {
    const page = await open(browser, file, options);
    await page.emulateMedia(media);
    const png = await fewColours(blank, await page.screenshot());
    await writeFile(new URL(`${name}.png`, folder), png);
    console.log(`${fileURLToPath(folder)}${name}.png: ${Math.round(png.length / 1000)} kB`);
    await page.context().close();
  }
});
