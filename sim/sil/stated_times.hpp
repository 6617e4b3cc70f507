// Orders the photographs of a strip by their EXIF times, and takes over these times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/photograph.hpp"
#include "sim/host/strip.hpp"

namespace ilp::sil {

/// An image of a strip with its metadata.
struct Photo {
  host::StripFrame frame;
  std::optional<host::PhotographFacts> header;  ///< empty: cannot be read
  std::string fault;                            ///< why the header cannot be read
  bool too_large = false;                       ///< valid, but larger than the programs accept
  std::filesystem::path original;               ///< the user's file
};

/// Time 0 of a strip: the exposure of its first image, since 1970.
struct StripEpoch {
  std::int64_t time_ns = 0;
  bool utc = false;  ///< false: by the camera's clock, whose time zone is not known
};

/// Replaces assumed times of a strip by EXIF times, with 0 at the first image, and sorts the strip by them. The EXIF
/// times are the times of exposure, or the times of the position fixes if more of these differ. Photographs without a
/// time, or more than 30 days from the median time, are removed. Equal times in whole seconds are spread over their
/// second, in the order of the names. Returns empty and changes nothing if the strip's times are not assumed, if half
/// of the photographs or more would be removed, or if fewer than two times, or less than a quarter of them, differ.
/// `messages` says what was done, which photographs are removed, and why EXIF times are not used.
std::optional<StripEpoch> take_stated_times(std::vector<Photo>& strip, std::ostream& messages);

}  // namespace ilp::sil
