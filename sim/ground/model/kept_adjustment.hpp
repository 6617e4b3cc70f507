// Caches adjustments from one ground run to the next.
#pragma once

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/model/adjustment.hpp"

namespace ilp::model {

/// Does the same as adjust(), and returns Adjusted::moved. An equal problem that was adjusted before is taken from the
/// cache `results`, which may be null.
[[nodiscard]] bool adjust_once(AdjustmentProblem& problem, const AdjustmentParams& params,
                               intake::ResultCache* results);

}  // namespace ilp::model
