// Values over mission time, one canvas each.

const margin = { left: 46, right: 8, top: 22, bottom: 34 };

// About `wanted` round steps from low to high.
function ticks(low, high, wanted) {
  const raw = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((m) => m * power >= raw) * power;
  const list = [];
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) list.push(value);
  return list;
}

function label(value) {
  const size = Math.abs(value);
  if (size >= 1e6) return `${(value / 1e6).toPrecision(3)}M`;
  if (size >= 1e4) return `${(value / 1e3).toPrecision(3)}k`;
  return String(Number(value.toPrecision(4)));
}

function range(values, zero) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (zero) low = Math.min(0, low);
  if (high === low) {
    high += 1;
    if (!zero) low -= 1;
  }
  return [low, high];
}

export class Plot {
  // unit: of the values; values: their range; zero: it begins there, else it is that of the values.
  constructor(parent, caption, { unit = '', zero = false, line = false, values = null } = {}) {
    const figure = document.createElement('figure');
    const text = document.createElement('figcaption');
    text.textContent = caption;
    this.canvas = document.createElement('canvas');
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', caption);
    figure.append(text, this.canvas);
    parent.append(figure);
    this.unit = unit;
    this.zero = zero;
    this.line = line;
    this.range = values;
    this.points = [];
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // [[time in s, value], ...] in order of time.
  show(points) {
    this.points = points.filter(([t, value]) => Number.isFinite(t) && Number.isFinite(value));
    this.draw();
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext('2d');
    context.scale(ratio, ratio);
    const colours = getComputedStyle(document.documentElement);
    const colour = (name) => colours.getPropertyValue(name);
    context.font = '12px system-ui, sans-serif';
    context.fillStyle = colour('--muted');
    if (this.points.length === 0) {
      context.fillText('nothing has come down yet', margin.left, height / 2);
      return;
    }
    const [t0, t1] = range(this.points.map((p) => p[0]), false);
    const [v0, v1] = this.range ?? range(this.points.map((p) => p[1]), this.zero);
    const x = (t) => margin.left + (t - t0) / (t1 - t0) * (width - margin.left - margin.right);
    const y = (v) => height - margin.bottom - (v - v0) / (v1 - v0) * (height - margin.top - margin.bottom);
    context.strokeStyle = colour('--line');
    for (const value of ticks(v0, v1, 4)) {
      context.textAlign = 'right';
      context.fillText(label(value), margin.left - 6, y(value) + 4);
      context.beginPath();
      context.moveTo(margin.left, y(value));
      context.lineTo(width - margin.right, y(value));
      context.stroke();
    }
    context.textAlign = 'center';
    for (const time of ticks(t0, t1, Math.max(2, width / 110))) {
      context.fillText(label(time), Math.min(x(time), width - 24), height - 19);
    }
    context.textAlign = 'left';
    context.fillText(this.unit, 4, 13);
    context.textAlign = 'right';
    context.fillText('mission time, s', width - margin.right, height - 5);
    context.strokeStyle = colour('--muted');
    context.strokeRect(margin.left, margin.top, width - margin.left - margin.right, height - margin.top - margin.bottom);
    this.drawPoints(context, x, y, colour('--s1'));
  }

  drawPoints(context, x, y, colour) {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 1.5;
    context.beginPath();
    for (const [t, value] of this.points) {
      if (this.line) context.lineTo(x(t), y(value));
      else context.rect(x(t) - 1.5, y(value) - 1.5, 3, 3);
    }
    this.line ? context.stroke() : context.fill();
  }
}
