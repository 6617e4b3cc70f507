// Writes the surface of a strip as a glTF 2.0 binary file with the orthoimage as texture, by tinygltf. Browsers,
// Blender and game engines open it.
#pragma once

#include <cstdint>
#include <iosfwd>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::exports {

/// Writes one mesh with normals, texture coordinates and indices. glTF's axes are x east, y up and -z north in the map
/// coordinates of `place` (without an anchor the strip's own axes); the origin is the map's centre at height 0. The
/// unit is that of `place`, and `extras` of the asset names it. `texture` covers all of `map` (read_ortho). Throws
/// std::runtime_error if the mesh has no face, or the file would exceed 4 GiB.
void write_gltf(const map::SurfaceMesh& mesh, const map::MapGeometry& map, const host::Raster<std::uint8_t>& texture,
                const Georeference& place, std::ostream& out);

}  // namespace ilp::exports
