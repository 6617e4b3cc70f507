// Selects the photographs of a folder that the same camera has taken, because a flight has one camera.
#pragma once

#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/image_io.hpp"
#include "sim/sil/stated_times.hpp"

namespace ilp::sil {

/// Removes photographs of another size, of another sensor (Model in EXIF, BandName in XMP) and of another focal length
/// (by more than 1 %) than most. A value that a photograph does not state agrees with every value, and photographs with
/// unreadable headers stay. The size to keep is the most frequent one, among sizes with the aspect ratio of `of_camera`
/// if there are any; of equally frequent sizes, the one with more pixels. The exact size `of_camera` (size in the
/// camera file) is kept instead if at least a quarter as many photographs have it. `messages` gets a line with number
/// and first file for each reason.
void keep_one_camera(std::vector<Photo>& strip, const std::optional<host::ImageSize>& of_camera,
                     std::ostream& messages);

}  // namespace ilp::sil
