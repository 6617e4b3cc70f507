// A flight has one camera: of the photographs of a folder those fly that one camera has taken.
#pragma once

#include <iosfwd>
#include <optional>
#include <vector>

#include "sim/host/image_io.hpp"
#include "sim/sil/stated_times.hpp"

namespace ilp::sil {

/// Leaves out, with a line in `messages` that counts and names them, photographs of another size, of another sensor
/// (Model in EXIF, BandName in XMP) and of another focal length than most. What a photograph does not state agrees with
/// everything. Of sizes, that of the camera file counts (`of_camera`) where a fourth as many photographs have it as
/// have the most frequent one; otherwise the most frequent one, first among those of the camera's shape. A tie goes to
/// more pixels. Photographs whose header cannot be read stay.
void keep_one_camera(std::vector<Photo>& strip, const std::optional<host::ImageSize>& of_camera,
                     std::ostream& messages);

}  // namespace ilp::sil
