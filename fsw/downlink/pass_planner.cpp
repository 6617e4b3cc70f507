#include "fsw/downlink/pass_planner.hpp"

namespace ilp {
namespace {

static_assert(PlanWorkspace::cells < 4096, "a cell and a layer share 16 bits");
static_assert(limits::max_quality_layers < 16);

using Levels = std::array<std::uint8_t, limits::max_plan_candidates>;

double utility_at(const PlanCandidate& candidate, int layers) {
  return layers == 0 ? 0.0 : candidate.utility[static_cast<std::size_t>(layers - 1)];
}
/// Size of the file that extends the candidate from the sent layers to `layers`.
std::uint32_t bytes_at(const PlanCandidate& candidate, int layers) {
  return layers <= candidate.sent ? 0U : candidate.bytes[static_cast<std::size_t>(layers - 1)];
}
double gain_at(const PlanCandidate& candidate, int layers) {
  return utility_at(candidate, layers) - utility_at(candidate, candidate.sent);
}

struct Step {
  std::size_t candidate = 0;
  int layers = 0;  ///< layers after the step
  double efficiency = 0;
};

/// The most efficient step of one candidate from `level` that fits into `capacity`; layers 0 if there is none.
Step best_step(const PlanCandidate& candidate, std::size_t index, int level, std::uint64_t capacity) {
  Step best;
  for (int layers = level + 1; layers <= candidate.layers; ++layers) {
    const std::uint32_t cost = bytes_at(candidate, layers) - bytes_at(candidate, level);
    if (cost > capacity) continue;
    const double gain = utility_at(candidate, layers) - utility_at(candidate, level);
    const double efficiency = gain / (cost > 0 ? cost : 1U);
    if (best.layers == 0 || efficiency > best.efficiency) best = {index, layers, efficiency};
  }
  return best;
}

/// Repeatedly takes the most efficient step that still fits.
void raise(std::span<const PlanCandidate> candidates, std::uint64_t capacity, Levels& levels) {
  for (;;) {  // bound: the candidates' layers; each turn adds one or more
    Step best;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Step step = best_step(candidates[i], i, levels[i], capacity);
      if (step.layers != 0 && (best.layers == 0 || step.efficiency > best.efficiency)) best = step;
    }
    if (best.layers == 0 || !(best.efficiency > 0)) return;
    const PlanCandidate& chosen = candidates[best.candidate];
    capacity -= bytes_at(chosen, best.layers) - bytes_at(chosen, levels[best.candidate]);
    levels[best.candidate] = static_cast<std::uint8_t>(best.layers);
  }
}

struct Sum {
  std::uint64_t bytes = 0;
  double gain = 0;
};

Sum sum_of(std::span<const PlanCandidate> candidates, const Levels& levels) {
  Sum sum;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    sum.bytes += bytes_at(candidates[i], levels[i]);
    sum.gain += gain_at(candidates[i], levels[i]);
  }
  return sum;
}

/// One state per cell of bytes, with its exact size, so that rounding loses only states that share a cell.
void solve(std::span<const PlanCandidate> candidates, std::uint64_t bytes, PlanWorkspace& workspace) {
  constexpr std::size_t cells = PlanWorkspace::cells;
  const double cells_per_byte = static_cast<double>(cells) / static_cast<double>(bytes > 0 ? bytes : 1);
  for (auto& state : workspace.now) state = {0, -1};
  workspace.now[0] = {0, 0};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const PlanCandidate& candidate = candidates[i];
    for (auto& state : workspace.next) state = {0, -1};
    for (std::size_t cell = 0; cell <= cells; ++cell) {
      const PlanWorkspace::State from = workspace.now[cell];
      if (from.gain < 0) continue;
      for (int layers = candidate.sent; layers <= candidate.layers; ++layers) {
        const PlanWorkspace::State to{from.bytes + bytes_at(candidate, layers), from.gain + gain_at(candidate, layers)};
        if (to.bytes > bytes) continue;
        const auto raw = static_cast<std::size_t>(static_cast<double>(to.bytes) * cells_per_byte);
        const std::size_t place = raw < cells ? raw : cells;
        PlanWorkspace::State& best = workspace.next[place];
        if (to.gain < best.gain || (to.gain == best.gain && to.bytes >= best.bytes)) continue;
        best = to;
        workspace.came_from[i][place] =
            static_cast<std::uint16_t>(16 * cell + static_cast<std::size_t>(layers - candidate.sent));
      }
    }
    workspace.now = workspace.next;
  }
  std::size_t cell = 0;
  for (std::size_t k = 1; k <= cells; ++k) {
    if (workspace.now[k].gain > workspace.now[cell].gain) cell = k;
  }
  for (std::size_t i = candidates.size(); i-- > 0;) {
    const std::uint16_t from = workspace.came_from[i][cell];
    workspace.exact[i] = static_cast<std::uint8_t>(candidates[i].sent + from % 16U);
    cell = from / 16U;
  }
}

/// True when `a` goes before `b`.
bool goes_before(const PlannedFile& a, bool a_requested, const PlannedFile& b, bool b_requested) {
  if (a_requested != b_requested) return a_requested;
  const bool a_new = a.first_layer == 1, b_new = b.first_layer == 1;
  if (a_new != b_new) return a_new;
  const double left = a.gain * b.bytes, right = b.gain * a.bytes;
  return left != right ? left > right : a.id < b.id;
}

void write_plan(std::span<const PlanCandidate> candidates, const Levels& levels, PassPlan& plan) {
  std::array<bool, limits::max_plan_candidates> requested{};
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const PlanCandidate& candidate = candidates[i];
    if (levels[i] <= candidate.sent) continue;
    PlannedFile file;
    file.id = candidate.id;
    file.first_layer = static_cast<std::uint8_t>(candidate.sent + 1);
    file.last_layer = levels[i];
    file.bytes = bytes_at(candidate, levels[i]);
    file.gain = gain_at(candidate, levels[i]);
    plan.bytes += file.bytes;
    plan.gain += file.gain;
    if (!plan.files.push_back(file)) return;
    std::size_t at = plan.files.size() - 1;
    for (; at > 0 && goes_before(file, candidate.requested, plan.files[at - 1], requested[at - 1]); --at) {
      plan.files[at] = plan.files[at - 1];
      requested[at] = requested[at - 1];
    }
    plan.files[at] = file;
    requested[at] = candidate.requested;
  }
}

double quality_of(const ProductRecord& product, const ProductUtility& utility, int layers) {
  const auto layer = static_cast<std::size_t>(layers - 1);
  const auto stated = static_cast<double>(product.layer_quality[layer]);
  if (stated > 0 && product.kind == ProductKind::image) {
    constexpr double nothing_db = 15, good_db = 36, exact_db = 57, beyond = 0.2;
    const double db = stated < exact_db ? stated : exact_db;
    if (db <= nothing_db) return 0;
    const double counted = db < good_db ? db - nothing_db : good_db - nothing_db + beyond * (db - good_db);
    return counted / (good_db - nothing_db);
  }
  if (stated > 0) {
    constexpr double half_px = 2;
    return half_px * half_px / (half_px * half_px + stated * stated);
  }
  constexpr double half_bpp = 0.3;
  const std::uint32_t bytes = product.layer_bytes[layer] != 0 ? product.layer_bytes[layer] : product.bytes;
  const double bits = 8.0 * bytes / (utility.newly_seen_px > 1 ? utility.newly_seen_px : 1);
  return bits / (bits + half_bpp);
}

}  // namespace

double best_efficiency(const PlanCandidate& candidate) {
  return best_step(candidate, 0, candidate.sent, ~std::uint64_t{0}).efficiency;
}

void CandidateList::offer(const PlanCandidate& candidate) {
  if (candidate.layers <= candidate.sent) return;
  const double efficiency = best_efficiency(candidate);
  if (list_.push_back(candidate)) {
    efficiency_[list_.size() - 1] = efficiency;
    return;
  }
  std::size_t least = 0;
  for (std::size_t i = 1; i < list_.size(); ++i) {
    if (efficiency_[i] < efficiency_[least]) least = i;
  }
  if (efficiency <= efficiency_[least]) return;
  list_[least] = candidate;
  efficiency_[least] = efficiency;
}

void plan_pass(std::span<const PlanCandidate> candidates, std::uint64_t bytes, PlanWorkspace& workspace,
               PassPlan& plan) {
  plan.files.clear();
  plan.bytes = 0;
  plan.gain = 0;
  if (candidates.size() > limits::max_plan_candidates) candidates = candidates.first(limits::max_plan_candidates);
  std::uint64_t everything = 0;
  for (const PlanCandidate& candidate : candidates) everything += bytes_at(candidate, candidate.layers);
  Levels& levels = workspace.greedy;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    levels[i] = everything <= bytes ? candidates[i].layers : candidates[i].sent;
  }
  if (everything <= bytes) return write_plan(candidates, levels, plan);

  raise(candidates, bytes, levels);
  if (candidates.size() > limits::max_exact_candidates) return write_plan(candidates, levels, plan);
  solve(candidates, bytes, workspace);
  raise(candidates, bytes - sum_of(candidates, workspace.exact).bytes, workspace.exact);
  const bool exact = sum_of(candidates, workspace.exact).gain > sum_of(candidates, levels).gain;
  write_plan(candidates, exact ? workspace.exact : levels, plan);
}

double utility_of_layers(const ProductRecord& product, const ProductUtility& utility, int layers) {
  if (layers <= 0) return 0;
  constexpr double least_share = 0.02, least_richness = 0.2, asked_for = 64;
  const double place = (utility.newly_seen_share + least_share) * (utility.richness + least_richness);
  return place * quality_of(product, utility, layers) * (utility.requested ? asked_for : 1);
}

}  // namespace ilp
