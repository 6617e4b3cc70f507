// pose-strip: runs the onboard chain on a folder of images up to final poses and links, without products and downlink,
// and joins the strips as the ground does.

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "cfg/mission.hpp"
#include "fsw/records/serial.hpp"
#include "fsw/shared/frame_access.hpp"
#include "hal/camera/directory/directory_camera.hpp"
#include "hal/clock/virtual_clock.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "sim/ground/export/colmap_model.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "sim/host/camera_file.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/strip.hpp"
#include "sim/host/text_format.hpp"
#include "sim/sil/flyable_images.hpp"
#include "sim/tools/lab/input_files.hpp"
#include "sim/tools/lab/lab.hpp"
#include "sim/tools/lab/stage_range.hpp"

namespace ilp::lab {
namespace fs = std::filesystem;
namespace {

struct PoseStripOptions {
  std::string folder, camera, out, mission;
  double target_overlap = 0;  ///< 0: the mission's
  bool apart = false;         ///< strips stay as they are on board
};

/// A folder of its own that goes when the command ends.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "ilp-lab-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create a folder " + name);
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

using KeyframeImage = host::Raster<std::uint8_t>;

struct PosedStrip {
  intake::Outbox records;
  std::map<std::int64_t, KeyframeImage> images;  ///< by keyframe
  double overlap_ms = 0, motion_ms = 0;
};

Status write_camera(Store& store, const CameraModel& camera) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, camera_record(camera)));
  return transaction.commit();
}

/// With the bytes of its blobs; frames come without their images.
intake::RecordEntry entry_of(Store& store, const RecordInfo& info, const void* record, std::int64_t id) {
  intake::RecordEntry entry{info.type, std::vector<std::uint8_t>(serial_bytes(info)), {}};
  host::require(serialize(info, record, entry.serial), "reading the store");
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type != FieldType::blob) continue;
    Blob blob;
    std::memcpy(&blob, static_cast<const std::uint8_t*>(record) + field.offset, sizeof(blob));
    std::vector<std::uint8_t> bytes(info.type == RecordType::frame ? 0 : blob.bytes);
    if (!bytes.empty()) host::require(store.read_blob(info, field.name, id, 0, bytes), "reading the store");
    entry.blobs.push_back(std::move(bytes));
  }
  return entry;
}

void collect(Store& store, intake::Outbox& outbox) {
  for (const RecordType type :
       {RecordType::camera, RecordType::frame, RecordType::overlap, RecordType::strip, RecordType::keyframe,
        RecordType::pose, RecordType::structure, RecordType::link, RecordType::tie, RecordType::event}) {
    const RecordInfo& info = record_info(type);
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    std::int64_t id = 0;
    Status found;
    while ((found = store.next(info, id, record)).ok()) {
      std::memcpy(&id, record, sizeof(id));
      outbox.records.push_back(entry_of(store, info, record, id));
    }
    if (!found.is(StatusCode::not_found)) host::require(found, "reading the store");
  }
}

std::map<std::int64_t, KeyframeImage> keyframe_images(Store& store) {
  std::map<std::int64_t, KeyframeImage> images;
  const auto image = std::make_unique<FrameImage>();
  KeyframeRecord keyframe;
  Status found;
  while ((found = next(store, keyframe.id, keyframe)).ok()) {
    host::require(load_frame_image(store, keyframe.frame_id, *image), "reading the store");
    KeyframeImage& copy = images.emplace(keyframe.id, KeyframeImage(image->width(), image->height())).first->second;
    std::copy_n(image->view().data, copy.samples.size(), copy.samples.begin());
  }
  if (!found.is(StatusCode::not_found)) host::require(found, "reading the store");
  return images;
}

PosedStrip pose_strip(const fs::path& index, std::size_t frames, const CameraModel& model, MissionParameters mission,
                      bool apart) {
  // Images and depths stay, as nothing turns them into products. Only what is used becomes real memory.
  const std::size_t frame_bytes =
      8 * static_cast<std::size_t>(model.width) * static_cast<std::size_t>(model.height) + 65536;
  const std::size_t region_bytes = (std::size_t{512} << 20U) + frames * frame_bytes;
  const auto region = std::make_unique_for_overwrite<std::byte[]>(region_bytes);
  RamStore store({region.get(), region_bytes});
  DirectoryCamera camera;
  host::require(camera.open(index.c_str(), model.width, model.height, host::decode_image), "opening " + index.string());
  VirtualClock clock;
  // The camera is given, so that nobody calibrates it. Links between strips need depths.
  std::vector<std::string> names = {"capture_clock", "acquisition", "overlap_checker", "structure_and_motion"};
  if (!apart) names.insert(names.end(), {"dense_matcher", "place_memory"});
  StageRange stages(names, {store, clock, mission, &camera});
  host::require(write_camera(store, model), "writing the camera");
  Executive& executive = stages.executive();
  host::require(executive.start(), "starting the flight software");
  TimeNs next = 0;
  do {
    executive.run_minor_frame();
    next += minor_frame_ns;
    clock.sleep_until(next);
  } while (!stages.camera_ended() || !executive.idle());

  PosedStrip posed;
  posed.overlap_ms = 1e-6 * static_cast<double>(executive.stats(ComponentId::overlap_checker).busy_ns);
  posed.motion_ms = 1e-6 * static_cast<double>(executive.stats(ComponentId::structure_and_motion).busy_ns);
  collect(store, posed.records);
  if (!apart) posed.images = keyframe_images(store);
  return posed;
}

MissionParameters mission_for(const PoseStripOptions& options) {
  MissionParameters mission = host::read_mission(options.mission);
  if (options.target_overlap > 0) mission.target_overlap = options.target_overlap;
  host::require(validate(mission), "mission parameters");
  return mission;
}

std::size_t posed_count(const intake::Flight& flight, const intake::Strip& strip) {
  return static_cast<std::size_t>(std::count_if(strip.keyframes.begin(), strip.keyframes.end(),
                                                [&](std::int64_t id) { return flight.keyframes.at(id).posed(); }));
}

/// The strip with most poses into `folder`, further ones into `folder`/strip-ID.
Json write_models(const intake::Flight& flight, const fs::path& folder) {
  const intake::Strip* longest = nullptr;
  for (const auto& [id, strip] : flight.strips) {
    if (longest == nullptr || posed_count(flight, strip) > posed_count(flight, *longest)) longest = &strip;
  }
  Json strips = Json::array();
  for (const auto& [id, strip] : flight.strips) {
    if (strip.keyframes.empty()) continue;  // joined to another one
    const fs::path place = &strip == longest ? folder : folder / ("strip-" + std::to_string(id));
    const exports::ColmapCounts counts = exports::write_colmap_model(flight, strip, place);
    strips.push_back({{"strip", id},
                      {"keyframes", strip.keyframes.size()},
                      {"images", counts.images},
                      {"points", counts.points},
                      {"observations", counts.observations},
                      {"model", counts.images > 0 ? Json(place.string()) : Json()}});
  }
  return strips;
}

/// Of the images that fly. The camera file is that of the photographs as they came, or of those.
CameraModel camera_of(const sil::FlyableImages& images, CameraModel camera) {
  if (images.frames.empty()) throw std::runtime_error("no image can be used");
  if (images.binning > 1 && images.source == host::ImageSize{camera.width, camera.height})
    camera = sil::binned_camera(camera, images.binning);
  const fs::path& first = images.frames.front().file;
  const host::ImageSize size = host::read_image_size(first);
  return host::camera_for_size(camera, size.width, size.height, first.string() + " has", std::cerr);
}

/// Records and images of joined strips as the ground joins those that came down.
Json join(std::map<std::int64_t, KeyframeImage>& images, intake::Flight& flight) {
  for (auto& [id, image] : images) flight.keyframes.at(id).image = std::move(image);
  const model::JoinedFlight joined = model::join_strips(flight, [](const std::string&) {});
  Json models = Json::array();
  for (const model::JoinedModel& one : joined.models) {
    models.push_back({{"strip", one.strip_id},
                      {"strips", one.strips},
                      {"keyframes", one.members.size()},
                      {"links", one.links.size()},
                      {"median_error_px", one.median_error_px}});
  }
  return models;
}

Json run_pose_strip(const PoseStripOptions& options, int repeat) {
  const MissionParameters mission = mission_for(options);
  const std::vector<host::StripFrame> listed = host::list_strip(options.folder);
  const CameraModel given = host::read_global_shutter_camera(options.camera);
  const TemporaryFolder temporary;
  sil::FlyableImages flyable =
      sil::make_flyable(listed, temporary.path() / "images", std::cerr, host::ImageSize{given.width, given.height});
  const CameraModel model = camera_of(flyable, given);
  std::vector<host::StripFrame>& frames = flyable.frames;
  for (host::StripFrame& frame : frames) frame.file = fs::absolute(frame.file);
  const fs::path index = temporary.path() / "frames.txt";
  host::write_strip_index(index, frames);

  PosedStrip posed;
  std::vector<double> overlap_ms, motion_ms, kernel_ms;
  for (int run = 0; run < (repeat > 1 ? repeat + 1 : 1); ++run) {
    posed = pose_strip(index, frames.size(), model, mission, options.apart);
    if (repeat > 1 && run == 0) continue;
    overlap_ms.push_back(posed.overlap_ms);
    motion_ms.push_back(posed.motion_ms);
    kernel_ms.push_back(posed.overlap_ms + posed.motion_ms);
  }
  intake::Flight flight = intake::build_flight(posed.records);
  const Json joined = options.apart ? Json::array() : join(posed.images, flight);
  std::size_t images = 0, points = 0;
  Json strips = write_models(flight, options.out);
  for (const Json& strip : strips) {
    images += strip["images"].get<std::size_t>();
    points += strip["points"].get<std::size_t>();
  }
  Json events = Json::array();
  for (const EventRecord& event : flight.events) {
    const Status status(static_cast<StatusCode>(event.code), event.a, event.b);
    if (is_status_code(event.code)) events.push_back(host::describe(status));
  }
  return {{"verdict", images > 0 ? "ok" : "no_pose"},
          {"frames", frames.size()},
          {"keyframes", flight.keyframes.size()},
          {"images", images},
          {"points", points},
          {"strips", strips},
          {"joined", joined},
          {"events", events},
          {"overlap_ms", median(overlap_ms)},
          {"motion_ms", median(motion_ms)},
          {"kernel_ms", median(kernel_ms)}};
}

}  // namespace

void add_pose_strip_command(Lab& lab) {
  const auto options = std::make_shared<PoseStripOptions>();
  CLI::App& app = lab.add("pose-strip", "camera poses and points of a folder of images, as a COLMAP text model",
                          "images --camera cameras.txt --out model",
                          [options](int repeat) { return run_pose_strip(*options, repeat); });
  app.add_option("DIR", options->folder, "folder of PNG, PGM, JPEG or TIFF images, as sim/fly --images takes them")
      ->required();
  app.add_option("--camera", options->camera, "intrinsics, cameras.txt")->required();
  app.add_option("--mission", options->mission, "mission parameters, an .ini file");
  app.add_option("--target-overlap", options->target_overlap,
                 "a frame at or below it becomes a keyframe (default: the mission's); 0.98 takes nearly every image")
      ->check(finite_in(0.5, 0.98))
      ->default_str("");
  app.add_flag("--apart", options->apart,
               "strips stay as they are on board: no dense matching, no links, no joining on the ground");
  app.add_option("--out", options->out, "folder for cameras.txt, images.txt, points3D.txt")->required();
}

}  // namespace ilp::lab
