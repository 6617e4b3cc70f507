#include "fsw/maps/map_tile.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/maps/byte_fields.hpp"
#include "fsw/maps/map_tile_file.hpp"
#include "fsw/maps/plane_coding.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"

namespace ilp {
namespace {

using map_file::fault_at;
using map_file::FieldReader;
using map_file::TileHead;
using Octets = std::span<const std::uint8_t>;

constexpr double largest_height_m = 1e6;

struct Sections {
  Octets image_mask, image, post_mask, posts, image_features, shape_features;
};

bool is_valid(const TileHead& head) {
  return std::isfinite(head.height_offset_m) && std::fabs(head.height_offset_m) <= largest_height_m &&
         std::isfinite(head.height_step_m) && head.height_step_m > 0 &&
         head.height_step_m <= largest_height_m / 32768 && is_plane_step(head.image_step) &&
         head.image_features <= limits::max_map_features && head.shape_features <= limits::max_map_features;
}

/// The sections of a file that is the one of the directory's entry.
Status open_tile(Octets file, const MapDirectory& directory, std::size_t entry, TileHead& head, Sections& sections) {
  if (entry >= directory.tiles.size()) return {StatusCode::not_found, static_cast<std::int64_t>(entry)};
  const MapTileEntry& meant = directory.tiles[entry];
  if (!is_map_tile(directory, meant, file)) return {StatusCode::record_damaged, static_cast<std::int64_t>(entry)};
  FieldReader in(file);
  each_field(head, [&](auto& field) { in.read(field); });
  if (!in.whole()) {
    return {StatusCode::truncated, static_cast<std::int64_t>(file.size()), map_file::tile_head_bytes};
  }
  if (head.magic != map_file::tile_magic) return fault_at(0);
  if (head.version != map_file::tile_version) return {StatusCode::unsupported_format, head.version};
  if (head.map_id != directory.id || head.layer != meant.layer || head.row != meant.row ||
      head.column != meant.column || !is_valid(head)) {
    return fault_at(in.at());
  }
  sections.image_mask = in.take(head.image_mask_bytes);
  sections.image = in.take(head.image_bytes);
  sections.post_mask = in.take(head.post_mask_bytes);
  sections.posts = in.take(head.post_bytes);
  sections.image_features = in.take(head.image_features * map_file::feature_bytes);
  sections.shape_features = in.take(head.shape_features * map_file::feature_bytes);
  if (!in.whole()) {
    return {StatusCode::truncated, static_cast<std::int64_t>(file.size()), static_cast<std::int64_t>(in.at())};
  }
  return in.at() == file.size() ? Status{} : fault_at(in.at());
}

/// A fault of a section is reported at its place in the file.
Status moved(const Status& status, Octets file, Octets section) {
  if (!status.is(StatusCode::parse_error)) return status;
  return fault_at(static_cast<std::size_t>(section.data() - file.data() + status.a));
}

/// Decodes a plane and its mask: where nothing is known, `workspace.mask` is 0.
Status decode(Octets file, Octets mask, Octets plane, std::int32_t side, std::int32_t step,
              MapTileWorkspace& workspace) {
  const ImageView<std::uint8_t> known(workspace.mask.data(), side, side);
  std::fill_n(workspace.mask.begin(), known.area(), static_cast<std::uint8_t>(plane.empty() ? 0 : 1));
  if (plane.empty()) return {};
  if (!mask.empty()) ILP_TRY(moved(decode_mask(mask.data(), mask.size(), known), file, mask));
  const ImageView<std::int32_t> samples(workspace.samples.data(), side, side);
  return moved(decode_plane(plane, step, workspace.scratch.data(), samples), file, plane);
}

Status read_features(Octets file, Octets section, MapFeatures& features) {
  features.clear();
  FieldReader in(section);
  // bound: limits::max_map_features, as the head was checked
  while (in.at() < section.size()) {
    const std::size_t begin = in.at();
    std::uint16_t x = 0, y = 0;
    PlaceFeature feature;
    in.read(x);
    in.read(y);
    in.read(feature.level);
    in.read(feature.angle);
    for (std::uint32_t& word : feature.descriptor) in.read(word);
    constexpr auto beyond = static_cast<std::uint32_t>(map_tile_side * map_file::feature_steps_per_px);
    if (x >= beyond || y >= beyond || feature.level >= place_levels || !in.whole()) {
      return moved(fault_at(begin), file, section);
    }
    feature.x = static_cast<float>(x) / map_file::feature_steps_per_px - 0.5F;
    feature.y = static_cast<float>(y) / map_file::feature_steps_per_px - 0.5F;
    if (!features.push_back(feature)) return moved(fault_at(begin), file, section);
  }
  return {};
}

}  // namespace

Status decode_map_tile(Octets file, const MapDirectory& directory, std::size_t entry, MapTileWorkspace& workspace,
                       MapTile& tile) {
  TileHead head;
  Sections sections;
  ILP_TRY(open_tile(file, directory, entry, head, sections));
  tile.layer = head.layer;
  tile.row = head.row;
  tile.column = head.column;
  tile.height_offset_m = head.height_offset_m;
  tile.height_step_m = head.height_step_m;
  ILP_TRY(decode(file, sections.image_mask, sections.image, map_tile_side, head.image_step, workspace));
  for (std::size_t i = 0; i < map_tile_pixels; ++i) {
    const std::int32_t grey = std::clamp(workspace.samples[i], 1, 255);
    tile.image[i] = workspace.mask[i] != 0 ? static_cast<std::uint8_t>(grey) : std::uint8_t{0};
  }
  ILP_TRY(decode(file, sections.post_mask, sections.posts, map_tile_posts, lossless_step, workspace));
  for (std::size_t i = 0; i < map_tile_post_count; ++i) {
    const std::int32_t steps = std::clamp(workspace.samples[i], -32767, 32767);
    tile.posts[i] = workspace.mask[i] != 0 ? static_cast<std::int16_t>(steps) : unknown_post;
  }
  return {};
}

Status read_map_features(Octets file, const MapDirectory& directory, std::size_t entry, MapTileFeatures& features) {
  TileHead head;
  Sections sections;
  ILP_TRY(open_tile(file, directory, entry, head, sections));
  ILP_TRY(read_features(file, sections.image_features, features.image));
  return read_features(file, sections.shape_features, features.shape);
}

}  // namespace ilp
