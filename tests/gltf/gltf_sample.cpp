// Surfaces with few and with many vertices as glTF: gltf_sample FOLDER
#include <cmath>
#include <filesystem>
#include <iostream>

#include "sim/ground/export/gltf_writer.hpp"
#include "sim/host/files.hpp"

namespace {

using namespace ilp;

map::SurfaceMesh hills(std::uint32_t side) {
  map::SurfaceMesh mesh;
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const double x = column, y = side - 1 - row;
      const double z = 3 * std::sin(0.2 * x) * std::cos(0.15 * y);
      mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 128, 0});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t i = row * side + column;
      // With a hole, so that some vertices belong to no face.
      if (row > 5 && row < 12 && column > 5 && column < 12) continue;
      mesh.faces.push_back({i, i + side, i + 1});
      mesh.faces.push_back({i + 1, i + side, i + side + 1});
    }
  }
  return mesh;
}

host::Raster<std::uint8_t> stripes(std::int32_t width, std::int32_t height) {
  host::Raster<std::uint8_t> picture(width, height);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) picture.at(x, y) = static_cast<std::uint8_t>(x / 4 % 2 * 100 + y % 100);
  }
  return picture;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: gltf_sample FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  exports::Georeference place;
  place.unit = "metre";
  place.sentence = "a \"made-up\" surface";
  for (const auto& [name, side] : {std::pair("small.glb", 40), std::pair("large.glb", 300)}) {
    const map::MapGeometry map{0, static_cast<double>(side - 1), 1, side, side};
    host::update_file(folder / name, [&](std::ostream& out) {
      exports::write_gltf(hills(static_cast<std::uint32_t>(side)), map, stripes(side, side - 7), place, out);
    });
  }
  return 0;
}
