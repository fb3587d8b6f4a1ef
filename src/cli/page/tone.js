'use strict';
// The view transform of the PNG, on linear light in half precision.
const TONES = /*TONES*/;

/** Single numbers by the 65,536 values of half precision. */
const HALF = Float32Array.from({ length: 65536 }, (_, bits) => {
  const exponent = bits >> 10 & 31, mantissa = bits & 1023;
  const size = exponent === 31 ? (mantissa ? NaN : Infinity)
    : exponent ? (1 + mantissa / 1024) * 2 ** (exponent - 15) : mantissa * 2 ** -24;
  return bits >> 15 ? -size : size;
});

const limit = (x, low, high) => x > low ? (x < high ? x : high) : low;
const encode = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
/** Stored bytes by light in [0, 1], in steps of which 20 are no more than one byte. */
const BYTES = Uint8Array.from({ length: 65537 }, (_, i) => Math.round(255 * encode(i / 65536)));
const byte = (x) => BYTES[Math.round(65536 * limit(x, 0, 1))];

/** Powers with the exponent of AgX, of numbers from 0 to 1.3. */
const POWERS = Float32Array.from({ length: 8194 }, (_, i) => (1.3 * i / 8192) ** TONES.agxGamma[0]);
function power(x) {
  const at = limit(x / 1.3, 0, 1) * 8192, i = Math.floor(at);
  return POWERS[i] + (at - i) * (POWERS[i + 1] - POWERS[i]);
}

/** A matrix by columns, times a vector; `put` takes what comes of it. */
const product = (m, r, g, b, put) => put(m[0] * r + m[3] * g + m[6] * b, m[1] * r + m[4] * g + m[7] * b,
  m[2] * r + m[5] * g + m[8] * b);

const [DARKEST, BRIGHTEST] = TONES.agxStops;
const contrast = (light) => {
  const x = limit((Math.log2(light) - DARKEST) / (BRIGHTEST - DARKEST), 0, 1);
  return TONES.agxContrast.reduce((sum, coefficient) => sum * x + coefficient, 0);
};
const [A, B, C, D, E] = TONES.acesCurve;
const aces = (x) => (x * (x + A) - B) / (x * (C * x + D) + E);

/** By name: each hands light as a screen shows it to `put`. */
const CURVES = {
  srgb: (r, g, b, put) => put(r, g, b),
  agx: (r, g, b, put) => product(TONES.agxIn, r, g, b, (r, g, b) =>
    product(TONES.agxOut, contrast(r), contrast(g), contrast(b), (r, g, b) =>
      product(TONES.agxScreen, power(r), power(g), power(b), put))),
  aces: (r, g, b, put) => product(TONES.acesIn, r, g, b, (r, g, b) =>
    product(TONES.acesOut, aces(r), aces(g), aces(b), put)),
};

/** Bytes of a picture, with full alpha, times 2 to the power `stops`. */
function develop(halves, stops, tone, to) {
  const gain = 2 ** stops, curve = CURVES[tone], light = (half) => limit(HALF[half] * gain, 0, 1e9);
  for (let from = 0, i = 0; from < halves.length; from += 3, i += 4) {
    curve(light(halves[from]), light(halves[from + 1]), light(halves[from + 2]), (r, g, b) => {
      to[i] = byte(r);
      to[i + 1] = byte(g);
      to[i + 2] = byte(b);
      to[i + 3] = 255;
    });
  }
}
