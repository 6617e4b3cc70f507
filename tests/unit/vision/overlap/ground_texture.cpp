#include "tests/unit/vision/overlap/ground_texture.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr int side = GroundTexture::side;
using Raster = std::vector<float>;

std::size_t texel(int x, int y) {
  return static_cast<std::size_t>(y & (side - 1)) * side + static_cast<std::size_t>(x & (side - 1));
}

// One octave of smooth noise with `cells` lattice cells along each side.
void add_octave(int cells, double amplitude, Rng& rng, Raster& out) {
  std::vector<float> lattice(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells));
  for (float& v : lattice) v = static_cast<float>(amplitude * (2 * rng.uniform() - 1));
  const auto node = [&](int x, int y) { return lattice[static_cast<std::size_t>((y % cells) * cells + x % cells)]; };
  const double size = static_cast<double>(side) / cells;
  for (int y = 0; y < side; ++y) {
    const double v = y / size, fv = v - std::floor(v), sv = fv * fv * (3 - 2 * fv);
    const int iv = static_cast<int>(v);
    for (int x = 0; x < side; ++x) {
      const double u = x / size, fu = u - std::floor(u), su = fu * fu * (3 - 2 * fu);
      const int iu = static_cast<int>(u);
      const double top = node(iu, iv) * (1 - su) + node(iu + 1, iv) * su;
      const double bottom = node(iu, iv + 1) * (1 - su) + node(iu + 1, iv + 1) * su;
      out[texel(x, y)] += static_cast<float>(top * (1 - sv) + bottom * sv);
    }
  }
}

// `fall` is the ratio of the amplitudes of neighbouring octaves, coarse to fine.
void add_fractal(int coarsest, int finest, double amplitude, double fall, Rng& rng, Raster& out) {
  for (int cells = coarsest; cells <= finest; cells *= 2, amplitude *= fall) add_octave(cells, amplitude, rng, out);
}

void dunes(Rng& rng, Raster& out) {
  Raster warp(out.size());
  add_fractal(4, 64, 1, 0.6, rng, warp);
  // Whole waves across the raster, so that it stays toroidal.
  const double along_x = 10 + rng.below(14), along_y = rng.below(10);
  const double bend = 5 + 8 * rng.uniform();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const double phase = 2 * pi * (along_x * x + along_y * y) / side + bend * warp[texel(x, y)];
      const double wave = 0.5 * (phase / pi - std::floor(phase / pi));  // gentle windward side, steep lee
      out[texel(x, y)] = static_cast<float>(wave < 0.4 ? wave : 0.8 - wave * 1.2);
    }
  }
  add_fractal(32, 512, 0.08, 0.9, rng, out);
}

void craters(Rng& rng, Raster& out) {
  Raster height(out.size());
  add_fractal(8, 256, 4, 0.5, rng, height);
  for (int k = 0; k < 900; ++k) {
    const double radius = std::min(3.5 / std::sqrt(rng.uniform() + 1e-4), 90.0);
    const int cx = static_cast<int>(rng.below(side)), cy = static_cast<int>(rng.below(side));
    const int reach = static_cast<int>(1.6 * radius) + 1;
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const double r = std::hypot(x, y) / radius;
        const double bowl = r < 1 ? r * r - 0.8 : 0.2 * std::exp(-6 * (r - 1));
        if (r < 1.6) height[texel(cx + x, cy + y)] += static_cast<float>(0.35 * radius * bowl);
      }
    }
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      out[texel(x, y)] = 0.8F * (height[texel(x + 1, y)] - height[texel(x - 1, y)]) +
                         0.6F * (height[texel(x, y + 1)] - height[texel(x, y - 1)]);
    }
  }
}

void boulders(Rng& rng, Raster& out) {
  add_fractal(8, 512, 0.35, 0.75, rng, out);
  for (int k = 0; k < 2200; ++k) {
    const double radius = std::min(1.5 / std::sqrt(rng.uniform() + 1e-3), 22.0);
    const int cx = static_cast<int>(rng.below(side)), cy = static_cast<int>(rng.below(side));
    const int reach = static_cast<int>(2 * radius) + 1;
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        float& p = out[texel(cx + x, cy + y)];
        if (std::hypot(x, y) < radius) {
          p = 1.2F;
        } else if (std::hypot(x - 0.8 * radius, y - 0.4 * radius) < radius) {
          p = -1.2F;
        }
      }
    }
  }
}

// Cracked ground: each cell has its own albedo, the borders are dark.
void cells(Rng& rng, Raster& out) {
  constexpr int grid = 40;
  constexpr double size = static_cast<double>(side) / grid;
  struct Seed {
    double x, y;
    float albedo;
  };
  std::vector<Seed> seeds;
  for (int k = 0; k < grid * grid; ++k) {
    seeds.push_back({rng.uniform(), rng.uniform(), static_cast<float>(0.8 * (2 * rng.uniform() - 1))});
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int gx = static_cast<int>(x / size), gy = static_cast<int>(y / size);
      double first = 1e9, second = 1e9;
      float albedo = 0;
      for (int j = gy - 1; j <= gy + 1; ++j) {
        for (int i = gx - 1; i <= gx + 1; ++i) {
          const Seed& s = seeds[static_cast<std::size_t>((j + grid) % grid * grid + (i + grid) % grid)];
          const double d = std::hypot((i + s.x) * size - x, (j + s.y) * size - y);
          if (d < first) {
            second = first;
            first = d;
            albedo = s.albedo;
          } else {
            second = std::min(second, d);
          }
        }
      }
      out[texel(x, y)] = second - first < 3 ? -1.5F : albedo;
    }
  }
  add_fractal(64, 512, 0.3, 0.8, rng, out);
}

void normalise(Raster& out) {
  double sum = 0, squares = 0;
  for (const float v : out) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double n = static_cast<double>(out.size());
  const double mean = sum / n, inverse = 1 / std::sqrt(squares / n - mean * mean);
  for (float& v : out) v = static_cast<float>((v - mean) * inverse);
}

double wrapped(double x, double period) {
  return period > 0 ? x - period * std::floor(x / period) : x;
}

}  // namespace

GroundTexture::GroundTexture(Ground kind, std::uint64_t seed) : texels_(static_cast<std::size_t>(side) * side) {
  Rng rng(seed, static_cast<std::uint64_t>(kind));
  switch (kind) {
    case Ground::fractal:
      add_fractal(8, 512, 1, 0.55 + 0.35 * rng.uniform(), rng, texels_);
      break;
    case Ground::dunes:
      dunes(rng, texels_);
      break;
    case Ground::craters:
      craters(rng, texels_);
      break;
    case Ground::boulders:
      boulders(rng, texels_);
      break;
    case Ground::cells:
    case Ground::count:
      cells(rng, texels_);
      break;
  }
  normalise(texels_);
}

double GroundTexture::at(double x, double y) const {
  const double fx = std::floor(x), fy = std::floor(y);
  const double u = x - fx, v = y - fy;
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const double top = texels_[texel(ix, iy)] * (1 - u) + texels_[texel(ix + 1, iy)] * u;
  const double bottom = texels_[texel(ix, iy + 1)] * (1 - u) + texels_[texel(ix + 1, iy + 1)] * u;
  return top * (1 - v) + bottom * v;
}

double gaussian(Rng& rng) {
  double sum = -6;
  for (int k = 0; k < 12; ++k) sum += rng.uniform();
  return sum;
}

Image look_at(const GroundTexture& ground, const Tiling& tiling, const Similarity2& ground_from_image,
              std::int32_t width, std::int32_t height, const Exposure& exposure, Rng& rng) {
  Image image(width, height);
  const double c = ground_from_image.scale * std::cos(ground_from_image.rotation_rad);
  const double s = ground_from_image.scale * std::sin(ground_from_image.rotation_rad);
  const int smear = exposure.smear_px > 0 ? 1 + static_cast<int>(2 * exposure.smear_px) : 1;
  const double corner = 0.25 * (width * width + height * height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      double value = 0;
      for (int k = 0; k < 4 * smear; ++k) {
        const double moved = smear > 1 ? exposure.smear_px * (k / 4 / (smear - 1.0) - 0.5) : 0;
        const double px = x + (k % 2 == 0 ? -0.25 : 0.25) + moved, py = y + (k / 2 % 2 == 0 ? -0.25 : 0.25);
        const double gx = c * px - s * py + ground_from_image.shift_x_px;
        const double gy = s * px + c * py + ground_from_image.shift_y_px;
        value += ground.at(wrapped(gx, tiling.period_x), wrapped(gy, tiling.period_y));
      }
      value = exposure.mean + exposure.contrast * value / (4 * smear);
      const double dx = x - 0.5 * width, dy = y - 0.5 * height;
      value *= exposure.gain * (1 - exposure.vignette * (dx * dx + dy * dy) / corner);
      value += exposure.offset + (exposure.noise > 0 ? exposure.noise * gaussian(rng) : 0.0);
      image.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
    }
  }
  return image;
}

double counted_overlap(const Similarity2& b_from_a, std::int32_t width, std::int32_t height) {
  // Additive recurrence of the plastic number (M. Roberts): no direction in which the points line up.
  constexpr int points = 20000;
  const double c = b_from_a.scale * std::cos(b_from_a.rotation_rad);
  const double s = b_from_a.scale * std::sin(b_from_a.rotation_rad);
  int inside = 0;
  for (int k = 0; k < points; ++k) {
    const double u = 0.5 + 0.7548776662466927 * k, v = 0.5 + 0.5698402909980532 * k;
    const double x = (u - std::floor(u)) * width - 0.5, y = (v - std::floor(v)) * height - 0.5;
    const double bx = c * x - s * y + b_from_a.shift_x_px, by = s * x + c * y + b_from_a.shift_y_px;
    inside += bx >= -0.5 && by >= -0.5 && bx < width - 0.5 && by < height - 0.5 ? 1 : 0;
  }
  return inside / static_cast<double>(points);
}

Similarity2 about_centre(double scale, double rotation_rad, double shift_x_px, double shift_y_px, std::int32_t width,
                         std::int32_t height) {
  const double cx = 0.5 * (width - 1), cy = 0.5 * (height - 1);
  Similarity2 turned{scale, rotation_rad, 0, 0};
  double x = 0, y = 0;
  apply(turned, cx, cy, x, y);
  turned.shift_x_px = cx - x + shift_x_px;
  turned.shift_y_px = cy - y + shift_y_px;
  return turned;
}

Similarity2 with_overlap(double overlap, double scale, double rotation_rad, double direction_rad, std::int32_t width,
                         std::int32_t height) {
  // Bisection; the overlap falls with the distance.
  double near = 0, far = scale * std::hypot(width, height) + std::hypot(width, height);
  for (int k = 0; k < 14; ++k) {
    const double shift = 0.5 * (near + far);
    const Similarity2 b_from_a = about_centre(scale, rotation_rad, shift * std::cos(direction_rad),
                                              shift * std::sin(direction_rad), width, height);
    (counted_overlap(b_from_a, width, height) > overlap ? near : far) = shift;
  }
  return about_centre(scale, rotation_rad, near * std::cos(direction_rad), near * std::sin(direction_rad), width,
                      height);
}

}  // namespace ilp::test
