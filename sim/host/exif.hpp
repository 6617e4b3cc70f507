// Reads the metadata of a photograph: Exif (CIPA DC-008) and the gimbal's angles in XMP, by exiv2.
#pragma once

#include <filesystem>

#include "sim/host/photograph.hpp"

namespace ilp::host {

/// Fills in all members of `facts` except width, height and `deep`, which must be set before. A member stays empty if
/// its tag is missing or damaged, or is a fraction with the denominator 0. Throws nothing of its own.
void read_exif(const std::filesystem::path& path, PhotographFacts& facts);

}  // namespace ilp::host
