// Chooses what is sent in a pass: which layers of which products, in which order (decisions.md, 11).
//
// The layers of a product have value only with all layers before them, so this is a knapsack problem whose items come
// in steps. Two plans are computed and the better one is used: steps by value per byte, which loses at most one step's
// value (Sinha and Zoltners 1979, the multiple-choice knapsack's linear relaxation), and for few products a dynamic
// programme over bytes, which fills the end of a pass without gaps.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// A product that could be sent or refined.
struct PlanCandidate {
  std::int64_t id = 0;
  std::uint8_t sent = 0;    ///< layers that were sent
  std::uint8_t layers = 0;  ///< of the product; more than `sent`
  bool requested = false;   ///< the ground has requested it
  /// [k]: size of the file that brings layers sent + 1 to k + 1. Entries below `sent` are unused.
  std::array<std::uint32_t, limits::max_quality_layers> bytes{};
  /// [k]: worth of layers 1 to k + 1; below `sent` the worth of the layers already sent.
  std::array<double, limits::max_quality_layers> utility{};
};

/// Largest worth per byte of the candidate's possible next files.
[[nodiscard]] double best_efficiency(const PlanCandidate& candidate);

/// The most efficient of any number of offered candidates; the least efficient ones are left out.
class CandidateList {
 public:
  void clear() { list_.clear(); }
  void offer(const PlanCandidate& candidate);
  [[nodiscard]] std::span<const PlanCandidate> all() const { return {list_.data(), list_.size()}; }

 private:
  FixedVector<PlanCandidate, limits::max_plan_candidates> list_;
  std::array<double, limits::max_plan_candidates> efficiency_{};
};

struct PlannedFile {
  std::int64_t id = 0;
  std::uint8_t first_layer = 0, last_layer = 0;  ///< from 1
  std::uint32_t bytes = 0;
  double gain = 0;  ///< of worth
};

struct PassPlan {
  FixedVector<PlannedFile, limits::max_plan_candidates> files;  ///< in the order in which they go
  std::uint64_t bytes = 0;
  double gain = 0;
};

/// Scratch; a static object of its owner.
struct PlanWorkspace {
  static constexpr std::size_t cells = limits::plan_cells;
  struct State {
    std::uint64_t bytes;
    double gain;  ///< negative: nothing reaches this cell
  };
  std::array<State, cells + 1> now, next;
  /// For each state of a candidate its origin: 16 times the previous cell plus the layers after it.
  std::array<std::array<std::uint16_t, cells + 1>, limits::max_exact_candidates> came_from;
  std::array<std::uint8_t, limits::max_plan_candidates> greedy, exact;
};

/// Plans at most one file per candidate, all together at most `bytes`. If everything fits, everything is sent. The
/// order is: requests of the ground, then products of which nothing was sent, then refinements, each by worth per byte.
/// The same input gives the same plan. Bounded: max_plan_candidates^2 * max_quality_layers^2 + max_exact_candidates *
/// plan_cells * max_quality_layers elementary steps.
void plan_pass(std::span<const PlanCandidate> candidates, std::uint64_t bytes, PlanWorkspace& workspace,
               PassPlan& plan);

/// The worth to the ground of the first `layers` layers of a product, 0 for none:
///   (newly seen share of the image + 0.02) * (0.2 + richness) * quality,  times 64 for a request of the ground.
/// Quality is that of the last of these layers (ProductRecord::layer_quality). For an image it is linear in PSNR from
/// 15 dB (nothing is visible) to 36 dB (1: coding errors are below the camera's noise), and grows by a fifth of that
/// slope above. For a depth map with a largest error of e px of disparity it is 1 / (1 + (e / 2)^2), because errors
/// smaller than the matcher's own gain little. If no quality is on record, it is b / (b + 0.3) for b bits per newly
/// seen pixel.
struct ProductUtility {
  double richness = 0;
  double newly_seen_share = 0;
  double newly_seen_px = 0;
  bool requested = false;
};
[[nodiscard]] double utility_of_layers(const ProductRecord& product, const ProductUtility& utility, int layers);

}  // namespace ilp
