// The map of a strip with the track: drag or arrow keys move it, wheel or + and - bring it closer.

const dot_px = 3;

function roundLength(wanted) {
  const decade = 10 ** Math.floor(Math.log10(wanted));
  return decade * (wanted >= 5 * decade ? 5 : wanted >= 2 * decade ? 2 : 1);
}

// White on a dark casing is seen over any ground.
function cased(context, path) {
  context.strokeStyle = '#10141a';
  context.lineWidth = 5;
  context.stroke(path);
  context.strokeStyle = '#fff';
  context.lineWidth = 2;
  context.stroke(path);
}

function casedText(context, text, x, y) {
  context.font = '600 13px system-ui, sans-serif';
  context.textAlign = 'center';
  context.strokeStyle = '#10141a';
  context.lineWidth = 3;
  context.strokeText(text, x, y);
  context.fillStyle = '#fff';
  context.fillText(text, x, y);
}

export class StripMap {
  constructor(canvas, note, legend) {
    this.canvas = canvas;
    this.note = note;
    this.legend = legend;
    this.pictures = new Map();
    this.zoom = 1;
    this.shift = [0, 0];  // of the middle, strip units
    this.kind = 'image';
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  listen() {
    const canvas = this.canvas;
    let last = null;
    canvas.addEventListener('pointerdown', (e) => {
      last = [e.clientX, e.clientY];
      canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener('pointerup', () => { last = null; });
    canvas.addEventListener('pointermove', (e) => {
      if (!last) return;
      this.move(e.clientX - last[0], e.clientY - last[1]);
      last = [e.clientX, e.clientY];
    });
    canvas.addEventListener('wheel', (e) => {
      e.preventDefault();
      this.closer(Math.exp(-e.deltaY / 400));
    }, { passive: false });
    canvas.addEventListener('keydown', (e) => {
      const by = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[e.key];
      if (by) { e.preventDefault(); this.move(...by); }
      if (e.key === '+') this.closer(1.5);
      if (e.key === '-') this.closer(1 / 1.5);
    });
  }

  show(strip, place, keyframes, kind) {
    this.strip = { unit: strip?.unit, north: place?.north, map: place?.image && place };
    this.track = keyframes.filter((k) => k.pose?.state === 'final').map((k) => k.pose.centre);
    this.kind = kind;
    this.draw();
  }

  whole() { this.zoom = 1; this.shift = [0, 0]; this.draw(); }
  closer(factor) { this.zoom = Math.min(400, Math.max(0.5, this.zoom * factor)); this.draw(); }
  move(dx, dy) { this.shift[0] -= dx / this.scale; this.shift[1] += dy / this.scale; this.draw(); }

  // Low and high x and y of map and track.
  bounds() {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    const include = (x, y) => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.max(box[1], x);
      box[2] = Math.min(box[2], y);
      box[3] = Math.max(box[3], y);
    };
    for (const [x, y] of this.track) include(x, y);
    const map = this.strip?.map;
    if (map) {
      include(map.x, map.y);
      include(map.x + map.size[0] * map.unit_per_px, map.y - map.size[1] * map.unit_per_px);
    }
    return box;
  }

  picture(path) {
    let image = this.pictures.get(path);
    if (!image) {
      // What is shown stays until the next picture is there.
      image = new Image();
      image.onload = () => { this.pictures = new Map([[path, image]]); this.draw(); };
      image.src = path;
      this.pictures.set(path, image);
    }
    return image;
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (this.canvas.width !== Math.round(width * ratio)) this.canvas.width = Math.round(width * ratio);
    if (this.canvas.height !== Math.round(height * ratio)) this.canvas.height = Math.round(height * ratio);
    const context = this.canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    if (!this.track) return;
    const box = this.bounds();
    if (!(box[1] >= box[0])) {
      this.note.textContent = 'No pose has come down yet.';
      return;
    }
    const spans = [Math.max(box[1] - box[0], 1e-9), Math.max(box[3] - box[2], 1e-9)];
    this.scale = this.zoom * Math.min((width - 24) / spans[0], (height - 24) / spans[1]);
    const middle = [(box[0] + box[1]) / 2 + this.shift[0], (box[2] + box[3]) / 2 + this.shift[1]];
    const at = (x, y) => [width / 2 + (x - middle[0]) * this.scale, height / 2 - (y - middle[1]) * this.scale];
    this.drawPicture(context, at);
    this.drawTrack(context, at);
    this.drawScale(context, height);
    this.drawDirection(context, width, height);
    this.showLegend();
    const hatched = this.kind === 'image' && this.strip?.map?.laid ? '; hatched: no height, the image is laid on interpolated ground' : '';
    this.note.textContent = `${this.track.length} posed keyframes; the line is the track of the camera${hatched}`;
  }

  drawScale(context, height) {
    const length = roundLength(140 / this.scale);
    const [left, right, y] = [16, 16 + length * this.scale, height - 16];
    const bar = new Path2D(`M${left} ${y - 5}V${y}H${right}V${y - 5}`);
    cased(context, bar);
    casedText(context, `${Number(length.toPrecision(3))} ${this.strip?.unit ?? 'units'}`, (left + right) / 2, y - 9);
  }

  // North where the place of the strip is known, else the world's y axis.
  drawDirection(context, width, height) {
    const [x, y] = this.strip?.north ?? [0, 1];
    const at = (ahead, aside) => [width - 40 + ahead * x - aside * y, height - 36 - ahead * y - aside * x];
    const path = new Path2D();
    path.moveTo(...at(-14, 0));
    path.lineTo(...at(14, 0));
    path.moveTo(...at(6, 5));
    path.lineTo(...at(14, 0));
    path.lineTo(...at(6, -5));
    cased(context, path);
    const [u, v] = at(24, 0);
    casedText(context, this.strip?.north ? 'N' : 'y', u, v + 5);
  }

  showLegend() {
    const range = this.kind === 'relief' && this.strip?.map?.range;
    this.legend.hidden = !range;
    if (!range) return;
    const [title, , low, high] = this.legend.children;
    title.textContent = `Height above the mean plane, ${this.strip.unit}`;
    low.textContent = Number(range[0].toPrecision(3));
    high.textContent = Number(range[1].toPrecision(3));
  }

  drawPicture(context, at) {
    const map = this.strip?.map;
    if (!map || this.kind === 'none') return;
    const image = this.picture(map[this.kind]);
    if (!image.complete || !image.naturalWidth) return;
    const [x, y] = at(map.x, map.y);
    context.imageSmoothingEnabled = this.scale * map.unit_per_px < 4;
    const px = map.unit_per_px * this.scale;
    context.drawImage(image, x, y, map.size[0] * px, map.size[1] * px);
  }

  drawTrack(context, at) {
    const line = new Path2D();
    const dots = new Path2D();
    this.track.forEach((centre, i) => {
      const [x, y] = at(centre[0], centre[1]);
      i === 0 ? line.moveTo(x, y) : line.lineTo(x, y);
      dots.rect(x - dot_px / 2, y - dot_px / 2, dot_px, dot_px);
    });
    context.lineWidth = 4;
    context.strokeStyle = '#fff';
    context.stroke(line);
    context.lineWidth = 2;
    context.strokeStyle = '#b8430f';
    context.stroke(line);
    context.fillStyle = '#1d232b';
    context.fill(dots);
    const last = this.track.at(-1);
    if (!last) return;
    const [x, y] = at(last[0], last[1]);
    context.beginPath();
    context.arc(x, y, 7, 0, 2 * Math.PI);
    context.fillStyle = '#b8430f';
    context.fill();
    context.strokeStyle = '#fff';
    context.stroke();
  }
}
