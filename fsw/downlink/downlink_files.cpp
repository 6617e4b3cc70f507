#include "fsw/downlink/downlink_files.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/product_layers.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/refinement.hpp"

namespace ilp {
namespace {

/// In the end every class can afford the largest file.
constexpr auto most_owed_bytes = static_cast<std::int64_t>(limits::max_transfer_bytes);

}  // namespace

Status DownlinkFiles::stored(const Status& answer) {
  work_.store_failed = !answer.ok();
  return answer;
}

Status DownlinkFiles::open(const char* name) {
  // If the store accepts no writes, it cannot record that the file was sent, and the file would be sent repeatedly.
  ILP_TRY(stored(save_checkpoint(wiring_.store, Downlink::checkpoint, cursor_, state_)));
  const bool lenient = abandoned(work_.subject.kind, work_.subject.id);
  ILP_TRY(file_.begin(name));
  if (lenient) file_.be_lenient();
  return {};
}

Status DownlinkFiles::close_file(DownlinkRecord sent, State& after) {
  ILP_TRY(file_.end());
  sent.id = after.last_downlink_id + 1;
  sent.bytes = file_.bytes();
  sent.crc32 = file_.crc();
  sent.sent_ns = wiring_.clock.now();
  sent.records_through = after.records_through;
  sent.points_through = after.points_through;
  copy_text(sent.name, file_.name());
  after.last_downlink_id = sent.id;
  after.credit_bytes -= sent.bytes;
  after.pass_bytes += sent.bytes;
  const auto own = static_cast<std::size_t>(work_.subject.kind);
  for (std::size_t i = 0; i < file_classes; ++i) {
    std::int64_t& owed = after.owed_bytes[i];
    owed += link_share_permille[i] * sent.bytes / 1000;
    if (i == own) owed -= sent.bytes;
    // Bytes beyond a class's share are no debt, because no other file waited.
    if (owed < 0) owed = 0;
    if (owed > most_owed_bytes) owed = most_owed_bytes;
  }
  if (work_.subject.kind == FileClass::products) after.planned_bytes = sent.bytes;
  drop_late({work_.subject.kind, work_.subject.id}, after);
  work_.quarantine.remove(work_.subject.kind, work_.subject.id);
  ILP_TRY(stored(put(wiring_.store, sent)));
  work_.newest_sent_ns = sent.sent_ns;
  return {};
}

void DownlinkFiles::drop_late(const LateFile& late, State& after) {
  std::size_t kept = 0;
  for (const LateFile& one : after.late) {
    if (!(one == late)) after.late[kept++] = one;
  }
  if (kept != after.late.size()) work_.changed = true;
  static_cast<void>(after.late.resize(kept));
}

Result<bool> DownlinkFiles::send_records(std::int64_t keyframe_id, State& after) {
  work_.subject = {FileClass::records, keyframe_id};
  const bool without = abandoned(FileClass::records, keyframe_id);
  KeyframeRecord keyframe;
  const Status known = get(wiring_.store, keyframe_id, keyframe);
  if (known.is(StatusCode::not_found)) {
    // It was erased with the history.
    drop_late({FileClass::records, keyframe_id}, after);
    return false;
  }
  if (!known.ok() && !without) return known;
  FixedText<32> name;
  name.add("records-").add(keyframe_id, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write_records_head());
  PoseRecord pose;
  ILP_TAKE(const bool posed, file_.take(get(wiring_.store, keyframe_id, pose)));
  CameraRecord camera;
  ILP_TAKE(const bool seen, file_.take(get_camera(wiring_.store, camera_id, camera)));
  if (seen) ILP_TRY(file_.write_record(camera));
  ILP_TAKE(const bool found, file_.take(known));
  if (found) {
    ILP_TRY(file_.write_if_present<StripRecord>(keyframe.strip_id));
    ILP_TRY(file_.write_if_present<StripFrameRecord>(keyframe.strip_id));
    ILP_TRY(file_.write_if_present<TieRecord>(keyframe.strip_id));
    ILP_TRY(file_.write_if_present<NavigationRecord>(keyframe_id));
    ILP_TRY(file_.write_record(keyframe));
    ILP_TRY(file_.write_if_present<OverlapRecord>(keyframe.frame_id));
  }
  if (posed) ILP_TRY(file_.write_record(pose));
  ILP_TRY(file_.write_if_present<CalibrationRecord>(keyframe_id));
  for (std::int64_t number = 0; number < limits::max_links_per_keyframe; ++number) {
    ILP_TRY(write_link(link_id(keyframe_id, number)));
  }
  ILP_TRY(write_fix(keyframe_id));
  ILP_TRY(write_depth(keyframe_id));
  ILP_TRY(write_mask(keyframe_id));
  ILP_TRY(file_.write_if_present<RichnessRecord>(keyframe_id));
  ILP_TRY(write_products_of(keyframe_id, keyframe.frame_id));
  ILP_TRY(file_.write_records_tail());
  if (after.records_through < keyframe_id) after.records_through = keyframe_id;
  DownlinkRecord record;
  record.kind = DownlinkKind::records;
  record.subject_id = keyframe_id;
  const std::int64_t left_out = file_.left_out();
  ILP_TRY(close_file(record, after));
  if (left_out != 0) work_.event = {StatusCode::records_incomplete, keyframe_id, left_out};
  return true;
}

Status DownlinkFiles::write_depth(std::int64_t keyframe_id) {
  DepthRecord depth;
  ILP_TAKE(const bool found, file_.take(get(wiring_.store, keyframe_id, depth)));
  if (!found) return {};
  depth.values.bytes = 0;
  depth.sigma.bytes = 0;
  depth.cells.bytes = 0;
  return file_.write_record(depth);
}

Status DownlinkFiles::write_mask(std::int64_t keyframe_id) {
  MaskRecord mask;
  ILP_TAKE(const bool found, file_.take(get(wiring_.store, keyframe_id, mask)));
  if (!found) return {};
  auto& buffer = wiring_.scratch.as<DownlinkBuffers>().product;
  ILP_ASSERT(mask.code.bytes <= buffer.size(), mask.code.bytes);
  // The record states the length of the code, so the code is read first.
  const std::span<std::uint8_t> code = std::span(buffer).first(mask.code.bytes);
  if (!code.empty()) {
    ILP_TAKE(const bool whole, file_.take(read_blob<MaskRecord>(wiring_.store, "code", keyframe_id, 0, code)));
    if (!whole) mask.code.bytes = 0;
  }
  ILP_TRY(file_.write_record(mask));
  return file_.write(code.first(mask.code.bytes));
}

Status DownlinkFiles::write_link(std::int64_t id) {
  LinkRecord link;
  ILP_TAKE(const bool found, file_.take(get(wiring_.store, id, link)));
  if (!found) return {};
  std::array<std::uint8_t, limits::max_link_points * sizeof(LinkPoint)> bytes;
  ILP_ASSERT(link.points.bytes <= bytes.size(), link.points.bytes);
  // The record states the number of points, so they are read first.
  const std::span<std::uint8_t> points = std::span(bytes).first(link.points.bytes);
  if (!points.empty()) {
    ILP_TAKE(const bool whole, file_.take(read_blob<LinkRecord>(wiring_.store, "points", id, 0, points)));
    if (!whole) link.points.bytes = 0;
  }
  ILP_TRY(file_.write_record(link));
  return file_.write(points.first(link.points.bytes));
}

Status DownlinkFiles::write_fix(std::int64_t keyframe_id) {
  FixRecord fix;
  ILP_TAKE(const bool found, file_.take(get(wiring_.store, keyframe_id, fix)));
  if (!found) return {};
  std::array<std::uint8_t, limits::max_fix_points * sizeof(FixPoint)> bytes;
  ILP_ASSERT(fix.points.bytes <= bytes.size(), fix.points.bytes);
  const std::span<std::uint8_t> points = std::span(bytes).first(fix.points.bytes);
  if (!points.empty()) {
    ILP_TAKE(const bool whole, file_.take(read_blob<FixRecord>(wiring_.store, "points", keyframe_id, 0, points)));
    if (!whole) fix.points.bytes = 0;
  }
  ILP_TRY(file_.write_record(fix));
  return file_.write(points.first(fix.points.bytes));
}

Status DownlinkFiles::write_products_of(std::int64_t keyframe_id, std::int64_t frame_id) {
  for (std::int64_t kind = 0; kind < static_cast<std::int64_t>(ProductKind::count); ++kind) {
    ProductRecord product;
    const std::int64_t id = product_id(keyframe_id, static_cast<ProductKind>(kind));
    ILP_TAKE(const bool found, file_.take(get(wiring_.store, id, product)));
    if (!found) continue;
    product.data.bytes = 0;
    ILP_TRY(file_.write_record(product));
    const bool no_image = product.kind == ProductKind::image && product.state == ProductState::dropped;
    if (no_image) ILP_TRY(write_frame(frame_id));
  }
  return {};
}

/// An image tells what frame it is; without one the frame's record does.
Status DownlinkFiles::write_frame(std::int64_t id) {
  FrameRecord frame;
  ILP_TAKE(const bool found, file_.take(get(wiring_.store, id, frame)));
  if (!found) return {};
  frame.image.bytes = 0;
  return file_.write_record(frame);
}

Status DownlinkFiles::write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer,
                                       int last_layer) {
  LayerSegments segments;
  ILP_TRY(compare_layers(longer, product.layers_sent, segments));
  RefinementHeader header;
  header.product_id = product.id;
  header.first_layer = static_cast<std::uint8_t>(product.layers_sent + 1);
  header.last_layer = static_cast<std::uint8_t>(last_layer);
  header.shorter_bytes = static_cast<std::uint32_t>(segments.shorter_bytes);
  header.bytes = static_cast<std::uint32_t>(longer.size());
  header.crc32 = crc32(longer);
  header.same_head = static_cast<std::uint32_t>(segments.same_head);
  header.head_end = static_cast<std::uint32_t>(segments.head_end);
  header.shorter_data = static_cast<std::uint32_t>(segments.shorter_data);
  header.same_data = static_cast<std::uint32_t>(segments.same_data);
  std::array<std::uint8_t, refinement_header_bytes> head{};
  write_refinement_header(header, head);
  FixedText<32> name;
  name.add("refine-").add(product.keyframe_id, 6).add("-").add(name_of(product.kind));
  name.add("-").add(header.first_layer, 1).add("-").add(header.last_layer, 1).add(".ilr");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write(head));
  ILP_TRY(file_.write(longer.subspan(segments.same_head, segments.head_end - segments.same_head)));
  ILP_TRY(file_.write(longer.subspan(segments.head_end + segments.same_data)));
  return file_.write_u32(file_.crc());
}

Result<bool> DownlinkFiles::send_layers(const ProductRecord& product, int last_layer, State& after) {
  work_.subject = {FileClass::products, product.id};
  auto& buffer = wiring_.scratch.as<DownlinkBuffers>().product;
  ILP_ASSERT(product.data.bytes <= buffer.size(), product.data.bytes);
  const std::span<std::uint8_t> whole{buffer.data(), product.data.bytes};
  ProductRecord changed = product;
  std::size_t bytes = whole.size();
  const int layers = layers_of(product);
  bool damaged = abandoned(FileClass::products, product.id);
  if (!damaged) {
    ILP_TRY(read_blob<ProductRecord>(wiring_.store, "data", product.id, 0, whole));
    // The bytes may have been damaged in memory or on disk since the compressor made them.
    damaged = crc32(whole) != product.crc32;
    if (!damaged && last_layer < layers) damaged = !truncate_to_layers(whole, last_layer, bytes).ok();
  }
  if (damaged) {
    work_.event = {StatusCode::product_damaged, product.id};
    work_.quarantine.remove(work_.subject.kind, work_.subject.id);
    changed.state = ProductState::dropped;
    work_.changed = true;
    ILP_TRY(stored(amend(wiring_.store, changed)));
    return true;
  }
  if (product.layers_sent == 0) {
    FixedText<32> name;
    name.add("product-").add(product.keyframe_id, 6).add("-").add(name_of(product.kind)).add(".jp2");
    ILP_TRY(open(name.c_str()));
    ILP_TRY(file_.write(whole.first(bytes)));
  } else {
    ILP_TRY(write_refinement(product, whole.first(bytes), last_layer));
  }
  DownlinkRecord record;
  record.kind = DownlinkKind::product;
  record.subject_id = product.id;
  record.first_layer = static_cast<std::uint8_t>(product.layers_sent + 1);
  record.last_layer = static_cast<std::uint8_t>(last_layer);
  ILP_TRY(close_file(record, after));
  changed.layers_sent = static_cast<std::uint8_t>(last_layer);
  changed.state = last_layer >= layers ? ProductState::sent : ProductState::stored;
  ILP_TRY(stored(amend(wiring_.store, changed)));
  return true;
}

Result<bool> DownlinkFiles::send_points(std::int64_t id, std::int64_t most, State& after) {
  work_.subject = {FileClass::points, id};
  const bool without = abandoned(FileClass::points, id);
  StructureRecord structure;
  const Status found = get(wiring_.store, id, structure);
  const bool none = found.is(StatusCode::not_found) || (found.ok() && structure.points.bytes == 0);
  if (without || none) {
    if (without && !none) work_.event = {StatusCode::points_given_up, id, static_cast<std::int64_t>(found.code)};
    work_.quarantine.remove(work_.subject.kind, id);
    drop_late({FileClass::points, id}, after);
    if (after.points_through < id) after.points_through = id;
    return false;
  }
  ILP_TRY(found);
  if (!may_go(after, structure.points.bytes, most)) return false;
  FixedText<32> name;
  name.add("points-").add(structure.id, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  ILP_TRY(file_.write_records_head());
  ILP_TRY(file_.write_record(structure));
  ILP_TRY(file_.write_blob_of(record_info<StructureRecord>(), "points", structure.id, structure.points.bytes));
  ILP_TRY(file_.write_records_tail());
  if (after.points_through < id) after.points_through = id;
  DownlinkRecord file;
  file.kind = DownlinkKind::points;
  file.subject_id = id;
  ILP_TRY(close_file(file, after));
  return true;
}

std::int64_t DownlinkFiles::housekeeping_fingerprint() const {
  std::int64_t steps = 0;
  for (std::int64_t id = 1; id <= std::int64_t{component_numbers}; ++id) {
    ComponentRecord record;
    if (get(wiring_.store, id, record).ok()) steps += record.steps;
  }
  return steps;
}

Result<bool> DownlinkFiles::send_events(std::int64_t through, bool late, std::int64_t housekeeping_steps,
                                        State& after) {
  const std::int64_t first_id = through + 1;
  work_.subject = {FileClass::events, first_id};
  const bool without = abandoned(FileClass::events, first_id);
  FixedText<32> name;
  name.add("events-").add(after.event_files + 1, 6).add(".ilp");
  ILP_TRY(open(name.c_str()));
  // Housekeeping is repeated in the next file: an unreadable part delays no event.
  file_.be_lenient();
  ILP_TRY(file_.write_records_head());
  std::int64_t first = 0;
  for (std::int64_t i = 0; i < events_per_file; ++i) {
    EventRecord event;
    const Status found = next(wiring_.store, through, event);
    const bool over = late && found.ok() && event.id >= first_id + events_per_file;
    if (found.is(StatusCode::not_found) || over) break;
    if (found.ok()) {
      through = event.id;
      if (first == 0) first = event.id;
      ILP_TRY(file_.write_record(event));
      continue;
    }
    const bool damaged = found.is(StatusCode::record_damaged);
    if (!damaged && !without) return found;
    through = damaged ? found.a : through + 1;
    work_.event = {StatusCode::event_given_up, through, static_cast<std::int64_t>(found.code)};
  }
  for (std::int64_t id = 1; id <= std::int64_t{component_numbers}; ++id) {
    ILP_TRY(file_.write_if_present<ComponentRecord>(id));
  }
  ILP_TRY(file_.write_newest<StartRecord>());
  ILP_TRY(file_.write_if_present<TimingRecord>(1));
  ILP_TRY(file_.write_if_present<StorageRecord>(1));
  ILP_TRY(file_.write_newest<CalibrationRecord>());
  ILP_TRY(file_.write_newest<CalibrationCheckRecord>());
  ILP_TRY(file_.write_records_tail());
  if (!late) after.events_through = through;
  after.event_files += 1;
  after.events_sent_ns = wiring_.clock.now();
  after.housekeeping_steps = housekeeping_steps;
  DownlinkRecord record;
  record.kind = DownlinkKind::records;
  record.subject_id = -first;
  ILP_TRY(close_file(record, after));
  return true;
}

}  // namespace ilp
