// The surface: one mesh, one draw call. Relief is exaggerated and shaded on the graphics processor; colours come from a
// texture with one texel per cell, or from the orthoimage.

import * as THREE from 'three';
import { reliefOf } from './layers.js';
import { centreOf, planeAt, rangeOf } from './grid.js';

// As the exported surface model: steeper than this is a wall that nobody measured.
const maxJump = 4;

const vertexShader = `
  attribute vec2 slope;
  attribute float laid;
  uniform float exaggeration;
  varying float vLaid;
  varying vec2 vUv;
  varying vec3 vNormal;
  void main() {
    vUv = uv;
    vLaid = laid;
    vNormal = normalize(vec3(-slope * exaggeration, 1.0));
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position.xy, position.z * exaggeration, 1.0);
  }`;
const fragmentShader = `
  uniform sampler2D picture;
  uniform vec2 stretch;
  uniform float isOrtho;
  varying float vLaid;
  varying vec2 vUv;
  varying vec3 vNormal;
  void main() {
    vec3 texel = texture2D(picture, vUv).rgb;
    vec3 n = normalize(vNormal);
    float sun = max(dot(n, normalize(vec3(-0.55, 0.55, 0.62))), 0.0);
    float sky = 0.5 + 0.5 * n.z;
    float light = 0.26 + 0.66 * sun + 0.20 * sky;
    vec3 grey = vec3(clamp((texel.r - stretch.x) / (stretch.y - stretch.x), 0.0, 1.0)) * vec3(1.0, 0.965, 0.92) * 0.9 + 0.06;
    vec3 colour = mix(texel * light, grey * mix(1.0, light, 0.35), isOrtho);
    if (vLaid > 0.5 && mod(gl_FragCoord.x + gl_FragCoord.y, 7.0) < 1.5) colour = vec3(0.84, 0.51, 0.27);
    gl_FragColor = vec4(colour, 1.0);
  }`;

// For the surface that is drawn only: places, profiles and colours know what was measured.
function reliefWithLaid(strip) {
  const { grid } = strip;
  const relief = reliefOf(strip).slice();
  for (let c = 0; c < relief.length; ++c) {
    if (Number.isNaN(grid.laid_of[c])) continue;
    const [x, y] = centreOf(grid, c);
    relief[c] = grid.laid_of[c] - planeAt(strip, x, y);
  }
  return relief;
}

function buildGeometry(strip, origin) {
  const { grid } = strip;
  const { width, height, cell } = grid;
  const relief = reliefWithLaid(strip);
  const vertices = grid.covered + grid.laid;
  const laid = new Float32Array(vertices);
  const vertexOf = new Int32Array(width * height).fill(-1);
  const position = new Float32Array(3 * vertices);
  const uv = new Float32Array(2 * vertices);
  const slope = new Float32Array(2 * vertices);
  const at = (i, j, other) => {
    if (i < 0 || j < 0 || i >= width || j >= height) return other;
    const z = relief[j * width + i];
    return Number.isNaN(z) ? other : z;
  };
  let vertex = 0;
  for (let j = 0, c = 0; j < height; ++j) {
    for (let i = 0; i < width; ++i, ++c) {
      const z = relief[c];
      if (Number.isNaN(z)) continue;
      vertexOf[c] = vertex;
      laid[vertex] = Number.isNaN(grid.height_of[c]) ? 1 : 0;
      position.set([grid.x0 + i * cell - origin[0], grid.y0 - j * cell - origin[1], z], 3 * vertex);
      uv.set([(i + 0.5) / width, 1 - (j + 0.5) / height], 2 * vertex);
      slope.set([(at(i + 1, j, z) - at(i - 1, j, z)) / (2 * cell), (at(i, j - 1, z) - at(i, j + 1, z)) / (2 * cell)], 2 * vertex);
      ++vertex;
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
  geometry.setAttribute('uv', new THREE.BufferAttribute(uv, 2));
  geometry.setAttribute('slope', new THREE.BufferAttribute(slope, 2));
  geometry.setAttribute('laid', new THREE.BufferAttribute(laid, 1));
  const fine = faces(grid, vertexOf, relief, 1);
  return { geometry, fine, coarse: coarser(grid, vertexOf, relief, fine) };
}

// A net over some of the same vertices keeps a slow machine moving.
const coarseTriangles = 20000;
function coarser(grid, vertexOf, relief, fine) {
  const step = Math.ceil(Math.sqrt(fine.length / 3 / coarseTriangles));
  return step > 1 ? faces(grid, vertexOf, relief, step) : fine;
}

// Between every step-th cell of every step-th row.
function faces(grid, vertexOf, relief, step) {
  const { width, height, cell } = grid;
  const index = [];
  const steepest = maxJump * cell * step;
  const add = (a, b, c) => {
    if (vertexOf[a] < 0 || vertexOf[b] < 0 || vertexOf[c] < 0) return;
    const [p, q, r] = [relief[a], relief[b], relief[c]];
    if (Math.max(p, q, r) - Math.min(p, q, r) <= steepest) index.push(vertexOf[a], vertexOf[b], vertexOf[c]);
  };
  for (let j = 0; j + step < height; j += step) {
    for (let i = 0; i + step < width; i += step) {
      const c = j * width + i;
      const below = c + step * width;
      add(c, below, c + step);
      add(c + step, below, below + step);
    }
  }
  return new Uint32Array(index);
}

// A hole's texel takes a neighbour's colour, so that edges do not fade into nothing.
function fillEdges(pixels, grid) {
  const { width, height, height_of: z } = grid;
  for (let c = 0; c < width * height; ++c) {
    if (!Number.isNaN(z[c]) || !Number.isNaN(grid.laid_of[c])) continue;
    const i = c % width;
    const near = [i > 0 ? c - 1 : -1, i + 1 < width ? c + 1 : -1, c - width, c + width].find((n) => n >= 0 && n < z.length && !Number.isNaN(z[n]));
    if (near !== undefined) pixels.copyWithin(4 * c, 4 * near, 4 * near + 4);
  }
}

const untold = [118, 122, 128];

export async function makeTerrain(strip, origin) {
  const { grid } = strip;
  const { geometry, fine, coarse } = buildGeometry(strip, origin);
  const indices = { fine: new THREE.BufferAttribute(fine, 1), coarse: new THREE.BufferAttribute(coarse, 1) };
  geometry.setIndex(indices.fine);
  const ortho = await new THREE.TextureLoader().loadAsync(grid.texture);
  ortho.anisotropy = 4;
  const pixels = new Uint8Array(4 * grid.width * grid.height);
  const coloured = new THREE.DataTexture(pixels, grid.width, grid.height);
  coloured.flipY = true;
  const uniforms = {
    exaggeration: { value: 1 },
    picture: { value: ortho },
    stretch: { value: new THREE.Vector2(...orthoStretch(ortho.image)) },
    isOrtho: { value: 1 },
  };
  const material = new THREE.ShaderMaterial({ uniforms, vertexShader, fragmentShader, side: THREE.DoubleSide });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;

  function paint(layer) {
    for (let c = 0; c < grid.height_of.length; ++c) {
      const laid = !Number.isNaN(grid.laid_of[c]);
      if (Number.isNaN(grid.height_of[c]) && !laid) continue;
      const [r, g, b] = (laid ? null : layer.colour(c)) ?? untold;
      pixels[4 * c] = r;
      pixels[4 * c + 1] = g;
      pixels[4 * c + 2] = b;
      pixels[4 * c + 3] = 255;
    }
    fillEdges(pixels, grid);
    const filter = layer.smooth ? THREE.LinearFilter : THREE.NearestFilter;
    coloured.minFilter = coloured.magFilter = filter;
    coloured.needsUpdate = true;
  }

  return {
    mesh,
    vertices: grid.covered,
    triangles: fine.length / 3,
    setLayer(id, layer) {
      uniforms.isOrtho.value = id === 'ortho' ? 1 : 0;
      uniforms.picture.value = id === 'ortho' ? ortho : coloured;
      if (id !== 'ortho') paint(layer);
    },
    setExaggeration: (factor) => { uniforms.exaggeration.value = factor; },
    setCoarse: (on) => geometry.setIndex(on ? indices.coarse : indices.fine),
    dispose() {
      geometry.dispose();
      material.dispose();
      ortho.dispose();
      coloured.dispose();
    },
  };
}

// The central 98 % of the grey values that were seen fill the scale (0 is where nothing was).
function orthoStretch(image) {
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [Math.min(256, image.width), Math.min(256, image.height)];
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.imageSmoothingEnabled = false;
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const grey = [];
  for (let i = 0; i < data.length; i += 4) if (data[i] > 0) grey.push(data[i] / 255);
  const [low, high] = rangeOf(grey, 0.01, 0.99);
  return [low, Math.max(high, low + 0.06)];
}
