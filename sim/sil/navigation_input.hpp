// Converts a user's file of vehicle measurements to the file that the flight reads.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/strip.hpp"
#include "sim/sil/stated_times.hpp"

namespace ilp::sil {

/// Accepts a byte-order mark, semicolons or tabs between the cells (with decimal commas), quotes, and times since 1970
/// or in ISO 8601. Such times become times since the first image, if `epoch` (the time of the first image) is known. If
/// the time zone of the camera's clock is unknown, zones in steps of 15 minutes are compared with the measurements; a
/// zone is used only if no other one fits. Returns `given` if the flight can read it, else `made`, which is written.
/// `messages` gets a line for every change, for lines that cannot be used, and if no measurement lies within 0.5 s of
/// an image. Throws std::runtime_error that names an unknown or missing column, or the line with a comma in a cell.
[[nodiscard]] std::filesystem::path prepare_navigation(const std::filesystem::path& given,
                                                       const std::vector<host::StripFrame>& frames,
                                                       const std::optional<StripEpoch>& epoch,
                                                       const std::filesystem::path& made, std::ostream& messages);

}  // namespace ilp::sil
