// What part of the pictures is seen: one view for all panels, moved by wheel, drag, pinch and keys.

/** The largest size of a pixel of the picture, in CSS pixels. */
const LARGEST_PIXEL = 64;

/** A wheel that scrolled the page goes on doing so for this long, in ms, though a picture comes under it. */
const WHEEL_PAUSE = 250;

const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

class View {
  /** `changed` is called after each move. */
  constructor(changed) {
    this.changed = changed;
    this.size = [1, 1];
    this.zoom = 1;
    this.centre = [0.5, 0.5];
  }

  show(width, height) {
    this.size = [width, height];
    this.fit();
  }

  /** The whole picture. `zoom` counts from there, so that panels of any size show the same part. */
  fit() {
    this.zoom = 1;
    this.centre = this.size.map(side => side / 2);
    this.changed();
  }

  /** CSS pixels per pixel of the picture in a panel. */
  scale(canvas) {
    return this.zoom * this.fitting(canvas);
  }

  fitting(canvas) {
    return Math.min(canvas.clientWidth / this.size[0], canvas.clientHeight / this.size[1]);
  }

  /** Place in the picture, in its pixels, of a place on the screen. */
  place(canvas, clientX, clientY) {
    const box = canvas.getBoundingClientRect();
    const scale = this.scale(canvas);
    return [
      this.centre[0] + (clientX - box.left - box.width / 2) / scale,
      this.centre[1] + (clientY - box.top - box.height / 2) / scale,
    ];
  }

  /** Moves the picture by CSS pixels. */
  pan(canvas, dx, dy) {
    const scale = this.scale(canvas);
    this.centre = [this.centre[0] - dx / scale, this.centre[1] - dy / scale];
    this.keepInside(canvas);
  }

  /** Enlarges by `factor`, the place under `at` (client coordinates; the middle where there are none) staying. */
  zoomBy(canvas, factor, at) {
    const fixed = at ? this.place(canvas, ...at) : [...this.centre];
    const fitting = this.fitting(canvas);
    const before = this.zoom;
    this.zoom = clamp(before * factor, Math.min(1, this.actual(canvas)), Math.max(1, LARGEST_PIXEL / fitting));
    this.centre = this.centre.map((c, i) => fixed[i] + (c - fixed[i]) * before / this.zoom);
    this.keepInside(canvas);
  }

  /** The zoom at which one pixel of the picture is one of the screen. */
  actual(canvas) {
    return 1 / (this.fitting(canvas) * devicePixelRatio);
  }

  /** No more border is shown than there must be. */
  keepInside(canvas) {
    const scale = this.scale(canvas);
    const half = [canvas.clientWidth, canvas.clientHeight].map(side => side / scale / 2);
    this.centre = this.centre.map((c, i) => 2 * half[i] >= this.size[i]
      ? this.size[i] / 2 : clamp(c, half[i], this.size[i] - half[i]));
    this.changed();
  }
}

/** Pixels of wheel movement; a pinch on a touchpad comes as a wheel with ctrl, and in smaller steps. */
function wheelPixels(event) {
  const line = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 1 : 16;
  return event.deltaY * line * (event.ctrlKey ? 5 : 1);
}

function listenToWheel(stage, view) {
  let scrolled = -Infinity;
  window.addEventListener('wheel', event => {
    const canvas = event.target.closest?.('canvas');
    if (!canvas || !stage.contains(canvas) || event.timeStamp - scrolled < WHEEL_PAUSE) {
      scrolled = event.timeStamp;
      return;
    }
    event.preventDefault();
    view.zoomBy(canvas, Math.exp(-0.002 * wheelPixels(event)), [event.clientX, event.clientY]);
  }, { passive: false });
}

/** One pointer drags, two pinch. */
function listenToPointers(stage, view) {
  const pointers = new Map();
  let canvas = null;
  const middle = () => [0, 1].map(i => [...pointers.values()].reduce((sum, at) => sum + at[i], 0) / pointers.size);
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 1;
  };
  stage.addEventListener('pointerdown', event => {
    if (event.target.localName !== 'canvas' || event.button !== 0 || pointers.size === 2) return;
    if (pointers.size === 0) canvas = event.target;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  window.addEventListener('pointermove', event => {
    if (!pointers.has(event.pointerId)) return;
    const [[x, y], apart] = [middle(), spread()];
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const [toX, toY] = middle();
    // Enlarged first: a picture that is seen whole cannot be moved.
    if (pointers.size === 2 && apart > 0) view.zoomBy(canvas, spread() / apart, [x, y]);
    view.pan(canvas, toX - x, toY - y);
  });
  const lift = event => pointers.delete(event.pointerId);
  window.addEventListener('pointerup', lift);
  window.addEventListener('pointercancel', lift);
}

/** Moves the view by a key; whether the key was one for it. */
function viewKey(key, canvas, view) {
  const step = 0.1 * Math.min(canvas.clientWidth, canvas.clientHeight);
  const moves = {
    ArrowLeft: () => view.pan(canvas, step, 0), ArrowRight: () => view.pan(canvas, -step, 0),
    ArrowUp: () => view.pan(canvas, 0, step), ArrowDown: () => view.pan(canvas, 0, -step),
    '+': () => view.zoomBy(canvas, 1.5), '=': () => view.zoomBy(canvas, 1.5), '-': () => view.zoomBy(canvas, 1 / 1.5),
    0: () => view.fit(),
  };
  moves[key]?.();
  return key in moves;
}
