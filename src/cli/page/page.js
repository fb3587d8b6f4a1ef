// Asks once a second how far the render is, and takes each new picture.
const element = (id) => document.getElementById(id);
const say = (id, text) => { if (element(id).textContent !== text) element(id).textContent = text; };
const visitor = crypto.getRandomValues(new Uint32Array(1))[0];
const SECOND = 1000, PATIENCE = 5;
let picture = null, tone = 'srgb', failures = 0, drawing = false;

function time(seconds) {
  const s = Math.round(seconds);
  if (s < 60) return `${s} s`;
  return s < 3600 ? `${Math.floor(s / 60)} min ${s % 60} s` : `${Math.floor(s / 3600)} h ${Math.floor(s / 60) % 60} min`;
}
const digits = (x, n = 3) => Number(x.toPrecision(n)).toLocaleString('en');
const amount = (x, unit) => x >= 1e6 ? `${digits(x / 1e6)} M${unit}` : `${digits(x / 1e3)} k${unit}`;
const percent = (x) => `${(100 * x).toFixed(x < 0.1 ? 1 : 0)} %`;

/** Draws the picture, at most once for each frame of the screen. */
function draw() {
  const change = Number(element('exposure').value);
  const shown = `${change > 0 ? '+' : ''}${change.toFixed(1)} stops`;
  say('stops', shown);
  element('exposure').setAttribute('aria-valuetext', shown);
  if (!picture || drawing) return;
  drawing = true;
  requestAnimationFrame(() => {
    drawing = false;
    const canvas = element('picture'), { width, height } = picture;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const context = canvas.getContext('2d'), image = context.createImageData(width, height);
    const stops = picture.stops - picture.exponent + Number(element('exposure').value);
    develop(picture.halves, stops, tone, image.data);
    context.putImageData(image, 0, 0);
  });
}

async function take(number) {
  const answer = await fetch(`picture?page=${visitor}`);
  if (!answer.ok) return;
  const bytes = await answer.arrayBuffer(), head = new DataView(bytes, 0, 16);
  picture = { number, width: head.getUint32(0, true), height: head.getUint32(4, true), stops: head.getFloat32(8, true),
    exponent: head.getInt32(12, true), halves: new Uint16Array(bytes, 16) };
  say('caption', `${picture.width} × ${picture.height} pixels, shown as the PNG, with the tone curve ${tone}`);
  draw();
}

function figures({ figures: f, guide, progress: p }) {
  if (p) {
    const { share, left_seconds: left } = p;
    if (share === null) element('share').removeAttribute('value'); else element('share').value = share;
    say('percent', share === null ? '' : percent(share));
    say('left', left === null ? '–' : time(left));
  }
  if (!f) return;
  say('samples', (p?.samples ?? f.samples).toLocaleString('en'));
  say('error', f.relative_error === null ? 'not known yet' : `about ${percent(f.relative_error)}`);
  say('time', time(f.wall_seconds));
  const rate = (n) => n / Math.max(f.wall_seconds, 1e-9);
  say('speed', `${amount(rate(f.paths), 'samples/s')}, ${amount(rate(f.rays), 'rays/s')}`);
  say('guide', guide);
  say('memory', f.guide ? `${digits(f.guide.bytes / 2 ** 20)} MiB in ${f.guide.states.toLocaleString('en')} places` : '–');
  say('drawn', f.guide ? percent(f.guide.drawn_share) : '–');
}

/** What the render is busy with. */
function state({ ended, progress: p }) {
  if (ended) return `The render has ended (${ended}). This is its last picture.`;
  if (!p) return 'waiting for the render';
  const frame = p.frame ? `frame ${p.frame.number} (${p.frame.k} of ${p.frame.of}): ` : '';
  return frame + (p.finishing ? 'finishing' : p.stage);
}

async function ask() {
  try {
    const status = await (await fetch(`status?page=${visitor}`)).json();
    [failures, tone] = [0, status.tone];
    say('state', state(status));
    document.title = `${status.ended ? 'ended' : percent(status.progress?.share ?? 0)} – ${status.name}`;
    figures(status);
    if (status.picture && status.picture !== picture?.number) await take(status.picture);
    if (!status.ended) setTimeout(ask, SECOND);
    else say('left', '–');
  } catch {
    failures += 1;
    if (failures < PATIENCE) setTimeout(ask, SECOND);
    else say('state', 'The render does not answer any more: it has ended. This is the last picture that came.');
  }
}

element('exposure').addEventListener('input', draw);
element('view').addEventListener('reset', () => setTimeout(draw));
element('view').addEventListener('submit', (event) => event.preventDefault());
ask();
