// Makes an orthoimage of a strip in colour, from the photographs of which the flight used grey versions.
#pragma once

#include <filesystem>
#include <iosfwd>

#include "sim/ground/export/strip_exports.hpp"

namespace ilp::exports {

/// Writes `colour` + `strip.suffix` + `.tif`, a GeoTIFF of red, green and blue in the grid of `strip.grid`; 0 where
/// nothing was seen. A cell is projected into the camera of its keyframe, and takes the colour from the photograph with
/// the keyframe's name (without extension) in `photographs`. The brightness is that of the balanced grey orthoimage. A
/// cell without a photograph stays grey. Photographs may be larger than the flight's images by an integer factor; those
/// of other sizes are named in `messages` and not used. If no photograph can be used, `messages` says so, and no file
/// is written. Adds the file to `strip.files`. Throws std::runtime_error for a folder without images, and if the file
/// cannot be written.
void write_colour_ortho(const intake::Flight& flight, const Georeference& place,
                        const std::filesystem::path& photographs, const std::filesystem::path& folder,
                        ExportedStrip& strip, std::ostream& messages);

}  // namespace ilp::exports
