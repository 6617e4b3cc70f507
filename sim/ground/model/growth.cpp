#include "sim/ground/model/growth.hpp"

#include <algorithm>

namespace ilp::model {
namespace {

/// The model is adjusted when it has grown by this much since the last time.
constexpr double grown = 1.15;
/// Where no error is above this share of a bound, the bound has nothing to do.
constexpr double idle_share = 1.0 / 16;

}  // namespace

void adjust_in_steps(const Scene& scene, double max_px, Model& model, double tolerance) {
  triangulate(scene, max_px, model);
  adjust_model(scene, std::max(0.5, max_px / 4), model, tolerance);
  refuse_outliers(scene, max_px, model);
}

void close_loops(const Scene& scene, double drift_px, Model& model, double tolerance) {
  for (double bound = 2 * drift_px; bound > placing_px; bound /= 4) {
    const ModelExtent extent = extent_of(scene, model);
    if (extent.refused == 0 && extent.largest_error_px < idle_share * bound) continue;
    adjust_in_steps(scene, bound, model, tolerance);
  }
}

void place_all(const Scene& scene, const std::vector<Unit>& units, std::vector<std::uint8_t>& taken, Model& model) {
  std::size_t adjusted = model.size();
  std::vector<std::size_t> failed_at(units.size(), 0);
  const TracksByView seen_by = tracks_by_view(scene);
  std::vector<std::size_t> common = common_tracks(scene, model, units);
  while (true) {
    std::size_t best = units.size(), most = 0;
    for (std::size_t u = 0; u < units.size(); ++u) {
      if (taken[u] != 0 || failed_at[u] == model.size()) continue;
      if (common[u] <= most) continue;
      most = common[u];
      best = u;
    }
    if (best == units.size()) return;
    if (!place(scene, seen_by, units[best], model)) {
      failed_at[best] = model.size();
      continue;
    }
    taken[best] = 1;
    common = common_tracks(scene, model, units);
    triangulate(scene, placing_px, model);
    if (static_cast<double>(model.size()) < grown * static_cast<double>(adjusted)) continue;
    adjust_in_steps(scene, placing_px, model);
    adjusted = model.size();
  }
}

}  // namespace ilp::model
