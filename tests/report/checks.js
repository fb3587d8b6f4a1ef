// What a reader does with the page, done by events, and whether the page does what it says. Verdicts go to the console.

/** On one line: the test reads lines. */
const tell = words => console.log(`verdict: ${words.replace(/\s+/g, ' ').slice(0, 400)}`);
const $ = selector => document.querySelector(selector);
const $$ = selector => [...document.querySelectorAll(selector)];
const same = (value, wanted, what = '') => {
  const [a, b] = [JSON.stringify(value), JSON.stringify(wanted)];
  if (a !== b) throw new Error(`${what} ${a} is not ${b}`);
};
const holds = (truth, what) => { if (!truth) throw new Error(what); };
const frame = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
const until = async (truth, what) => {
  for (let i = 0; i < 500; i++) {
    if (truth()) return;
    await new Promise(done => setTimeout(done, 10));
  }
  throw new Error(`never came: ${what}`);
};

async function check(name, act) {
  try {
    await act();
    tell(`ok ${name}`);
  } catch (error) {
    tell(`FAILED ${name}: ${error.message}`);
  }
}

const radio = (name, value) => $(`input[name=${name}][value="${value}"]`).click();
const key = (target, name) => target.dispatchEvent(new KeyboardEvent('keydown',
  { key: name, bubbles: true, cancelable: true }));
const canvases = () => $$('#stage canvas');
const caption = () => $('#stage figcaption').textContent;

/** Client coordinates of a share of a canvas. */
const client = (canvas, u, v) => {
  const box = canvas.getBoundingClientRect();
  return { clientX: box.left + u * box.width, clientY: box.top + v * box.height };
};
const pointer = (target, kind, at, id = 1) => target.dispatchEvent(new PointerEvent(kind,
  { ...at, pointerId: id, button: 0, bubbles: true, cancelable: true }));
const wheel = (canvas, deltaY, at) => canvas.dispatchEvent(new WheelEvent('wheel',
  { ...at, deltaY, bubbles: true, cancelable: true }));

/** R, G, B on the screen at a share of a canvas. */
const pixel = (canvas, u, v) => [...canvas.getContext('2d')
  .getImageData(Math.floor(u * canvas.width), Math.floor(v * canvas.height), 1, 1).data.slice(0, 3)];
const srgb = linear => Math.round(255 * Math.min(1,
  linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));

/** The pictures of the tests: red tells the column, green the row, blue the picture (0: the reference). */
const SIZE = [16, 8];
const texel = (x, y, picture) => [10 * x + 5, 20 * y + 5, 40 * picture + 20].map(m => m / 256);
const toned = (x, y, picture, stops = 0) => texel(x, y, picture).map(value => srgb(value * 2 ** stops));
const near = (value, wanted, what) => holds(value.every((v, i) => Math.abs(v - wanted[i]) <= 1),
  `${what}: ${value} is not ${wanted}`);

/** The column and row seen at a share of a canvas, at exposure 0. */
function seen(canvas, u, v) {
  const [red, green] = pixel(canvas, u, v);
  const columns = Array.from({ length: SIZE[0] }, (_, x) => Math.abs(toned(x, 0, 0)[0] - red));
  const rows = Array.from({ length: SIZE[1] }, (_, y) => Math.abs(toned(0, y, 0)[1] - green));
  return [columns.indexOf(Math.min(...columns)), rows.indexOf(Math.min(...rows))];
}

async function expose(stops) {
  $('#exposure').value = stops;
  $('#exposure').dispatchEvent(new Event('input'));
  await frame();
}

async function mode(name) {
  radio('viewer-mode', name);
  await frame();
  key($('#stage'), '0');
  await frame();
}

await check('pictures are unpacked', () => until(() => canvases().length === 4, 'canvases'));
await frame();

await check('summary names best, worst and what is wrong', () => {
  const text = $('#summary').textContent;
  for (const words of ['tree, fine 4.00× (3.00 to 5.00)', 'grid 0.500× (0.400 to 0.600, biased)', 'Biased: grid in a<b',
    'Not finite: tree, fine in a<b']) holds(text.includes(words), `no "${words}" in ${text}`);
  same(document.title, 'A <\/script> title');
});

await check('matrix colours what is certain and follows its controls', () => {
  const look = () => $$('#matrix tbody td').map(cell => [cell.className, cell.querySelector('.ratio').textContent]);
  const [base, biased, better] = look();
  same(base, ['undecided', '1.00×']);
  same(biased, ['undecided', '0.500×'], 'biased:');
  same(better, ['better', '4.00×']);
  same(look()[4], ['worse', '0.250×']);
  same(look()[5], ['undecided', '1.10×'], 'an interval about 1:');
  holds($('#matrix tbody').textContent.includes('biased'), 'no word for bias');
  radio('matrix-error', 'trimmed');
  same(look()[2][1], '2.00×', 'trimmed:');
  radio('matrix-budget', '4 spp');
  same(look()[5][1], '–', 'an undefined ratio:');
});

await check('means over scenes are told, with what the figures were made with', () => {
  const text = $('#summary').textContent;
  for (const words of ['grid over 2 scenes: geometric mean 0.350× (0.315 to 0.385', 'a factor of 1.60, from 0.175× in hall to 0.700× in a<b',
    'Commit abc, compiled for x86-64-v3; Embree 4.3.0 with avx2; 2026-01-02T03:04:05Z']) holds(text.includes(words), `no "${words}" in ${text}`);
  radio('matrix-budget', '16 spp');
  const row = $$('#matrix tfoot td').map(cell => [cell.className, cell.querySelector('.ratio')?.textContent]);
  same(row.slice(1), [['worse', '0.350×'], ['better', '2.10×']]);
});

await check('verdicts are marked, told and explained', () => {
  const marks = $$('#gallery .verdict').map(button => button.querySelector('.mark').textContent);
  same(marks, ['✓', '✗', '~', '✓', '~', '~']);
  holds($('#gallery').textContent.includes('1 failure unexplained'), 'no word on what is unexplained');
  const red = $$('#gallery .verdict')[1];
  holds(red.textContent.includes('0.500×') && red.textContent.includes('worst 4.00×'), red.textContent);
  red.focus();
  red.click();
  const detail = $('#gallery-detail').textContent;
  for (const words of ['a<b, grid: failed', 'Unbiased: what unbiased says', 'It <knows> nothing.', 'Unexplained'])
    holds(detail.includes(words), `no "${words}" in ${detail}`);
  same([red.ariaExpanded, document.activeElement.tagName], ['true', 'H3']);
});

await check('a verdict shows its picture beside the reference', async () => {
  $$('#pictures [role=tab]')[1].click();
  await until(() => canvases().length === 4, 'the other scene');
  $$('#gallery-detail button').at(-1).click();
  await until(() => canvases().length === 2, 'two pictures');
  await frame();
  same($$('#stage figcaption').map(words => words.textContent.split('  ')[1].split(',')[0]), ['reference', 'grid']);
  $$('#pictures [role=tab]')[0].click();
  await until(() => canvases().length === 4, 'all again');
  await frame();
  window.scrollTo(0, 0);
});

await check('chart tabs go by click and by key', () => {
  const shown = () => $$('#charts [role=tabpanel]').map(panel => !panel.hidden);
  const tabs = $$('#charts [role=tab]');
  same(shown(), [true, false, false]);
  tabs[1].click();
  same(shown(), [false, true, false]);
  tabs[1].focus();
  key(tabs[1], 'ArrowRight');
  same([shown(), document.activeElement === tabs[2]], [[false, false, true], true]);
  key(tabs[2], 'ArrowRight');
  same(shown(), [true, false, false], 'round the end:');
  holds($('#charts .drawing').shadowRoot.querySelector('svg').namespaceURI.endsWith('/svg'), 'no drawing');
});

await check('table sorts both ways, stably, what is undefined last', () => {
  const heads = $$('#table-box thead th');
  const column = label => heads.findIndex(head => head.textContent === label);
  const read = label => $$('#table-box tbody tr').map(row => row.cells[column(label)].firstChild.textContent);
  const sort = label => heads[column(label)].querySelector('button').click();
  const numbers = () => read('Efficiency ratio').filter(text => text !== '–').map(Number);
  sort('Efficiency ratio');
  same(numbers(), [...numbers()].sort((a, b) => a - b), 'rising:');
  same([heads[column('Efficiency ratio')].ariaSort, read('Efficiency ratio').at(-1)], ['ascending', '–']);
  sort('Efficiency ratio');
  same(numbers(), [...numbers()].sort((a, b) => b - a), 'falling:');
  same([heads[column('Efficiency ratio')].ariaSort, read('Efficiency ratio').at(-1)], ['descending', '–']);
  sort('Budget');
  same([read('Budget')[0], read('Budget').at(-1)], ['4 spp', '16 spp'], 'by number, not by letter:');
  sort('Method');
  same(read('Budget').slice(0, 4), ['4 spp', '16 spp', '4 spp', '16 spp'], 'equal rows as they were written:');
  same(heads.filter(head => head.ariaSort !== 'none').length, 1);
});

await check('table filters, and copies as CSV', async () => {
  let copied = null;
  Object.defineProperty(navigator, 'clipboard', { value: { writeText: async text => { copied = text; } } });
  const list = $('#table-controls select');
  list.value = 'a<b';
  list.dispatchEvent(new Event('change'));
  same($$('#table-box tbody tr').length, 6);
  $$('#table-controls button').at(-1).click();
  await until(() => copied !== null, 'the copy');
  const lines = copied.split('\r\n');
  same([lines.length, lines[0].split(',').slice(0, 7).join()], [8, 'scene,method,budget,runs,ratio,ratio_low,ratio_high']);
  holds(lines.some(line => line.startsWith('a<b,"tree, fine",16 spp,3,4,3,5,2,')), copied);
});

await check('pictures are toned by sRGB and exposure', async () => {
  for (const stops of [0, 1, -2]) {
    await expose(stops);
    canvases().forEach((canvas, i) => near(pixel(canvas, 8.5 / 16, 4.5 / 8), toned(8, 4, i, stops), `${stops} stops`));
  }
  await expose(0);
});

await check('all panels zoom about the pointer and move in step', async () => {
  const [first, second] = canvases();
  const at = [[4.5 / 16, 2.5 / 8], [8.5 / 16, 4.5 / 8], [14.5 / 16, 7.5 / 8]];
  const looks = canvas => at.map(([u, v]) => seen(canvas, u, v));
  same(looks(first), [[4, 2], [8, 4], [14, 7]], 'at first:');
  const fixed = client(second, 12.5 / 16, 2.5 / 8);
  wheel(second, -400, fixed);
  await frame();
  same(seen(second, 12.5 / 16, 2.5 / 8), [12, 2], 'under the pointer:');
  holds(JSON.stringify(looks(second)) !== '[[4,2],[8,4],[14,7]]', 'nothing was enlarged');
  canvases().forEach(canvas => same(looks(canvas), looks(second), 'not in step:'));
  const [before] = seen(second, 0.5, 0.5);
  pointer(second, 'pointerdown', client(second, 0.5, 0.5));
  pointer(window, 'pointermove', client(second, 0.9, 0.5));
  pointer(window, 'pointerup', client(second, 0.9, 0.5));
  pointer(window, 'pointermove', client(second, 0.1, 0.5));
  await frame();
  same(seen(second, 0.9, 0.5)[0], before, 'dragged:');
  canvases().forEach(canvas => same(looks(canvas), looks(second), 'not in step when dragged:'));
  const held = looks(first);
  key($('#stage'), 'ArrowRight');
  await frame();
  holds(JSON.stringify(looks(first)) !== JSON.stringify(held), 'an arrow key moved nothing');
  key($('#stage'), '0');
  await frame();
  same(looks(first), [[4, 2], [8, 4], [14, 7]], 'the whole again:');
});

await check('two fingers pinch', async () => {
  const [canvas] = canvases();
  pointer(canvas, 'pointerdown', client(canvas, 0.4, 0.5), 1);
  pointer(canvas, 'pointerdown', client(canvas, 0.6, 0.5), 2);
  pointer(window, 'pointermove', client(canvas, 0.2, 0.5), 1);
  pointer(window, 'pointermove', client(canvas, 0.8, 0.5), 2);
  [1, 2].forEach(id => pointer(window, 'pointerup', client(canvas, 0.5, 0.5), id));
  await frame();
  // The fingers lie where they lay on the picture: 0.4 and 0.6 of its 16 columns.
  same([seen(canvas, 0.22, 0.5)[0], seen(canvas, 0.78, 0.5)[0]], [6, 9]);
});

await check('enlarged pixels keep hard edges', async () => {
  await mode('flip');
  for (let i = 0; i < 12; i++) key($('#stage'), '+');
  await frame();
  const [canvas] = canvases();
  const row = canvas.getContext('2d').getImageData(0, canvas.height / 2, canvas.width, 1).data;
  const reds = new Set(Array.from({ length: canvas.width }, (_, i) => row[4 * i]));
  const allowed = new Set(Array.from({ length: 16 }, (_, x) => toned(x, 0, 0)[0]));
  holds([...reds].every(red => [red - 1, red, red + 1].some(value => allowed.has(value))), `blended: ${[...reds]}`);
});

await check('digits choose and the space bar flips', async () => {
  await mode('flip');
  const blue = () => pixel(canvases()[0], 0.5, 0.5)[2];
  const shows = () => [0, 1, 2, 3].findIndex(i => Math.abs(toned(0, 0, i)[2] - blue()) <= 1);
  const wanted = [['1', 0], ['3', 2], [' ', 0], [' ', 2], ['2', 1], [' ', 2], ['9', 2]];
  for (const [name, picture] of wanted) {
    key($('#stage'), name);
    await frame();
    same(shows(), picture, `after ${name}:`);
  }
  holds(caption().includes('grid'), caption());
});

await check('the slider shows one picture on each side', async () => {
  await mode('slider');
  const [canvas] = canvases();
  const blue = u => pixel(canvas, u, 0.5)[2];
  const [left, right] = [toned(0, 0, 0)[2], toned(0, 0, 3)[2]];
  near([blue(0.4), blue(0.6)], [left, right], 'in the middle');
  const bar = $('.splitter');
  pointer(bar, 'pointerdown', client(canvas, 0.5, 0.5));
  pointer(window, 'pointermove', client(canvas, 0.8, 0.5));
  pointer(window, 'pointerup', client(canvas, 0.8, 0.5));
  await frame();
  near([blue(0.75), blue(0.85)], [left, right], 'dragged');
  same(bar.ariaValueNow, '80');
  key(bar, 'Home');
  await frame();
  near([blue(0.02), blue(0.98)], [right, right], 'at its left end');
  key($('#stage'), ' ');
  await frame();
  near([blue(0.02), blue(0.98)], [left, left], 'swapped');
});

await check('false colours are those of the legend', async () => {
  await mode('grid');
  radio('viewer-what', 'error');
  await frame();
  holds(!$('#error-legend').hidden && $('#exposure').disabled, 'no legend, or an exposure that does nothing');
  const hex = $('#error-legend .bar').style.background.match(/rgb\([^)]*\)/g).map(c => c.match(/\d+/g).map(Number));
  const [reference, ...others] = canvases();
  near(pixel(reference, 8.5 / 16, 4.5 / 8), toned(8, 4, 0), 'the reference as it is');
  others.forEach((canvas, i) => {
    const wanted = texel(0, 0, 0)[2];
    const error = ((texel(0, 0, i + 1)[2] - wanted) ** 2 / (wanted ** 2 + 0.01)) / 3;
    const place = ((Math.log10(error) + 4) / 5) * (hex.length - 1);
    const [low, share] = [Math.floor(place), place % 1];
    const colour = hex[low].map((c, k) => c + share * (hex[low + 1][k] - c));
    const found = pixel(canvas, 2.5 / 16, 2.5 / 8);
    holds(found.every((c, k) => Math.abs(c - colour[k]) <= 4), `error ${error}: ${found} is not ${colour}`);
  });
  radio('viewer-what', 'picture');
  await frame();
});

await check('the pixel under the pointer is read out', async () => {
  const [, second] = canvases();
  pointer(second, 'pointermove', client(second, 3.5 / 16, 6.5 / 8));
  await frame();
  same($('#readout-place').textContent, 'Pixel 3, 6');
  const rows = $$('#readout tbody tr').map(row => [...row.cells].map(cell => cell.textContent));
  const wanted = [0, 1].map(i => texel(3, 6, i).map(value => value.toPrecision(3)));
  same(rows[0], ['reference', ...wanted[0], '–']);
  same(rows[1].slice(0, 4), ['none', ...wanted[1]]);
  holds(Math.abs(Number(rows[1][4]) / 0.5060 - 1) < 2e-3, `error ${rows[1][4]}`);
});

await check('a picture can be left out of the row', async () => {
  key($('#stage'), '2');
  await frame();
  same([canvases().length, $$('#pickers button')[1].ariaPressed], [3, 'false']);
  $$('#pickers button')[1].click();
  same(canvases().length, 4);
});
