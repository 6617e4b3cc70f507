// The vehicle's measurements as people bring them: made into the file that the flight reads, or refused in plain words.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/strip.hpp"
#include "sim/sil/stated_times.hpp"

namespace ilp::sil {

/// Reads a byte-order mark, semicolons or tabs between the cells (with decimal commas), quotes, and times since 1970 or
/// of ISO 8601: these become times since the first image where the images state theirs (`epoch`). A clock of unknown
/// zone is compared with the measurements in steps of a quarter of an hour; only one zone that fits is used. Returns
/// `given` where the flight can read it as it is, else `made`, which is written. Says in `messages` what was done,
/// which lines cannot be used, and when no measurement lies within half a second of an image. Throws std::runtime_error
/// that names the column that is not known or missing, or the line with a comma in a cell.
[[nodiscard]] std::filesystem::path prepare_navigation(const std::filesystem::path& given,
                                                       const std::vector<host::StripFrame>& frames,
                                                       const std::optional<StripEpoch>& epoch,
                                                       const std::filesystem::path& made, std::ostream& messages);

}  // namespace ilp::sil
