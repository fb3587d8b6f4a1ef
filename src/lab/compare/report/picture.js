// Pictures as they come (RGBE, deflated, base64), toned to the screen, or their error in false colours.

/** Decades of the relative square error that the false colours span. */
const ERROR_DECADES = [-4, 1];

/** Of rising lightness, so that a print in grey keeps the order. */
const FALSE_COLOURS = ['#05060f', '#2c2f7a', '#8a3a8f', '#e0695b', '#f7b955', '#fcf7d2'];

/** As in relMSE: keeps the error finite where the reference is black. */
const EPSILON = 0.01;

const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

async function unpacked({ rgbe, width, height }) {
  if (typeof DecompressionStream === 'undefined') throw new Error('this browser has no DecompressionStream');
  const characters = atob(rgbe);
  const packed = new Uint8Array(characters.length);
  for (let i = 0; i < packed.length; i++) packed[i] = characters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const texels = new Uint8Array(await new Response(stream).arrayBuffer());
  if (texels.length !== 4 * width * height) throw new Error('its size is not that of its pixels');
  return texels;
}

/** Unit of a mantissa by exponent byte; a mantissa of 0 gives black by itself. */
const UNITS = Float64Array.from({ length: 256 }, (_, e) => e === 0 ? 0 : 2 ** (e - 136));

/** The byte that a screen is sent for each exponent (upper byte) and mantissa (lower byte): sRGB, IEC 61966-2-1. */
function toneTable(stops) {
  return Uint8ClampedArray.from({ length: 65536 }, (_, i) => {
    const linear = (i & 255) * UNITS[i >> 8] * 2 ** stops;
    return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
  });
}

function surface(width, height) {
  return el('canvas', { width, height });
}

/** 256 colours, three bytes each. */
function falseColours() {
  const context = surface(256, 1).getContext('2d');
  const gradient = context.createLinearGradient(0, 0, 256, 0);
  FALSE_COLOURS.forEach((colour, i) => gradient.addColorStop(i / (FALSE_COLOURS.length - 1), colour));
  context.fillStyle = gradient;
  context.fillRect(0, 0, 256, 1);
  return context.getImageData(0, 0, 256, 1).data;
}

/** Relative square error of the texel at byte `i`, the mean over its channels. */
function squareError(texels, wanted, i) {
  const [unit, wantedUnit] = [UNITS[texels[i + 3]], UNITS[wanted[i + 3]]];
  let sum = 0;
  for (let c = 0; c < 3; c++) {
    const r = wanted[i + c] * wantedUnit;
    sum += (texels[i + c] * unit - r) ** 2 / (r * r + EPSILON);
  }
  return sum / 3;
}

class Picture {
  constructor(image, texels, reference) {
    const { method, seed, width, height } = image;
    Object.assign(this, { method, seed, width, height, texels });
    this.reference = reference;
    this.label = method;
    this.toned = { stops: null, canvas: surface(width, height) };
    this.errors = null;
  }

  /** Linear R, G, B of a pixel. */
  at(x, y) {
    const i = 4 * (y * this.width + x);
    const unit = UNITS[this.texels[i + 3]];
    return [0, 1, 2].map(c => this.texels[i + c] * unit);
  }

  /** Relative square error of a pixel; null without a reference. */
  errorAt(x, y) {
    if (!this.reference) return null;
    return squareError(this.texels, this.reference.texels, 4 * (y * this.width + x));
  }

  /** A canvas of the picture made brighter by `stops` doublings; `table` is their `toneTable`. */
  tone(stops, table) {
    if (this.toned.stops === stops) return this.toned.canvas;
    this.paint((texels, out) => {
      for (let i = 0; i < texels.length; i += 4) {
        const exponent = texels[i + 3] << 8;
        out[i] = table[exponent | texels[i]];
        out[i + 1] = table[exponent | texels[i + 1]];
        out[i + 2] = table[exponent | texels[i + 2]];
      }
    }, this.toned.canvas);
    this.toned.stops = stops;
    return this.toned.canvas;
  }

  /** A canvas of the relative square error; null without a reference. */
  falseColour(colours) {
    if (!this.reference || this.errors) return this.errors;
    const [low, high] = ERROR_DECADES;
    this.errors = surface(this.width, this.height);
    this.paint((texels, out) => {
      for (let i = 0; i < texels.length; i += 4) {
        const error = squareError(texels, this.reference.texels, i);
        const place = 255 * (Math.log10(error) - low) / (high - low);
        const from = 4 * Math.round(Math.min(255, Math.max(0, place)));
        for (let c = 0; c < 3; c++) out[i + c] = colours[from + c];
      }
    }, this.errors);
    return this.errors;
  }

  paint(fill, canvas) {
    const context = canvas.getContext('2d');
    const pixels = context.createImageData(this.width, this.height);
    pixels.data.fill(255);
    fill(this.texels, pixels.data);
    context.putImageData(pixels, 0, 0);
  }

  /** Stops that bring the geometric mean of the luminances to 18 %, in quarters. */
  middleGrey() {
    let [sum, lit] = [0, 0];
    for (let i = 0; i < this.texels.length; i += 4) {
      const [r, g, b, e] = this.texels.subarray(i, i + 4);
      const light = luminance(r, g, b) * UNITS[e];
      if (light > 0) { sum += Math.log2(light); lit += 1; }
    }
    const stops = lit > 0 ? Math.log2(0.18) - sum / lit : 0;
    return Math.min(12, Math.max(-12, Math.round(4 * stops) / 4));
  }
}

/** The pictures of a scene under a budget, the reference first. */
async function loadPictures(scene, budget) {
  const images = results.images.filter(image => image.scene === scene);
  const first = images.find(image => image.method === 'reference');
  const reference = first ? new Picture(first, await unpacked(first), null) : null;
  const pictures = reference ? [reference] : [];
  for (const image of images) {
    if (image === first || image.budget !== budget) continue;
    pictures.push(new Picture(image, await unpacked(image), reference));
  }
  for (const picture of pictures) {
    const namesakes = pictures.filter(other => other.method === picture.method);
    if (namesakes.length > 1) picture.label = `${picture.method}, seed ${picture.seed}`;
  }
  return pictures;
}
