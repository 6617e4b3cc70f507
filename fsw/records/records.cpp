#include "fsw/records/records.hpp"

#include <iterator>
#include <type_traits>

namespace ilp {
namespace {

template <typename Record>
struct Fields;

#include "fsw/records/rows_as_tables.inc"
// The rows.
#include "fsw/records/records.inc"

template <typename Record>
constexpr std::size_t blob_fields() {
  std::size_t count = 0;
  for (const FieldInfo& field : Fields<Record>::table) count += field.type == FieldType::blob ? 1U : 0U;
  return count;
}

template <typename Record>
constexpr RecordInfo describe(RecordType type, const char* name, Numbering numbering, const char* description) {
  static_assert(std::is_trivially_copyable_v<Record> && std::is_standard_layout_v<Record>);
  static_assert(sizeof(Record) <= limits::max_record_bytes);
  static_assert(std::size(Fields<Record>::table) <= limits::max_record_fields);
  static_assert(blob_fields<Record>() <= limits::max_blob_fields);
  return {type,
          name,
          numbering,
          description,
          static_cast<std::uint16_t>(sizeof(Record)),
          static_cast<std::uint16_t>(std::size(Fields<Record>::table)),
          Fields<Record>::table};
}

constexpr RecordInfo infos[] = {
#define RECORD(number, record, name, numbering, description) \
  describe<record>(RecordType::name, #name, Numbering::numbering, description),
#include "fsw/records/records.inc"
};
static_assert(std::size(infos) == static_cast<std::size_t>(RecordType::count));
static_assert(std::size(infos) <= limits::max_record_types && std::size(infos) < 64, "a RecordMask has 64 bits");
constexpr bool in_order() {
  for (std::size_t i = 0; i < std::size(infos); ++i) {
    if (infos[i].type != static_cast<RecordType>(i) || infos[i].fields[0].offset != 0) return false;
  }
  return true;
}
static_assert(in_order());

}  // namespace

const RecordInfo& record_info(RecordType type) {
  return infos[static_cast<std::size_t>(type)];
}

#define RECORD(number, record, name, ...)   \
  template <>                               \
  const RecordInfo& record_info<record>() { \
    return infos[number];                   \
  }
#include "fsw/records/records.inc"

CameraModel camera_model(const CameraRecord& r) {
  return {r.width, r.height, r.fx, r.fy, r.cx, r.cy, r.k1,   r.k2,
          r.p1,    r.p2,     r.k3, r.k4, r.k5, r.k6, r.lens, r.readout_s};
}

CameraRecord camera_record(const CameraModel& c) {
  return {camera_id,           c.width, c.height, c.fx, c.fy, c.cx,   c.cy, c.k1, c.k2,        c.p1, c.p2, 1, 0, 0, 0,
          CameraSource::given, c.k3,    c.k4,     c.k5, c.k6, c.lens, 0,    {},   c.readout_s, 0};
}

CameraRecord nominal_camera_record(const CameraModel& camera) {
  CameraRecord record = camera_record(camera);
  record.frozen = false;
  record.source = CameraSource::nominal;
  record.sigma_focal_px = record.sigma_cx_px = record.sigma_cy_px = unknown;
  return record;
}

Pose pose_of(const PoseRecord& record) {
  Pose pose;
  for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = record.q_cam_from_world[i];
  for (int i = 0; i < 3; ++i) pose.centre[i] = record.centre[i];
  return pose;
}

}  // namespace ilp
