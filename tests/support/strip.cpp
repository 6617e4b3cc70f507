#include "tests/support/strip.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "fsw/base/rng.hpp"

namespace ilp::test {

std::vector<StripImage> read_strip(const std::string& folder) {
  std::ifstream file(data_root + folder + "/cameras.txt");
  std::vector<StripImage> strip;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    StripImage image;
    in >> image.name >> image.camera.width >> image.camera.height >> image.camera.fx >> image.camera.fy >>
        image.camera.cx >> image.camera.cy;
    for (auto& row : image.rotation) {
      for (double& value : row) in >> value;
    }
    for (double& value : image.centre) in >> value;
    if (in) strip.push_back(image);
  }
  return strip;
}

Image read_strip_image(const std::string& folder, const std::string& name) {
  return read_image(data_root + folder + "/images/" + name);
}

namespace {

struct Vector {
  double v[3];
};

Vector ray_in_world(const StripImage& image, double x, double y) {
  const double r[3] = {(x - image.camera.cx) / image.camera.fx, (y - image.camera.cy) / image.camera.fy, 1.0};
  Vector w{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) w.v[i] += image.rotation[k][i] * r[k];
  }
  return w;
}

Vector cross(const Vector& a, const Vector& b) {
  return {{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2], a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

// The epipolar plane of a's ray cuts image b in a line: its normal, in b's camera, is that line with K removed.
double one_way(const StripImage& a, const StripImage& b, double xa, double ya, double xb, double yb) {
  const Vector baseline{{b.centre[0] - a.centre[0], b.centre[1] - a.centre[1], b.centre[2] - a.centre[2]}};
  const Vector normal = cross(baseline, ray_in_world(a, xa, ya));
  double n[3] = {};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) n[i] += b.rotation[i][k] * normal.v[k];
  }
  const double lx = n[0] / b.camera.fx, ly = n[1] / b.camera.fy;
  const double lc = n[2] - lx * b.camera.cx - ly * b.camera.cy;
  return std::fabs(lx * xb + ly * yb + lc) / std::hypot(lx, ly);
}

double lattice(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  const std::uint64_t h =
      mix64(seed ^ mix64(static_cast<std::uint64_t>(x) * 0x9E3779B9U + mix64(static_cast<std::uint64_t>(y))));
  return static_cast<double>(h >> 11U) * 0x1p-53 - 0.5;
}

// Quintic fade: continuous second derivatives, so that the texture has no lattice lines.
double value_noise(double x, double y, std::uint64_t seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const double tx = x - fx, ty = y - fy;
  const double u = tx * tx * tx * (tx * (tx * 6 - 15) + 10), v = ty * ty * ty * (ty * (ty * 6 - 15) + 10);
  const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
  const double top = lattice(ix, iy, seed) * (1 - u) + lattice(ix + 1, iy, seed) * u;
  const double bottom = lattice(ix, iy + 1, seed) * (1 - u) + lattice(ix + 1, iy + 1, seed) * u;
  return top * (1 - v) + bottom * v;
}

}  // namespace

double epipolar_distance(const StripImage& a, const StripImage& b, double xa, double ya, double xb, double yb) {
  return 0.5 * (one_way(a, b, xa, ya, xb, yb) + one_way(b, a, xb, yb, xa, ya));
}

double fractal_texture(double x, double y, double finest_px, std::uint64_t seed) {
  double value = 0, amplitude = 0.5;
  for (double wavelength = 160; wavelength >= finest_px; wavelength *= 0.5) {
    value += amplitude * value_noise(x / wavelength + 0.37 * wavelength, y / wavelength, seed);
    amplitude *= 0.87;
    seed = mix64(seed);
  }
  return 128 + 110 * value;
}

Image render_texture(std::int32_t width, std::int32_t height, const Similarity2& world_from_image, double gain,
                     double offset, double noise, std::uint64_t seed) {
  Image image(width, height);
  Rng rng(seed, 7);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      double wx = 0, wy = 0;
      apply(world_from_image, x, y, wx, wy);
      double gaussian = -6;
      for (int k = 0; k < 12 && noise > 0; ++k) gaussian += rng.uniform();
      const double value = gain * fractal_texture(wx, wy, 5, 1) + offset + (noise > 0 ? noise * gaussian : 0);
      image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
    }
  }
  return image;
}

void apply(const Similarity2& b_from_a, double xa, double ya, double& xb, double& yb) {
  const double c = b_from_a.scale * std::cos(b_from_a.rotation_rad),
               s = b_from_a.scale * std::sin(b_from_a.rotation_rad);
  xb = c * xa - s * ya + b_from_a.shift_x_px;
  yb = s * xa + c * ya + b_from_a.shift_y_px;
}

Similarity2 compose(const Similarity2& c_from_b, const Similarity2& b_from_a) {
  Similarity2 c{.scale = c_from_b.scale * b_from_a.scale,
                .rotation_rad = c_from_b.rotation_rad + b_from_a.rotation_rad};
  apply(c_from_b, b_from_a.shift_x_px, b_from_a.shift_y_px, c.shift_x_px, c.shift_y_px);
  return c;
}

Similarity2 inverse(const Similarity2& b_from_a) {
  Similarity2 a{1 / b_from_a.scale, -b_from_a.rotation_rad, 0, 0};
  double x = 0, y = 0;
  apply(a, b_from_a.shift_x_px, b_from_a.shift_y_px, x, y);
  a.shift_x_px = -x;
  a.shift_y_px = -y;
  return a;
}

}  // namespace ilp::test
