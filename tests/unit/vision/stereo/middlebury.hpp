// Middlebury pairs with their true disparities, and the share of wrong pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "fsw/vision/stereo/stereo_params.hpp"
#include "tests/support/read_image.hpp"

namespace ilp::test {

struct StereoPair {
  std::string name;
  Image left, right;
  std::vector<double> truth_px;         ///< 0 = unknown
  std::vector<std::uint8_t> evaluated;  ///< known and visible in the right image
};

/// Visible: inside the right image and not behind a nearer pixel of the same row (by more than 1 px of disparity).
inline void mark_visible(StereoPair& pair) {
  const auto width = static_cast<std::size_t>(pair.left.width);
  pair.evaluated.assign(pair.truth_px.size(), 0);
  for (std::size_t row = 0; row < pair.truth_px.size(); row += width) {
    std::vector<double> nearest(width, 0);
    for (std::size_t x = 0; x < width; ++x) {
      const double d = pair.truth_px[row + x];
      const auto target = static_cast<std::ptrdiff_t>(std::lround(static_cast<double>(x) - d));
      if (d > 0 && target >= 0)
        nearest[static_cast<std::size_t>(target)] = std::max(nearest[static_cast<std::size_t>(target)], d);
    }
    for (std::size_t x = 0; x < width; ++x) {
      const double d = pair.truth_px[row + x];
      const auto target = static_cast<std::ptrdiff_t>(std::lround(static_cast<double>(x) - d));
      if (d > 0 && target >= 0 && nearest[static_cast<std::size_t>(target)] <= d + 1) pair.evaluated[row + x] = 1;
    }
  }
}

/// Empty images when the data are absent.
inline StereoPair read_stereo_pair(const std::string& name) {
  const std::string folder = std::string(data_root) + "stereo_middlebury/" + name + "/";
  StereoPair pair{.name = name, .left = read_image(folder + "left.png"), .right = read_image(folder + "right.png")};
  const Image16 truth = read_image16(folder + "disp_left_x256.png");
  if (pair.left.empty() || pair.right.empty() || truth.empty()) return {};
  for (const std::uint16_t value : truth.pixels) pair.truth_px.push_back(value / 256.0);
  mark_visible(pair);
  const Image visible = read_image(folder + "nonocc_left.png");
  for (std::size_t i = 0; i < visible.pixels.size(); ++i) {
    if (visible.pixels[i] == 0) pair.evaluated[i] = 0;
  }
  return pair;
}

/// Still lifes: things in front of a far background break the order that terrain keeps, and walls without texture count
/// as wrong when they are left out.
inline StereoParams still_life_params() {
  StereoParams params;
  params.keep_order = false;
  params.min_texture_grey = 0;
  params.min_ncc = 0.001;
  params.uniqueness_permille = 0;
  params.min_large_step_penalty = 16;
  params.recovery_neighbours = 2;
  params.recovery_min_ncc = 0.05;
  params.recovery_step_px = 8;
  params.border_step_px = limits::max_disparities;
  return params;
}

struct DisparityScore {
  double bad = 0;        ///< off by more than 2 px or invalid, share of the evaluated pixels
  double wrong = 0;      ///< off by more than 2 px among the valid
  double invalid = 0;    ///< share of the evaluated pixels
  double median_px = 0;  ///< absolute error of the valid
};

inline DisparityScore score(const StereoPair& pair, const std::vector<float>& disparity_px,
                            const std::vector<float>& sigma_px) {
  DisparityScore s;
  std::size_t total = 0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < pair.truth_px.size(); ++i) {
    if (pair.evaluated[i] == 0) continue;
    ++total;
    if (sigma_px[i] > 0) errors.push_back(std::fabs(static_cast<double>(disparity_px[i]) - pair.truth_px[i]));
  }
  const auto wrong = static_cast<double>(std::count_if(errors.begin(), errors.end(), [](double e) { return e > 2; }));
  const auto valid = static_cast<double>(errors.size());
  const auto count = static_cast<double>(total);
  s.invalid = (count - valid) / count;
  s.bad = (count - valid + wrong) / count;
  s.wrong = wrong / valid;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  s.median_px = errors[errors.size() / 2];
  return s;
}

}  // namespace ilp::test
