// The orthoimage of a strip in the colours of the photographs that were flown in grey.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "sim/ground/export/strip_exports.hpp"

namespace ilp::exports {

/// Writes colour SUFFIX .tif, a GeoTIFF of red, green and blue in the grid of `strip.grid`; 0 where nothing was seen.
/// Each cell has the colour of the place where its keyframe's camera saw it, in the photograph of the keyframe's name
/// (without its ending) in `photographs`, and the brightness of the grey orthoimage, whose exposures are balanced.
/// Without a photograph a cell stays grey. Photographs may be larger than the images that flew by a whole factor; those
/// of other sizes are named in `messages` and not used. Where none fits, `messages` says so, and there is no file. Adds
/// the file to `strip.files`. Throws std::runtime_error for a folder without images, and when the file cannot be
/// written.
void write_colour_ortho(const intake::Flight& flight, const Georeference& place,
                        const std::filesystem::path& photographs, const std::filesystem::path& folder,
                        ExportedStrip& strip, std::ostream& messages);

}  // namespace ilp::exports
