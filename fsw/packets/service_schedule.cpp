#include "fsw/packets/service_schedule.hpp"

namespace ilp {
namespace {

Status malformed(std::size_t offset) {
  return {StatusCode::request_malformed, static_cast<std::int64_t>(offset)};
}

ScheduledId read_id(const Tailoring& tailoring, ByteReader& in) {
  static_cast<void>(in.take(tailoring.request_id_padding));
  ScheduledId id;
  id.source = in.u16();
  id.apid = in.u16();
  id.count = in.u16();
  return id;
}

void write_id(const Tailoring& tailoring, const ScheduledId& id, ByteWriter& out) {
  out.number(0, tailoring.request_id_padding);
  out.u16(id.source);
  out.u16(id.apid);
  out.u16(id.count);
}

Status read_ids(const Tailoring& tailoring, ByteReader& in, ScheduledIdList& ids) {
  ids.clear();
  const std::uint32_t count = read_count(tailoring.schedule_count, in);
  if (!in.ok() || count == 0) return malformed(in.offset());
  if (count > limits::max_scheduled) {
    return {StatusCode::capacity_exceeded, count, static_cast<std::int64_t>(limits::max_scheduled)};
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const ScheduledId id = read_id(tailoring, in);
    if (!in.ok()) return malformed(in.offset());
    static_cast<void>(ids.push_back(id));
  }
  return in.left() == 0 ? Status{} : malformed(in.offset());
}

Status write_head(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out) {
  out.number(item.sub_schedule, tailoring.sub_schedule);
  out.number(item.group, tailoring.group);
  return encode_time(tailoring.time, item.release, out);
}

}  // namespace

InsertReader::InsertReader(const Tailoring& tailoring, std::span<const std::uint8_t> data)
    : tailoring_(tailoring), in_(data) {
  sub_schedule_ = static_cast<std::uint32_t>(in_.number(tailoring.sub_schedule));
  count_ = read_count(tailoring.insert_count, in_);
  if (!in_.ok() || count_ == 0) status_ = malformed(in_.offset());
}

bool InsertReader::next(ScheduleItem& item) {
  if (!status_.ok()) return false;
  if (read_ == count_) {
    if (in_.left() != 0) status_ = malformed(in_.offset());
    return false;
  }
  item = {};
  item.sub_schedule = sub_schedule_;
  item.group = static_cast<std::uint32_t>(in_.number(tailoring_.group));
  status_ = decode_time(tailoring_.time, in_, item.release);
  if (status_.is(StatusCode::packet_too_short)) status_ = malformed(in_.offset());
  if (!status_.ok()) return false;
  if (!first_packet(in_.rest(), item.packet).ok()) {
    status_ = malformed(in_.offset());
    return false;
  }
  static_cast<void>(in_.take(item.packet.size()));
  ++read_;
  return true;
}

void encode_insert_head(const Tailoring& tailoring, std::uint32_t sub_schedule, std::size_t count, ByteWriter& out) {
  out.number(sub_schedule, tailoring.sub_schedule);
  write_count(tailoring.insert_count, count, out);
}

Status encode_insert_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out) {
  out.number(item.group, tailoring.group);
  ILP_TRY(encode_time(tailoring.time, item.release, out));
  out.put(item.packet);
  return {};
}

Status decode_scheduled_ids(const Tailoring& tailoring, std::span<const std::uint8_t> data, ScheduledIdList& ids) {
  ByteReader in(data);
  return read_ids(tailoring, in, ids);
}

Status decode_shift(const Tailoring& tailoring, std::span<const std::uint8_t> data, std::int32_t& ms,
                    ScheduledIdList& ids) {
  ByteReader in(data);
  ms = in.i32();
  return read_ids(tailoring, in, ids);
}

Status decode_shift_all(std::span<const std::uint8_t> data, std::int32_t& ms) {
  ByteReader in(data);
  ms = in.i32();
  return in.ok() && in.left() == 0 ? Status{} : malformed(in.offset());
}

void encode_report_head(const Tailoring& tailoring, std::size_t count, ByteWriter& out) {
  write_count(tailoring.schedule_count == 0 ? std::uint8_t{2} : tailoring.schedule_count, count, out);
}

Status encode_summary_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out) {
  ILP_TRY(write_head(tailoring, item, out));
  write_id(tailoring, item.id, out);
  return {};
}

Status encode_detail_item(const Tailoring& tailoring, const ScheduleItem& item, ByteWriter& out) {
  ILP_TRY(write_head(tailoring, item, out));
  out.put(item.packet);
  return {};
}

ScheduledId scheduled_id(const Telecommand& request) {
  return {request.source, request.primary.apid, request.primary.sequence_count};
}

}  // namespace ilp
