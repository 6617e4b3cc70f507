#include "sim/ground/export/keyframe_table.hpp"

#include "sim/ground/intake/strip_track.hpp"
#include "sim/host/status_words.hpp"

namespace ilp::exports {
namespace {

constexpr double ns_per_s = 1e9;

std::string state_of(const intake::Keyframe& keyframe) {
  if (!keyframe.pose) return "no pose received";
  switch (keyframe.pose->state) {
    case PoseState::final:
      return "posed";
    case PoseState::provisional:
      return "provisional pose only";
    case PoseState::failed:
      return std::string("no pose: ") + words_of(keyframe.pose->verdict);
    case PoseState::count:
      break;
  }
  return "unknown state";
}

std::string products_of(const intake::Keyframe& keyframe) {
  std::string names;
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    if (keyframe.product(kind)) names += (names.empty() ? "" : " ") + std::string(name_of(kind));
  }
  return names;
}

Cell bytes_of(const intake::Keyframe& keyframe, ProductKind kind) {
  const std::optional<intake::ProductAccount>& product = keyframe.product(kind);
  return product ? Cell(static_cast<std::int64_t>(product->bytes)) : Cell();
}

}  // namespace

std::vector<Column> keyframe_columns() {
  using enum ColumnType;
  return {{"keyframe", integer},    {"strip", integer},      {"frame", integer},   {"name", text},
          {"time_s", real},         {"state", text},         {"sigma_x", real},    {"sigma_y", real},
          {"sigma_z", real},        {"rms_px", real},        {"overlap", real},    {"depth", text},
          {"richness", real},       {"novelty", real},       {"newly_seen", real}, {"products", text},
          {"image_bytes", integer}, {"depth_bytes", integer}};
}

std::vector<Cell> keyframe_row(const intake::Keyframe& k, double unit_length) {
  std::vector<Cell> row(keyframe_columns().size());
  row[0] = k.id;
  row[1] = k.strip_id;
  row[3] = k.name;
  row[5] = state_of(k);
  if (k.record) {
    row[2] = k.record->frame_id;
    row[4] = static_cast<double>(k.record->time_ns) / ns_per_s;
    // The first keyframe of a strip overlaps with none.
    if (k.record->index > 0) row[10] = k.record->overlap;
  }
  if (k.posed()) {
    for (std::size_t i = 0; i < 3; ++i) row[6 + i] = unit_length * k.pose->sigma[i];
    row[9] = k.pose->rms_px;
  }
  if (k.depth) {
    row[11] = std::string(words_of(k.depth->verdict));
    const double pixels = static_cast<double>(k.camera.width) * k.camera.height;
    if (pixels > 0) row[14] = k.depth->newly_seen / pixels;
  }
  if (k.richness) {
    row[12] = k.richness->richness;
    row[13] = k.richness->novelty;
  }
  row[15] = products_of(k);
  row[16] = bytes_of(k, ProductKind::image);
  row[17] = bytes_of(k, ProductKind::depth);
  return row;
}

Table keyframe_table(const intake::Flight& flight) {
  Table table;
  table.columns = keyframe_columns();
  using enum ColumnType;
  for (const char* name : {"x", "y", "z", "q_w", "q_x", "q_y", "q_z"}) table.columns.push_back({name, real});
  table.columns.push_back({"unit", text});
  for (const auto& [id, keyframe] : flight.keyframes) {
    std::vector<Cell> row = keyframe_row(keyframe, 1);
    row.resize(table.columns.size());
    if (keyframe.posed()) {
      std::size_t at = keyframe_columns().size();
      for (const double c : keyframe.pose->centre) row[at++] = c;
      for (const double q : keyframe.pose->q_cam_from_world) row[at++] = q;
      const auto strip = flight.strips.find(keyframe.strip_id);
      if (strip != flight.strips.end()) row[at] = std::string(intake::unit_of(flight, strip->second));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace ilp::exports
