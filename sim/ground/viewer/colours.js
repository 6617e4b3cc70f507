// Colour maps that are perceptually even: viridis and magma (polynomials through matplotlib's tables), and distinct
// hues of one lightness for keyframes.

const polynomial = (c) => (t) => {
  const x = Math.min(1, Math.max(0, t));
  return [0, 1, 2].map((k) => {
    let sum = 0;
    for (let i = c.length - 1; i >= 0; --i) sum = sum * x + c[i][k];
    return Math.round(255 * Math.min(1, Math.max(0, sum)));
  });
};

export const viridis = polynomial([
  [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
  [0.1050930431085774, 1.404613529898575, 1.384590162594685],
  [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
  [-4.634230498983486, -5.799100973351585, -19.33244095627987],
  [6.228269936347081, 14.17993336680509, 56.69055260068105],
  [4.776384997670288, -13.74514537774601, -65.35303263337234],
  [-5.435455855934631, 4.645852612178535, 26.3124352495832],
]);

export const magma = polynomial([
  [-0.002136485053939582, -0.000749655052795221, -0.005386127855323933],
  [0.2516605407371642, 0.6775232436837668, 2.494026599312351],
  [8.353717279216625, -3.577719514958484, 0.3144679030132573],
  [-27.66873308576866, 14.26473078096533, -13.64921318813922],
  [52.17613981234068, -27.94360607168351, 12.94416944238394],
  [-50.76852536473588, 29.04658282127291, 4.23415299384598],
  [18.65570506591883, -11.48977351997711, -5.601961508734096],
]);

/// Neighbouring numbers get hues that are far apart (golden angle), all in OKLCH of the same lightness and chroma.
export function distinct(number) {
  const hue = (number * 2.399963) % (2 * Math.PI);
  const lightness = number % 2 ? 0.72 : 0.62;
  const a = 0.125 * Math.cos(hue);
  const b = 0.125 * Math.sin(hue);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const gamma = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((v) => Math.round(255 * gamma(Math.min(1, Math.max(0, v)))));
}

export const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;
export const gradient = (map) =>
  `linear-gradient(90deg,${Array.from({ length: 17 }, (_, i) => css(map(i / 16))).join(',')})`;
