#include "sim/ground/export/ply_writer.hpp"

#include <bit>

namespace ilp::exports {
namespace {

void append_u32(std::vector<std::uint8_t>& to, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

std::vector<std::uint8_t> ply_bytes(const map::SurfaceMesh& mesh, const std::string& comment) {
  const std::string header = "ply\nformat binary_little_endian 1.0\ncomment " + comment + "\nelement vertex " +
                             std::to_string(mesh.vertices.size()) +
                             "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
                             "property uchar green\nproperty uchar blue\nelement face " +
                             std::to_string(mesh.faces.size()) +
                             "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.reserve(header.size() + mesh.vertices.size() * 15 + mesh.faces.size() * 13);
  for (const map::SurfaceVertex& v : mesh.vertices) {
    append_u32(bytes, std::bit_cast<std::uint32_t>(v.x));
    append_u32(bytes, std::bit_cast<std::uint32_t>(v.y));
    append_u32(bytes, std::bit_cast<std::uint32_t>(v.z));
    bytes.insert(bytes.end(), 3, v.grey);
  }
  for (const auto& face : mesh.faces) {
    bytes.push_back(3);
    for (const std::uint32_t vertex : face) append_u32(bytes, vertex);
  }
  return bytes;
}

}  // namespace ilp::exports
