// Adjustments that are kept from one ground run to the next.
#pragma once

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/model/adjustment.hpp"

namespace ilp::model {

/// The same as adjust(); whether anything moved. What has been adjusted once, from the same start, is taken from
/// `results`, which may be null.
[[nodiscard]] bool adjust_once(AdjustmentProblem& problem, const AdjustmentParams& params,
                               intake::ResultCache* results);

}  // namespace ilp::model
