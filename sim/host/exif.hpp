// What a photograph says of itself: Exif (CIPA DC-008) and the gimbal's angles in XMP, read by exiv2.
#pragma once

#include <filesystem>

#include "sim/host/photograph.hpp"

namespace ilp::host {

/// Fills in everything of `facts` but the size and the depth of the image, which must be there already. Numbers are
/// those of the file's fractions; a fraction over 0 is unknown. A file without such tags, or with damaged ones, leaves
/// what it does not say unknown. Throws nothing of its own.
void read_exif(const std::filesystem::path& path, PhotographFacts& facts);

}  // namespace ilp::host
