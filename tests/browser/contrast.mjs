// Contrast of text with what is painted behind it, by the formula of WCAG 2.

/** Least contrast of text (WCAG 2, level AA). */
const LEAST = 4.5;

/**
 * Counts visible texts and lists those with too little contrast. What is behind a text is the nearest opaque
 * background around it; behind the text of a figure also the shape that is painted there.
 */
export function illegible(page) {
  return page.evaluate(least => {
    const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
    canvas.canvas.width = canvas.canvas.height = 1;
    const seen = new Map();
    // Red, green, blue and opacity of any CSS colour.
    const parse = colour => {
      if (!seen.has(colour)) {
        canvas.clearRect(0, 0, 1, 1);
        canvas.fillStyle = colour;
        canvas.fillRect(0, 0, 1, 1);
        const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
        seen.set(colour, [r, g, b, a / 255]);
      }
      return seen.get(colour);
    };
    const over = ([r, g, b, a], below) => [r, g, b].map((channel, n) => channel * a + below[n] * (1 - a));
    const luminance = rgb => {
      const [r, g, b] = rgb.map(channel => channel / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const contrast = (a, b) => {
      const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return (high + 0.05) / (low + 0.05);
    };
    const opacity = element => element ? Number(getComputedStyle(element).opacity) * opacity(element.parentElement) : 1;
    const faded = ([r, g, b, a], share) => [r, g, b, a * share];
    const canvasColour = () => parse(matchMedia('(prefers-color-scheme: dark)').matches ? '#121212' : '#ffffff').slice(0, 3);
    // The backgrounds of an element and of those around it, painted over each other.
    const background = element => {
      if (!element) return canvasColour();
      return over(parse(getComputedStyle(element).backgroundColor), background(element.parentElement));
    };
    const shapes = new WeakMap();
    const shapesOf = svg => {
      if (!shapes.has(svg)) {
        const painted = [...svg.querySelectorAll('rect, path, polygon, circle')]
          .map(shape => ({ shape, style: getComputedStyle(shape), box: shape.getBoundingClientRect() }))
          .filter(({ style, box }) => style.fill !== 'none' && box.width > 0 && box.height > 0 && style.visibility === 'visible');
        shapes.set(svg, painted);
      }
      return shapes.get(svg);
    };
    const inside = (shape, x, y) => {
      const point = new DOMPoint(x, y).matrixTransform(shape.getScreenCTM().inverse());
      return shape.isPointInFill(point);
    };
    // What a figure paints behind its text, in the order of painting.
    const behind = (text, box) => {
      let colour = background(text.ownerSVGElement);
      const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
      for (const { shape, style, box: own } of shapesOf(text.ownerSVGElement)) {
        if (own.left > x || own.right < x || own.top > y || own.bottom < y) continue;
        if (text.compareDocumentPosition(shape) & Node.DOCUMENT_POSITION_PRECEDING && inside(shape, x, y)) {
          colour = over(faded(parse(style.fill), Number(style.fillOpacity) * opacity(shape)), colour);
        }
      }
      return colour;
    };
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const result = { texts: 0, faint: [] };
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const element = node.parentElement;
      if (!node.data.trim() || ['SCRIPT', 'STYLE', 'title', 'desc'].includes(element.tagName)) continue;
      if (!element.checkVisibility({ visibilityProperty: true })) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      const box = range.getBoundingClientRect();
      if (box.width === 0 || box.height === 0) continue;
      const style = getComputedStyle(element);
      const drawn = element instanceof SVGElement;
      const below = drawn ? behind(element, box) : background(element);
      const share = opacity(element) * (drawn ? Number(style.fillOpacity) : 1);
      const colour = over(faded(parse(drawn ? style.fill : style.color), share), below);
      const found = contrast(colour, below);
      result.texts += 1;
      if (found < least) {
        const hex = rgb => `#${rgb.map(channel => Math.round(channel).toString(16).padStart(2, '0')).join('')}`;
        result.faint.push({ contrast: found, text: node.data.trim().slice(0, 40), colours: `${hex(colour)} on ${hex(below)}` });
      }
    }
    return result;
  }, LEAST);
}
