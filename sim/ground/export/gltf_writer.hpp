// The surface of a strip as a glTF 2.0 binary file with its orthoimage as texture, which browsers, Blender and game
// engines open. Written by tinygltf.
#pragma once

#include <cstdint>
#include <iosfwd>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::exports {

/// One mesh with normals, texture coordinates and indices, y up: glTF's x is east, its -z is north, as `place` has
/// them, about the map's centre at height 0 (without an anchor the strip's own axes). In metres where `place` is;
/// `extras` of the asset say the unit. `texture` covers all of `map` (read_ortho). Throws std::runtime_error when the
/// mesh has no face or the file would pass 4 GiB.
void write_gltf(const map::SurfaceMesh& mesh, const map::MapGeometry& map, const host::Raster<std::uint8_t>& texture,
                const Georeference& place, std::ostream& out);

}  // namespace ilp::exports
