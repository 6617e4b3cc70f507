// Makes parts of report.json.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/ground/report/report.hpp"

namespace ilp::report {

/// The errors that the flight has estimated, standard deviations in % of the flying height; null if there are none.
[[nodiscard]] nlohmann::ordered_json estimated_errors_json(const Report& report);
/// All housekeeping reports, in the order of the flight.
[[nodiscard]] nlohmann::ordered_json housekeeping_json(const intake::Flight& flight);
/// The latest record of storage or of timing; null: none came.
[[nodiscard]] nlohmann::ordered_json storage_json(const intake::Flight& flight);
[[nodiscard]] nlohmann::ordered_json timing_json(const intake::Flight& flight);
/// The part of score.json that the page shows; unknown values are null.
[[nodiscard]] nlohmann::ordered_json score_json(const ScoreFile& score);

}  // namespace ilp::report
