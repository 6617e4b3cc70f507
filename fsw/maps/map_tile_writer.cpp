#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/maps/byte_fields.hpp"
#include "fsw/maps/map_tile.hpp"
#include "fsw/maps/map_tile_file.hpp"
#include "fsw/maps/plane_coding.hpp"
#include "fsw/vision/codec/background_fill.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"

namespace ilp {
namespace {

using map_file::FieldWriter;

/// Writes the mask's section, which is empty where everything is known. False if nothing is.
Status write_mask(MapTileWorkspace& workspace, std::int32_t side, FieldWriter& out, std::uint16_t& bytes, bool& any) {
  const ImageView<std::uint8_t> mask(workspace.mask.data(), side, side);
  const auto known = static_cast<std::size_t>(
      std::count_if(workspace.mask.begin(), workspace.mask.begin() + static_cast<std::ptrdiff_t>(mask.area()),
                    [](std::uint8_t inside) { return inside != 0; }));
  any = known > 0;
  bytes = 0;
  if (!any || known == mask.area()) return {};
  std::size_t size = 0;
  ILP_TRY(encode_mask(mask, out.unused().data(), out.unused().size(), size));
  bytes = static_cast<std::uint16_t>(size);
  out.skip(size);
  return {};
}

Status write_section(std::size_t size, FieldWriter& out, std::uint16_t& bytes) {
  out.skip(size);
  if (!out.fits() || size > limits::max_map_tile_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(out.size()), limits::max_map_tile_bytes};
  }
  bytes = static_cast<std::uint16_t>(size);
  return {};
}

void load_image(const MapTile& tile, MapTileWorkspace& workspace) {
  for (std::size_t i = 0; i < map_tile_pixels; ++i) {
    workspace.mask[i] = tile.image[i] != 0 ? 1 : 0;
    workspace.samples[i] = tile.image[i];
  }
}

/// Bytes of the image with a step.
std::size_t write_image(const MapTile& tile, std::int32_t step, MapTileWorkspace& workspace,
                        std::span<std::uint8_t> bytes) {
  const ImageView<std::int32_t> samples(workspace.samples.data(), map_tile_side, map_tile_side);
  load_image(tile, workspace);
  fill_background(samples, {workspace.mask.data(), map_tile_side, map_tile_side}, workspace.scratch.data());
  return encode_plane(samples, step, workspace.scratch.data(), bytes);
}

/// The finest step that keeps the ceiling: without loss, or found by bisection to a hundredth.
Status choose_step(const MapTile& tile, std::size_t ceiling, MapTileWorkspace& workspace, std::int32_t& step) {
  const auto fits = [&](std::int32_t tried) { return write_image(tile, tried, workspace, {}) <= ceiling; };
  step = lossless_step;
  if (fits(step)) return {};
  std::int32_t fine = finest_plane_step, coarse = coarsest_plane_step;
  if (!fits(coarse)) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(map_tile_pixels),
            static_cast<std::int64_t>(ceiling)};
  }
  for (int round = 0; round < 24 && coarse - fine > fine / 100; ++round) {
    const std::int32_t middle = fine + (coarse - fine) / 2;
    (fits(middle) ? coarse : fine) = middle;
  }
  step = coarse;
  return {};
}

Status write_posts(const MapTile& tile, MapTileWorkspace& workspace, FieldWriter& out, map_file::TileHead& head) {
  for (std::size_t i = 0; i < map_tile_post_count; ++i) {
    workspace.mask[i] = tile.posts[i] != unknown_post ? 1 : 0;
    workspace.samples[i] = tile.posts[i];
  }
  bool any = false;
  ILP_TRY(write_mask(workspace, map_tile_posts, out, head.post_mask_bytes, any));
  if (!any) return {};
  const ImageView<std::int32_t> samples(workspace.samples.data(), map_tile_posts, map_tile_posts);
  fill_background(samples, {workspace.mask.data(), map_tile_posts, map_tile_posts}, workspace.scratch.data());
  return write_section(encode_plane(samples, lossless_step, workspace.scratch.data(), out.unused()), out,
                       head.post_bytes);
}

Status write_features(const MapFeatures& features, FieldWriter& out, std::uint16_t& count) {
  constexpr float beyond = map_tile_side;
  for (const PlaceFeature& feature : features) {
    const float x = feature.x + 0.5F, y = feature.y + 0.5F;
    if (!(x >= 0 && x < beyond && y >= 0 && y < beyond) || feature.level >= place_levels) {
      return out_of_range(Argument::features, feature.x);
    }
    out.write(static_cast<std::uint16_t>(x * map_file::feature_steps_per_px));
    out.write(static_cast<std::uint16_t>(y * map_file::feature_steps_per_px));
    out.write(feature.level);
    out.write(feature.angle);
    for (const std::uint32_t word : feature.descriptor) out.write(word);
  }
  count = static_cast<std::uint16_t>(features.size());
  return {};
}

}  // namespace

Status encode_map_tile(const MapTile& tile, const MapTileFeatures& features, std::uint64_t map_id,
                       const MapTileCoding& coding, MapTileWorkspace& workspace, std::span<std::uint8_t> file,
                       std::size_t& size) {
  size = 0;
  const std::span<std::uint8_t> unused = file.first(std::min(file.size(), limits::max_map_tile_bytes));
  map_file::TileHead head;
  head.layer = tile.layer;
  head.row = tile.row;
  head.column = tile.column;
  head.map_id = map_id;
  head.height_offset_m = tile.height_offset_m;
  head.height_step_m = tile.height_step_m;
  FieldWriter out(unused);
  out.skip(map_file::tile_head_bytes);
  load_image(tile, workspace);
  bool any = false;
  ILP_TRY(write_mask(workspace, map_tile_side, out, head.image_mask_bytes, any));
  if (any) {
    ILP_TRY(choose_step(tile, coding.image_bytes, workspace, head.image_step));
    ILP_TRY(write_section(write_image(tile, head.image_step, workspace, out.unused()), out, head.image_bytes));
  }
  ILP_TRY(write_posts(tile, workspace, out, head));
  ILP_TRY(write_features(features.image, out, head.image_features));
  ILP_TRY(write_features(features.shape, out, head.shape_features));
  if (!out.fits()) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(out.size()),
            static_cast<std::int64_t>(unused.size())};
  }
  FieldWriter front(unused);
  each_field(head, [&](const auto& field) { front.write(field); });
  size = out.size();
  return {};
}

void set_map_id(std::span<std::uint8_t> file, std::uint64_t map_id) {
  if (file.size() >= map_file::tile_head_bytes) store_little_endian(map_id, file.data() + map_file::map_id_at);
}

}  // namespace ilp
