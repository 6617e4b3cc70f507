// The 5/3 transform against the standard's formulas written out sample by sample, and the mask against its promise.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/codec/wavelet53.hpp"

namespace ilp {
namespace {

struct Plane {
  std::int32_t width, height, stride;
  std::vector<std::int32_t> data;
  Plane(std::int32_t w, std::int32_t h)
      : width(w), height(h), stride(w + 3), data(static_cast<std::size_t>((w + 3) * h), -7777) {}
  ImageView<std::int32_t> view() { return {data.data(), width, height, stride}; }
};

Plane random_plane(std::int32_t w, std::int32_t h, std::uint64_t seed) {
  Rng rng(seed);
  Plane plane(w, h);
  for (std::int32_t y = 0; y < h; ++y) {
    for (std::int32_t x = 0; x < w; ++x) plane.view().at(x, y) = static_cast<std::int32_t>(rng.below(8192)) - 4096;
  }
  return plane;
}

// T.800, F.4.8.2 with the periodic symmetric extension of F.4.7, one signal, interleaved.
std::vector<std::int32_t> standard_forward(const std::vector<std::int32_t>& x) {
  const int n = static_cast<int>(x.size());
  if (n == 1) return x;
  const auto reflect = [n](int i) {
    const int period = 2 * (n - 1);
    const int m = ((i % period) + period) % period;
    return static_cast<std::size_t>(m < period - m ? m : period - m);
  };
  const auto floor_div = [](std::int32_t a, std::int32_t b) { return (a - ((a % b) + b) % b) / b; };
  const auto high = [&](int odd) { return x[reflect(odd)] - floor_div(x[reflect(odd - 1)] + x[reflect(odd + 1)], 2); };
  std::vector<std::int32_t> out;
  for (int i = 0; i < n; i += 2) {
    out.push_back(x[static_cast<std::size_t>(i)] + floor_div(high(i - 1) + high(i + 1) + 2, 4));
  }
  for (int i = 1; i < n; i += 2) out.push_back(high(i));
  return out;
}

// F.3.8.2: even samples, then odd ones.
std::vector<std::int32_t> standard_inverse(const std::vector<std::int32_t>& bands) {
  const int n = static_cast<int>(bands.size()), lows = (n + 1) / 2, highs = n / 2;
  if (n == 1) return bands;
  const auto high = [&](int k) { return bands[static_cast<std::size_t>(lows + std::clamp(k, 0, highs - 1))]; };
  std::vector<std::int32_t> x(bands.size());
  for (int k = 0; k < lows; ++k) {
    x[static_cast<std::size_t>(2 * k)] = bands[static_cast<std::size_t>(k)] - ((high(k - 1) + high(k) + 2) >> 2);
  }
  for (int i = 1; i < n; i += 2) {
    const auto at = static_cast<std::size_t>(i);
    x[at] = high(i / 2) + ((x[at - 1] + x[i + 1 < n ? at + 1 : at - 1]) >> 1);
  }
  return x;
}

void invert(ImageView<std::int32_t> image, int levels) {
  for (int level = levels - 1; level >= 0; --level) {
    const std::int32_t width = low_band_side(image.width, level), height = low_band_side(image.height, level);
    for (std::int32_t y = 0; y < height; ++y) {
      const std::vector<std::int32_t> row = standard_inverse({image.row(y), image.row(y) + width});
      std::copy(row.begin(), row.end(), image.row(y));
    }
    for (std::int32_t x = 0; x < width; ++x) {
      std::vector<std::int32_t> column;
      for (std::int32_t y = 0; y < height; ++y) column.push_back(image.at(x, y));
      column = standard_inverse(column);
      for (std::int32_t y = 0; y < height; ++y) image.at(x, y) = column[static_cast<std::size_t>(y)];
    }
  }
}

TEST(Wavelet53, OneLevelIsTheStandards) {
  for (std::int32_t h = 1; h <= 9; ++h) {
    for (std::int32_t w = 1; w <= 9; ++w) {
      Plane plane = random_plane(w, h, static_cast<std::uint64_t>(w * 100 + h));
      std::vector<std::vector<std::int32_t>> truth;
      for (std::int32_t x = 0; x < w; ++x) {
        std::vector<std::int32_t> column;
        for (std::int32_t y = 0; y < h; ++y) column.push_back(plane.view().at(x, y));
        truth.push_back(standard_forward(column));
      }
      std::vector<std::int32_t> scratch(static_cast<std::size_t>(w * h));
      forward_wavelet53(plane.view(), 1, scratch.data());
      for (std::int32_t y = 0; y < h; ++y) {
        std::vector<std::int32_t> row;
        for (std::int32_t x = 0; x < w; ++x)
          row.push_back(truth[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)]);
        row = standard_forward(row);
        for (std::int32_t x = 0; x < w; ++x) {
          ASSERT_EQ(plane.view().at(x, y), row[static_cast<std::size_t>(x)])
              << w << "x" << h << " at " << x << "," << y;
        }
      }
    }
  }
}

TEST(Wavelet53, TheStandardsInverseGivesEverySizeBackExactly) {
  for (std::int32_t h = 1; h <= 20; ++h) {
    for (std::int32_t w = 1; w <= 20; ++w) {
      for (const int levels : {0, 1, 2, 5}) {
        const Plane original = random_plane(w, h, static_cast<std::uint64_t>(w * 31 + h));
        Plane plane = original;
        std::vector<std::int32_t> scratch(static_cast<std::size_t>(w * h));
        forward_wavelet53(plane.view(), levels, scratch.data());
        invert(plane.view(), levels);
        ASSERT_EQ(plane.data, original.data) << w << "x" << h << ", " << levels << " levels";
      }
    }
  }
}

TEST(Wavelet53, TheInverseIsTheStandards) {
  for (std::int32_t h = 1; h <= 20; ++h) {
    for (std::int32_t w = 1; w <= 20; ++w) {
      for (const int levels : {0, 1, 2, 5}) {
        Plane plane = random_plane(w, h, static_cast<std::uint64_t>(w * 37 + h)), truth = plane;
        std::vector<std::int32_t> scratch(static_cast<std::size_t>(w * h));
        invert(truth.view(), levels);
        inverse_wavelet53(plane.view(), levels, scratch.data());
        ASSERT_EQ(plane.data, truth.data) << w << "x" << h << ", " << levels << " levels";
      }
    }
  }
}

TEST(Wavelet53, BandsStandWhereTheyShould) {
  // A constant image has nothing but a low band; a step between columns only horizontal detail.
  Plane plane(13, 10);
  for (std::int32_t y = 0; y < 10; ++y) {
    for (std::int32_t x = 0; x < 13; ++x) plane.view().at(x, y) = x % 2 == 0 ? 100 : 20;
  }
  std::vector<std::int32_t> scratch(130);
  forward_wavelet53(plane.view(), 1, scratch.data());
  EXPECT_EQ(plane.view().at(9, 2), -80) << "high band of the rows, right of ceil(13/2)";
  for (std::int32_t x = 0; x < 13; ++x) EXPECT_EQ(plane.view().at(x, 7), 0) << "no vertical detail";
}

// What lies outside the mask of coefficients may be anything: the pixels inside must not notice.
TEST(Wavelet53, MaskedPixelsNeedOnlyMaskedCoefficients) {
  Rng rng(5);
  for (int trial = 0; trial < 400; ++trial) {
    const auto w = static_cast<std::int32_t>(1 + rng.below(40));
    const auto h = static_cast<std::int32_t>(1 + rng.below(40));
    const int levels = static_cast<int>(rng.below(6));
    const auto size = static_cast<std::size_t>(w * h);
    Plane original = random_plane(w, h, rng.next());
    std::vector<std::uint8_t> pixels(size);
    const std::uint32_t rarity = 1 + rng.below(static_cast<std::uint32_t>(2 * size));
    for (auto& m : pixels) m = rng.below(rarity) == 0 ? 255 : 0;
    std::vector<std::uint8_t> mask = pixels;
    std::vector<std::uint8_t> mask_scratch(size);
    std::vector<std::int32_t> scratch(size);
    propagate_mask53({mask.data(), w, h}, levels, mask_scratch.data());
    Plane plane = original;
    forward_wavelet53(plane.view(), levels, scratch.data());
    for (std::int32_t y = 0; y < h; ++y) {
      for (std::int32_t x = 0; x < w; ++x) {
        const std::uint8_t m = mask[static_cast<std::size_t>(y * w + x)];
        ASSERT_LE(m, 1);
        if (m == 0) plane.view().at(x, y) = static_cast<std::int32_t>(rng.below(20000)) - 10000;
      }
    }
    invert(plane.view(), levels);
    for (std::int32_t y = 0; y < h; ++y) {
      for (std::int32_t x = 0; x < w; ++x) {
        if (pixels[static_cast<std::size_t>(y * w + x)] == 0) continue;
        ASSERT_EQ(plane.view().at(x, y), original.view().at(x, y)) << w << "x" << h << ", " << levels << " levels";
      }
    }
  }
}

// And the mask is not larger than needed: each coefficient that one pixel marks does move that pixel.
TEST(Wavelet53, MaskOfAPixelIsTight) {
  constexpr std::int32_t side = 15;
  for (std::int32_t py = 0; py < side; ++py) {
    for (std::int32_t px = 0; px < side; ++px) {
      std::vector<std::uint8_t> mask(side * side);
      std::vector<std::uint8_t> mask_scratch(side * side);
      mask[static_cast<std::size_t>(py * side + px)] = 1;
      propagate_mask53({mask.data(), side, side}, 1, mask_scratch.data());
      for (std::int32_t i = 0; i < side * side; ++i) {
        if (mask[static_cast<std::size_t>(i)] == 0) continue;
        Plane plane(side, side);
        for (std::int32_t y = 0; y < side; ++y) {
          for (std::int32_t x = 0; x < side; ++x) plane.view().at(x, y) = 0;
        }
        plane.view().at(i % side, i / side) = 1 << 16;
        invert(plane.view(), 1);
        ASSERT_NE(plane.view().at(px, py), 0) << "pixel " << px << "," << py << " coefficient " << i;
      }
    }
  }
}

}  // namespace
}  // namespace ilp
