#include "sim/ground/intake/flight_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include "fsw/base/crc.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/intake/level_strips.hpp"
#include "sim/ground/intake/move_keyframe.hpp"
#include "sim/ground/intake/valid_links.hpp"
#include "sim/host/files.hpp"

namespace ilp::intake {
namespace {

/// Places of records in a list, by id.
using Places = std::map<std::int64_t, std::size_t>;

template <typename Record>
void keep_by_id(std::vector<Record>& records, const Record& record, Places& places) {
  const auto [place, is_new] = places.emplace(record.id, records.size());
  if (is_new) {
    records.push_back(record);
  } else {
    records[place->second] = record;
  }
}

template <typename Record>
void sort_by_id(std::vector<Record>& records) {
  std::sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.id < b.id; });
}

std::vector<StructureTrackPoint> parse_points(std::span<const std::uint8_t> blob, std::uint32_t count) {
  std::vector<StructureTrackPoint> points;
  std::size_t at = 0;
  const auto take = [&](void* to, std::size_t bytes) {
    if (bytes > blob.size() - at) throw BadFile("the structure blob ends inside a point");
    std::memcpy(to, blob.data() + at, bytes);
    at += bytes;
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    StructureTrackPoint track;
    take(&track.point, sizeof(track.point));
    for (std::uint32_t o = 0; o < track.point.observations; ++o) {
      StructureObservation observation;
      take(&observation, sizeof(observation));
      track.observations.push_back(observation);
    }
    points.push_back(std::move(track));
  }
  return points;
}

bool plausible(const PoseRecord& pose) {
  double length2 = 0;
  for (const double q : pose.q_cam_from_world) length2 += q * q;
  bool finite = std::isfinite(length2);
  for (const double c : pose.centre) finite = finite && std::fabs(c) < largest_coordinate;
  return finite && std::fabs(length2 - 1) < 1e-3;
}

class FlightBuilder {
 public:
  explicit FlightBuilder(Flight& flight) : flight_(flight) {}

  void add(const RecordEntry& entry);
  void add(ReceivedProduct& received, ReceivedFile& file);
  void finish();

 private:
  Keyframe& keyframe(std::int64_t id) {
    Keyframe& k = flight_.keyframes[id];
    k.id = id;
    return k;
  }
  void add_camera(const CameraRecord& record);
  void add_pose(const PoseRecord& record);
  void add_component(const ComponentRecord& record);
  void add_storage(const StorageRecord& record);
  void add_strip(const StripRecord& record);
  void add_strip_frame(const StripFrameRecord& record);
  void add_structure(const RecordEntry& entry);
  void add_mask(const RecordEntry& entry);
  void add_link(const RecordEntry& entry);
  void add_product_record(const ProductRecord& record);
  void check_depth(Keyframe& k, const ProductHeader& header);
  void complete(Keyframe& k);

  [[nodiscard]] std::int64_t all_busy_ns() const {
    std::int64_t sum = 0;
    for (const auto& [id, busy_ns] : busy_ns_) sum += busy_ns;
    return sum;
  }

  Flight& flight_;
  Places links_, events_, components_, ties_;
  std::map<std::int64_t, std::int64_t> busy_ns_;  ///< by component, as last read
  std::map<std::int64_t, OverlapRecord> overlaps_;
  std::map<std::int64_t, ProductHeader> depth_headers_;
  std::map<std::int64_t, Metadata> metadata_;
};

void FlightBuilder::add_structure(const RecordEntry& entry) {
  const auto record = record_of<StructureRecord>(entry);
  Keyframe& k = keyframe(record.id);
  try {
    (void)parse_points(entry.blobs[0].bytes(), record.count);
    k.coded_points = entry.blobs[0];
    k.structure = record;
  } catch (const BadFile& fault) {
    flight_.remarks.push_back("keyframe " + std::to_string(record.id) + ": " + fault.what());
  }
}

void FlightBuilder::add_mask(const RecordEntry& entry) {
  const auto record = record_of<MaskRecord>(entry);
  Keyframe& k = keyframe(record.id);
  k.mask_record = record;
  const CodedFile& coded = entry.blobs[0];
  if (coded.empty() || record.width <= 0 || record.height <= 0 || record.width > limits::max_image_side ||
      record.height > limits::max_image_side) {
    return;
  }
  host::Raster<std::uint8_t> mask(record.width, record.height);
  const std::vector<std::uint8_t> bytes = coded.bytes();
  if (decode_mask(bytes.data(), bytes.size(), mask.view()).ok()) {
    k.coded_mask = coded;
    k.mask_width = record.width;
    k.mask_height = record.height;
  } else {
    flight_.remarks.push_back("keyframe " + std::to_string(record.id) + ": its mask is malformed");
  }
}

void FlightBuilder::add_link(const RecordEntry& entry) {
  const auto record = record_of<LinkRecord>(entry);
  keep_by_id(flight_.links, record, links_);
  std::vector<LinkPoint>& points = flight_.link_points[record.id];
  const std::vector<std::uint8_t> bytes = entry.blobs[0].bytes();
  points.resize(bytes.size() / sizeof(LinkPoint));
  if (!points.empty()) std::memcpy(points.data(), bytes.data(), points.size() * sizeof(LinkPoint));
}

void FlightBuilder::add_strip(const StripRecord& record) {
  std::optional<StripRecord>& known = flight_.strips[record.id].record;
  // Every keyframe's file repeats its strip, as it was when the file was sent.
  const bool newer = !known || record.last_keyframe_id > known->last_keyframe_id ||
                     (record.last_keyframe_id == known->last_keyframe_id && record.end != StripEnd::open);
  if (newer) known = record;
}

void FlightBuilder::add_strip_frame(const StripFrameRecord& record) {
  std::optional<StripFrameRecord>& known = flight_.strips[record.id].frame;
  if (!known || record.through_keyframe_id > known->through_keyframe_id) known = record;
}

void FlightBuilder::add_camera(const CameraRecord& record) {
  // Files that went before the camera was calibrated carry the nominal one.
  if (flight_.camera_record && flight_.camera_record->frozen && !record.frozen) return;
  flight_.camera_record = record;
  flight_.camera = camera_model(record);
}

void FlightBuilder::add_product_record(const ProductRecord& record) {
  const auto kind = static_cast<std::size_t>(record.kind);
  if (kind < 2) keyframe(record.keyframe_id).product_records[kind] = record;
}

void FlightBuilder::add(const RecordEntry& entry) {
  const auto into = [&entry]<typename Record>(std::map<std::int64_t, Record>& map) {
    const auto record = record_of<Record>(entry);
    map[record.id] = record;
  };
  const auto into_keyframe = [this, &entry]<typename Record>(std::optional<Record> Keyframe::*part) {
    const auto record = record_of<Record>(entry);
    keyframe(record.id).*part = record;
  };
  switch (entry.type) {
    // clang-format off
    case RecordType::camera: return add_camera(record_of<CameraRecord>(entry));
    case RecordType::calibration: return into(flight_.calibrations);
    case RecordType::calibration_check: return into(flight_.camera_checks);
    case RecordType::strip: return add_strip(record_of<StripRecord>(entry));
    case RecordType::keyframe: return into_keyframe(&Keyframe::record);
    case RecordType::overlap: return into(flight_.overlaps);
    case RecordType::pose: return add_pose(record_of<PoseRecord>(entry));
    case RecordType::structure: return add_structure(entry);
    case RecordType::depth: return into_keyframe(&Keyframe::depth);
    case RecordType::mask: return add_mask(entry);
    case RecordType::navigation: return into_keyframe(&Keyframe::navigation);
    case RecordType::fix: return into_keyframe(&Keyframe::fix);
    case RecordType::strip_frame: return add_strip_frame(record_of<StripFrameRecord>(entry));
    case RecordType::richness: return into_keyframe(&Keyframe::richness);
    case RecordType::product: return add_product_record(record_of<ProductRecord>(entry));
    case RecordType::event: return keep_by_id(flight_.events, record_of<EventRecord>(entry), events_);
    case RecordType::component: return add_component(record_of<ComponentRecord>(entry));
    case RecordType::link: return add_link(entry);
    case RecordType::tie: return keep_by_id(flight_.ties, record_of<TieRecord>(entry), ties_);
    case RecordType::timing: flight_.timing = record_of<TimingRecord>(entry); return;
    case RecordType::storage: return add_storage(record_of<StorageRecord>(entry));
    case RecordType::frame: return into(flight_.frames);
    case RecordType::capture: return into(flight_.captures);
    default: return;
      // clang-format on
  }
}

void FlightBuilder::add_pose(const PoseRecord& record) {
  Keyframe& k = keyframe(record.id);
  if (!k.posed()) k.pose = record;
}

void FlightBuilder::add_component(const ComponentRecord& record) {
  busy_ns_[record.id] = record.busy_ns;
  keep_by_id(flight_.components, record, components_);
}

void FlightBuilder::add_storage(const StorageRecord& record) {
  flight_.storage = record;
  // The components stand before it in a file.
  flight_.housekeeping.push_back({record, all_busy_ns()});
}

void FlightBuilder::add(ReceivedProduct& received, ReceivedFile& file) {
  const std::vector<std::uint8_t> bytes = received.bytes.bytes();
  const ProductHeader header = read_product_header(bytes);
  const auto stated = header.metadata.id("keyframe");
  if (!stated || *stated != received.keyframe_id)
    throw BadFile("its metadata name another keyframe than its file name");
  const auto kind = static_cast<std::size_t>(received.kind);
  Keyframe& k = keyframe(received.keyframe_id);
  const auto time = header.metadata.integer("time_ns");
  if (k.record && time && *time != k.record->time_ns) {
    throw BadFile("of another flight: taken at another time than its keyframe's record says");
  }

  ProductAccount account;
  account.file = file.name;
  account.bytes = bytes.size();
  account.layers = header.layers;
  if (const auto grant = header.metadata.integer("grant_bytes"); grant && *grant > 0) {
    account.grant_bytes = static_cast<std::uint32_t>(*grant);
  }
  if (const auto& record = k.product_records[kind]) {
    account.grant_bytes = record->grant_bytes;
    account.scheme = record->scheme;
    // Fewer bytes than coded are a product cut at a layer; as many bytes with another sum are damage.
    if (record->bytes == account.bytes && record->crc32 != crc32(bytes)) {
      throw BadFile("checksum differs from the product record: damaged in transfer");
    }
  }
  k.products[kind] = account;
  k.product_files[kind] = std::move(received.bytes);
  metadata_[k.id] = header.metadata;
  if (received.kind == ProductKind::depth) depth_headers_[k.id] = header;
}

/// A depth map is used with its scale and its mask only.
void FlightBuilder::check_depth(Keyframe& k, const ProductHeader& header) {
  const std::string subject = "keyframe " + std::to_string(k.id) + ": ";
  if (!depth_scale_of(header.metadata)) {
    flight_.remarks.push_back(subject + "the depth product does not state its scale");
    k.product_files[static_cast<std::size_t>(ProductKind::depth)].clear();
  } else if (k.mask_width != header.width || k.mask_height != header.height) {
    flight_.remarks.push_back(subject +
                              "no mask came for its depth; outside it samples say nothing, and none is taken");
    k.coded_mask.clear();
  }
}

void FlightBuilder::complete(Keyframe& k) {
  const auto product = metadata_.find(k.id);
  const Metadata metadata = product == metadata_.end() ? Metadata() : product->second;

  if (k.record) k.strip_id = k.record->strip_id;
  if (!k.pose) k.pose = pose_record_of(metadata);
  if (k.pose && k.pose->state == PoseState::final && !plausible(*k.pose)) {
    flight_.remarks.push_back("keyframe " + std::to_string(k.id) + ": its pose is not a pose");
    k.pose->state = PoseState::failed;
  }
  if (k.strip_id == 0 && k.pose) k.strip_id = k.pose->strip_id;
  if (k.strip_id == 0) k.strip_id = metadata.id("strip").value_or(0);

  if (k.record) {
    if (const auto overlap = flight_.overlaps.find(k.record->frame_id); overlap != flight_.overlaps.end()) {
      k.overlap = overlap->second;
    }
    if (const auto frame = flight_.frames.find(k.record->frame_id); frame != flight_.frames.end()) {
      k.name = host::safe_name(frame->second.name);
    }
  }
  if (k.name.empty()) k.name = host::safe_name(metadata.text("frame_name"));
  if (k.name.empty()) k.name = "keyframe-" + host::six_digits(k.id);

  const auto own_camera = camera_of(metadata);
  if (own_camera) {
    k.camera = *own_camera;
  } else if (flight_.camera) {
    k.camera = *flight_.camera;
  }
  if (!flight_.camera) flight_.camera = own_camera;
  if (const auto depth = depth_headers_.find(k.id); depth != depth_headers_.end()) check_depth(k, depth->second);
}

void FlightBuilder::finish() {
  for (auto& [id, keyframe] : flight_.keyframes) complete(keyframe);
  for (const auto& [id, keyframe] : flight_.keyframes) {
    if (keyframe.strip_id > 0) flight_.strips[keyframe.strip_id].keyframes.push_back(id);
  }
  for (auto& [id, strip] : flight_.strips) strip.id = id;
  leave_out_invalid_fixes(flight_);
  level_strips(flight_);
  sort_by_id(flight_.events);
  sort_by_id(flight_.components);
  sort_by_id(flight_.links);
  sort_by_id(flight_.ties);
  leave_out_invalid_links(flight_);
  // The onboard database is read first, and files may come late: counts that only grow tell the order.
  const auto age = [](const HousekeepingReport& r) {
    return std::tuple(r.storage.frames_released, r.storage.rows_erased, r.busy_ns);
  };
  std::stable_sort(flight_.housekeeping.begin(), flight_.housekeeping.end(),
                   [&](const HousekeepingReport& a, const HousekeepingReport& b) { return age(a) < age(b); });
}

}  // namespace

Flight index_flight(Outbox& outbox) {
  Flight flight;
  FlightBuilder builder(flight);
  for (const RecordEntry& entry : outbox.records) builder.add(entry);
  for (ReceivedProduct& product : outbox.products) {
    ReceivedFile& file = outbox.files[product.file];
    try {
      builder.add(product, file);
    } catch (const BadFile& fault) {
      file.fault = fault.what();
    }
  }
  builder.finish();
  flight.remarks.insert(flight.remarks.end(), outbox.waiting.begin(), outbox.waiting.end());
  return flight;
}

Flight build_flight(Outbox& outbox) {
  Flight flight = index_flight(outbox);
  for (auto& [id, keyframe] : flight.keyframes) {
    DecodedProducts decoded = decode_products(keyframe);
    static_cast<KeyframeRasters&>(keyframe) = std::move(decoded.rasters);
    drop_faulty(keyframe, decoded.faults, outbox);
  }
  return flight;
}

std::vector<StructureTrackPoint> points_of(const Keyframe& keyframe) {
  std::vector<StructureTrackPoint> points = keyframe.points;
  if (keyframe.coded_points.empty() || !keyframe.structure) return points;
  for (StructureTrackPoint& track : parse_points(keyframe.coded_points.bytes(), keyframe.structure->count)) {
    for (const Similarity& by : keyframe.points_moved) move(by, track.point);
    points.push_back(std::move(track));
  }
  return points;
}

std::vector<TrackPoint> track_of(const Flight& flight, const Strip& strip) {
  std::vector<TrackPoint> track;
  for (const std::int64_t id : strip.keyframes) {
    const Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    const double(&c)[3] = keyframe.pose->centre;
    track.push_back({id, Vec3(c[0], c[1], c[2])});
  }
  return track;
}

const char* unit_of(const Flight& flight, const Strip& strip) {
  for (const std::int64_t id : strip.keyframes) {
    const Keyframe& keyframe = flight.keyframes.at(id);
    if (keyframe.posed() && keyframe.pose->scale_source != ScaleSource::first_baseline) return "m";
  }
  return "units";
}

}  // namespace ilp::intake
