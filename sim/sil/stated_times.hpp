// The order and the times of photographs by what EXIF states in most of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/photograph.hpp"
#include "sim/host/strip.hpp"

namespace ilp::sil {

/// An image of a strip with what its header says.
struct Photo {
  host::StripFrame frame;
  std::optional<host::PhotographFacts> header;  ///< none: it cannot be read
  std::string fault;                            ///< why
  bool too_large = false;                       ///< it is whole, but more than the programs take
  std::filesystem::path original;               ///< the file as it came
};

/// Time 0 of a strip, since 1970.
struct StripEpoch {
  std::int64_t time_ns = 0;
  bool utc = false;  ///< false: as the camera's clock says, in a zone that nobody states
};

/// Where the times of a strip are assumed: puts it into the order of the times of exposure (or else of the positions,
/// where more of these differ), from 0 at the first. Photographs without such a time, and those a month and more from
/// the others, fall away, as long as more than half stay. Equal times are spread over their second, in the order of the
/// names. Says in `messages` what was done, what falls away, and why the times of EXIF are not used. None where they
/// are not.
std::optional<StripEpoch> take_stated_times(std::vector<Photo>& strip, std::ostream& messages);

}  // namespace ilp::sil
