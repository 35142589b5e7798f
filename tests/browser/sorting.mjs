// Sorting of tables by clicks on their headings, tried on every column of a page.

/** Clicks every heading three times and compares the rows: `wrong` lists what is not in order. */
export function sortEveryColumn(page) {
  return page.evaluate(() => {
    const number = text => {
      const plain = text.replace(/[\s\u00a0\u202f]/g, '').replace('\u2212', '-');
      const digits = plain.match(/^[<>]?([-+]?[0-9]+(?:\.[0-9]+)?(?:e[-+]?[0-9]+)?)/);
      return digits ? Number(digits[1]) : NaN;
    };
    const words = new Intl.Collator('en', { numeric: true });
    const rowsOf = body => [...body.rows].filter(row => !row.classList.contains('group'));
    const rises = (values, compare) => values.every((value, n) => n === 0 || compare(values[n - 1], value) <= 0);
    const found = { columns: 0, unlikeCharacters: 0, wrong: [] };

    const checkOrder = (name, isWords, texts, sign) => {
      if (isWords) return rises(texts, (a, b) => sign * words.compare(a, b)) ? [] : [`${name}: ${texts.join(', ')}`];
      const known = texts.map(number).filter(value => !Number.isNaN(value));
      // What has no number comes last, either way.
      const last = texts.slice(known.length).every(text => Number.isNaN(number(text)));
      if (sign === 1 && !rises(texts.slice(0, known.length), (a, b) => a < b ? -1 : a > b ? 1 : 0)) found.unlikeCharacters += 1;
      return last && rises(known, (a, b) => sign * (a - b)) ? [] : [`${name}: ${texts.join(', ')}`];
    };
    const checkColumn = (name, bodies, head, place) => {
      const button = head.querySelector('button');
      if (!button) return [`${name}: no button`];
      found.columns += 1;
      const content = () => bodies.map(body => rowsOf(body).map(row => row.textContent).join('\n')).join('\n');
      const before = content();
      const wrong = [];
      for (const [order, sign] of [['ascending', 1], ['descending', -1]]) {
        button.click();
        const state = head.getAttribute('aria-sort');
        if (state !== order) wrong.push(`${name}: aria-sort is ${state}, not ${order}`);
        for (const body of bodies) {
          const texts = rowsOf(body).map(row => row.cells[place]?.textContent.trim() ?? '');
          wrong.push(...checkOrder(`${name}, ${order}`, head.classList.contains('words'), texts, sign));
        }
      }
      button.click();
      const restored = !head.hasAttribute('aria-sort') && content() === before;
      return restored ? wrong : [...wrong, `${name}: the third click does not restore the order`];
    };

    for (const table of document.querySelectorAll('table')) {
      const bodies = [...table.tBodies];
      if (!bodies.some(body => rowsOf(body).length > 1)) continue;
      const place = table.closest('section')?.id ?? 'first screen';
      [...table.tHead.rows[0].cells].forEach((head, n) => {
        found.wrong.push(...checkColumn(`${place}, ${head.textContent}`, bodies, head, n));
      });
    }
    return found;
  });
}
