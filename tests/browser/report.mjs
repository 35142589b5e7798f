// Checks reports in a browser: `node report.mjs REPORT.html...`. Prints every rule that is broken; exit 1 if there is one.
import { dirname, basename, join } from 'node:path';
import { pathToFileURL } from 'node:url';

import { DESKTOP, PAPER_PX, PHONE, open, openEverything, withBrowser } from './browser.mjs';
import { illegible } from './contrast.mjs';
import { sortEveryColumn } from './sorting.mjs';

/** Screens of 1400 x 900 that a page has as it opens, and words that are visible there. */
const MOST_SCREENS = 8;
const MOST_WORDS = 2500;
/** Pages of paper as it opens. */
const MOST_PAGES = 12;

/** Most findings that are listed for a rule. */
const MOST_LISTED = 3;

/** Findings of the page that is checked, by the rule that they break. */
let broken = new Map();
const expect = (holds, rule, found) => {
  if (!holds) broken.set(rule, [...(broken.get(rule) ?? []), found]);
};

/** Records everything that the page loads or complains about. */
function listen(page, file) {
  const own = pathToFileURL(file).href;
  page.on('request', request => {
    const url = request.url();
    expect(url.split('#')[0] === own || url.startsWith('data:'), 'nothing but the file itself is loaded', url);
  });
  page.on('console', message => {
    expect(!['error', 'warning'].includes(message.type()), 'the console is empty', message.text());
  });
  page.on('pageerror', error => expect(false, 'no script fails', error.message));
}

/** Length, words and first screen, as a reader finds them. */
async function checkSize(page) {
  const { height, words, top } = await page.evaluate(() => {
    const inside = selector => [...document.querySelectorAll(selector)]
      .map(element => element.getBoundingClientRect())
      .filter(box => box.width > 100 && box.height > 20 && box.top >= 0 && box.bottom <= innerHeight).length;
    return {
      height: document.documentElement.scrollHeight / innerHeight,
      words: document.body.innerText.split(/\s+/).filter(Boolean).length,
      top: { verdict: inside('.verdict'), figures: inside('svg.chart'), tables: inside('table') },
    };
  });
  expect(height <= MOST_SCREENS, `at most ${MOST_SCREENS} screens of 1400 x 900 as it opens`, height.toFixed(1));
  expect(words <= MOST_WORDS, `at most ${MOST_WORDS} words visible as it opens`, words);
  expect(top.verdict === 1, 'the verdict is on the first screen, whole', top.verdict);
  expect(top.figures >= 1, 'a figure is on the first screen, whole', top.figures);
  expect(top.tables === 1, 'one table is on the first screen, whole', top.tables);
}

/** Every part that is folded away opens by a click on its words and has something to show. */
async function checkMore(page) {
  const parts = page.locator('main details');
  const count = await parts.count();
  expect(count > 0, 'parts are folded away under "more"', count);
  const atFirst = await page.locator('main details[open]').count();
  expect(atFirst === 0, 'all of them are closed as the page opens', `${atFirst} open`);
  for (let n = 0; n < count; n++) {
    const part = parts.nth(n);
    const summary = part.locator('> summary');
    const name = (await summary.innerText()).trim();
    const closed = (await part.boundingBox()).height;
    await summary.click();
    const { open, height, empty } = await part.evaluate(details => ({
      open: details.open,
      height: details.getBoundingClientRect().height,
      empty: [...details.querySelectorAll('svg.chart')]
        .filter(chart => chart.checkVisibility())
        .map(chart => chart.getBoundingClientRect())
        .filter(box => box.width < 100 || box.height < 30).length,
    }));
    expect(open && height > closed + 10, `"${name}" opens by a click`, `${closed} px high before, ${height} px after`);
    expect(empty === 0, `figures under "${name}" have a size`, `${empty} without`);
  }
}

/** Every table sorts by every column: up, down, as it was. */
async function checkTables(page) {
  const first = page.locator('table th button:visible').first();
  expect(await first.count() > 0, 'a table sorts', 'no heading with a button');
  if (await first.count() === 0) return;
  await first.click();
  const head = page.locator('table th:has(button:visible)').first();
  const sorted = await head.getAttribute('aria-sort');
  expect(sorted === 'ascending', 'a click on a heading sorts up', `aria-sort ${sorted}`);
  await first.click();
  await first.click();
  const { wrong, columns, unlikeCharacters } = await sortEveryColumn(page);
  for (const fault of wrong) expect(false, 'tables sort by every column, numbers as numbers', fault);
  expect(columns > 0, 'tables sort', `${columns} columns`);
  // Without one, a sort by characters would pass.
  expect(unlikeCharacters > 0, 'a column has numbers whose order is not that of their characters', unlikeCharacters);
}

/** What reaches beyond the right edge, unless it scrolls in a box of its own. */
async function checkWidth(page, where) {
  const { width, wide } = await page.evaluate(() => {
    const edge = document.documentElement.clientWidth;
    const scrolls = element => element && element !== document.body
      && (['auto', 'scroll', 'hidden'].includes(getComputedStyle(element).overflowX) || scrolls(element.parentElement));
    const wide = [...document.body.querySelectorAll('*')]
      .filter(element => !(element instanceof SVGElement) || element.classList.contains('chart'))
      .filter(element => element.getBoundingClientRect().right > edge + 1)
      .filter(element => !scrolls(element.parentElement) && element.checkVisibility());
    const name = element => `${element.tagName.toLowerCase()} "${element.textContent.trim().slice(0, 40)}"`;
    return { width: document.documentElement.scrollWidth - edge, wide: wide.slice(0, 3).map(name) };
  });
  const found = `${width} px too wide: ${wide.join(', ') || 'unknown'}`;
  expect(width <= 0 && wide.length === 0, `nothing is wider than ${where}`, found);
}

/** Text against what is behind it, in both colour schemes. */
async function checkColours(page) {
  for (const colorScheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme });
    const { texts, faint } = await illegible(page);
    expect(texts > 100, `text is found on the ${colorScheme} page`, texts);
    for (const { contrast, text, colours } of faint) {
      const found = `${contrast.toFixed(2)} of "${text}" (${colours})`;
      expect(false, `text on the ${colorScheme} page has a contrast of at least 4.5`, found);
    }
  }
  await page.emulateMedia({ colorScheme: null });
}

/** Prints the page; returns the number of pages of paper and the headings among the bookmarks. */
async function print(page) {
  const options = { preferCSSPageSize: true, printBackground: true, tagged: true, outline: true };
  const pdf = (await page.pdf(options)).toString('latin1');
  const octal = (_, digits) => String.fromCharCode(parseInt(digits, 8));
  const titles = [...pdf.matchAll(/\/Title\s*(?:\(((?:\\.|[^)\\])*)\)|<([0-9A-Fa-f]*)>)/g)];
  return {
    pages: (pdf.match(/\/Type\s*\/Page\b(?!s)/g) ?? []).length,
    // Text in parentheses, or UTF-16 in hexadecimal digits where it has other characters.
    headings: titles.map(([, text, hex]) => hex === undefined
      ? text.replace(/\\([0-7]{3})/g, octal).replace(/\\(.)/g, '$1')
      : Buffer.from(hex, 'hex').swap16().toString('utf16le').replace('\ufeff', '')),
  };
}

/** Paper: short as the page opens, complete where everything was chosen. */
async function checkPrint(page) {
  const short = await print(page);
  expect(short.pages > 0 && short.pages <= MOST_PAGES, `at most ${MOST_PAGES} pages of paper as it opens`, short.pages);
  const closed = await openEverything(page);
  expect(closed === 0, 'one box opens everything that is folded away, for print', `${closed} parts still closed`);
  const all = await print(page);
  expect(all.pages > short.pages, 'everything takes more paper', `${all.pages} pages, ${short.pages} without`);
  const headings = await page.locator('main h2').allInnerTexts();
  const missing = headings.filter(heading => !all.headings.includes(heading.trim()));
  const found = `without ${missing.join(', ')} of ${headings.length}`;
  expect(headings.length > 4 && missing.length === 0, 'every section is on paper', found);
  await page.emulateMedia({ media: 'print' });
  await page.setViewportSize({ width: PAPER_PX, height: 1000 });
  const charts = await page.locator('svg.chart').evaluateAll(charts => ({
    all: charts.length,
    empty: charts.map(chart => chart.getBoundingClientRect()).filter(box => box.width < 80 || box.height < 30).length,
  }));
  expect(charts.all > 3 && charts.empty === 0, 'every figure is on paper', `${charts.empty} of ${charts.all} without a size`);
  await checkWidth(page, 'the paper');
  await page.emulateMedia({ media: null });
  return { short, all, charts: charts.all };
}

async function check(browser, file) {
  broken = new Map();
  const started = performance.now();
  const page = await open(browser, file, DESKTOP, listen);
  await checkSize(page);
  await checkMore(page);
  await checkTables(page);
  await checkColours(page);
  await page.reload();
  const paper = await checkPrint(page);
  await page.context().close();

  const phone = await open(browser, file, PHONE, listen);
  await checkWidth(phone, 'a phone of 390 px');
  await phone.evaluate(() => document.querySelectorAll('details').forEach(details => { details.open = true; }));
  await checkWidth(phone, 'a phone of 390 px with everything open');
  await phone.context().close();

  const name = join(basename(dirname(file)), basename(file));
  const seconds = ((performance.now() - started) / 1000).toFixed(1);
  const result = broken.size ? `${broken.size} rules broken` : 'all rules kept';
  const { short, all, charts } = paper;
  console.log(`${name}: ${result}; ${short.pages} pages of paper, ${all.pages} with everything, ${charts} figures (${seconds} s)`);
  for (const [rule, found] of broken) {
    console.log(`  expected: ${rule}`);
    for (const one of found.slice(0, MOST_LISTED)) console.log(`    found: ${one}`);
    if (found.length > MOST_LISTED) console.log(`    and ${found.length - MOST_LISTED} more`);
  }
  return broken.size;
}

const files = process.argv.slice(2);
if (files.length === 0) throw new Error('expected at least one report: node report.mjs REPORT.html...');
await withBrowser(async browser => {
  for (const file of files) if (await check(browser, file) > 0) process.exitCode = 1;
});
