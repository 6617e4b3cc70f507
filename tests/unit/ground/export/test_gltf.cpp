// The glTF file, taken apart by its specification's own layout.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/ground/export/gltf_writer.hpp"
#include "tests/unit/ground/export/strip_of_poses.hpp"

namespace ilp::exports {
namespace {
using nlohmann::json;

struct Glb {
  json head;
  std::vector<std::uint8_t> buffer;

  template <typename T>
  [[nodiscard]] std::vector<T> elements(int accessor, std::size_t components) const {
    const json& a = head.at("accessors").at(static_cast<std::size_t>(accessor));
    const json& view = head.at("bufferViews").at(a.at("bufferView").get<std::size_t>());
    std::vector<T> out(a.at("count").get<std::size_t>() * components);
    const std::size_t offset = view.value("byteOffset", std::size_t{0});
    EXPECT_EQ(view.at("byteLength"), out.size() * sizeof(T));
    EXPECT_EQ(offset % 4, 0U);
    std::memcpy(out.data(), buffer.data() + offset, out.size() * sizeof(T));
    return out;
  }
  [[nodiscard]] json primitive() const { return head.at("meshes").at(0).at("primitives").at(0); }
  [[nodiscard]] int attribute(const char* name) const { return primitive().at("attributes").at(name); }
};

std::uint32_t u32_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

Glb parse(const std::vector<std::uint8_t>& file) {
  EXPECT_EQ(u32_at(file, 0), 0x46546C67U);
  EXPECT_EQ(u32_at(file, 4), 2U);
  EXPECT_EQ(u32_at(file, 8), file.size());
  const std::size_t json_bytes = u32_at(file, 12);
  EXPECT_EQ(u32_at(file, 16), 0x4E4F534AU);
  EXPECT_EQ(u32_at(file, 24 + json_bytes), 0x004E4942U);
  Glb glb{.head = json::parse(file.begin() + 20, file.begin() + 20 + static_cast<std::ptrdiff_t>(json_bytes))};
  glb.buffer.assign(file.begin() + 28 + static_cast<std::ptrdiff_t>(json_bytes), file.end());
  return glb;
}

// z = x / 2 on a grid of side x side cells of 1, its first cell's centre at (0, side - 1).
map::SurfaceMesh slope(std::uint32_t side) {
  map::SurfaceMesh mesh;
  for (std::uint32_t row = 0; row < side; ++row) {
    for (std::uint32_t column = 0; column < side; ++column) {
      const auto x = static_cast<float>(column);
      mesh.vertices.push_back({x, static_cast<float>(side - 1 - row), x / 2, 100, 0});
    }
  }
  for (std::uint32_t row = 0; row + 1 < side; ++row) {
    for (std::uint32_t column = 0; column + 1 < side; ++column) {
      const std::uint32_t i = row * side + column;
      mesh.faces.push_back({i, i + side, i + 1});
      mesh.faces.push_back({i + 1, i + side, i + side + 1});
    }
  }
  return mesh;
}

map::MapGeometry map_of(std::int32_t side) {
  return {0, static_cast<double>(side - 1), 1, side, side};
}

Georeference local_place() {
  const intake::Flight flight = test::strip_of_poses(true);
  return georeference_of(flight, flight.strips.at(1), nullptr);
}

std::vector<std::uint8_t> gltf_bytes(const map::SurfaceMesh& mesh, const map::MapGeometry& map,
                                     const host::Raster<std::uint8_t>& texture, const Georeference& place) {
  std::ostringstream file;
  write_gltf(mesh, map, texture, place, file);
  const std::string bytes = std::move(file).str();
  return {bytes.begin(), bytes.end()};
}

TEST(Gltf, PointsNormalsAndTexturePlacesAreThoseOfTheSurface) {
  const Glb glb = parse(gltf_bytes(slope(5), map_of(5), host::Raster<std::uint8_t>(5, 5, 90), local_place()));
  const auto points = glb.elements<float>(glb.attribute("POSITION"), 3);
  const auto normals = glb.elements<float>(glb.attribute("NORMAL"), 3);
  const auto uv = glb.elements<float>(glb.attribute("TEXCOORD_0"), 2);
  for (std::size_t i = 0; i < 25; ++i) {
    const auto x = static_cast<float>(i % 5), y = static_cast<float>(4 - i / 5);
    // y is up, north is -z.
    EXPECT_EQ(points[3 * i], x);
    EXPECT_EQ(points[3 * i + 1], x / 2);
    EXPECT_EQ(points[3 * i + 2], -y);
    EXPECT_NEAR(normals[3 * i], -0.4472136, 1e-6);
    EXPECT_NEAR(normals[3 * i + 1], 0.8944272, 1e-6);
    EXPECT_NEAR(normals[3 * i + 2], 0, 1e-6);
    EXPECT_FLOAT_EQ(uv[2 * i], (x + 0.5F) / 5);
    EXPECT_FLOAT_EQ(uv[2 * i + 1], (static_cast<float>(i / 5) + 0.5F) / 5);
  }
  EXPECT_EQ(glb.head.at("accessors").at(0).at("min"), json({0.0, 0.0, -4.0}));
  EXPECT_EQ(glb.head.at("accessors").at(0).at("max"), json({4.0, 2.0, 0.0}));
  EXPECT_EQ(glb.head.at("asset").at("extras").at("unit"), "metre");
}

TEST(Gltf, TheTextureIsAPngInsideTheFile) {
  const Glb glb = parse(gltf_bytes(slope(5), map_of(5), host::Raster<std::uint8_t>(16, 16, 90), local_place()));
  const json& image = glb.head.at("images").at(0);
  EXPECT_EQ(image.at("mimeType"), "image/png");
  EXPECT_FALSE(image.contains("uri"));
  const json& view = glb.head.at("bufferViews").at(image.at("bufferView").get<std::size_t>());
  EXPECT_EQ(std::memcmp(glb.buffer.data() + view.at("byteOffset").get<std::size_t>(), "\x89PNG", 4), 0);
}

TEST(Gltf, IndicesAreAsWideAsTheyMustBe) {
  const Glb small = parse(gltf_bytes(slope(5), map_of(5), host::Raster<std::uint8_t>(5, 5), local_place()));
  EXPECT_EQ(small.head.at("accessors").at(small.primitive().at("indices").get<std::size_t>()).at("componentType"),
            5123);
  EXPECT_EQ(small.elements<std::uint16_t>(small.primitive().at("indices"), 1).size(), 96U);
  const map::SurfaceMesh mesh = slope(257);
  const Glb large = parse(gltf_bytes(mesh, map_of(257), host::Raster<std::uint8_t>(5, 5), local_place()));
  EXPECT_EQ(large.head.at("accessors").at(large.primitive().at("indices").get<std::size_t>()).at("componentType"),
            5125);
  const auto indices = large.elements<std::uint32_t>(large.primitive().at("indices"), 1);
  EXPECT_EQ(indices.back(), 257U * 257U - 1);
}

TEST(Gltf, AnAnchoredSurfaceIsInMetresAboutItsAnchor) {
  const intake::Flight flight = test::strip_of_poses(false);
  const Anchors anchors{find_body("mars"), {{1, std::nullopt, 10, 20, -4000, 0, 3.0}}};
  const Georeference place = georeference_of(flight, flight.strips.at(1), &anchors);
  const Glb glb = parse(gltf_bytes(slope(5), map_of(5), host::Raster<std::uint8_t>(5, 5), place));
  EXPECT_EQ(glb.head.at("accessors").at(0).at("max"), json({12.0, 6.0, 0.0}));
  EXPECT_EQ(glb.head.at("asset").at("extras").at("height_of_zero"), -4000.0);
}

TEST(Gltf, ASurfaceWithoutAFaceIsRefused) {
  EXPECT_THROW((void)gltf_bytes({}, map_of(5), host::Raster<std::uint8_t>(5, 5), local_place()), std::runtime_error);
}

}  // namespace
}  // namespace ilp::exports
