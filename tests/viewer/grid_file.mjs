// The height grid that ilp-ground exports (height.pfm, placed by ortho.pgw), read independently of the page.

import { readFileSync } from 'node:fs';

export class Grid {
  constructor(folder) {
    const file = readFileSync(`${folder}/height.pfm`);
    const header = file.subarray(0, 64).toString('latin1').match(/^Pf\n(\d+) (\d+)\n(-[\d.]+)\n/);
    [this.width, this.heightCells] = [Number(header[1]), Number(header[2])];
    const data = file.subarray(header[0].length);
    this.values = new Float32Array(this.width * this.heightCells);
    // Rows go from the bottom to the top.
    for (let j = 0; j < this.heightCells; ++j) {
      for (let i = 0; i < this.width; ++i) {
        const v = data.readFloatLE(4 * ((this.heightCells - 1 - j) * this.width + i));
        this.values[j * this.width + i] = Number.isFinite(v) ? v : NaN;
      }
    }
    const world = readFileSync(`${folder}/ortho.pgw`, 'utf8').trim().split('\n').map(Number);
    [this.cell, this.x0, this.y0] = [world[0], world[4], world[5]];
  }

  at(i, j) {
    return i >= 0 && j >= 0 && i < this.width && j < this.heightCells ? this.values[j * this.width + i] : NaN;
  }

  // Bilinear; NaN where a corner is missing.
  corners(x, y) {
    const u = (x - this.x0) / this.cell;
    const v = (this.y0 - y) / this.cell;
    const [i, j] = [Math.floor(u), Math.floor(v)];
    return { s: u - i, t: v - j, z: [this.at(i, j), this.at(i + 1, j), this.at(i, j + 1), this.at(i + 1, j + 1)], nearest: this.at(Math.round(u), Math.round(v)) };
  }

  surrounded(x, y) {
    return this.corners(x, y).z.every((z) => !Number.isNaN(z));
  }

  height(x, y) {
    const { s, t, z, nearest } = this.corners(x, y);
    const value = (1 - t) * ((1 - s) * z[0] + s * z[1]) + t * ((1 - s) * z[2] + s * z[3]);
    return Number.isNaN(value) ? nearest : value;
  }

  covered(stride) {
    let count = 0;
    for (let j = 0; j < this.heightCells; j += stride) {
      for (let i = 0; i < this.width; i += stride) count += Number.isNaN(this.at(i, j)) ? 0 : 1;
    }
    return count;
  }

  // A place well inside what was seen, some share of the way through it.
  somePlace(share) {
    const seen = [];
    for (let j = 3; j < this.heightCells - 3; j += 3) {
      for (let i = 3; i < this.width - 3; i += 3) {
        if ([-3, 0, 3].every((d) => !Number.isNaN(this.at(i + d, j)) && !Number.isNaN(this.at(i, j + d)))) seen.push([i, j]);
      }
    }
    seen.sort((p, q) => p[0] - q[0] || p[1] - q[1]);
    const column = seen[Math.floor(share * seen.length)][0];
    const rows = seen.filter((c) => c[0] === column);
    const [i, j] = rows[rows.length >> 1];
    return [this.x0 + i * this.cell, this.y0 - j * this.cell];
  }
}
