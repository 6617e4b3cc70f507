// Plans a pass: which layers of which products are sent, and in which order (decisions.md, 11).
//
// A layer has utility only with all layers before it, so that this is a multiple-choice knapsack problem. Two plans are
// computed, and the better one is used. The greedy plan takes layers in the order of utility per byte and loses at most
// the utility of one step (linear relaxation, Sinha and Zoltners 1979). For few products dynamic programming over bytes
// also fills the end of a pass.
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
  std::uint8_t sent = 0;    ///< number of layers that were sent
  std::uint8_t layers = 0;  ///< number of layers of the product, above `sent`
  bool requested = false;   ///< the ground has requested it
  /// [k]: size of the file with layers sent + 1 to k + 1. Entries with k < sent are unused.
  std::array<std::uint32_t, limits::max_quality_layers> bytes{};
  /// [k]: utility of layers 1 to k + 1.
  std::array<double, limits::max_quality_layers> utility{};
};

/// Largest gain of utility per byte of the candidate's possible next files.
[[nodiscard]] double best_efficiency(const PlanCandidate& candidate);

/// Keeps the candidates with the largest best_efficiency() of all that are offered.
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
  double gain = 0;  ///< gain of utility
};

struct PassPlan {
  FixedVector<PlannedFile, limits::max_plan_candidates> files;  ///< in the order in which they are sent
  std::uint64_t bytes = 0;
  double gain = 0;
};

/// Scratch of plan_pass. It is too large for the stack.
struct PlanWorkspace {
  static constexpr std::size_t cells = limits::plan_cells;
  struct State {
    std::uint64_t bytes;
    double gain;  ///< negative: the cell is not reached
  };
  std::array<State, cells + 1> now, next;
  /// [i][cell]: how the cell was reached with candidate i: 16 times the cell before plus the number of its layers in
  /// the file.
  std::array<std::array<std::uint16_t, cells + 1>, limits::max_exact_candidates> came_from;
  std::array<std::uint8_t, limits::max_plan_candidates> greedy, exact;
};

/// Plans at most one file per candidate and at most `bytes` bytes in total. If everything fits, everything is planned.
/// The order is: requests of the ground, then products of which nothing was sent, then refinements; within each group
/// by utility per byte. The same input gives the same plan. It takes at most max_plan_candidates^2 *
/// max_quality_layers^2 + max_exact_candidates * plan_cells * max_quality_layers elementary steps.
void plan_pass(std::span<const PlanCandidate> candidates, std::uint64_t bytes, PlanWorkspace& workspace,
               PassPlan& plan);

/// What the utility of a product depends on, besides its layers.
struct ProductUtility {
  double richness = 0;          ///< ProductRecord::priority, which contains the richness
  double newly_seen_share = 0;  ///< newly seen share of the image
  double newly_seen_px = 0;     ///< newly seen pixels
  bool requested = false;       ///< the ground has requested it
};
/// The utility for the ground of the first `layers` layers of a product; 0 for no layers:
///   (newly seen share of the image + 0.02) * (0.2 + richness) * quality,  times 64 for a request of the ground.
/// The quality follows from that of the last of these layers (ProductRecord::layer_quality). For an image it is linear
/// in PSNR from 0 at 15 dB (nothing is visible) to 1 at 36 dB (coding errors are below the camera's noise), and grows
/// by a fifth of that slope above. For a depth map with a largest error of e px of disparity it is 1 / (1 + (e / 2)^2):
/// errors below those of the matcher matter little. If no quality is on record, it is b / (b + 0.3) for b bits per
/// newly seen pixel.
[[nodiscard]] double utility_of_layers(const ProductRecord& product, const ProductUtility& utility, int layers);

}  // namespace ilp
