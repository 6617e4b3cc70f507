#include "sim/ground/tasks/work_package.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/ground/map/keyframe_quick_look.hpp"
#include "sim/ground/tasks/sealed_block.hpp"

namespace ilp::tasks {
namespace {

using intake::Keyframe;
using nlohmann::json;

constexpr std::array<const char*, 3> kind_names = {"looks", "tiles", "finish"};

json as_json(const Keyframe& keyframe) {
  const CameraModel& c = keyframe.camera;
  const CameraNumbers numbers = camera_numbers(c);
  json value = {
      {"id", keyframe.id},
      {"products", {json::binary(keyframe.product_files[0].bytes()), json::binary(keyframe.product_files[1].bytes())}},
      {"mask", json::binary(keyframe.coded_mask.bytes())},
      {"mask_size", {keyframe.mask_width, keyframe.mask_height}},
      {"camera", std::vector<double>(numbers.span().begin(), numbers.span().end())},
      {"size", {c.width, c.height}},
      {"depth_scale", keyframe.depth_scale},
      {"digest", map::keyframe_digest(keyframe)}};
  if (keyframe.posed()) value["pose"] = {keyframe.pose->q_cam_from_world, keyframe.pose->centre};
  return value;
}

CameraModel camera_from(const json& numbers, const json& size) {
  const auto values = numbers.get<std::vector<double>>();
  if (values.size() != CameraNumbers::plain && values.size() != CameraNumbers::most)
    throw std::runtime_error("a camera has 8 or 13 numbers, not " + std::to_string(values.size()));
  return camera_of_numbers(size.at(0).get<std::int32_t>(), size.at(1).get<std::int32_t>(), values);
}

Keyframe keyframe_from(const json& value) {
  Keyframe keyframe;
  value.at("id").get_to(keyframe.id);
  for (std::size_t kind = 0; kind < 2; ++kind) {
    keyframe.product_files[kind] = value.at("products").at(kind).get_binary();
  }
  keyframe.coded_mask = std::vector<std::uint8_t>(value.at("mask").get_binary());
  value.at("mask_size").at(0).get_to(keyframe.mask_width);
  value.at("mask_size").at(1).get_to(keyframe.mask_height);
  keyframe.camera = camera_from(value.at("camera"), value.at("size"));
  value.at("depth_scale").get_to(keyframe.depth_scale);
  if (value.contains("pose")) {
    PoseRecord& pose = keyframe.pose.emplace();
    pose.state = PoseState::final;
    for (std::size_t i = 0; i < 4; ++i) value.at("pose").at(0).at(i).get_to(pose.q_cam_from_world[i]);
    for (std::size_t i = 0; i < 3; ++i) value.at("pose").at(1).at(i).get_to(pose.centre[i]);
  }
  // Also finds a package that another version of the program has written.
  if (map::keyframe_digest(keyframe) != value.at("digest").get<std::uint64_t>())
    throw std::runtime_error("a keyframe is not what the plan says");
  return keyframe;
}

json as_json(const std::vector<Keyframe>& keyframes) {
  json list = json::array();
  for (const Keyframe& keyframe : keyframes) list.push_back(as_json(keyframe));
  return list;
}

std::vector<Keyframe> keyframes_from(const json& list) {
  std::vector<Keyframe> keyframes;
  for (const json& value : list) keyframes.push_back(keyframe_from(value));
  return keyframes;
}

intake::TilePlace place_from(const json& value) {
  return {value.at(0).get<std::int32_t>(), value.at(1).get<std::int32_t>()};
}

json as_json(const QuickLookBlock& block) {
  return {{"kind", "looks"}, {"width", block.width_px}, {"keyframes", as_json(block.keyframes)}};
}

json as_json(const TileBlock& block) {
  json tiles = json::array();
  for (const map::TilePlan& tile : block.tiles) {
    tiles.push_back(
        {{"place", {tile.place.column, tile.place.row}}, {"keyframes", tile.keyframes}, {"digest", tile.digest}});
  }
  return {{"kind", "tiles"},
          {"strip", block.strip_id},
          {"cell", block.cell},
          {"tiles", tiles},
          {"keyframes", as_json(block.keyframes)}};
}

json as_json(const std::vector<map::Balance>& balance) {
  json list = json::array();
  for (const map::Balance& one : balance) list.push_back({one.gain, one.offset, one.ramp, one.middle});
  return list;
}

json as_json(const FinishBlock& block) {
  json tiles = json::array();
  for (std::size_t i = 0; i < block.tiles.size(); ++i) {
    const map::TileFinish& tile = block.tiles[i];
    tiles.push_back({{"place", {tile.place.column, tile.place.row}},
                     {"painted", tile.painted},
                     {"digest", tile.digest},
                     {"keyframes", tile.keyframes},
                     {"balance", as_json(tile.balance)},
                     {"cells", json::binary(block.painted[i])}});
  }
  return {{"kind", "finish"}, {"strip", block.strip_id}, {"cell", block.cell}, {"tiles", tiles}};
}

QuickLookBlock quick_looks_from(const json& value) {
  return {value.at("width").get<std::int32_t>(), keyframes_from(value.at("keyframes"))};
}

TileBlock tiles_from(const json& value) {
  TileBlock block{value.at("strip").get<std::int64_t>(), value.at("cell").get<double>(), {}, {}};
  for (const json& tile : value.at("tiles")) {
    block.tiles.push_back({place_from(tile.at("place")), tile.at("keyframes").get<std::vector<std::int64_t>>(),
                           tile.at("digest").get<std::uint64_t>()});
  }
  block.keyframes = keyframes_from(value.at("keyframes"));
  return block;
}

std::vector<map::Balance> balance_from(const json& value) {
  std::vector<map::Balance> balance;
  for (const json& one : value) balance.push_back({one.at(0), one.at(1), one.at(2), one.at(3)});
  return balance;
}

FinishBlock finish_from(const json& value) {
  FinishBlock block{value.at("strip").get<std::int64_t>(), value.at("cell").get<double>(), {}, {}};
  for (const json& tile : value.at("tiles")) {
    block.tiles.push_back({place_from(tile.at("place")), tile.at("painted").get<std::uint64_t>(),
                           tile.at("digest").get<std::uint64_t>(),
                           tile.at("keyframes").get<std::vector<std::int64_t>>(), balance_from(tile.at("balance"))});
    block.painted.push_back(tile.at("cells").get_binary());
  }
  return block;
}

Block block_from(const json& value) {
  const auto kind = value.at("kind").get<std::string>();
  if (kind == "looks") return quick_looks_from(value);
  if (kind == "tiles") return tiles_from(value);
  if (kind == "finish") return finish_from(value);
  throw std::runtime_error("unknown kind of work: " + kind);
}

}  // namespace

const char* name_of(WorkKind kind) {
  return kind_names.at(static_cast<std::size_t>(kind));
}

std::optional<WorkKind> kind_of(const std::string& name) {
  for (const WorkKind kind : {WorkKind::quick_looks, WorkKind::tiles, WorkKind::finish}) {
    if (name == name_of(kind)) return kind;
  }
  return std::nullopt;
}

PackageWriter::PackageWriter(std::filesystem::path file)
    : file_(std::move(file)), part_(file_.string() + ".part"), stream_(part_, std::ios::binary) {}

void PackageWriter::add(const Block& block) {
  write_block(stream_, json::to_cbor(std::visit([](const auto& kind) { return as_json(kind); }, block)));
}

void PackageWriter::close() {
  stream_.close();
  if (!stream_) throw std::runtime_error("cannot write " + part_.string());
  std::filesystem::rename(part_, file_);
}

PackageReader::PackageReader(const std::filesystem::path& file) : file_(file), stream_(file, std::ios::binary) {
  if (!stream_) throw std::runtime_error("cannot read " + file.string());
}

std::optional<Block> PackageReader::next() {
  try {
    const auto bytes = read_block(stream_);
    return bytes ? std::optional(block_from(json::from_cbor(*bytes))) : std::nullopt;
  } catch (const std::exception& fault) {
    throw std::runtime_error(file_.string() + ": " + fault.what());
  }
}

}  // namespace ilp::tasks
