#include "tests/unit/vision/overlap/mixed_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "fsw/base/math.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

constexpr std::int32_t width = 160, height = 120;

// Trains of waves that travel: both images show the same sea, and nothing in it has stayed.
Image sea(Rng& shape, double time, const Similarity2& sea_from_image, Rng& rng) {
  struct Wave {
    double x, y, phase;
  };
  std::array<Wave, 24> waves{};
  for (Wave& wave : waves) {
    const double length = between_ratio(shape, 6, 60), way = between(shape, -0.8, 0.8);
    const double k = 2 * pi / length;
    wave = {k * std::cos(way), k * std::sin(way), between(shape, 0, 2 * pi) + std::sqrt(9.8 * k) * time};
  }
  Image image(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      double sx = 0, sy = 0, value = 0;
      apply(sea_from_image, x, y, sx, sy);
      for (const Wave& wave : waves) value += std::sin(wave.x * sx + wave.y * sy + wave.phase);
      image.view().at(x, y) =
          static_cast<std::uint8_t>(std::clamp(110 + 9 * value + 2 * gaussian(rng) + 0.5, 0.0, 255.0));
    }
  }
  return image;
}

void mirror(Image& image) {
  for (std::int32_t y = 0; y < image.height; ++y) std::reverse(image.view().row(y), image.view().row(y) + image.width);
}

void turn_by_half(Image& image) {
  std::reverse(image.pixels.begin(), image.pixels.end());
}

}  // namespace

OverlapParams any_attitude() {
  OverlapParams params{.max_rotation_rad = pi, .max_scale = 1.4};
  return params;
}

const GroundTexture& texture(std::size_t k) {
  constexpr std::size_t kinds = static_cast<std::size_t>(Ground::count);
  static std::map<std::size_t, GroundTexture> made;
  const auto found = made.find(k);
  if (found != made.end()) return found->second;
  return made.emplace(k, GroundTexture(static_cast<Ground>(k % kinds), ILP_OVERLAP_TEXTURES + k)).first->second;
}
double between(Rng& rng, double low, double high) {
  return low + (high - low) * rng.uniform();
}
double between_ratio(Rng& rng, double low, double high) {
  return low * det_pow(high / low, rng.uniform());
}

Similarity2 somewhere(Rng& rng, double texels) {
  return {texels, between(rng, 0, 2 * pi), between(rng, 0, 1000), between(rng, 0, 1000)};
}

MixedPair mixed_pair(int number, bool full_turn) {
  Rng rng(static_cast<std::uint64_t>(number), ILP_OVERLAP_STREAM);
  const std::uint32_t on = rng.below(textures);
  // The same kind of ground at other times: k and k + 5.
  const std::uint32_t other = rng.below(2) == 0 ? (on + 5) % textures : (on + 1 + rng.below(textures - 1)) % textures;
  const double turn = full_turn ? pi : 0.33, ratio = full_turn ? 1.33 : 1.2;
  const double rotation = between(rng, -turn, turn), scale = between_ratio(rng, 1 / ratio, ratio);
  const double direction = between(rng, 0, 2 * pi);
  Exposure first;
  first.mean = 90;
  first.contrast = 5 + 30 * rng.uniform() * rng.uniform();
  first.noise = between(rng, 1, 6);
  first.vignette = rng.below(3) == 0 ? between(rng, 0, 0.6) : 0;
  Exposure second = first;
  second.gain = between_ratio(rng, 0.5, 2);
  second.smear_px = rng.below(8) == 0 ? between(rng, 0, 4) : 0;
  double texels = between_ratio(rng, 0.25, 2);
  const std::uint32_t kind = rng.below(20);
  const bool low = kind % 2 == 1;
  const Similarity2 b_from_a =
      with_overlap(low ? between(rng, 0, 0.55) : between(rng, 0.55, 0.97), scale, rotation, direction, width, height);
  const Similarity2 ground_from_a = somewhere(rng, texels);
  const Similarity2 ground_from_b = compose(ground_from_a, inverse(b_from_a));
  const auto look = [&](std::uint32_t ground, const Tiling& tiling, const Similarity2& from, const Exposure& exposure) {
    return look_at(texture(ground), tiling, from, width, height, exposure, rng);
  };

  MixedPair pair{.truth = counted_overlap(b_from_a, width, height)};
  if (kind < 6) {
    pair.kind = low ? "little overlap" : "related";
    pair.a = look(on, {}, ground_from_a, first);
    pair.b = look(on, {}, ground_from_b, second);
  } else if (kind < 12) {
    pair.kind = "unrelated";
    pair.truth = 0;
    pair.a = look(on, {}, ground_from_a, first);
    pair.b = look(other, {}, somewhere(rng, texels * scale), second);
  } else if (kind < 16) {
    // A period that the image shows at least one and a half times: a longer one looks like any ground.
    pair.kind = "repetitive";
    Tiling tiling{.period_x = texels * between_ratio(rng, 5, height / 1.6)};
    tiling.period_y = rng.below(2) == 0 ? tiling.period_x : texels * between_ratio(rng, 5, height / 1.6);
    pair.a = look(on, tiling, ground_from_a, first);
    pair.b = look(on, tiling, ground_from_b, second);
  } else if (kind == 16) {
    pair.kind = "blank or saturated";
    Exposure blown = second;
    blown.gain = between_ratio(rng, 0.02, 40);
    blown.contrast = rng.below(2) == 0 ? 0 : first.contrast;
    pair.a = look(on, {}, ground_from_a, rng.below(2) == 0 ? blown : first);
    pair.b = look(on, {}, ground_from_b, blown);
  } else if (kind == 17) {
    pair.kind = "sea";
    Rng shape(static_cast<std::uint64_t>(number), 10 * ILP_OVERLAP_STREAM + 4);
    Rng same = shape;
    pair.a = sea(shape, 0, ground_from_a, rng);
    pair.b = sea(same, between(rng, 2, 10), ground_from_b, rng);
  } else if (kind == 18) {
    pair.kind = "mirrored";
    pair.truth = 0;
    pair.a = look(on, {}, ground_from_a, first);
    pair.b = look(on, {}, ground_from_b, second);
    mirror(pair.b);
  } else {
    pair.kind = "half turn or identical";
    pair.truth = 1;
    pair.a = look(on, {}, ground_from_a, first);
    pair.b = pair.a;
    if (rng.below(2) == 0) turn_by_half(pair.b);
  }
  return pair;
}

}  // namespace ilp::test
