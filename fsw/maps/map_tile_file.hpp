// The layout of a tile's file: its head, and sizes of its sections.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp::map_file {

inline constexpr std::uint32_t tile_magic = 0x54504C49;  // "ILPT"
inline constexpr std::uint16_t tile_version = 2;

/// The head. The sections follow in the order of their lengths here. If a mask has length 0, everything is known; if
/// the image or the posts have length 0, nothing of them is known.
struct TileHead {
  std::uint32_t magic = tile_magic;
  std::uint16_t version = tile_version;
  std::uint16_t layer = 0, row = 0, column = 0;
  std::uint64_t map_id = 0;
  double height_offset_m = 0, height_step_m = 1;
  std::int32_t image_step = 0;  ///< step of encode_plane()
  std::uint16_t image_mask_bytes = 0, image_bytes = 0;
  std::uint16_t post_mask_bytes = 0, post_bytes = 0;
  std::uint16_t image_features = 0, shape_features = 0;  ///< numbers of features
};
inline constexpr std::size_t tile_head_bytes = 52, map_id_at = 12;

/// Calls `field` for each field of the head in the order of the file, for reading and for writing.
template <typename Head, typename Field>
void each_field(Head& head, Field field) {
  field(head.magic);
  field(head.version);
  field(head.layer);
  field(head.row);
  field(head.column);
  field(head.map_id);
  field(head.height_offset_m);
  field(head.height_step_m);
  field(head.image_step);
  field(head.image_mask_bytes);
  field(head.image_bytes);
  field(head.post_mask_bytes);
  field(head.post_bytes);
  field(head.image_features);
  field(head.shape_features);
}

// Size of a feature: x and y in 1/128 px from the tile's north-western corner, level, angle, words of the descriptor.
inline constexpr std::size_t feature_bytes = 2 + 2 + 1 + 1 + 32;
inline constexpr float feature_steps_per_px = 128;

}  // namespace ilp::map_file
