// Parts of report.json that stand alone.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// What the flight itself says of its errors, one sigma, in per cent of the flying height; null where it says nothing.
[[nodiscard]] nlohmann::ordered_json estimated_errors_json(const Report& report);
/// In the order of the flight.
[[nodiscard]] nlohmann::ordered_json housekeeping_json(const intake::Flight& flight);
/// The latest; null where none came.
[[nodiscard]] nlohmann::ordered_json storage_json(const intake::Flight& flight);
[[nodiscard]] nlohmann::ordered_json timing_json(const intake::Flight& flight);
/// What the page shows of score.json; unknown values are null.
[[nodiscard]] nlohmann::ordered_json score_json(const ScoreFile& score);

}  // namespace ilp::report
