// How the page looks: contrast of all text, and no sideways scrolling. Runs after the checks, in light, dark and narrow.

const paint = document.createElement('canvas').getContext('2d', { willReadFrequently: true });

/** R, G, B, alpha of a CSS colour laid over another. */
function over(css, under) {
  paint.fillStyle = `rgb(${under.join(' ')})`;
  paint.fillRect(0, 0, 1, 1);
  paint.fillStyle = css;
  paint.fillRect(0, 0, 1, 1);
  return [...paint.getImageData(0, 0, 1, 1).data.slice(0, 3)];
}

/** Relative luminance as WCAG 2 defines it. */
function lightness(rgb) {
  const [r, g, b] = rgb.map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

const WHITE = [255, 255, 255];

const ground = node => over(getComputedStyle(node).backgroundColor,
  node.parentElement ? ground(node.parentElement) : WHITE);

function contrast(node) {
  const behind = ground(node);
  const [a, b] = [lightness(over(getComputedStyle(node).color, behind)), lightness(behind)];
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}

const speaks = node => [...node.childNodes].some(child => child.nodeType === Node.TEXT_NODE && child.data.trim() !== '')
  && node.getClientRects().length > 0;

await check('all text stands out from its ground', () => {
  const texts = $$('body *').filter(node => !['OPTION', 'SCRIPT', 'STYLE'].includes(node.tagName) && speaks(node));
  holds(texts.length > 100, `only ${texts.length} texts`);
  const faint = texts.filter(node => contrast(node) < 4.5);
  same(faint.map(node => `${node.tagName} ${node.className}: ${node.textContent.slice(0, 20)}: ${contrast(node)}`), []);
});

await check('charts stand out from the page, in the size that fits it', () => {
  const shown = $$('#charts figure')[0].querySelectorAll('.drawing');
  const narrow = document.documentElement.clientWidth < 640;
  same([...shown].map(drawing => drawing.getClientRects().length > 0), [!narrow, narrow]);
  const line = shown[narrow ? 1 : 0].shadowRoot.querySelector('path');
  const [a, b] = [lightness(over(getComputedStyle(line).stroke, WHITE)), lightness(ground(document.body))];
  const found = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  holds(found > 4.5, `contrast ${found}`);
});

await check('the page does not scroll sideways', () => {
  const { scrollWidth, clientWidth } = document.documentElement;
  holds(scrollWidth <= clientWidth, `${scrollWidth} is wider than ${clientWidth}`);
  const wide = $('#table-box');
  holds(wide.scrollWidth > wide.clientWidth || clientWidth > 1000, 'the table was to be wider than its box');
});

await check('nothing went wrong and nothing was asked for', () => {
  same(window.wrong, []);
  same(performance.getEntriesByType('resource').map(entry => entry.name).filter(name => !name.startsWith('data:')), []);
});

const dark = matchMedia('(prefers-color-scheme: dark)').matches;
tell(`done, ${dark ? 'dark' : 'light'}, ${document.documentElement.clientWidth} wide`);
