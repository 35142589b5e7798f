'use strict';
/* Tables sort by a click on a heading: up, down, as they were. Without this script they just do not. */
const number = text => {
  const plain = text.replace(/[\u202f\u00a0\s]/g, '').replace(/\u2212/g, '-');
  const found = /^([<>]?)([+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?)/.exec(plain);
  if (!found) return null;
  const value = Number(found[2]);
  /* "< 0.01" lies just below 0.01, "> 99.9" just above. */
  return found[1] === '<' ? value - 1e-9 : found[1] === '>' ? value + 1e-9 : value;
};
const compare = (a, b, words, sign) => {
  if (words) return sign * a.localeCompare(b, 'en', { numeric: true });
  const [x, y] = [number(a), number(b)];
  /* What is not known comes last, either way. */
  if (x === null || y === null) return (x === null) - (y === null);
  return sign * (x - y);
};
for (const table of document.querySelectorAll('table')) {
  const heads = [...table.querySelectorAll('thead th')];
  const bodies = [...table.tBodies].map(body => [body, [...body.rows].filter(row => !row.classList.contains('group'))]);
  if (!bodies.some(([, rows]) => rows.length > 1)) continue;
  heads.forEach((head, place) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.title = 'sort';
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener('click', () => {
      const next = { ascending: 'descending', descending: 'none' }[head.getAttribute('aria-sort')] || 'ascending';
      for (const other of heads) other.removeAttribute('aria-sort');
      if (next !== 'none') head.setAttribute('aria-sort', next);
      const sign = next === 'ascending' ? 1 : -1;
      const words = head.classList.contains('words');
      for (const [body, rows] of bodies) {
        const text = row => row.cells[place] ? row.cells[place].textContent.trim() : '';
        const sorted = next === 'none' ? rows : [...rows].sort((a, b) => compare(text(a), text(b), words, sign));
        body.append(...sorted);
      }
    });
  });
}

/* Values at once where a pointer is: titles of shapes, and the nearest point of a line. */
const tip = document.createElement('div');
tip.className = 'tip';
tip.setAttribute('role', 'status');
document.body.append(tip);
const titles = new WeakMap();
const titleOf = shape => {
  for (let at = shape; at && at.ownerSVGElement; at = at.parentNode) {
    const own = [...at.children].find(child => child.tagName === 'title');
    if (own) {
      titles.set(at, own.textContent);
      /* The browser's own tooltip would come on top of this one; those who listen keep the words. */
      at.setAttribute('aria-label', own.textContent);
      own.remove();
    }
    if (titles.has(at)) return titles.get(at);
  }
  return '';
};
const value = (axis, pixel) => {
  const [spread, low, high, from, to] = axis.split(' ').map((part, k) => k ? Number(part) : part);
  const share = (pixel - from) / (to - from);
  return Number((spread === 'log' ? low * (high / low) ** share : low + share * (high - low)).toPrecision(3));
};
const points = new WeakMap();
const pointsOf = line => {
  if (!points.has(line)) {
    points.set(line, [...line.getAttribute('d').matchAll(/[ML](\S+?) ([^ML]+)/g)].map(m => [Number(m[1]), Number(m[2])]));
  }
  return points.get(line);
};
const nearest = (lines, event) => {
  let best = null;
  for (const line of lines.querySelectorAll('path.line')) {
    const inside = new DOMPoint(event.clientX, event.clientY).matrixTransform(line.getScreenCTM().inverse());
    for (const [x, y] of pointsOf(line)) {
      const far = Math.hypot(x - inside.x, y - inside.y);
      if (far < 24 && (!best || far < best.far)) best = { far, line, x, y };
    }
  }
  if (!best) return '';
  const [x, y] = [value(lines.dataset.x, best.x), value(lines.dataset.y, best.y)];
  return `${titleOf(best.line)}\n${lines.dataset.xName}: ${x}\n${lines.dataset.yName}: ${y}`;
};
document.addEventListener('pointermove', event => {
  const shape = event.target instanceof SVGElement ? event.target : null;
  const drawing = shape && shape.closest('svg.chart');
  const lines = drawing && drawing.querySelector('[data-x]');
  const text = drawing ? (lines && nearest(lines, event)) || titleOf(shape) : '';
  tip.textContent = text;
  tip.classList.toggle('shown', text !== '');
  if (text) {
    const room = document.documentElement.clientWidth - tip.offsetWidth - 8;
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, room))}px`;
    tip.style.top = `${event.clientY + 18 + tip.offsetHeight > innerHeight ? event.clientY - tip.offsetHeight - 10 : event.clientY + 18}px`;
  }
});

/* One box opens everything that is folded away: on the screen, and so in print. */
const boxes = [...document.querySelectorAll('.everything input')];
for (const box of boxes) {
  box.parentNode.hidden = false;
  box.addEventListener('change', () => {
    for (const other of boxes) other.checked = box.checked;
    for (const details of document.querySelectorAll('main details')) details.open = box.checked;
  });
}
