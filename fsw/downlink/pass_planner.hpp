// What goes down in a pass: which layers of which products, in which order (decisions.md, 11).
//
// The layers of a product are worth something only with all layers before them, so this is a knapsack problem whose
// items come in steps. Two answers are made and the better one taken: steps by value per byte, which loses at most one
// step's value (Sinha and Zoltners 1979, the multiple-choice knapsack's linear relaxation), and where products are few
// a dynamic programme over bytes, which fills the end of a pass without gaps.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

/// A product that could go, or go on.
struct PlanCandidate {
  std::int64_t id = 0;
  std::uint8_t sent = 0;    ///< layers that have gone
  std::uint8_t layers = 0;  ///< of the product; more than `sent`
  bool requested = false;   ///< the ground has asked for it
  /// [k]: size of the file that brings layers sent + 1 to k + 1. Entries below `sent` mean nothing.
  std::array<std::uint32_t, limits::max_quality_layers> bytes{};
  /// [k]: what layers 1 to k + 1 are worth. Below `sent` what is already down.
  std::array<double, limits::max_quality_layers> worth{};
};

/// Best worth per byte of anything that the candidate could bring next.
[[nodiscard]] double best_efficiency(const PlanCandidate& candidate);

/// The candidates that promise most, from any number that is offered: those of the least efficiency are left out.
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
  /// What a state of a candidate came from: 16 times the cell before it plus the layers it then has.
  std::array<std::array<std::uint16_t, cells + 1>, limits::max_exact_candidates> came_from;
  std::array<std::uint8_t, limits::max_plan_candidates> greedy, exact;
};

/// At most one file for each candidate, all together at most `bytes`. Where everything fits, everything goes. Order:
/// what the ground has asked for, then products of which nothing is down, then refinements, each by worth per byte.
/// Same input, same plan. Bounded: max_plan_candidates^2 * max_quality_layers^2 + max_exact_candidates * plan_cells *
/// max_quality_layers elementary steps.
void plan_pass(std::span<const PlanCandidate> candidates, std::uint64_t bytes, PlanWorkspace& workspace,
               PassPlan& plan);

/// What the ground gains when it holds the first `layers` layers of a product, 0 for none:
///   (newly seen share of the image + 0.02) * (0.2 + richness) * quality,  times 64 for what the ground has asked for.
/// Quality is that of the last of these layers (ProductRecord::layer_quality). Of an image every dB of PSNR counts
/// alike from 15 (nothing to be seen) to 36 (1: coding errors hide behind the camera's noise), and a fifth as much
/// beyond; of a depth map with a largest error of e px of disparity it is 1 / (1 + (e / 2)^2): smaller errors than the
/// matcher's own gain little. Where no quality is on record, b / (b + 0.3) for b bits per newly seen pixel.
struct ProductWorth {
  double richness = 0;
  double newly_seen_share = 0;
  double newly_seen_px = 0;
  bool requested = false;
};
[[nodiscard]] double layers_worth(const ProductRecord& product, const ProductWorth& worth, int layers);

}  // namespace ilp
