#include "sim/ground/fixes/map_check.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <ostream>
#include <stdexcept>

#include "fsw/localisation/map_fix.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/ground/fixes/map_image.hpp"
#include "sim/ground/fixes/view_cells.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::fixes {
namespace {

/// Steps that no keyframe needs: tiles, patches and features are bounded, and so is the number of attempts.
constexpr int most_steps = 1'000'000;

/// Tiles of the directory that the flight could not use, in a sentence; empty where there are none.
std::string missing_tiles(MapSource& source, const MapDirectory& directory) {
  std::vector<std::uint8_t> file(limits::max_map_tile_bytes);
  std::size_t missing = 0, damaged = 0;
  for (const MapTileEntry& entry : directory.tiles) {
    std::size_t size = 0;
    const Status read = source.read_tile({entry.layer, entry.row, entry.column}, file, size);
    const auto bytes = std::span(file).first(read.ok() ? size : 0);
    const bool whole = read.ok() && is_map_tile(directory, entry, bytes);
    if (!whole) ++(read.is(StatusCode::not_found) ? missing : damaged);
  }
  if (missing + damaged == 0) return "";
  return "Of " + host::counted(directory.tiles.size(), "tile") + " that " + map_directory_name + " names, " +
         std::to_string(missing) + " are not in the folder and " + std::to_string(damaged) +
         " are damaged or of another map: they count as holes";
}

/// The stage with a store of its own, which holds what it reads.
class Stage {
 public:
  Stage(const MissionParameters& mission, MapSource& source, std::size_t keyframes, std::size_t largest_image)
      : region_(capacity(keyframes, largest_image)),
        store_(region_),
        memory_(std::make_unique<StepMemory<MapFix>>()),
        stage_(std::make_unique<MapFix>(store_, mission, *memory_, &source)) {
    const Status status = stage_->restore();
    if (!restored(status)) host::require(status, "the stage that localises keyframes");
  }

  /// The record of the keyframe, whose image and cells are released again.
  FixRecord localise(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                     const std::vector<float>& cells, std::vector<std::string>& events) {
    put_records(keyframe, rasters, cells);
    run(events);
    FixRecord fix;
    host::require(get(store_, keyframe.id, fix), "the fix of keyframe " + std::to_string(keyframe.id));
    FrameRecord frame;
    frame.id = keyframe.id;
    DepthRecord depth;
    depth.id = keyframe.id;
    change([&] {
      host::require(put(store_, frame), "releasing an image");
      host::require(put(store_, depth), "releasing depths");
    });
    return fix;
  }

 private:
  static std::size_t capacity(std::size_t keyframes, std::size_t largest_image) {
    constexpr std::size_t fixed = std::size_t{8} << 20, each = 16384;
    return fixed + each * keyframes + 4 * largest_image;
  }

  static PoseRecord pose_of(const intake::Keyframe& keyframe) {
    PoseRecord pose = *keyframe.pose;
    pose.id = keyframe.id;
    pose.strip_id = keyframe.strip_id;
    return pose;
  }

  template <typename Work>
  void change(Work work) {
    Transaction transaction(store_);
    host::require(transaction.begin(), "the store of the check");
    work();
    host::require(transaction.commit(), "the store of the check");
  }

  void put_records(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                   const std::vector<float>& cells) {
    CameraRecord camera = camera_record(keyframe.camera);
    camera.frozen = true;
    KeyframeRecord record = *keyframe.record;
    record.frame_id = keyframe.id;
    record.strip_id = keyframe.strip_id;
    FrameRecord frame;
    frame.id = keyframe.id;
    frame.time_ns = record.time_ns;
    frame.width = rasters.image.width;
    frame.height = rasters.image.height;
    frame.image.bytes = static_cast<std::uint32_t>(rasters.image.samples.size());
    DepthRecord depth = keyframe.depth.value_or(DepthRecord{});
    depth.id = keyframe.id;
    depth.strip_id = keyframe.strip_id;
    depth.values.bytes = depth.sigma.bytes = 0;
    depth.cells.bytes = static_cast<std::uint32_t>(cells.size() * (1 + sizeof(float)));
    NavigationRecord navigation = keyframe.navigation.value_or(NavigationRecord{});
    navigation.id = keyframe.id;
    change([&] {
      const std::string what = "the records of keyframe " + std::to_string(keyframe.id);
      host::require(put_camera(store_, camera), what);
      host::require(put(store_, record), what);
      host::require(put(store_, frame), what);
      if (frame.image.bytes != 0)
        host::require(write_blob<FrameRecord>(store_, "image", frame.id, 0, rasters.image.samples), what);
      if (keyframe.pose) host::require(put(store_, pose_of(keyframe)), what);
      host::require(put(store_, navigation), what);
      host::require(put(store_, depth), what);
      if (cells.empty()) return;
      const auto* const bytes = reinterpret_cast<const std::uint8_t*>(cells.data());
      host::require(write_blob<DepthRecord>(store_, "cells", depth.id, cells.size(),
                                            std::span(bytes, cells.size() * sizeof(float))),
                    what);
    });
  }

  void run(std::vector<std::string>& events) {
    for (int i = 0; i < most_steps; ++i) {
      const StepResult result = stage_->step();
      // Every keyframe over a damaged tile finds it again.
      const std::string sentence = result.status.ok() ? "" : host::status_sentence(result.status);
      if (!sentence.empty() && std::find(events.begin(), events.end(), sentence) == events.end())
        events.push_back(sentence);
      if (result.then == Then::restore) {
        const Status status = stage_->restore();
        if (!restored(status)) host::require(status, "the stage that localises keyframes");
      }
      if (!result.pending) return;
    }
    throw std::runtime_error("the stage that localises keyframes does not end");
  }

  std::vector<std::byte> region_;
  RamStore store_;
  std::unique_ptr<StepMemory<MapFix>> memory_;
  std::unique_ptr<MapFix> stage_;
};

/// Empty where the image cannot be used with the keyframe's camera.
intake::KeyframeRasters rasters_of(const intake::Keyframe& keyframe) {
  intake::KeyframeRasters rasters = intake::decode_products(keyframe).rasters;
  const CameraModel& camera = keyframe.camera;
  const bool fits = validate(camera).ok() && rasters.image.same_size(camera.width, camera.height);
  if (!fits) rasters.image = {};
  if (!fits || !rasters.inverse_depth.same_size(camera.width, camera.height)) rasters.inverse_depth = {};
  return rasters;
}

std::size_t largest_image(const intake::Flight& flight) {
  std::size_t largest = 0;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!validate(keyframe.camera).ok()) continue;
    largest = std::max(
        largest, static_cast<std::size_t>(keyframe.camera.width) * static_cast<std::size_t>(keyframe.camera.height));
  }
  return largest;
}

void localise_all(intake::Flight& flight, const MissionParameters& mission, MapSource& source,
                  std::vector<std::string>& events, std::ostream& messages) {
  const auto stage = std::make_unique<Stage>(mission, source, flight.keyframes.size(), largest_image(flight));
  host::Progress progress(messages, "Localising keyframes");
  ViewCells seen;
  std::size_t done = 0;
  for (auto& [id, keyframe] : flight.keyframes) {
    keyframe.fix.reset();
    progress(++done, flight.keyframes.size());
    // Its file did not come.
    if (!keyframe.record || keyframe.camera.width == 0) continue;
    const intake::KeyframeRasters rasters = rasters_of(keyframe);
    const bool usable = keyframe.posed() && !rasters.image.empty();
    const std::vector<float> cells = usable ? seen.add(keyframe, rasters) : std::vector<float>{};
    keyframe.fix = stage->localise(keyframe, rasters, cells, events);
  }
}

}  // namespace

MapCheck check_map(const MapCheckOptions& options, std::ostream& messages) {
  DirectoryMapSource source;
  host::require(source.open(options.map.c_str()), "map " + options.map.string());
  source.require_key(options.key);
  const auto directory = std::make_unique<MapDirectory>();
  MapCheck check;
  read_map_directory(source, options.map, *directory);
  check.body = directory->body;
  if (std::string holes = missing_tiles(source, *directory); !holes.empty()) check.events.push_back(std::move(holes));
  MissionParameters mission = options.mission;
  if (!options.any_body && mission.body != check.body) {
    throw std::runtime_error("the map shows " + std::string(name_of(check.body)) + ", but the mission names " +
                             name_of(mission.body) + ": correct [navigation] body in the mission file");
  }
  mission.body = check.body;
  mission.use_map = true;
  mission.safe_mode = false;
  intake::Outbox outbox = intake::read_outbox(options.outbox);
  intake::Flight flight = intake::index_flight(outbox);
  if (flight.keyframes.empty())
    throw std::runtime_error(options.outbox.string() +
                             " has no keyframe: name the folder with the files that came down");
  check.in_flight = fixes_of(flight);
  localise_all(flight, mission, source, check.events, messages);
  check.fixes = fixes_of(flight);
  return check;
}

}  // namespace ilp::fixes
