#include "sim/ground/map/blend.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ilp::map {
namespace {

/// Whether a cell of another piece lies within `reach` columns and rows; two passes of a running minimum and maximum.
host::Raster<std::uint8_t> near_borders(const host::Raster<std::uint16_t>& source, std::int32_t reach) {
  const std::int32_t width = source.width, height = source.height;
  host::Raster<std::uint16_t> low(width, height), high(width, height);
  constexpr std::uint16_t none = 0xFFFF;
  const auto lowest = [](std::uint16_t s) { return s == 0 ? none : s; };
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      std::uint16_t least = none, most = 0;
      for (std::int32_t u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
        least = std::min(least, lowest(source.at(u, y)));
        most = std::max(most, source.at(u, y));
      }
      low.at(x, y) = least;
      high.at(x, y) = most;
    }
  }
  host::Raster<std::uint8_t> near(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      std::uint16_t least = none, most = 0;
      for (std::int32_t v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v) {
        least = std::min(least, low.at(x, v));
        most = std::max(most, high.at(x, v));
      }
      near.at(x, y) = source.at(x, y) != 0 && least < most ? 1 : 0;
    }
  }
  return near;
}

/// weight * (coefficients . corrections - wanted)^2 over cells in a row or column.
struct Term {
  std::uint32_t first = 0, step = 0;
  bool bend = false;  ///< a second difference about the middle of three cells; else a difference of two
  double weight = 0, wanted = 0;
};

class Blend {
 public:
  Blend(const host::Raster<std::uint16_t>& source, const host::Raster<float>& sigma, float usual_sigma,
        const BlendParams& params, const host::Raster<float>& values)
      : source_(source), values_(values), params_(params) {
    active_ = near_borders(source, blend_reach_cells);
    band_ = near_borders(source, params.band_cells);
    const std::size_t cells = values.samples.size();
    variance_.resize(cells);
    for (std::size_t i = 0; i < cells; ++i) {
      const float s = sigma.empty() ? 0.0F : sigma.samples[i];
      // A quarter of the usual error bounds how stiff a cell can be, so that the system stays well conditioned.
      const double one = std::isfinite(s) && s > 0 ? std::max(s, usual_sigma / 4) : usual_sigma;
      variance_[i] = one * one;
      if (active_.samples[i] != 0) cells_.push_back(static_cast<std::uint32_t>(i));
    }
    if (cells_.empty()) return;
    set_up();
  }

  /// The corrections; empty without a border.
  std::vector<double> solve() {
    if (cells_.empty()) return {};
    // Conjugate gradients, preconditioned by the diagonal, in the order of the cells.
    constexpr int most_iterations = 150;
    constexpr double small_enough = 1e-8;
    std::vector<double> x(right_.size()), r = right_, p(right_.size()), q(right_.size());
    double rz = 0;
    for (const std::uint32_t i : cells_) {
      p[i] = r[i] / diagonal_[i];
      rz += r[i] * p[i];
    }
    const double enough = small_enough * rz;
    for (int k = 0; k < most_iterations && rz > enough; ++k) {
      apply(p, q);
      double pq = 0;
      for (const std::uint32_t i : cells_) pq += p[i] * q[i];
      const double step = rz / pq;
      double next = 0;
      for (const std::uint32_t i : cells_) {
        x[i] += step * p[i];
        r[i] -= step * q[i];
        next += r[i] * r[i] / diagonal_[i];
      }
      for (const std::uint32_t i : cells_) p[i] = r[i] / diagonal_[i] + next / rz * p[i];
      rz = next;
    }
    return x;
  }

 private:
  [[nodiscard]] bool same_patch(std::size_t a, std::size_t b) const {
    return source_.samples[a] != 0 && source_.samples[a] == source_.samples[b];
  }

  void set_up() {
    const std::size_t cells = values_.samples.size();
    screen_.resize(cells);
    right_.resize(cells);
    diagonal_.resize(cells, 1);
    for (const std::uint32_t i : cells_) {
      screen_[i] = 1 / (variance_[i] * params_.fade_cells * params_.fade_cells);
      diagonal_[i] = screen_[i];
    }
    const auto width = static_cast<std::uint32_t>(values_.width);
    for (const std::uint32_t i : cells_) {
      const auto x = static_cast<std::int32_t>(i % width), y = static_cast<std::int32_t>(i / width);
      add_terms(i, 1, x, values_.width);
      add_terms(i, width, y, values_.height);
    }
    for (const Term& term : terms_) {
      const auto [a, b, c] = cells_of(term);
      if (term.bend) {
        for (const auto& [at, share] : {std::pair{a, 1.0}, {b, -2.0}, {c, 1.0}}) {
          right_[at] += term.weight * share * term.wanted;
          diagonal_[at] += term.weight * share * share;
        }
      } else {
        right_[a] -= term.weight * term.wanted;
        right_[b] += term.weight * term.wanted;
        diagonal_[a] += term.weight;
        diagonal_[b] += term.weight;
      }
    }
  }

  static std::array<std::uint32_t, 3> cells_of(const Term& term) {
    return {term.first, term.first + term.step, term.first + 2 * term.step};
  }

  /// Terms between cell i and the next one, and about cell i; `at` is its place along the line.
  void add_terms(std::uint32_t i, std::uint32_t step, std::int32_t at, std::int32_t length) {
    const auto usable = [&](std::uint32_t k) { return active_.samples[k] != 0; };
    if (at + 1 < length && usable(i + step)) {
      const std::uint32_t j = i + step;
      double weight = 2 / (variance_[i] + variance_[j]);
      if (source_.samples[i] == source_.samples[j]) {
        if (band_.samples[i] != 0 && band_.samples[j] != 0 && params_.band_smoothness > 0) {
          weight *= params_.band_shape;
        }
        terms_.push_back({i, step, false, weight, 0});
      } else {
        double rise = 0;
        int sides = 0;
        if (at > 0 && same_patch(i - step, i)) {
          rise += value(i) - value(i - step);
          ++sides;
        }
        if (at + 2 < length && same_patch(j, j + step)) {
          rise += value(j + step) - value(j);
          ++sides;
        }
        terms_.push_back({i, step, false, weight, (sides > 0 ? rise / sides : 0) - (value(j) - value(i))});
      }
    }
    const bool bends = params_.band_smoothness > 0 && band_.samples[i] != 0 && at > 0 && at + 1 < length &&
                       usable(i - step) && usable(i + step);
    if (!bends) return;
    terms_.push_back({i - step, step, true, params_.band_smoothness / variance_[i],
                      -(value(i - step) - 2 * value(i) + value(i + step))});
  }

  [[nodiscard]] double value(std::size_t i) const { return values_.samples[i]; }

  void apply(const std::vector<double>& x, std::vector<double>& y) const {
    for (const std::uint32_t i : cells_) y[i] = screen_[i] * x[i];
    for (const Term& term : terms_) {
      const auto [a, b, c] = cells_of(term);
      if (term.bend) {
        const double pull = term.weight * (x[a] - 2 * x[b] + x[c]);
        y[a] += pull;
        y[b] -= 2 * pull;
        y[c] += pull;
      } else {
        const double pull = term.weight * (x[b] - x[a]);
        y[a] -= pull;
        y[b] += pull;
      }
    }
  }

  const host::Raster<std::uint16_t>& source_;
  const host::Raster<float>& values_;
  const BlendParams& params_;
  host::Raster<std::uint8_t> active_, band_;
  std::vector<std::uint32_t> cells_;  ///< those that may change
  std::vector<double> variance_, screen_, right_, diagonal_;
  std::vector<Term> terms_;
};

}  // namespace

void blend_patches(const host::Raster<std::uint16_t>& source, const host::Raster<float>& sigma, float usual_sigma,
                   const BlendParams& params, host::Raster<float>& values) {
  const std::vector<double> corrections = Blend(source, sigma, usual_sigma, params, values).solve();
  for (std::size_t i = 0; i < corrections.size(); ++i) values.samples[i] += static_cast<float>(corrections[i]);
}

}  // namespace ilp::map
