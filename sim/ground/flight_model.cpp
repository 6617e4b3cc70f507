#include "sim/ground/flight_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/crc.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"
#include "sim/ground/safe_name.hpp"

namespace ilp::ground {
namespace {

template <typename Record>
void keep_by_id(std::vector<Record>& records, const Record& record) {
  for (Record& other : records) {
    if (other.id != record.id) continue;
    other = record;
    return;
  }
  records.push_back(record);
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

// Of hostile or damaged files; anything inside is representable as float and as a grid.
constexpr double largest_coordinate = 1e9;

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
  void add(const ReceivedProduct& received, ReceivedFile& file);
  void finish();

 private:
  Keyframe& keyframe(std::int64_t id) {
    Keyframe& k = flight_.keyframes[id];
    k.id = id;
    return k;
  }
  void add_camera(const CameraRecord& record);
  void add_strip(const StripRecord& record);
  void add_structure(const RecordEntry& entry);
  void add_depth(const RecordEntry& entry);
  void add_product_record(const ProductRecord& record);
  void take_image(Keyframe& k, const Product& product);
  void take_depth(Keyframe& k, const Product& product);
  void complete(Keyframe& k);

  Flight& flight_;
  std::map<std::int64_t, OverlapRecord> overlaps_;
  std::map<std::int64_t, Raster<std::uint8_t>> masks_;
  std::map<std::int64_t, Product> depth_products_;
  std::map<std::int64_t, Metadata> metadata_;
};

void FlightBuilder::add_structure(const RecordEntry& entry) {
  const auto record = record_of<StructureRecord>(entry);
  Keyframe& k = keyframe(record.id);
  try {
    k.points = parse_points(entry.blobs[0], record.count);
    k.structure = record;
  } catch (const BadFile& fault) {
    flight_.remarks.push_back("keyframe " + std::to_string(record.id) + ": " + fault.what());
  }
}

void FlightBuilder::add_depth(const RecordEntry& entry) {
  const auto record = record_of<DepthRecord>(entry);
  keyframe(record.id).depth = record;
  const auto& coded = entry.blobs[2];
  if (coded.empty() || record.width <= 0 || record.height <= 0 || record.width > limits::max_image_side ||
      record.height > limits::max_image_side) {
    return;
  }
  Raster<std::uint8_t> mask(record.width, record.height);
  if (decode_mask(coded.data(), coded.size(), mask.view()).ok()) {
    masks_[record.id] = std::move(mask);
  } else {
    flight_.remarks.push_back("keyframe " + std::to_string(record.id) + ": its mask is malformed");
  }
}

void FlightBuilder::add_strip(const StripRecord& record) {
  std::optional<StripRecord>& known = flight_.strips[record.id].record;
  // Every keyframe's file repeats its strip, as it was when the file was sent.
  const bool newer = !known || record.last_keyframe_id > known->last_keyframe_id ||
                     (record.last_keyframe_id == known->last_keyframe_id && record.end != StripEnd::open);
  if (newer) known = record;
}

void FlightBuilder::add_camera(const CameraRecord& record) {
  // Files that went before the camera was calibrated carry the nominal one.
  if (flight_.camera_record && flight_.camera_record->frozen != 0 && record.frozen == 0) return;
  flight_.camera_record = record;
  flight_.camera = camera_model(record);
}

void FlightBuilder::add_product_record(const ProductRecord& record) {
  const auto kind = static_cast<std::size_t>(record.kind);
  if (kind < 2) keyframe(record.keyframe_id).product_records[kind] = record;
}

void FlightBuilder::add(const RecordEntry& entry) {
  switch (entry.type) {
    case RecordType::camera:
      add_camera(record_of<CameraRecord>(entry));
      break;
    case RecordType::calibration: {
      const auto record = record_of<CalibrationRecord>(entry);
      flight_.calibrations[record.id] = record;
      break;
    }
    case RecordType::calibration_check: {
      const auto record = record_of<CalibrationCheckRecord>(entry);
      flight_.calibration_checks[record.id] = record;
      break;
    }
    case RecordType::strip:
      add_strip(record_of<StripRecord>(entry));
      break;
    case RecordType::keyframe: {
      const auto record = record_of<KeyframeRecord>(entry);
      keyframe(record.id).record = record;
      break;
    }
    case RecordType::overlap: {
      const auto record = record_of<OverlapRecord>(entry);
      flight_.overlaps[record.id] = record;
      break;
    }
    case RecordType::pose: {
      const auto record = record_of<PoseRecord>(entry);
      Keyframe& k = keyframe(record.id);
      if (!k.posed()) k.pose = record;
      break;
    }
    case RecordType::structure:
      add_structure(entry);
      break;
    case RecordType::depth:
      add_depth(entry);
      break;
    case RecordType::richness: {
      const auto record = record_of<RichnessRecord>(entry);
      keyframe(record.id).richness = record;
      break;
    }
    case RecordType::product:
      add_product_record(record_of<ProductRecord>(entry));
      break;
    case RecordType::event:
      keep_by_id(flight_.events, record_of<EventRecord>(entry));
      break;
    case RecordType::component:
      keep_by_id(flight_.components, record_of<ComponentRecord>(entry));
      break;
    case RecordType::timing:
      flight_.timing = record_of<TimingRecord>(entry);
      break;
    case RecordType::storage:
      flight_.storage = record_of<StorageRecord>(entry);
      break;
    case RecordType::frame: {
      const auto record = record_of<FrameRecord>(entry);
      flight_.frames[record.id] = record;
      break;
    }
    case RecordType::capture: {
      const auto record = record_of<CaptureRecord>(entry);
      flight_.captures[record.id] = record;
      break;
    }
    default:
      break;
  }
}

void FlightBuilder::add(const ReceivedProduct& received, ReceivedFile& file) {
  Product product = decode_product(received.bytes);
  const auto stated = product.metadata.integer("keyframe");
  if (!stated || *stated != received.keyframe_id)
    throw BadFile("its metadata name another keyframe than its file name");
  const auto kind = static_cast<std::size_t>(received.kind);
  Keyframe& k = keyframe(received.keyframe_id);

  ProductAccount account;
  account.file = file.name;
  account.bytes = received.bytes.size();
  account.layers = product.layers;
  if (const auto grant = product.metadata.integer("grant_bytes"); grant && *grant > 0) {
    account.grant_bytes = static_cast<std::uint32_t>(*grant);
  }
  if (const auto& record = k.product_records[kind]) {
    account.grant_bytes = record->grant_bytes;
    account.scheme = record->scheme;
    // Fewer bytes than coded are a product cut at a layer; as many bytes with another sum are damage.
    if (record->bytes == account.bytes && record->crc32 != crc32(received.bytes)) {
      throw BadFile("checksum differs from the product record: damaged in transfer");
    }
  }
  k.products[kind] = account;
  metadata_[k.id] = product.metadata;
  if (received.kind == ProductKind::image) {
    take_image(k, product);
  } else {
    depth_products_[k.id] = std::move(product);
  }
}

void FlightBuilder::take_image(Keyframe& k, const Product& product) {
  k.image = Raster<std::uint8_t>(product.samples.width, product.samples.height);
  for (std::size_t i = 0; i < k.image.samples.size(); ++i) {
    k.image.samples[i] = static_cast<std::uint8_t>(std::clamp(product.samples.samples[i], 0, 255));
  }
}

/// Empty where the product has none, or one of another size.
Raster<float> sigma_blocks_of(const Product& product) {
  const std::string text = product.metadata.text("sigma_map");
  const auto scale = product.metadata.number("disparity_per_inverse_depth_px");
  const std::int32_t columns = sigma_map_side(product.samples.width), rows = sigma_map_side(product.samples.height);
  const bool fits = text.size() == static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (!fits || !scale || !(*scale > 0)) return {};
  Raster<float> blocks(columns, rows);
  for (std::size_t i = 0; i < text.size(); ++i) {
    blocks.samples[i] = static_cast<float>(sigma_of_character(text[i]) / (sigma_codes_per_px * *scale));
  }
  return blocks;
}

void FlightBuilder::take_depth(Keyframe& k, const Product& product) {
  const auto offset = product.metadata.number("depth_offset"), step = product.metadata.number("depth_step");
  if (!offset || !step || !(*step > 0)) {
    flight_.remarks.push_back("keyframe " + std::to_string(k.id) + ": the depth product does not state its scale");
    return;
  }
  const Raster<std::int32_t>& samples = product.samples;
  if (!k.mask.same_size(samples.width, samples.height)) {
    flight_.remarks.push_back("keyframe " + std::to_string(k.id) +
                              ": no mask came for its depth; outside it samples say nothing, and none is taken");
    k.mask = Raster<std::uint8_t>(samples.width, samples.height, 0);
  }
  k.sigma_blocks = sigma_blocks_of(product);
  k.depth_step = *step;
  k.inverse_depth = Raster<float>(samples.width, samples.height);
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    const double inverse = *offset + *step * samples.samples[i];
    const bool valid = k.mask.samples[i] != 0 && samples.samples[i] >= 1 && inverse > 1 / largest_coordinate &&
                       inverse < largest_coordinate;
    k.inverse_depth.samples[i] = valid ? static_cast<float>(inverse) : 0.0F;
  }
}

void FlightBuilder::complete(Keyframe& k) {
  if (const auto mask = masks_.find(k.id); mask != masks_.end()) k.mask = std::move(mask->second);
  const auto product = metadata_.find(k.id);
  const Metadata metadata = product == metadata_.end() ? Metadata() : product->second;

  if (k.record) k.strip_id = k.record->strip_id;
  if (!k.pose) k.pose = pose_record_of(metadata);
  if (k.pose && k.pose->state == PoseState::final && !plausible(*k.pose)) {
    flight_.remarks.push_back("keyframe " + std::to_string(k.id) + ": its pose is not a pose");
    k.pose->state = PoseState::failed;
  }
  if (k.strip_id == 0 && k.pose) k.strip_id = k.pose->strip_id;
  if (k.strip_id == 0) k.strip_id = metadata.integer("strip").value_or(0);

  if (k.record) {
    if (const auto overlap = flight_.overlaps.find(k.record->frame_id); overlap != flight_.overlaps.end()) {
      k.overlap = overlap->second;
    }
    if (const auto frame = flight_.frames.find(k.record->frame_id); frame != flight_.frames.end()) {
      k.name = safe_name(frame->second.name);
    }
  }
  if (k.name.empty()) k.name = safe_name(metadata.text("frame_name"));
  if (k.name.empty()) k.name = "keyframe-" + six_digits(k.id);

  const auto own_camera = camera_of(metadata);
  if (own_camera) {
    k.camera = *own_camera;
  } else if (flight_.camera) {
    k.camera = *flight_.camera;
  }
  if (!flight_.camera) flight_.camera = own_camera;
  if (const auto depth = depth_products_.find(k.id); depth != depth_products_.end()) take_depth(k, depth->second);
}

void FlightBuilder::finish() {
  for (auto& [id, keyframe] : flight_.keyframes) complete(keyframe);
  for (const auto& [id, keyframe] : flight_.keyframes) {
    if (keyframe.strip_id > 0) flight_.strips[keyframe.strip_id].keyframes.push_back(id);
  }
  for (auto& [id, strip] : flight_.strips) strip.id = id;
  sort_by_id(flight_.events);
  sort_by_id(flight_.components);
}

}  // namespace

Flight build_flight(Outbox& outbox) {
  Flight flight;
  FlightBuilder builder(flight);
  for (const RecordEntry& entry : outbox.records) builder.add(entry);
  for (const ReceivedProduct& product : outbox.products) {
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

double inverse_depth_sigma(const Keyframe& keyframe, std::int32_t x, std::int32_t y) {
  const std::int32_t column = x / sigma_block_px, row = y / sigma_block_px;
  const Raster<float>& blocks = keyframe.sigma_blocks;
  if (x < 0 || y < 0 || column >= blocks.width || row >= blocks.height) return 0;
  const double matching = blocks.at(column, row);
  if (!(matching > 0)) return 0;
  return std::sqrt(matching * matching + keyframe.depth_step * keyframe.depth_step / 12);
}

}  // namespace ilp::ground
