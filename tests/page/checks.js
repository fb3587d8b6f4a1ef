// What somebody does who watches a render, on its page. The answers of the server are put before the page's own script, as
// `answers`; what a PNG of the same picture holds as `expected`, by exposure.
const verdict = (text) => console.log(`verdict: ${text}`);
const check = (name, holds, seen) => verdict(`${holds ? 'ok' : 'FAILED'} ${name}${holds ? '' : `: ${JSON.stringify(seen)}`}`);
const $ = (id) => document.getElementById(id);

async function until(condition) {
  for (let i = 0; i < 200 && !condition(); i++) await new Promise((done) => setTimeout(done, 50));
}
const settled = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));

/** Largest difference between bytes of the canvas and those of a PNG. */
function distance(png) {
  const { width, height } = $('picture'), { data } = $('picture').getContext('2d').getImageData(0, 0, width, height);
  if (png.length !== 3 * width * height) return NaN;
  return png.reduce((worst, byte, i) => Math.max(worst, Math.abs(byte - data[4 * Math.floor(i / 3) + i % 3])), 0);
}

function expose(stops) {
  $('exposure').value = stops;
  $('exposure').dispatchEvent(new Event('input'));
  return settled();
}

async function run() {
  await until(() => $('picture').width === answers.width && $('state').textContent.includes('ended'));
  await settled();
  check('the picture is that of the PNG', distance(expected[0]) <= 1, distance(expected[0]));
  await expose(2);
  check('two stops more', distance(expected[2]) <= 1 && distance(expected[0]) > 20, [distance(expected[2]), distance(expected[0])]);
  check('the exposure is said', $('stops').textContent === '+2.0 stops', $('stops').textContent);
  $('reset').click();
  await settled();
  await settled();
  check('the exposure is taken back', distance(expected[0]) <= 1 && $('exposure').value === '0', $('exposure').value);
  check('the end is told', $('state').textContent.includes('done'), $('state').textContent);
  const shown = ['samples', 'error', 'time', 'speed', 'guide', 'memory', 'drawn'].map((id) => $(id).textContent);
  check('all figures are there', !shown.includes('–') && shown[1].includes('%') && shown[3].includes('rays/s'), shown);
  const reached = [...document.querySelectorAll('input, button')].filter((e) => e.tabIndex === 0 && e.getClientRects().length);
  check('the keyboard reaches the slider and the button', reached.length === 2, reached.length);
  check('each control has a name', [...document.querySelectorAll('input, progress')].every((e) => e.labels.length === 1));
  const { scrollWidth } = document.documentElement;
  check('nothing is wider than the screen', scrollWidth <= innerWidth, [scrollWidth, innerWidth]);
  check('nothing goes wrong', window.wrong.length === 0, window.wrong);
  const [ground] = getComputedStyle(document.body).backgroundColor.match(/\d+/g);
  verdict(`done, ${ground < 128 ? 'dark' : 'light'}, ${innerWidth} wide`);
}
run();
