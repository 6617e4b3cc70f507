#include "sim/ground/export/point_cloud.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <type_traits>

namespace ilp::exports {
namespace {

template <typename T>
void append(std::vector<std::uint8_t>& to, T value) {
  static_assert(std::endian::native == std::endian::little && std::is_trivially_copyable_v<T>);
  const std::size_t at = to.size();
  to.resize(at + sizeof(T));
  std::memcpy(to.data() + at, &value, sizeof(T));
}

std::uint8_t grey_of(const intake::StructureTrackPoint& track, const GreyOf& grey) {
  for (const StructureObservation& seen : track.observations) {
    if (!std::isfinite(seen.x) || !std::isfinite(seen.y)) continue;
    if (const auto value = grey(seen.keyframe_id, seen.x, seen.y)) return *value;
  }
  return 128;
}

void append_u32(std::vector<std::uint8_t>& to, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

std::vector<std::uint8_t> point_cloud_ply(const intake::Flight& flight, const intake::Strip& strip,
                                          const Georeference& place, const GreyOf& grey) {
  std::vector<std::uint8_t> body;
  std::size_t count = 0;
  for (const std::int64_t id : strip.keyframes) {
    for (const intake::StructureTrackPoint& track : intake::points_of(flight.keyframes.at(id))) {
      const Vec3 p = place.map_from_world({track.point.position[0], track.point.position[1], track.point.position[2]});
      if (!p.allFinite()) continue;
      for (int i = 0; i < 3; ++i) append(body, p[i]);
      body.insert(body.end(), 3, grey_of(track, grey));
      append(body, track.point.error_px);
      append(body, static_cast<std::uint32_t>(track.observations.size()));
      ++count;
    }
  }
  if (count == 0) return {};
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment " + place.sentence + "\ncomment unit: " + place.unit +
      "\nelement vertex " + std::to_string(count) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty float error_px\nproperty uint observations\nend_header\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

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
